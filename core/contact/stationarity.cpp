// The balance of forces. See stationarity.h. RT: yes.
#include "core/contact/stationarity.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <span>

#include "core/contact/coupling_axes.h"

namespace hapticd {
namespace {

/// What acts on the unknowns of strings and soft parts, N.
struct Pulls {
  std::array<Vector3, kMaxDeflectingStrings> string;
  std::array<Vector3, kMaxSoftParts> part;
};

/// Adds what a pair presses on tool, soft parts and string.
void add_pair(const ContactView& view, const ActiveContact& active, Wrench& F_H_W,
              Pulls& pulls) noexcept {
  const ContactState& state = view.state;
  const Contact& contact = view.contact_of(active);
  const GapGradient gradient = view.strings.gradient(state, contact);
  F_H_W.f += active.multiplier * gradient.linear;
  F_H_W.t += active.multiplier * gradient.angular;
  const int own = find_part(view.input.parts, state.parts, contact.key.tool_sphere);
  for (std::size_t p = 0; p < state.parts.size(); ++p) {
    pulls.part[p] += active.multiplier *
                     view.strings.part_gradient(contact, gradient, p, own == static_cast<int>(p));
  }
  if (gradient.string < 0) return;
  const auto s = static_cast<std::size_t>(gradient.string);
  const double share = deflection_share(state.touched[s].bend, contact.lambda);
  pulls.string[s] -= (active.multiplier * share) * contact.nhat_OG_W;
}

/// Adds what a string pulls tool and soft parts by along its axis.
void add_lateral(const StringBlock& block, Wrench& F_H_W, Pulls& pulls) noexcept {
  if (block.lateral_force == 0.0) return;
  const Vector3 f = block.lateral_force * block.axis_W;
  F_H_W.f += f;
  F_H_W.t += block.p_GS_W.cross(f);
  for (std::size_t p = 0; p < block.parts; ++p) pulls.part[p] += block.part_share[p] * f;
}

/// Adds what an anchor does at `p_GC_W` to tool and soft parts, by their shares.
void add_anchor(const Vector3& f, const Vector3& p_GC_W, std::span<const double> part_share,
                Wrench& F_H_W, Pulls& pulls) noexcept {
  F_H_W.f += f;
  F_H_W.t += p_GC_W.cross(f);
  for (std::size_t p = 0; p < part_share.size(); ++p) pulls.part[p] += part_share[p] * f;
}

/// Adds friction as the stick anchors stand.
void add_friction(const ContactView& view, Wrench& F_H_W, Pulls& pulls) noexcept {
  for (std::size_t k = 0; k < view.state.touched.size(); ++k) {
    const StringBlock& block = view.strings.block(k);
    if (block.slip_stiffness == 0.0) continue;
    const Vector3 f = -block.slip_stiffness * block.slip_W;
    add_anchor(f, block.p_GC_W, std::span(block.part_share).first(block.parts), F_H_W, pulls);
    if (block.unknown < 0) continue;
    pulls.string[k] -= deflection_share(view.state.touched[k].bend, block.lambda) * f;
  }
  for (std::size_t k = 0; k < view.state.grips.size(); ++k) {
    const GripBlock& block = view.friction.block(k);
    add_anchor(-block.slip_stiffness * block.slip_W, block.p_GC_W,
               std::span(block.part_share).first(block.parts), F_H_W, pulls);
  }
}

bool balanced(const ContactView& view, const Pulls& pulls, double tolerance) noexcept {
  for (std::size_t k = 0; k < view.state.parts.size(); ++k) {
    const PartBlock& part = view.parts.block(k);
    if (part.unknown >= 0 && pulls.part[k].norm() > tolerance * part.stiffness) return false;
  }
  for (std::size_t k = 0; k < view.state.touched.size(); ++k) {
    const StringBlock& block = view.strings.block(k);
    if (block.unknown < 0) continue;
    const double radial = std::abs(pulls.string[k].dot(block.radial_W)) / block.radial_stiffness;
    const double tangential =
        std::abs(pulls.string[k].dot(block.tangential_W)) / block.tangential_stiffness;
    if (std::max(radial, tangential) > tolerance) return false;
  }
  return true;
}

}  // namespace

std::optional<Wrench> balanced_wrench(const ContactView& view, const PoseError& error_GH) noexcept {
  const double tolerance = kSettledShare * view.input.options.stop_tolerance;
  Wrench F_H_W;
  Pulls pulls;
  for (std::size_t k = 0; k < view.state.touched.size(); ++k) {
    const StringBlock& block = view.strings.block(k);
    pulls.string[k] = -block.force * block.radial_W;
  }
  for (std::size_t k = 0; k < view.state.parts.size(); ++k) {
    pulls.part[k] = view.parts.block(k).pull_W;
  }
  for (std::size_t k = 0; k < view.state.touched.size(); ++k) {
    add_lateral(view.strings.block(k), F_H_W, pulls);
  }
  for (int k = 0; k < view.result.active_count; ++k) {
    const ActiveContact& active = view.result.active[static_cast<std::size_t>(k)];
    // A row that bears force would take its gap to the clearance.
    if (active.multiplier > 0.0 &&
        std::abs(view.contact_of(active).gap - view.state.clearance) > tolerance) {
      return std::nullopt;
    }
    add_pair(view, active, F_H_W, pulls);
  }
  add_friction(view, F_H_W, pulls);
  const PoseError held = stretch_under(view.input.stiffness, view.input.X_WH.q, error_GH, F_H_W);
  const ToolMotion wanted{error_GH.dp - held.dp, error_GH.dtheta - held.dtheta};
  if (displacement_bound(wanted, tool_reach(view.at())) > tolerance) return std::nullopt;
  if (!balanced(view, pulls, tolerance)) return std::nullopt;
  return F_H_W;
}

}  // namespace hapticd
