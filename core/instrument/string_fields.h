// The fields of what a string keeps from tick to tick, and of its parameters, for snapshots and
// replay (core/math/state_fields.h). RT: yes.
#pragma once

#include "core/instrument/instrument_options.h"
#include "core/instrument/string_response.h"
#include "core/instrument/wave_state.h"
#include "core/math/state_fields.h"

namespace hapticd {

HD_VISIT_FIELDS(EnergyTank, full, energy, held_force)
HD_VISIT_FIELDS(Vibration, energy, amplitude, released_energy, lambda, decay, phase, t_ns,
                anchor_energy, anchor_ns)
HD_VISIT_FIELDS(ReleaseDetector, touching, inside, contact, armed, outside, slipped, deflection,
                force, normal_speed, tangential_speed, lambda, withdrawal, largest_force,
                largest_deflection, lost_deflection, lost_ns, sounded, sounded_ns)

template <FieldsOf<StringState> State, typename Visit>
HD_REALTIME void visit_fields(State& state, Visit& visit) noexcept {
  auto& [level, detector, vibration, tank, granted_ns] = state;
  visit.bounded(level, 0, static_cast<int>(StringPhase::kFundamental));
  visit(detector, vibration, tank, granted_ns);
}

HD_VISIT_FIELDS(Transverse, y, z)

template <FieldsOf<WaveTuning> State, typename Visit>
HD_REALTIME void visit_fields(State& state, Visit& visit) noexcept {
  auto& [length, tension, frequency, modal_mass, inharmonicity, decay, loss_n2, modes, substeps] =
      state;
  visit(length, tension, frequency, modal_mass, inharmonicity, decay, loss_n2);
  visit.bounded(modes, 0, kMaxModes);
  visit.bounded(substeps, 8, 64);
}

HD_VISIT_FIELDS(WaveGrip, touching, armed, began_ns, felt_ns, pressed_ns, energy_before, lambda,
                share, deflection, largest_force, normal_speed, tangential_speed)
HD_VISIT_FIELDS(WaveTank, energy, let_go, beyond, law, pull, stored)
HD_VISIT_FIELDS(ToldEnvelope, t_ns, amplitude, decay)
HD_VISIT_FIELDS(ToldSounding, sounds, plucked, t_ns, looked_ns, paced_ns, number, from, to, place,
                frequency, cents_per_s, onset, pitch, pitch_ns, amplitude, decay, heard)

template <FieldsOf<StringContactPath> State, typename Visit>
HD_REALTIME void visit_fields(State& state, Visit& visit) noexcept {
  auto& [shape, lambda_from, lambda_to, d_from, d_to, normal, radius, radius_from, stiffness,
         damping, friction, bristle, slope, stretched, force, work, stored, touched, first, last] =
      state;
  visit.bounded(shape, 0, static_cast<int>(StringContactShape::kPlane));
  visit(lambda_from, lambda_to, d_from, d_to, normal, radius, radius_from, stiffness, damping,
        friction, bristle, slope, stretched, force, work, stored, touched, first, last);
}

// One that is not near begins anew.
template <FieldsOf<WaveContact> State, typename Visit>
HD_REALTIME void visit_fields(State& state, Visit& visit) noexcept {
  auto& [near, firm, path, centre, reach, push, lacking, held, speed, astray, load] = state;
  visit(near);
  if (near) visit(firm, path, centre, reach, push, lacking, held, speed, astray, load);
}

template <FieldsOf<WaveRest> State, typename Visit>
HD_REALTIME void visit_fields(State& state, Visit& visit) noexcept {
  auto& [number, path, lacking, load, share] = state;
  visit(number);
  if (number >= 0) visit(path, lacking, load, share);
}

// Modes beyond the count mean nothing.
template <FieldsOf<WaveString> State, typename Visit>
HD_REALTIME void visit_fields(State& state, Visit& visit) noexcept {
  auto& [tuning, count, motion, done_ns, contacts, rests] = state;
  visit(tuning);
  visit.bounded(count, 0, kMaxModes);
  visit.first(motion.qy, count);
  visit.first(motion.qz, count);
  visit.first(motion.vy, count);
  visit.first(motion.vz, count);
  visit(done_ns, contacts, rests);
}

// Of one asleep only what it may give, and when it sounded, is kept.
template <FieldsOf<WaveState> State, typename Visit>
HD_REALTIME void visit_fields(State& state, Visit& visit) noexcept {
  auto& [awake, stepped, sounded, player, sounded_ns, ringing, stored, string, released,
         held_tension, grips, tank, told, sounding] = state;
  visit(awake, stepped, sounded);
  visit.bounded(player, 0, static_cast<std::int64_t>(kMaxTools) - 1);
  visit(sounded_ns, ringing, stored, released, held_tension, tank, told, sounding.number);
  if (awake) visit(string, grips, sounding);
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

// How often modes are stepped is the scene's alone: nothing changes it while the scene is played,
// and recordings from before it was asked for can be read.
template <FieldsOf<InstrumentOptions> State, typename Visit>
HD_REALTIME void visit_fields(State& state, Visit& visit) noexcept {
  auto& [vibration, pitch_glide, sleep_energy, modes, substeps, friction, anchor_stiffness,
         lateral_force, max_acceleration, release, tones] = state;
  static_cast<void>(substeps);
  visit(vibration, pitch_glide, sleep_energy, modes, friction, anchor_stiffness, lateral_force,
        max_acceleration, release, tones);
}

}  // namespace hapticd
