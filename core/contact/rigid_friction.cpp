// See rigid_friction.h. RT: yes.
#include "core/contact/rigid_friction.h"

#include <algorithm>

namespace hapticd {
namespace {

/// Part of `v` across the unit vector `nhat`.
Vector3 across(const Vector3& v, const Vector3& nhat) noexcept { return v - nhat.dot(v) * nhat; }

/// Sums over the pairs of one object.
struct GripSum {
  Vector3 f_W{0.0, 0.0, 0.0};
  Vector3 p_WC{0.0, 0.0, 0.0};
  double multiplier = 0.0;
  std::array<double, kMaxSoftParts> of_part{};
};

int find_grip(const Grips& grips, const ContactKey& key) noexcept {
  for (std::size_t k = 0; k < grips.size(); ++k) {
    if (grips[k].kind == key.kind && grips[k].obstacle == key.obstacle) return static_cast<int>(k);
  }
  return -1;
}

double coefficient(const ContactInput& input, const ContactKey& key) noexcept {
  // Strings are the first capsules.
  const bool string =
      is_string(key) && static_cast<std::size_t>(key.obstacle) < input.strings.size();
  return string ? 0.0 : input.rigid_friction.of(key.kind, key.obstacle);
}

StickAnchor anchor_of(const ContactInput& input, const Grip& grip) noexcept {
  return {input.instrument.anchor_stiffness,
          input.rigid_friction.of(grip.kind, grip.obstacle) * grip.normal_force};
}

/// Motion of the tool's material point at the grip's centre over a step, its tangential part, m.
Vector3 slip_motion(const GripBlock& block, const ConfigurationStep& step) noexcept {
  Vector3 motion = step.tool.dp + step.tool.dtheta.cross(block.p_GC_W);
  for (std::size_t k = 0; k < block.parts; ++k) motion += block.part_share[k] * step.parts[k].dv_W;
  return across(motion, block.nhat_W);
}

/// Keeps the grips that `pressed` names, and takes up those that it has beside them.
void take_up(const ContactInput& input, std::span<const ActivePair> pressed, Grips& grips,
             int& refused) noexcept {
  std::size_t kept = 0;
  for (std::size_t k = 0; k < grips.size(); ++k) {
    const Grip& grip = grips[k];
    const bool holds = std::any_of(pressed.begin(), pressed.end(), [&](const ActivePair& pair) {
      return pair.multiplier > 0.0 && pair.key.kind == grip.kind &&
             pair.key.obstacle == grip.obstacle;
    });
    if (holds && input.rigid_friction.of(grip.kind, grip.obstacle) > 0.0) grips[kept++] = grip;
  }
  if (kept == 0) {
    grips.clear();
  } else {
    grips.truncate(kept);
  }
  for (const ActivePair& pair : pressed) {
    if (!(pair.multiplier > 0.0) || !(coefficient(input, pair.key) > 0.0) ||
        find_grip(grips, pair.key) >= 0) {
      continue;
    }
    Grip grip;
    grip.kind = pair.key.kind;
    grip.obstacle = pair.key.obstacle;
    if (!grips.push_back(grip)) ++refused;
  }
}

void place_block(const ContactInput& input, const ContactState& state, const GripSum& sum,
                 Grip& grip, GripBlock& block) noexcept {
  grip.normal_force = sum.f_W.norm();
  block.parts = state.parts.size();
  for (std::size_t p = 0; p < block.parts; ++p) {
    block.part_share[p] = sum.multiplier > 0.0 ? sum.of_part[p] / sum.multiplier : 0.0;
  }
  if (grip.normal_force > 0.0) {
    block.p_GC_W = sum.p_WC / sum.multiplier - state.X_WG.p;
    block.nhat_W = sum.f_W / grip.normal_force;
  } else {
    block.p_GC_W = Vector3::Zero();
    block.nhat_W = Vector3::Zero();
  }
  // The spring stays tangential where the contact has turned: it shortens, and gains no energy.
  block.slip_W = across(grip.slip_W, block.nhat_W);
  block.anchor = anchor_of(input, grip);
  block.slip_stiffness = block.anchor.stiffness_at(block.slip_W.norm());
  block.slipping_W = block.anchor.slipping(block.slip_W);
}

}  // namespace

void RigidFriction::build(const Configuration& at, ContactState& state, const ContactSet& contacts,
                          int& refused) noexcept {
  const ContactInput& input = at.input;
  if (input.rigid_friction.none() || !input.instrument.friction) {
    if (!state.grips.empty()) state.grips.clear();
    return;
  }
  const auto pressed = std::span(state.active).first(static_cast<std::size_t>(state.active_count));
  take_up(input, pressed, state.grips, refused);
  if (state.grips.empty()) return;
  std::array<GripSum, kMaxGrips> sums;
  for (const Contact& contact : contacts.contacts) {
    const int g = find_grip(state.grips, contact.key);
    if (g < 0) continue;
    for (const ActivePair& pair : pressed) {
      if (!(pair.key == contact.key)) continue;
      GripSum& sum = sums[static_cast<std::size_t>(g)];
      sum.f_W += pair.multiplier * contact.nhat_OG_W;
      sum.p_WC += pair.multiplier * contact.p_WC;
      sum.multiplier += pair.multiplier;
      const int part = find_part(input.parts, state.parts, pair.key.tool_sphere);
      if (part >= 0) sum.of_part[static_cast<std::size_t>(part)] += pair.multiplier;
    }
  }
  for (std::size_t k = 0; k < state.grips.size(); ++k) {
    place_block(input, state, sums[k], state.grips[k], blocks_[k]);
  }
}

double RigidFriction::energy_gain(const Configuration& at,
                                  const ConfigurationStep& step) const noexcept {
  double gain = 0.0;
  for (std::size_t k = 0; k < at.state.grips.size(); ++k) {
    const GripBlock& block = blocks_[k];
    const Vector3 slip = block.slip_W + slip_motion(block, step);
    gain += block.anchor.energy(slip.norm()) - block.anchor.energy(block.slip_W.norm());
  }
  return gain;
}

void RigidFriction::add_stored_energy(const Configuration& at, double& energy) const noexcept {
  for (std::size_t k = 0; k < at.state.grips.size(); ++k) {
    energy += 0.5 * blocks_[k].slip_stiffness * blocks_[k].slip_W.squaredNorm();
  }
}

void RigidFriction::commit(const ConfigurationStep& step, ContactState& state) const noexcept {
  for (std::size_t k = 0; k < state.grips.size(); ++k) {
    state.grips[k].slip_W = blocks_[k].slip_W + slip_motion(blocks_[k], step);
  }
}

void RigidFriction::settle(const ContactInput& input, const ContactSet& contacts,
                           const ContactResult& result, const ConfigurationStep& step,
                           ContactState& state) const noexcept {
  if (state.grips.empty()) return;
  std::array<Vector3, kMaxGrips> pressed;
  pressed.fill(Vector3(0.0, 0.0, 0.0));
  for (int k = 0; k < result.active_count; ++k) {
    const ActiveContact& active = result.active[static_cast<std::size_t>(k)];
    const Contact& contact = contacts.contacts[static_cast<std::size_t>(active.contact)];
    const int g = find_grip(state.grips, contact.key);
    if (g >= 0) pressed[static_cast<std::size_t>(g)] += active.multiplier * contact.nhat_OG_W;
  }
  for (std::size_t k = 0; k < state.grips.size(); ++k) {
    const GripBlock& block = blocks_[k];
    Grip& grip = state.grips[k];
    grip.normal_force = pressed[k].norm();
    const Vector3 f = anchor_of(input, grip).force(block.slip_W + slip_motion(block, step));
    state.F_H_W.f += f;
    state.F_H_W.t += block.p_GC_W.cross(f);
  }
}

void RigidFriction::finish(const ContactInput& input, Grips& grips) noexcept {
  for (Grip& grip : grips) grip.slip_W = anchor_of(input, grip).left_of(grip.slip_W);
}

}  // namespace hapticd
