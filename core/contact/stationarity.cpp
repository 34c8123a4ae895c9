// The balance of forces. See stationarity.h. RT: yes.
#include "core/contact/stationarity.h"

#include <algorithm>
#include <cmath>

#include "core/collision/primitive_gap.h"
#include "core/contact/string_block.h"

namespace hapticd {
namespace {

/// True where friction or lateral force may act on the tool.
bool pulled_aside(const ContactInput& input, const ContactState& state) noexcept {
  for (const TouchedString& hold : state.touched) {
    const auto string = static_cast<std::size_t>(hold.bend.capsule);
    if (input.instrument.lateral_force && hold.yields) return true;
    if (input.instrument.friction && input.strings[string].friction_coefficient > 0.0) return true;
  }
  return false;
}

}  // namespace

bool is_stationary(const ContactInput& input, const ContactState& state, const PoseError& error_GH,
                   OptimiserWorkspace& w, const ContactResult& result, Wrench& F_H_W) noexcept {
  if (result.active_count == 0 || pulled_aside(input, state)) return false;
  const double tolerance = kSettledShare * input.options.stop_tolerance;
  int unknowns = kToolDof;
  if (!state.parts.empty()) {
    unknowns = model_parts(input.parts, rotation_matrix(state.X_WG.q), input.stiffness.kt, input.dt,
                           state.parts, unknowns, w.parts);
  }
  if (!state.touched.empty()) {
    static_cast<void>(model_strings(input, w.contacts, state, unknowns, w.models));
  }
  F_H_W = Wrench{};
  std::array<Vector3, kMaxDeflectingStrings> pulled;
  for (std::size_t k = 0; k < state.touched.size(); ++k) {
    pulled[k] = -w.models[k].force * w.models[k].radial_W;
  }
  std::array<Vector3, kMaxSoftParts> pushed;
  for (std::size_t k = 0; k < state.parts.size(); ++k) pushed[k] = w.parts[k].pull_W;
  for (int k = 0; k < result.active_count; ++k) {
    const ActiveContact& active = result.active[static_cast<std::size_t>(k)];
    const Contact& contact = w.contacts.contacts[static_cast<std::size_t>(active.contact)];
    // A row that bears force would take its gap to the skin.
    if (active.multiplier > 0.0 && std::abs(contact.gap - input.options.skin) > tolerance) {
      return false;
    }
    const GapGradient gradient = gap_gradient(state, w.models, contact);
    F_H_W.f += active.multiplier * gradient.linear;
    F_H_W.t += active.multiplier * gradient.angular;
    const int own = find_part(input.parts, state.parts, contact.key.tool_sphere);
    for (std::size_t p = 0; p < state.parts.size(); ++p) {
      pushed[p] += active.multiplier *
                   part_gradient(w.models, contact, gradient, p, own == static_cast<int>(p));
    }
    if (gradient.hold < 0) continue;
    const auto s = static_cast<std::size_t>(gradient.hold);
    const StringBend& bend = state.touched[s].bend;
    pulled[s] -= (active.multiplier * deflection_share(bend, contact.lambda)) * contact.nhat_OG_W;
  }
  const ToolMotion wanted{error_GH.dp + F_H_W.f / input.stiffness.kt,
                          error_GH.dtheta + F_H_W.t / input.stiffness.kr()};
  if (displacement_bound(wanted, tool_reach(input.tool, state)) > tolerance) return false;
  for (std::size_t k = 0; k < state.parts.size(); ++k) {
    const PartBlock& part = w.parts[k];
    if (part.unknown >= 0 && pushed[k].norm() > tolerance * part.stiffness) return false;
  }
  for (std::size_t k = 0; k < state.touched.size(); ++k) {
    const StringBlock& hold = w.models[k];
    if (hold.unknown < 0) continue;
    const double radial = std::abs(pulled[k].dot(hold.radial_W)) / hold.radial_stiffness;
    const double tangential =
        std::abs(pulled[k].dot(hold.tangential_W)) / hold.tangential_stiffness;
    if (std::max(radial, tangential) > tolerance) return false;
  }
  return true;
}

}  // namespace hapticd
