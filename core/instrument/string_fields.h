// The fields of what a string keeps from tick to tick, and of its parameters, for snapshots and
// replay (core/math/state_fields.h). RT: yes.
#pragma once

#include "core/instrument/instrument_options.h"
#include "core/instrument/string_response.h"
#include "core/math/state_fields.h"

namespace hapticd {

HD_VISIT_FIELDS(EnergyTank, energy, held_force)
HD_VISIT_FIELDS(Vibration, energy, amplitude, released_energy, lambda, reach, decay, phase, t_ns,
                anchor_energy, anchor_ns)
HD_VISIT_FIELDS(ReleaseDetector, touching, inside, contact, armed, outside, slipped, deflection,
                force, normal_speed, tangential_speed, lambda, withdrawal, largest_force,
                largest_deflection, lost_deflection, lost_amplitude, unload_deflection, unload_ns,
                lost_ns, residual_re, residual_im, sounded, sounded_ns)

template <FieldsOf<StringState> State, typename Visit>
HD_REALTIME void visit_fields(State& state, Visit& visit) noexcept {
  auto& [level, detector, vibration, tank, drawn, drawn_ns] = state;
  visit.bounded(level, 0, static_cast<int>(StringPhase::kModes));
  visit(detector, vibration, tank, drawn, drawn_ns);
}

// Modes beyond the count mean nothing.
template <FieldsOf<ModalString> State, typename Visit>
HD_REALTIME void visit_fields(State& state, Visit& visit) noexcept {
  auto& [count, amplitude, phase, t_ns] = state;
  visit.bounded(count, 0, kMaxModes);
  visit.first(amplitude, count);
  visit.first(phase, count);
  visit(t_ns);
}

template <FieldsOf<StringParameters> State, typename Visit>
HD_REALTIME void visit_fields(State& state, Visit& visit) noexcept {
  auto& [p_WA, p_WB, radius, tension, youngs_modulus, axial_stiffness, linear_density, frequency,
         tuning, decay, loss_n2, touch_decay, model, k_s, contact_stiffness, inharmonicity,
         friction_coefficient, max_level] = state;
  visit(p_WA, p_WB, radius, tension, youngs_modulus, axial_stiffness, linear_density, frequency);
  visit.bounded(tuning, 0, static_cast<int>(StringTuning::kTension));
  visit(decay, loss_n2, touch_decay);
  visit.bounded(model, 0, static_cast<int>(kMaxStringContact));
  visit(k_s, contact_stiffness, inharmonicity, friction_coefficient);
  visit.bounded(max_level, 0, static_cast<int>(StringDetail::kModes));
}

HD_VISIT_FIELDS(ReleaseOptions, arm_deflection, release_gap, refractory)

template <FieldsOf<ToneOptions> State, typename Visit>
HD_REALTIME void visit_fields(State& state, Visit& visit) noexcept {
  auto& [enabled, level, reference_amplitude, reference_force, gain] = state;
  visit(enabled);
  visit.bounded(level, 0, static_cast<int>(ToneLevel::kForce));
  visit(reference_amplitude, reference_force, gain);
}

HD_VISIT_FIELDS(InstrumentOptions, vibration, pitch_glide, sleep_energy, modes, modal_steps,
                friction, anchor_stiffness, lateral_force, max_acceleration, release, tones)

}  // namespace hapticd
