// Builds the models of the held strings around the present configuration. See touched_string.h. RT:
// yes, about 0.2 us per string.
#pragma once

#include "core/contact/contact_problem.h"

namespace hapticd {

/// Models of all holds of `state` at its pose, from the contacts and from the pairs that carried
/// force last; the first unknown is number `unknowns`. Returns the number of unknowns of the
/// program.
[[nodiscard]] HD_REALTIME int model_strings(const ContactInput& input, const ContactSet& contacts,
                                            const ContactState& state, int unknowns,
                                            StringBlocks& models) noexcept;

/// Derivative of a contact's gap with respect to the step of the tool, and equally the wrench of a
/// unit multiplier on it, about the origin of G: the normal at the contact, without what the
/// vertex's sliding along with the centre of the contact cancels of it.
struct GapGradient {
  Vector3 linear;
  Vector3 angular;
  int hold = -1;      ///< of the string that is touched, or -1
  double slid = 0.0;  ///< linear = normal - slid * axis of the string
};
[[nodiscard]] HD_REALTIME GapGradient gap_gradient(const ContactState& state,
                                                   const StringBlocks& models,
                                                   const Contact& contact) noexcept;

/// The same with respect to soft part number `part` of the state, which the contact's sphere
/// belongs to if it is its `own`.
[[nodiscard]] HD_REALTIME Vector3 part_gradient(const StringBlocks& models, const Contact& contact,
                                                const GapGradient& gradient, std::size_t part,
                                                bool own) noexcept;

/// How far the step takes the tool's material point at the contact's centre, m.
[[nodiscard]] HD_REALTIME Vector3 contact_motion(const StringBlock& model,
                                                 const ConfigurationStep& step) noexcept;

/// The string's motion in `step` when its vertex moves by `du_W` across the axis: along it goes
/// with the contact, and to its centre as far as that changes no gap by more than `room`, m.
[[nodiscard]] HD_REALTIME StringMotion string_motion(const StringBlock& model,
                                                     const StringBend& bend,
                                                     const ConfigurationStep& step,
                                                     const Vector3& du_W, double room) noexcept;

/// Motion of the tool's material point against the string's at the contact's centre over a step,
/// its tangential part, m.
[[nodiscard]] HD_REALTIME Vector3 slip_motion(const StringBlock& model, const StringBend& bend,
                                              const ConfigurationStep& step,
                                              const Vector3& du_W) noexcept;

}  // namespace hapticd
