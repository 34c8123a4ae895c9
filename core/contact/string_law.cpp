// See string_law.h. RT: yes.
#include "core/contact/string_law.h"

#include <algorithm>

namespace hapticd {
namespace {

/// True next to an end and for short strings, where the law may be stiffer than the program and its
/// rounding bear.
bool too_stiff(const StringConstants& string, double lambda, double kt) noexcept {
  const double run = std::min(lambda, 1.0 - lambda) * string.length;
  const double greatest = kMaxStringStiffness * kt;
  return string.tension > greatest * run || 4.0 * string.axial_stiffness > greatest * string.length;
}

}  // namespace

Deflection string_law(const ContactInput& input, const StringBend& bend,
                      double deflection) noexcept {
  const StringConstants& string = input.strings[static_cast<std::size_t>(bend.capsule)];
  const double kt = input.stiffness.kt;
  double compliance = std::max(0.0, 1.0 / string.contact_stiffness - 1.0 / kt);
  if (too_stiff(string, bend.lambda, kt)) compliance += 1.0 / (kMaxStringStiffness * kt);
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

StringLoad string_load(const ContactInput& input, const TouchedString* touched,
                       const StringPress& press) noexcept {
  const StringConstants& string = input.strings[static_cast<std::size_t>(press.string)];
  const double kt = input.stiffness.kt;
  const double kc = std::min(string.contact_stiffness, kt);
  const double pressed = press.F_W.norm();
  StringLoad load{pressed, 0.0, pressed / kt, 0.0};
  if (!(pressed > 0.0)) return load;
  const bool yields = touched != nullptr && touched->yields;
  const bool on_end = press.lambda <= 0.0 || press.lambda >= 1.0;
  if (yields || (on_end && string.model == StringContact::kYielding)) {
    // Next to an end, which does not yield, the program's contact is as stiff as kt.
    if (yields) {
      const Vector3& u_W = touched->bend.u_W;
      load.deflection = u_W.norm();
      // Along the normal: a string that slips aside is not pressed.
      load.displacement += deflection_share(touched->bend, press.lambda) *
                           std::max(0.0, -u_W.dot(press.F_W) / pressed);
    }
    load.force = std::min(pressed, kc * load.displacement);
    return load;
  }
  if (string.max_level < StringDetail::kStatic || !(string.length > 0.0)) return load;
  load.deflection = load.displacement / string.k_s;
  const Deflection law = deflect(string, press.lambda, load.deflection);
  load.force = std::min(law.force, kc * load.displacement);
  // Where kc bounds the force, the string's shape no longer gives it.
  if (input.instrument.lateral_force && load.force == law.force) load.lateral = law.lateral_force;
  return load;
}

}  // namespace hapticd
