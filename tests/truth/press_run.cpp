// Ticks of 1 ms through pluck, free time and press.
#include "tests/truth/press_run.h"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <cstddef>
#include <cstdint>

#include "core/instrument/deflection.h"
#include "core/instrument/modal_string.h"
#include "core/instrument/string_model.h"
#include "core/math/elementary.h"

namespace hapticd {
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

/// A string of the ladder and the hand at it.
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
    ModalString* const modes = options_.modes > 0 ? &modes_ : nullptr;
    return bent.force +
           respond({0, string_, options_, state_, modes}, touch, events_).vibration_force;
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
  static constexpr int kDrawingTicks = 100;
  static constexpr int kWaitingTicks = 2000;

  const StringConstants& string_;
  const InstrumentOptions& options_;
  double lambda_;
  double distance_ = 1e-3;
  std::int64_t t_ns_ = 0;
  StringState state_;
  ModalString modes_;
  StringEvents events_;
};

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
  press.pluck_lambda = pluck_lambda;
  press.stiffness = stiffness;
  PressCase made = press_case_of(string, press);
  find_truth(rate, made);
  return made;
}

void find_truth(int rate, PressCase& press_case) {
  press_case.truth = play_modes(press_case.truth_string, press_case.press, kTruthModes, rate).force;
}

PressRun play_modal(const PressCase& press_case, int modes, int steps) {
  const StringConstants& string = press_case.string;
  const TruthPress& press = press_case.press;
  PressRun run;
  ModalString state;
  pluck_modes(string, {press.pluck_lambda, press.pluck_delta}, modes, state);
  const std::int64_t touch_ns = std::llround(press.free_time * 1e9);
  for (std::int64_t t_ns = 0; t_ns < touch_ns; t_ns += kTick_ns) {
    advance_free_modes(string, 1.0, kTick_ns, state);
  }
  for (int i = 0; i < press.ticks; ++i) {
    const std::int64_t t_ns = touch_ns + (i + 1) * kTick_ns;
    const auto force_of = [&](double D_before, double D_after) {
      return touch_modes(string, {press.lambda, D_before, D_after, press.stiffness, steps},
                         {t_ns, kTick_ns}, state)
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

PressRun play_ladder(const PressCase& press_case, const InstrumentOptions& options) {
  const TruthPress& press = press_case.press;
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
