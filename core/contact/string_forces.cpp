// Sums of multipliers per string, and the law of rigid ones. See string_forces.h. RT: yes.
#include "core/contact/string_forces.h"

#include <algorithm>
#include <cmath>

#include "core/contact/string_block.h"

namespace hapticd {
namespace {

/// The contact of a string, appended in ascending order when it is new; null when there is no room.
PressedString* contact_of(std::int32_t string, PressedStrings& contacts) noexcept {
  for (PressedString& contact : contacts) {
    if (contact.string == string) return &contact;
  }
  PressedString* added = contacts.append();
  if (added == nullptr) return nullptr;
  *added = PressedString{string, Vector3::Zero(), Vector3::Zero(), Vector3::Zero()};
  while (added != contacts.begin() && added->string < (added - 1)->string) {
    std::swap(*added, *(added - 1));
    --added;
  }
  return added;
}

/// Sums force, and place and lambda weighted with it.
void add_pair(const Contact& contact, double multiplier, const Vector3& direction,
              double part_compliance, PressedString& sum) noexcept {
  sum.F_W += multiplier * direction;
  sum.p_WC += multiplier * contact.p_WC;
  sum.lambda += multiplier * contact.lambda;
  sum.force += multiplier;
  sum.part_compliance += multiplier * part_compliance;
}

/// What the spring of the part yields that a sphere of the tool belongs to, m/N.
double part_compliance(const ContactInput& input, const ContactState& state,
                       TreeSphereId sphere) noexcept {
  const int k = find_part(input.parts, state.parts, sphere);
  if (k < 0) return 0.0;
  const auto part = static_cast<std::size_t>(state.parts[static_cast<std::size_t>(k)].part);
  return 1.0 / input.parts.parts[part].stiffness;
}

/// True where the string would yield, but as many do as there is room for: it is a rigid line of
/// the program, which bears what is pressed on it.
bool has_no_room(const ContactInput& input, const ContactState& state, std::int32_t string) {
  const StringConstants& constants = input.strings[static_cast<std::size_t>(string)];
  return state.touched.size() == static_cast<std::size_t>(kMaxDeflectingStrings) &&
         constants.model == StringContact::kYielding &&
         constants.max_level >= StringDetail::kStatic;
}

/// A line that does not yield gives the hand what the program presses on it, no stiffer than kc.
StringLoad line_load(double pressed, double kt, double kc) noexcept {
  const double displacement = pressed / kt;
  return {std::min(pressed, kc * displacement), 0.0, displacement, 0.0};
}

/// Turns the sums of a string into its law's force; returns what that changes of the tool's wrench.
Wrench settle(const ContactInput& input, const ContactState& state,
              PressedString& contact) noexcept {
  contact.p_WC /= contact.force;
  contact.lambda /= contact.force;
  contact.part_compliance /= contact.force;
  const double pressed = contact.F_W.norm();
  const int h = find_touched(state.touched, {ObstacleKind::kCapsule, contact.string, 0, 0});
  const TouchedString* hold = h >= 0 ? &state.touched[static_cast<std::size_t>(h)] : nullptr;
  const StringConstants& string = input.strings[static_cast<std::size_t>(contact.string)];
  const double kt = input.stiffness.kt;
  const StringLoad load =
      hold == nullptr && has_no_room(input, state, contact.string)
          ? line_load(pressed, kt, std::min(string.contact_stiffness, kt))
          : string_load(input, hold, contact.string, contact.lambda, contact.F_W);
  contact.force = load.force;
  contact.deflection = load.deflection;
  contact.displacement = load.displacement;
  if (!(pressed > 0.0)) return {};
  contact.nhat_W = contact.F_W / pressed;
  Vector3 change = (load.force - pressed) * contact.nhat_W;
  if (load.lateral != 0.0) {
    const Capsule& line = input.obstacles.capsules_W[static_cast<std::size_t>(contact.string)];
    change += load.lateral * (line.p_B - line.p_A).normalized();
  }
  contact.F_W += change;
  if (hold != nullptr) contact.F_W += hold->tangential_W;
  contact.displacement += contact.part_compliance * contact.force;
  return {change, (contact.p_WC - state.X_WG.p).cross(change)};
}

}  // namespace

StringLoad string_load(const ContactInput& input, const TouchedString* hold, std::int32_t number,
                       double lambda, const Vector3& F_W) noexcept {
  const StringConstants& string = input.strings[static_cast<std::size_t>(number)];
  const double kt = input.stiffness.kt;
  const double kc = std::min(string.contact_stiffness, kt);
  const double pressed = F_W.norm();
  StringLoad load{pressed, 0.0, pressed / kt, 0.0};
  if (!(pressed > 0.0)) return load;
  const bool yields = hold != nullptr && hold->yields;
  const bool on_end = lambda <= 0.0 || lambda >= 1.0;
  if (yields || (on_end && string.model == StringContact::kYielding)) {
    // Next to an end, which does not yield, the program's contact is as stiff as kt.
    if (yields) {
      load.deflection = hold->bend.u_W.norm();
      // Along the normal: a string that slips aside is not pressed.
      load.displacement +=
          deflection_share(hold->bend, lambda) * std::max(0.0, -hold->bend.u_W.dot(F_W) / pressed);
    }
    load.force = std::min(pressed, kc * load.displacement);
    return load;
  }
  if (string.max_level < StringDetail::kStatic || !(string.length > 0.0)) return load;
  load.deflection = load.displacement / string.k_s;
  const Deflection law = deflect(string, lambda, load.deflection);
  load.force = std::min(law.force, kc * load.displacement);
  // Where kc bounds the force, the string's shape no longer gives it.
  if (input.instrument.lateral_force && load.force == law.force) load.lateral = law.lateral_force;
  return load;
}

void find_string_contacts(const ContactInput& input, const ContactState& state,
                          const OptimiserWorkspace& w, const ContactResult& result,
                          PressedStrings& contacts, Wrench& F_H_W) noexcept {
  contacts.clear();
  F_H_W = result.F_H_W;
  for (int k = 0; k < result.active_count; ++k) {
    const ActiveContact& active = result.active[static_cast<std::size_t>(k)];
    const Contact& contact = w.contacts.contacts[static_cast<std::size_t>(active.contact)];
    if (contact.key.kind != ObstacleKind::kCapsule || !(active.multiplier > 0.0) ||
        static_cast<std::size_t>(contact.key.obstacle) >= input.strings.size()) {
      continue;
    }
    PressedString* sum = contact_of(contact.key.obstacle, contacts);
    if (sum == nullptr) continue;
    add_pair(contact, active.multiplier, gap_gradient(state, w.models, contact).linear,
             part_compliance(input, state, contact.key.tool_sphere), *sum);
    if (active.multiplier > sum->part_force) {
      sum->part_force = active.multiplier;
      sum->part = input.parts.part_of(contact.key.tool_sphere);
    }
  }
  for (PressedString& contact : contacts) {
    const Wrench change = settle(input, state, contact);
    F_H_W.f += change.f;
    F_H_W.t += change.t;
  }
}

NearestPair nearest_to_string(const ContactInput& input, const ContactState& state,
                              const ContactSet& contacts, std::int32_t string,
                              double nothing) noexcept {
  NearestPair nearest{nothing, 0.5, Vector3::Zero(), Vector3::Zero()};
  const BentObstacles bent(input.obstacles, state.touched);
  const ToolShape shape(input.parts, state.parts);
  for (const Contact& listed : contacts.contacts) {
    if (listed.key.kind != ObstacleKind::kCapsule || listed.key.obstacle != string) continue;
    const Contact contact =
        evaluate_contact(listed.key, input.tool, state.X_WG, bent.view(), shape.view());
    if (contact.gap < nearest.gap) {
      nearest = {contact.gap, contact.lambda, contact.nhat_OG_W, contact.p_WC,
                 input.parts.part_of(listed.key.tool_sphere)};
    }
  }
  return nearest;
}

}  // namespace hapticd
