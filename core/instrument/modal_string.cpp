// Free modes: pluck, rotation, energy, and the way to the fundamental and back. The contact is in
// modal_touch.cpp. RT: yes.
#include "core/instrument/modal_string.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <type_traits>

#include "core/instrument/mode_series.h"
#include "core/math/elementary.h"

namespace hapticd {
namespace {

static_assert(std::is_trivially_copyable_v<ModalString>);

constexpr std::uint64_t kHalfTurn = std::uint64_t{1} << 63U;

/// sin(pi h) / (pi h).
double sinc_half_turns(double h) noexcept { return h == 0.0 ? 1.0 : sin_half_turns(h) / (kPi * h); }

/// Sum of m omega_n^2 A_n^2 / 2 with the current amplitudes.
double anchored_energy(const StringConstants& string, const ModalString& modes) noexcept {
  const ModeSeries series = mode_series(string);
  double energy = 0.0;
  for (int n = 1; n <= modes.count; ++n) {
    const double amplitude = modes.amplitude[static_cast<std::size_t>(n - 1)];
    energy += 0.5 * modal_stiffness(string, series.frequency(n)) * (amplitude * amplitude);
  }
  return energy;
}

}  // namespace

double pluck_amplitude(double lambda, double delta, int n) noexcept {
  if (!(lambda > 0.0 && lambda < 1.0)) return 0.0;
  const double number = n;
  return 2.0 * delta * (mode_shape(n, lambda) / (lambda * (1.0 - lambda))) /
         (number * number * (kPi * kPi));
}

void pluck_modes(const StringConstants& string, const Pluck& pluck, int count,
                 ModalString& modes) noexcept {
  modes = ModalString{};
  modes.t_ns = pluck.t_ns;
  if (!(string.frequency > 0.0)) return;
  modes.count = std::clamp(count, 0, kMaxModes);
  const ModeSeries series = mode_series(string);
  for (int n = 1; n <= modes.count; ++n) {
    const double frequency = series.frequency(n);
    const double ideal = n * string.frequency / frequency;
    const double turns = frequency * pluck.unload_time;
    const double amplitude = pluck_amplitude(pluck.lambda, pluck.deflection, n) * (ideal * ideal) *
                             sinc_half_turns(turns);
    const auto k = static_cast<std::size_t>(n - 1);
    modes.amplitude[k] = std::abs(amplitude);
    modes.phase[k] = phase_of_turns(0.5 * turns) + (amplitude < 0.0 ? kHalfTurn : 0U);
  }
}

void set_fundamental(const Fundamental& fundamental, int count, std::int64_t t_ns,
                     ModalString& modes) noexcept {
  modes = ModalString{};
  modes.count = std::clamp(count, 0, kMaxModes);
  modes.t_ns = t_ns;
  if (modes.count == 0) return;
  modes.amplitude[0] = fundamental.amplitude;
  modes.phase[0] = fundamental.phase;
}

double modal_energy(const StringConstants& string, const ModalString& modes, double decay,
                    std::int64_t t_ns) noexcept {
  const double factor = decay_over(t_ns - modes.t_ns, decay);
  return anchored_energy(string, modes) * (factor * factor);
}

int relative_partials(const ModalString& modes, std::array<float, kMaxModes>& partials) noexcept {
  partials = {};
  double largest = 0.0;
  for (const double amplitude : modes.amplitude) largest = std::max(largest, amplitude);
  if (!(largest > 0.0)) return 0;
  for (std::size_t k = 0; k < static_cast<std::size_t>(modes.count); ++k) {
    partials[k] = static_cast<float>(modes.amplitude[k] / largest);
  }
  return modes.count;
}

void advance_free_modes(const StringConstants& string, double pitch, std::int64_t dt_ns,
                        ModalString& modes) noexcept {
  const ModeSeries series = mode_series(string);
  const double time = pitch * (static_cast<double>(dt_ns) * kSecondsPerNanosecond);
  for (int n = 1; n <= modes.count; ++n) {
    modes.phase[static_cast<std::size_t>(n - 1)] += phase_of_turns(series.frequency(n) * time);
  }
}

}  // namespace hapticd
