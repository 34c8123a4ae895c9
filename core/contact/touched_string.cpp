// Which strings are held, and their law. See touched_string.h. RT: yes.
#include "core/contact/touched_string.h"

#include <algorithm>
#include <cmath>
#include <limits>

namespace hapticd {
namespace {

/// A deflection this small is rest, m: far below the rounding of any contact.
constexpr double kAtRest = 1e-13;

bool may_be_held(const StringContext& context, const Contact& contact) noexcept {
  if (contact.key.kind != ObstacleKind::kCapsule) return false;
  const auto index = static_cast<std::size_t>(contact.key.obstacle);
  if (index >= context.strings.size()) return false;
  const StringConstants& string = context.strings[index];
  if (!(string.length > 0.0)) return false;
  return string.model == StringContact::kYielding
             ? string.max_level >= StringDetail::kStatic && contact.lambda > 0.0 &&
                   contact.lambda < 1.0
             : context.options.friction && string.friction_coefficient > 0.0;
}

/// True next to an end and for short strings, where the law may be stiffer than the program and its
/// rounding bear.
bool too_stiff(const StringConstants& string, double lambda, double kt) noexcept {
  const double run = std::min(lambda, 1.0 - lambda) * string.length;
  const double greatest = kMaxStringStiffness * kt;
  return string.tension > greatest * run || 4.0 * string.axial_stiffness > greatest * string.length;
}

/// Inserts in the order of capsules; false when full.
bool insert(const TouchedString& hold, TouchedStrings& holds) noexcept {
  if (!holds.push_back(hold)) return false;
  for (std::size_t k = holds.size() - 1; k > 0 && holds[k].bend.capsule < holds[k - 1].bend.capsule;
       --k) {
    std::swap(holds[k], holds[k - 1]);
  }
  return true;
}

double nearest_gap(const ContactSet& contacts, std::int32_t capsule) noexcept {
  double gap = std::numeric_limits<double>::infinity();
  for (const Contact& contact : contacts.contacts) {
    if (contact.key.kind == ObstacleKind::kCapsule && contact.key.obstacle == capsule) {
      gap = std::min(gap, contact.gap);
    }
  }
  return gap;
}

/// Lets go of strings that are at rest and out of reach; true when one of them yielded.
bool release_holds(const ContactSet& contacts, double skin, TouchedStrings& holds) noexcept {
  bool changed = false;
  std::size_t kept = 0;
  for (std::size_t k = 0; k < holds.size(); ++k) {
    const TouchedString& hold = holds[k];
    const bool far = nearest_gap(contacts, hold.bend.capsule) > 2.0 * kTouchSkins * skin + kAtRest;
    if (far && hold.bend.u_W.norm() <= kAtRest) {
      changed = changed || hold.yields;
    } else {
      if (kept != k) holds[kept] = hold;
      ++kept;
    }
  }
  holds.truncate(kept);
  return changed;
}

}  // namespace

Deflection string_law(const StringContext& context, const StringBend& bend,
                      double deflection) noexcept {
  const StringConstants& string = context.strings[static_cast<std::size_t>(bend.capsule)];
  double compliance = std::max(0.0, 1.0 / string.contact_stiffness - 1.0 / context.kt);
  if (too_stiff(string, bend.lambda, context.kt)) {
    compliance += 1.0 / (kMaxStringStiffness * context.kt);
  }
  if (!(compliance > 0.0)) return deflect(string, bend.lambda, deflection);
  const SeriesDeflection series =
      deflect_in_series(string, bend.lambda, deflection, 1.0 / compliance);
  Deflection law = deflect(string, bend.lambda, series.delta);
  law.energy += 0.5 * compliance * series.force * series.force;
  law.force = series.force;
  law.slope = 1.0 / (1.0 / law.slope + compliance);
  law.secant = deflection > 0.0 ? series.force / deflection : law.slope;
  return law;
}

bool update_touched_strings(const StringContext& context, const ContactSet& contacts, double skin,
                            TouchedStrings& holds, int& refused) noexcept {
  bool changed = release_holds(contacts, skin, holds);
  for (const Contact& contact : contacts.contacts) {
    if (contact.gap > kTouchSkins * skin || find_touched(holds, contact.key) >= 0 ||
        !may_be_held(context, contact)) {
      continue;
    }
    const auto index = static_cast<std::size_t>(contact.key.obstacle);
    TouchedString hold;
    hold.bend = {contact.key.obstacle, contact.lambda, Vector3::Zero()};
    hold.yields = context.strings[index].model == StringContact::kYielding;
    if (insert(hold, holds)) {
      changed = changed || hold.yields;
    } else {
      ++refused;
    }
  }
  return changed;
}

StringBend moved(const StringBend& bend, const StringMotion& motion) noexcept {
  return {bend.capsule, std::clamp(bend.lambda + motion.dlambda, 0.0, 1.0), bend.u_W + motion.du_W};
}

double slip_energy(double stiffness, double limit, double slip) noexcept {
  const double force = stiffness * slip;
  return force <= limit ? 0.5 * force * slip : limit * (slip - 0.5 * limit / stiffness);
}

}  // namespace hapticd
