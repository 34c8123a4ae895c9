// Sums of multipliers per string, and the law of rigid ones. See string_contact.h. RT: yes.
#include "core/rendering/string_contact.h"

#include <algorithm>
#include <cmath>

#include "core/rendering/hold_model.h"

namespace hapticd {
namespace {

/// The contact of a string, appended in ascending order when it is new; null when there is no room.
StringContact* contact_of(std::int32_t string, StringContacts& contacts) noexcept {
  for (StringContact& contact : contacts) {
    if (contact.string == string) return &contact;
  }
  StringContact* added = contacts.append();
  if (added == nullptr) return nullptr;
  *added = StringContact{string, Vector3::Zero(), Vector3::Zero(), Vector3::Zero()};
  while (added != contacts.begin() && added->string < (added - 1)->string) {
    std::swap(*added, *(added - 1));
    --added;
  }
  return added;
}

/// Sums force, and place and lambda weighted with it.
void add_pair(const Contact& contact, double multiplier, const Vector3& direction,
              double part_compliance, StringContact& sum) noexcept {
  sum.F_W += multiplier * direction;
  sum.p_WC += multiplier * contact.p_WC;
  sum.lambda += multiplier * contact.lambda;
  sum.force += multiplier;
  sum.part_compliance += multiplier * part_compliance;
}

/// What the spring of the part yields that a sphere of the tool belongs to, m/N.
double part_compliance(const OptimiserInput& input, const OptimiserState& state,
                       TreeSphereId sphere) noexcept {
  const int k = find_part(input.parts, state.parts, sphere);
  if (k < 0) return 0.0;
  const auto part = static_cast<std::size_t>(state.parts[static_cast<std::size_t>(k)].part);
  return 1.0 / input.parts.parts[part].stiffness;
}

/// F_r of a string that does not yield, per unit of the contact force.
double rigid_share(const StringConstants& string, double kt, StringContact& contact) noexcept {
  const double D = contact.force / kt;
  if (string.max_level < StringLevel::kStatic || !(string.length > 0.0)) {
    contact.deflection = 0.0;
    return 1.0;
  }
  contact.deflection = D / string.k_s;
  const double force = std::min(deflection_force(string, contact.lambda, contact.deflection),
                                std::min(string.contact_stiffness, kt) * D);
  return force / contact.force;
}

/// Of a string that yields, in the program or with the program's force at its ends, which do not:
/// never more than kc D. Next to an end a tool rests on the short half or on the end itself, and
/// the program's contact is as stiff as kt there.
double yielding_share(const StringConstants& string, const StringHold* hold, double kt,
                      StringContact& contact) noexcept {
  contact.deflection = 0.0;
  if (hold != nullptr) {
    contact.deflection = hold->bend.u_W.norm();
    // Along the normal: a string that slips aside is not pressed.
    contact.displacement += deflection_share(hold->bend, contact.lambda) *
                            std::max(0.0, -hold->bend.u_W.dot(contact.nhat_W));
  }
  const double most = std::min(string.contact_stiffness, kt) * contact.displacement;
  return most < contact.force ? most / contact.force : 1.0;
}

/// Turns the sums of a string into its law's force; returns what that changes of the tool's wrench.
Wrench settle(const OptimiserInput& input, const OptimiserState& state,
              StringContact& contact) noexcept {
  contact.p_WC /= contact.force;
  contact.lambda /= contact.force;
  contact.part_compliance /= contact.force;
  contact.force = contact.F_W.norm();
  if (!(contact.force > 0.0)) return {};
  contact.nhat_W = contact.F_W / contact.force;
  const StringConstants& string = input.strings[static_cast<std::size_t>(contact.string)];
  contact.displacement = contact.force / input.stiffness.kt;
  const int h = find_hold(state.holds, {ObstacleKind::kCapsule, contact.string, 0, 0});
  const StringHold* hold = h >= 0 ? &state.holds[static_cast<std::size_t>(h)] : nullptr;
  if (hold != nullptr) contact.F_W += hold->tangential_W;
  const bool yields = hold != nullptr && hold->yields;
  const bool on_end = contact.lambda <= 0.0 || contact.lambda >= 1.0;
  const double kt = input.stiffness.kt;
  const double share = yields || (on_end && string.model == StringModel::kDeflecting)
                           ? yielding_share(string, hold, kt, contact)
                           : rigid_share(string, kt, contact);
  contact.displacement += contact.part_compliance * contact.force;
  if (share == 1.0) return {};
  const Vector3 change = (share - 1.0) * contact.F_W;
  contact.F_W *= share;
  contact.force *= share;
  return {change, (contact.p_WC - state.X_WG.p).cross(change)};
}

}  // namespace

void find_string_contacts(const OptimiserInput& input, const OptimiserState& state,
                          const OptimiserWorkspace& w, const OptimiserResult& result,
                          StringContacts& contacts, Wrench& F_H_W) noexcept {
  contacts.clear();
  F_H_W = result.F_H_W;
  for (int k = 0; k < result.active_count; ++k) {
    const ActiveContact& active = result.active[static_cast<std::size_t>(k)];
    const Contact& contact = w.contacts.contacts[static_cast<std::size_t>(active.contact)];
    if (contact.key.kind != ObstacleKind::kCapsule || !(active.multiplier > 0.0) ||
        static_cast<std::size_t>(contact.key.obstacle) >= input.strings.size()) {
      continue;
    }
    StringContact* sum = contact_of(contact.key.obstacle, contacts);
    if (sum == nullptr) continue;
    add_pair(contact, active.multiplier, force_direction(state, w.models, contact),
             part_compliance(input, state, contact.key.tool_sphere), *sum);
  }
  for (StringContact& contact : contacts) {
    const Wrench change = settle(input, state, contact);
    F_H_W.f += change.f;
    F_H_W.t += change.t;
  }
}

StringNearness nearest_to_string(const OptimiserInput& input, const OptimiserState& state,
                                 const OptimiserWorkspace& w, std::int32_t string,
                                 double nothing) noexcept {
  StringNearness nearest{nothing, 0.5, Vector3::Zero(), Vector3::Zero()};
  const BentObstacles bent(input.obstacles, state.holds);
  const ToolShape shape(input.parts, state.parts);
  for (const Contact& listed : w.contacts.contacts) {
    if (listed.key.kind != ObstacleKind::kCapsule || listed.key.obstacle != string) continue;
    const Contact contact =
        evaluate_contact(listed.key, input.tool, state.X_WG, bent.view(), shape.view());
    if (contact.gap < nearest.gap) {
      nearest = {contact.gap, contact.lambda, contact.nhat_OG_W, contact.p_WC};
    }
  }
  return nearest;
}

}  // namespace hapticd
