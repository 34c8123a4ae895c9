// Sums of multipliers per string, and the law of rigid ones. See string_forces.h. RT: yes.
#include "core/contact/string_forces.h"

#include <algorithm>
#include <cmath>

#include "core/contact/coupling_axes.h"

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

/// What a pair that bears force adds to its string.
struct PairShare {
  double multiplier;  ///< N
  Vector3 direction;  ///< of its force on the tool
  double part_compliance;
  double radius;  ///< of the tool's sphere, m
};

/// Sums force, and place and lambda weighted with it.
void add_pair(const Contact& contact, const PairShare& pair, PressedString& sum) noexcept {
  sum.F_W += pair.multiplier * pair.direction;
  sum.p_WC += pair.multiplier * contact.p_WC;
  sum.lambda += pair.multiplier * contact.lambda;
  sum.force += pair.multiplier;
  sum.radius += pair.multiplier * pair.radius;
  sum.part_compliance += pair.multiplier * pair.part_compliance;
}

/// What the spring of the part yields that a sphere of the tool belongs to, m/N.
double part_compliance(const Configuration& at, TreeSphereId sphere) noexcept {
  const int k = find_part(at.input.parts, at.state.parts, sphere);
  if (k < 0) return 0.0;
  const auto part = static_cast<std::size_t>(at.state.parts[static_cast<std::size_t>(k)].part);
  return 1.0 / at.input.parts.parts[part].stiffness;
}

/// True where the string would yield, but as many do as there is room for: it is a rigid line of
/// the program, which bears what is pressed on it.
bool has_no_room(const Configuration& at, std::int32_t string) noexcept {
  const StringConstants& constants = at.input.strings[static_cast<std::size_t>(string)];
  return at.state.touched.size() == static_cast<std::size_t>(kMaxDeflectingStrings) &&
         yields(constants) && bends(constants);
}

/// A line that does not yield gives the hand what the program presses on it, no stiffer than kc.
StringLoad line_load(const CouplingStiffness& stiffness, double kc, double pressed,
                     const Vector3& F_W) noexcept {
  const double depth = pressed > 0.0 ? depth_under(stiffness, pressed, F_W / pressed) : 0.0;
  return {std::min(pressed, kc * (pressed / stiffness.kt)), 0.0, depth, 0.0};
}

/// Turns the sums of a string into its law's force; returns what that changes of the tool's wrench.
Wrench settle(const Configuration& at, PressedString& contact) noexcept {
  const auto& [input, state] = at;
  contact.p_WC /= contact.force;
  contact.lambda /= contact.force;
  contact.radius /= contact.force;
  contact.part_compliance /= contact.force;
  const double pressed = contact.F_W.norm();
  const int k = find_touched(state.touched, contact.string);
  const TouchedString* touched = k >= 0 ? &state.touched[static_cast<std::size_t>(k)] : nullptr;
  const StringConstants& string = input.strings[static_cast<std::size_t>(contact.string)];
  const double kc = std::min(string.contact_stiffness, input.stiffness.kt);
  const StringLoad load =
      touched == nullptr && has_no_room(at, contact.string)
          ? line_load(input.stiffness, kc, pressed, contact.F_W)
          : string_load(input, touched, {contact.string, contact.lambda, contact.F_W});
  contact.force = load.force;
  contact.deflection = load.deflection;
  contact.displacement = load.displacement;
  if (!(pressed > 0.0)) return {};
  contact.nhat_W = contact.F_W / pressed;
  const Vector3 change = (load.force - pressed) * contact.nhat_W;
  const Vector3 p_GC_W = contact.p_WC - state.X_WG.p;
  Wrench wrench{change, p_GC_W.cross(change)};
  contact.F_W += change;
  if (load.lateral != 0.0) {
    // At the centres of the spheres, which say where along the string it is.
    const Capsule& line = input.obstacles.capsules_W[static_cast<std::size_t>(contact.string)];
    const Vector3 f = load.lateral * (line.p_B - line.p_A).normalized();
    contact.F_W += f;
    wrench.f += f;
    wrench.t += (p_GC_W + contact.radius * contact.nhat_W).cross(f);
  }
  if (touched != nullptr) contact.F_W += touched->tangential_W;
  contact.displacement += contact.part_compliance * contact.force;
  return wrench;
}

}  // namespace

void find_string_contacts(const ContactView& view, PressedStrings& contacts,
                          Wrench& F_H_W) noexcept {
  contacts.clear();
  F_H_W = view.result.F_H_W;
  for (int k = 0; k < view.result.active_count; ++k) {
    const ActiveContact& active = view.result.active[static_cast<std::size_t>(k)];
    const Contact& contact = view.contact_of(active);
    if (!is_string(contact.key) || !(active.multiplier > 0.0) ||
        static_cast<std::size_t>(contact.key.obstacle) >= view.input.strings.size()) {
      continue;
    }
    PressedString* sum = contact_of(contact.key.obstacle, contacts);
    if (sum == nullptr) continue;
    add_pair(contact,
             {active.multiplier, view.strings.gradient(view.state, contact).linear,
              part_compliance(view.at(), contact.key.tool_sphere),
              tree_sphere(view.input.tool, contact.key.tool_sphere).r},
             *sum);
    if (active.multiplier > sum->part_force) {
      sum->part_force = active.multiplier;
      sum->part = view.input.parts.part_of(contact.key.tool_sphere);
    }
  }
  for (PressedString& contact : contacts) {
    const Wrench change = settle(view.at(), contact);
    F_H_W.f += change.f;
    F_H_W.t += change.t;
  }
}

std::optional<NearestPair> nearest_to_string(const Configuration& at, const ContactSet& contacts,
                                             std::int32_t string) noexcept {
  const auto& [input, state] = at;
  std::optional<NearestPair> nearest;
  const BentObstacles bent(input.obstacles, state.touched);
  const ToolShape shape(input.parts, state.parts);
  for (const Contact& listed : contacts.contacts) {
    if (!is_string(listed.key) || listed.key.obstacle != string) continue;
    const Contact contact =
        evaluate_contact(listed.key, {input.tool, state.X_WG, shape.view()}, bent.view());
    if (!nearest || contact.gap < nearest->gap) {
      nearest = NearestPair{contact.gap,
                            contact.lambda,
                            contact.nhat_OG_W,
                            contact.p_WC,
                            input.parts.part_of(listed.key.tool_sphere),
                            tree_sphere(input.tool, listed.key.tool_sphere).r};
    }
  }
  return nearest;
}

}  // namespace hapticd
