// Builds the models of the held strings around the present configuration. See string_hold.h. RT:
// yes, about 0.2 us per string.
#pragma once

#include "core/rendering/configuration_optimiser.h"

namespace hapticd {

/// Models of all holds of `state` at its pose, from the contacts and from the pairs that carried
/// force last; the first unknown is number `unknowns`. Returns the number of unknowns of the
/// program.
[[nodiscard]] HD_REALTIME int model_holds(const OptimiserInput& input, const ContactSet& contacts,
                                          const OptimiserState& state, int unknowns,
                                          HoldModels& models) noexcept;

/// A row's derivative with respect to the tool's motion: the normal, without what the vertex's
/// sliding along with the contact cancels of it.
[[nodiscard]] HD_REALTIME Vector3 sliding_normal(const HoldModel& model, const StringBend& bend,
                                                 const Contact& contact) noexcept;

/// Direction of the force that a row's multiplier means: sliding_normal of a held string, else the
/// normal.
[[nodiscard]] HD_REALTIME Vector3 force_direction(const OptimiserState& state,
                                                  const HoldModels& models,
                                                  const Contact& contact) noexcept;

/// How far the step takes the tool's material point at the contact's centre, m.
[[nodiscard]] HD_REALTIME Vector3 contact_motion(const HoldModel& model,
                                                 const ConfigurationStep& step) noexcept;

/// How far the step moves the vertex along the string: with the contact, and to its centre.
[[nodiscard]] HD_REALTIME double vertex_motion(const HoldModel& model, const StringBend& bend,
                                               const ConfigurationStep& step, double skin) noexcept;

/// Motion of the tool's material point against the string's at the contact's centre over a step,
/// its tangential part, m.
[[nodiscard]] HD_REALTIME Vector3 slip_motion(const HoldModel& model, const StringBend& bend,
                                              const ConfigurationStep& step,
                                              const Vector3& du_W) noexcept;

}  // namespace hapticd
