// Ticks of 1 ms through pluck, free time and press.
#include "tests/core/instrument/press_run.h"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <cstddef>
#include <cstdint>

#include "core/instrument/deflection.h"
#include "core/instrument/modal_string.h"
#include "core/math/elementary.h"

namespace hapticd::test {
namespace {

constexpr int kTruthModes = 256;
constexpr std::int64_t kTick_ns = 1'000'000;
constexpr double kTick = 1e-3;

/// Plays one tick, force_of(D_before, D_after), and keeps its force and time.
template <typename ForceOf>
void play_tick(const TruthPress& press, int tick, const ForceOf& force_of, PressRun& run) {
  const double D_before = press.hand(tick * kTick);
  const double D_after = press.hand((tick + 1) * kTick);
  const auto start = std::chrono::steady_clock::now();
  const double force = force_of(D_before, D_after);
  const auto end = std::chrono::steady_clock::now();
  run.force.push_back(force);
  if (D_after <= 0.0) return;
  run.nanoseconds.push_back(std::chrono::duration<double, std::nano>(end - start).count());
}

}  // namespace

PressCase make_press_case(double frequency, double pluck_lambda, double stiffness, int rate) {
  PressCase made;
  made.truth_string.frequency = frequency;
  made.press.pluck_lambda = pluck_lambda;
  made.press.stiffness = stiffness;
  made.truth = play_modes(made.truth_string, made.press, kTruthModes, rate).force;

  StringParameters parameters;
  parameters.p_WB = {made.truth_string.length, 0.0, 0.0};
  parameters.tension = made.truth_string.tension;
  parameters.frequency = frequency;
  parameters.decay = made.truth_string.decay;
  parameters.touch_decay = made.truth_string.touch_decay;
  // The truth is linear: a string that tightens as it is drawn aside would only blur the
  // comparison.
  parameters.youngs_modulus = 0.0;
  made.string = derive_string(parameters);
  return made;
}

PressRun play_modal(const PressCase& press_case, int modes, int steps) {
  const StringConstants& string = press_case.string;
  const TruthPress& press = press_case.press;
  PressRun run;
  ModalString state;
  pluck_modes(string, press.pluck_lambda, press.pluck_delta, modes, 0.0, 0, state);
  const std::int64_t touch_ns = std::llround(press.free_time * 1e9);
  for (std::int64_t t_ns = 0; t_ns < touch_ns; t_ns += kTick_ns) {
    advance_free_modes(string, 1.0, kTick_ns, state);
  }
  for (int i = 0; i < press.ticks; ++i) {
    const std::int64_t t_ns = touch_ns + (i + 1) * kTick_ns;
    const auto force_of = [&](double D_before, double D_after) {
      return touch_modes(string, press.lambda, D_before, D_after, press.stiffness, steps, t_ns,
                         kTick_ns, state)
          .force;
    };
    play_tick(press, i, force_of, run);
  }
  return run;
}

PressRun play_printed(const PressCase& press_case, bool vibrates) {
  const StringConstants& string = press_case.string;
  const TruthPress& press = press_case.press;
  const double k_v = std::min(small_deflection_stiffness(string, press.lambda), press.stiffness);
  PressRun run;
  for (int i = 0; i < press.ticks; ++i) {
    const double t = press.free_time + (i + 1) * kTick;
    const auto force_of = [&](double, double D) {
      if (D <= 0.0) return 0.0;
      const double pressed = deflect_in_series(string, press.lambda, D, press.stiffness).force;
      if (!vibrates) return pressed;
      return pressed + k_v * press.pluck_delta * exponential(-t / string.decay) *
                           sin_cos(2.0 * kPi * string.frequency * t).sin;
    };
    play_tick(press, i, force_of, run);
  }
  return run;
}

PressError press_error(const PressRun& run, const PressCase& press_case) {
  double error = 0.0;
  double size = 0.0;
  double greatest = 0.0;
  for (std::size_t i = 0; i < press_case.truth.size(); ++i) {
    const double difference = run.force[i] - press_case.truth[i];
    error += difference * difference;
    size += press_case.truth[i] * press_case.truth[i];
    greatest = std::max(greatest, std::abs(difference));
  }
  return {100.0 * std::sqrt(error / size), greatest};
}

}  // namespace hapticd::test
