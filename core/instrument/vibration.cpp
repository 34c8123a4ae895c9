// The fundamental after a release: energy in closed form, phase by accumulation. RT: yes.
#include "core/instrument/vibration.h"

#include <algorithm>
#include <cmath>

#include "core/instrument/deflection.h"
#include "core/instrument/mode_series.h"
#include "core/math/elementary.h"

namespace hapticd {

double fundamental_energy(const StringConstants& string, double amplitude) noexcept {
  if (!(string.length > 0.0)) return 0.0;
  return kPi * kPi * string.tension * amplitude * amplitude / (4.0 * string.length);
}

double fundamental_amplitude(const StringConstants& string, double energy) noexcept {
  if (!(string.tension > 0.0)) return 0.0;
  return std::sqrt(energy * (4.0 * string.length / (kPi * kPi * string.tension)));
}

Vibration start_vibration(const StringConstants& string, double energy, double lambda,
                          std::int64_t t_ns) noexcept {
  Vibration vibration;
  vibration.released_energy = energy;
  vibration.lambda = lambda;
  vibration.decay = string.decay;
  vibration.t_ns = t_ns;
  set_energy(string, energy, vibration);
  return vibration;
}

double energy_at(const Vibration& vibration, std::int64_t t_ns) noexcept {
  if (!(vibration.decay > 0.0)) return vibration.anchor_energy;
  return vibration.anchor_energy * decay_over(t_ns - vibration.anchor_ns, 0.5 * vibration.decay);
}

void set_energy(const StringConstants& string, double energy, Vibration& vibration) noexcept {
  vibration.energy = energy;
  vibration.anchor_energy = energy;
  vibration.anchor_ns = vibration.t_ns;
  vibration.amplitude = fundamental_amplitude(string, energy);
}

void set_decay(double decay, Vibration& vibration) noexcept {
  if (decay == vibration.decay) return;
  vibration.anchor_energy = vibration.energy;
  vibration.anchor_ns = vibration.t_ns;
  vibration.decay = decay;
}

void advance_vibration(const StringConstants& string, bool glide, std::int64_t t_ns,
                       Vibration& vibration) noexcept {
  const std::int64_t elapsed_ns = t_ns - vibration.t_ns;
  if (elapsed_ns <= 0) return;
  const double swing_before = vibration.amplitude;
  vibration.energy = energy_at(vibration, t_ns);
  vibration.amplitude = fundamental_amplitude(string, vibration.energy);
  vibration.t_ns = t_ns;

  double pitch = 1.0;
  if (glide) {
    pitch = 0.5 * (pitch_factor(string, vibration.lambda, swing_before) +
                   pitch_factor(string, vibration.lambda, vibration.amplitude));
  }
  const double elapsed = static_cast<double>(elapsed_ns) * kSecondsPerNanosecond;
  vibration.phase += phase_of_turns(string.frequency * pitch * elapsed);
}

double displacement(const Vibration& vibration) noexcept {
  return vibration.amplitude * sin_half_turns(2.0 * turns_of_phase(vibration.phase));
}

double shape_factor(const Vibration& vibration, double lambda) noexcept {
  const double here = mode_shape(1, lambda);
  const double there = mode_shape(1, vibration.lambda);
  return here >= there ? 1.0 : here / there;
}

double vibration_stiffness(const StringConstants& string, double lambda) noexcept {
  return std::min(small_deflection_stiffness(string, lambda), string.contact_stiffness);
}

}  // namespace hapticd
