// What a linearisation solves for beside the motion of the tool: groups of unknowns, each of which
// knows its own law. The tool's six come first, then three of each soft part, then two of each
// string that yields. Sums over both groups take strings first: both orders are part of the
// results. Frames: W. SI.
#pragma once

#include <array>
#include <concepts>

#include "core/collision/contact.h"
#include "core/contact/configuration.h"
#include "core/math/limits.h"

namespace hapticd {

/// The unknowns y of a linearisation: [dp; dtheta; dv of the soft parts; du of the strings].
using Unknowns = std::array<double, kMaxQpUnknowns>;

/// Units in which coupling and springs are the identity, and the downhill gradient of the energy.
struct UnknownScale {
  Unknowns inverse_root;
  Unknowns downhill;
};

/// A group of unknowns: what SoftParts and YieldingStrings have in common.
/// `build` models what is touched around the present configuration and numbers its unknowns from
/// `unknowns` on; returns the number after its last. `measure` gives units and gradient of what
/// lies along one unknown alone. `read_step` says what the unknowns mean, once the tool's part of
/// the step is known. `travel` bounds how far a step moves any point of the group, m. `energy_gain`
/// is what a step adds to its energy, J; `add_stored_energy` adds what it can give. `commit` goes
/// the step.
template <typename Group>
concept UnknownGroup = requires(Group& group, const Group& built, const Configuration& at,
                                const ContactSet& contacts, ContactState& state, const Unknowns& y,
                                UnknownScale& scale, ConfigurationStep& step, double& energy) {
  { group.build(at, contacts, kToolDof) }
  noexcept->std::same_as<int>;
  { built.measure(at.state, scale) }
  noexcept;
  { built.read_step(at, y, step) }
  noexcept;
  { built.travel(at, step) }
  noexcept->std::same_as<double>;
  { built.energy_gain(at, step) }
  noexcept->std::same_as<double>;
  { built.add_stored_energy(at, energy) }
  noexcept;
  { built.commit(at.input, step, state) }
  noexcept;
};

}  // namespace hapticd
