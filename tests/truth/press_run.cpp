// Ticks of 1 ms through pluck, free time and press.
#include "tests/truth/press_run.h"

#include <algorithm>
#include <array>
#include <chrono>
#include <cmath>
#include <cstddef>
#include <cstdint>

#include "core/instrument/deflection.h"
#include "core/instrument/string_model.h"
#include "core/instrument/wave_string.h"
#include "core/math/elementary.h"

namespace hapticd {
namespace {

constexpr int kTruthModes = 256;
constexpr std::int64_t kTick_ns = 1'000'000;
constexpr double kTick = 1e-3;

/// Of a hand that draws a string aside, and of one that waits until that is forgotten.
constexpr int kDrawingTicks = 100;
constexpr int kWaitingTicks = 2000;
/// Of the finger and the string together, m.
constexpr double kReach = 5.34e-3;

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

/// A string that is quasi-static or rings with its fundamental, and the hand at it.
class Ladder {
 public:
  Ladder(const StringConstants& string, const InstrumentOptions& options, double lambda)
      : string_(string), options_(options), lambda_(lambda) {}

  void go_to(double lambda, double distance) {
    lambda_ = lambda;
    distance_ = distance;
  }

  /// Force of a tick in which the hand moves evenly to `distance` (negative: into the string); it
  /// passes the string's surface at the share `passing` of it.
  double tick(double distance, double passing = -1.0) {
    const SeriesDeflection bent =
        deflect_in_series(string_, lambda_, std::max(-distance, 0.0), string_.contact_stiffness);
    StringTouch touch;
    touch.distance_before = distance_;
    touch.distance = distance;
    touch.passing = passing;
    touch.force = bent.force;
    touch.deflection = bent.delta;
    touch.lambda = lambda_;
    touch.stiffness = string_.contact_stiffness;
    touch.normal_speed = (distance_ - distance) / kTick;
    touch.hand_speed = -touch.normal_speed;
    distance_ = distance;
    t_ns_ += kTick_ns;
    events_.clear();
    touch.time = {t_ns_, kTick_ns};
    return bent.force + respond({0, string_, options_, state_}, touch, events_).vibration_force;
  }

  /// Draws the string aside to `deflection`, waits until that is forgotten, and slips off it at the
  /// end of the last tick.
  void pluck(double deflection) {
    const double force = deflection_force(string_, lambda_, deflection);
    const double into = deflection + force / string_.contact_stiffness;
    for (int i = 1; i <= kDrawingTicks; ++i) tick(-into * i / kDrawingTicks);
    for (int i = 0; i < kWaitingTicks; ++i) tick(-into);
    tick(2.0 * options_.release.release_gap, 1.0);
  }

  [[nodiscard]] const Vibration& vibration() const { return state_.vibration; }

 private:
  const StringConstants& string_;
  const InstrumentOptions& options_;
  double lambda_;
  double distance_ = 1e-3;
  std::int64_t t_ns_ = 0;
  StringState state_;
  StringEvents events_;
};

/// A string that sounds, and a hand at it through a finger of `stiffness` (N/m). Displacements are
/// along y.
class Wave {
 public:
  Wave(const StringConstants& string, const InstrumentOptions& options, double stiffness)
      : string_(string), options_(options), stiffness_(stiffness) {
    WaveTuning tuning = tuning_at(string, string.tension, options);
    // Of the truth all modes decay alike.
    tuning.loss_n2 = 0.0;
    rest(0, state_);
    retune(tuning, table_, state_);
  }

  /// At rest, drawn aside to `deflection` (m) at lambda, and let go at once.
  void bend(double lambda, double deflection) {
    const double force = deflection_force(string_, lambda, deflection);
    PerMode shapes{};
    mode_shapes(table_.modes, lambda, shapes);
    for (std::size_t i = 0; i < static_cast<std::size_t>(table_.modes.count); ++i) {
      state_.motion.qy[i] = shapes[i] * force / table_.modes.stiffness[i];
    }
  }

  /// As bend(), by a hand that draws it aside and waits; it slips off at the end of the last tick.
  void pluck(double lambda, double deflection) {
    const double into = deflection + deflection_force(string_, lambda, deflection) / stiffness_;
    for (int i = 0; i < kDrawingTicks; ++i) {
      tick(lambda, into * i / kDrawingTicks, into * (i + 1) / kDrawingTicks);
    }
    for (int i = 0; i < kWaitingTicks; ++i) tick(lambda, into, into);
  }

  void free_tick() { step_to(nullptr); }

  /// Mean force of a tick in which the hand moves evenly from D_before to D_after into the string.
  double tick(double lambda, double D_before, double D_after) {
    const double force =
        deflect_in_series(string_, lambda, std::max(D_after, 0.0), stiffness_).force;
    WaveTouch touch;
    touch.lambda_before = lambda;
    touch.lambda = lambda;
    touch.radius = kReach;
    touch.normal = {-1.0, 0.0};
    touch.force = force;
    touch.compliance = 1.0 / stiffness_;
    touch.centre_before = {D_before - kReach, 0.0};
    touch.centre = {D_after - force / stiffness_ - kReach, 0.0};
    touch.hand_speed = std::abs(D_after - D_before) / kTick;
    step_to(&touch);
    return state_.contacts[0].path.force.y;
  }

 private:
  void step_to(const WaveTouch* touch) {
    const std::array touches{touch};
    t_ns_ += kTick_ns;
    static_cast<void>(step({string_, options_, table_}, {t_ns_, kTick_ns}, touches, state_));
  }

  const StringConstants& string_;
  const InstrumentOptions& options_;
  double stiffness_;
  std::int64_t t_ns_ = 0;
  WaveTable table_;
  WaveString state_;
};

/// Lets `wave` ring after its pluck and presses it as `press` says.
PressRun press_wave(const TruthPress& press, Wave& wave) {
  for (long k = 0; k < std::lround(press.free_time / kTick); ++k) wave.free_tick();
  PressRun run;
  for (int i = 0; i < press.ticks; ++i) {
    const auto force_of = [&](double D_before, double D_after) {
      return wave.tick(press.lambda, D_before, D_after);
    };
    play_tick(press, i, force_of, run);
  }
  return run;
}

}  // namespace

PressCase press_case_of(const TruthString& string, const TruthPress& press) {
  PressCase made;
  made.truth_string = string;
  made.press = press;
  StringParameters parameters;
  parameters.p_WB = {made.truth_string.length, 0.0, 0.0};
  parameters.tension = made.truth_string.tension;
  parameters.frequency = made.truth_string.frequency;
  parameters.decay = made.truth_string.decay;
  parameters.touch_decay = made.truth_string.touch_decay;
  // The truth is linear: a string that tightens as it is drawn aside would only blur the
  // comparison.
  parameters.youngs_modulus = 0.0;
  made.string = derive_string(parameters);
  return made;
}

PressCase make_press_case(double frequency, double pluck_lambda, double stiffness, int rate) {
  TruthString string;
  TruthPress press;
  string.frequency = frequency;
  string.touch_decay = string.decay;
  press.pluck_lambda = pluck_lambda;
  press.stiffness = stiffness;
  PressCase made = press_case_of(string, press);
  find_truth(rate, made);
  return made;
}

void find_truth(int rate, PressCase& press_case) {
  press_case.truth = play_modes(press_case.truth_string, press_case.press, kTruthModes, rate).force;
}

PressRun play_wave(const PressCase& press_case, int modes) {
  const TruthPress& press = press_case.press;
  InstrumentOptions options;
  options.modes = modes;
  Wave wave(press_case.string, options, press.stiffness);
  wave.bend(press.pluck_lambda, press.pluck_delta);
  return press_wave(press, wave);
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

PressRun play_ladder(const PressCase& press_case, const InstrumentOptions& options) {
  const TruthPress& press = press_case.press;
  if (options.modes > 0 && press_case.string.max_level == StringDetail::kModes) {
    Wave wave(press_case.string, options, press.stiffness);
    wave.pluck(press.pluck_lambda, press.pluck_delta);
    return press_wave(press, wave);
  }
  Ladder ladder(press_case.string, options, press.pluck_lambda);
  ladder.pluck(press.pluck_delta);
  ladder.go_to(press.lambda, -press.start_D);
  for (long k = 0; k < std::lround(press.free_time / kTick); ++k) ladder.tick(-press.start_D);
  PressRun run;
  for (int i = 0; i < press.ticks; ++i) {
    play_tick(
        press, i, [&](double, double D) { return ladder.tick(-D); }, run);
  }
  return run;
}

double ladder_frequency(const PressCase& press_case, const InstrumentOptions& options,
                        double seconds) {
  constexpr double kFar = 0.1;
  Ladder ladder(press_case.string, options, press_case.press.pluck_lambda);
  ladder.pluck(press_case.press.pluck_delta);
  ladder.go_to(press_case.press.pluck_lambda, kFar);
  double turns = 0.0;
  for (long k = 0; k < std::lround(seconds / kTick); ++k) {
    const std::uint64_t before = ladder.vibration().phase;
    ladder.tick(kFar);
    turns += static_cast<double>(ladder.vibration().phase - before) * 0x1p-64;
  }
  return turns / seconds;
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

}  // namespace hapticd
