// Friction between a tool and what is rigid: one stick anchor (stick_anchor.h) per body, and per
// capsule of a line, at the centre of the force between them. It adds no unknowns: the anchors are
// springs of the program, and what slips follows in the next linearisation. Friction on strings is
// YieldingStrings'. Frames: W. SI. RT: yes, about 0.2 us per object touched, nothing without
// friction.
#pragma once

#include <array>
#include <cstddef>

#include "core/contact/contact_result.h"
#include "core/contact/stick_anchor.h"
#include "core/contact/unknowns.h"

namespace hapticd {

/// A grip around the present configuration: what the program of a linearisation needs.
struct GripBlock {
  Vector3 p_GC_W;         ///< centre of the contact from G, m
  Vector3 nhat_W;         ///< mean normal, from the object to the tool, unit
  Vector3 slip_W;         ///< of the anchor, tangential to this contact, m
  StickAnchor anchor;     ///< with what the last program pressed
  double slip_stiffness;  ///< around the present slip, N/m,
  Vector3 slipping_W;     ///< but for this unit direction, in which it slips; zero: it sticks
  /// Share of each soft part of the state in the contact.
  std::array<double, kMaxSoftParts> part_share;
  std::size_t parts;
};

/// The grips of one tool on rigid objects; what they are between ticks stands in
/// ContactState::grips.
class RigidFriction {
 public:
  /// Takes up the objects that bore force in the last program and have friction, and lets go of the
  /// others; moves nothing. Objects beyond the capacity are smooth and counted in `refused`.
  HD_REALTIME void build(const Configuration& at, ContactState& state, const ContactSet& contacts,
                         int& refused) noexcept;

  /// What a step adds to the energy of the anchors, J.
  [[nodiscard]] HD_REALTIME double energy_gain(const Configuration& at,
                                               const ConfigurationStep& step) const noexcept;
  HD_REALTIME void add_stored_energy(const Configuration& at, double& energy) const noexcept;
  /// Goes the step.
  HD_REALTIME void commit(const ConfigurationStep& step, ContactState& state) const noexcept;

  /// Adds to state.F_H_W what the anchors do to the tool at the end of the full `step`, within mu
  /// times what the pairs of `result` press.
  HD_REALTIME void settle(const ContactInput& input, const ContactSet& contacts,
                          const ContactResult& result, const ConfigurationStep& step,
                          ContactState& state) const noexcept;

  /// Ends a tick: what slips takes its anchor along.
  HD_REALTIME static void finish(const ContactInput& input, Grips& grips) noexcept;

  /// Of grip number `k` of the state, as the last build left it.
  [[nodiscard]] const GripBlock& block(std::size_t k) const noexcept { return blocks_[k]; }

 private:
  std::array<GripBlock, kMaxGrips> blocks_;
};

}  // namespace hapticd
