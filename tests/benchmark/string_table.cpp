// What the models of a touched string err and cost. A string is plucked by 5 mm, 50 ms later a
// finger of 1 kN/m at lambda 0.3 comes down on it through the envelope it vibrates in, from 6 mm
// above it to 2 mm into it within 40 ms, and stays for 60 ms. Two tunings, plucked close to the end
// and in the middle. Prints a markdown table: error of the force of each tick against the truth
// (tests/support/string_truth.h), rms in percent of the truth's rms force and the greatest in mN,
// and the median time of a tick within the finger's reach. --quick: the first string only.
#include <algorithm>
#include <chrono>
#include <cmath>
#include <cstdint>
#include <cstdio>
#include <cstring>
#include <string>
#include <vector>

#include "core/instrument/deflection.h"
#include "core/instrument/modal_string.h"
#include "core/instrument/string_parameters.h"
#include "core/math/elementary.h"
#include "tests/support/string_truth.h"

namespace hapticd::test {
namespace {

constexpr int kTruthModes = 256;
constexpr int kTruthRate = 800'000;
constexpr std::int64_t kTick_ns = 1'000'000;
constexpr double kTick = 1e-3;
/// Times each case is played for its time, of which the median over all ticks is taken.
constexpr int kRepeats = 5;

/// A string, what happens to it, and what it does.
struct Case {
  StringConstants string;
  TruthString truth_string;
  TruthPress press;
  std::vector<double> truth;
};

Case make_case(double frequency, double pluck_lambda) {
  StringParameters parameters;
  parameters.p_WB = {1.1, 0.0, 0.0};
  parameters.frequency = frequency;
  Case made;
  made.string = derive_string(parameters);
  // The truth is a string without elongation: its force is linear in the displacement.
  made.string.axial_stiffness = 0.0;
  made.truth_string.frequency = frequency;
  made.press.pluck_lambda = pluck_lambda;
  made.truth = play_modes(made.truth_string, made.press, kTruthModes, kTruthRate).force;
  return made;
}

struct Played {
  std::vector<double> force;
  std::vector<double> nanoseconds;  ///< of ticks within reach
};

/// Ticks of the modal string, from the pluck on.
Played play_levels(const Case& played, int modes, int steps) {
  Played result;
  const TruthPress& press = played.press;
  ModalString state;
  pluck_modes(played.string, press.pluck_lambda, press.pluck_delta, modes, 0.0, 0, state);
  std::int64_t t_ns = 0;
  for (; t_ns < std::llround(press.free_time * 1e9); t_ns += kTick_ns) {
    advance_free_modes(played.string, 1.0, kTick_ns, state);
  }
  for (int i = 0; i < press.ticks; ++i) {
    t_ns += kTick_ns;
    const double D_before = press.hand(i * kTick);
    const double D_after = press.hand((i + 1) * kTick);
    const auto start = std::chrono::steady_clock::now();
    const ModalTouch touch = touch_modes(played.string, press.lambda, D_before, D_after,
                                         press.stiffness, steps, t_ns, kTick_ns, state);
    const auto end = std::chrono::steady_clock::now();
    result.force.push_back(touch.force);
    if (D_after > 0.0) {
      result.nanoseconds.push_back(std::chrono::duration<double, std::nano>(end - start).count());
    }
  }
  return result;
}

/// The static force, and on it the fundamental as Eq. 9 is printed: r_max the pluck's whole depth,
/// T_d and stiffness as if nobody touched the string.
Played play_printed(const Case& played, bool vibrates) {
  Played result;
  const StringConstants& string = played.string;
  const TruthPress& press = played.press;
  const double k_v = std::min(small_deflection_stiffness(string, press.lambda), press.stiffness);
  for (int i = 0; i < press.ticks; ++i) {
    const double D = press.hand((i + 1) * kTick);
    const double t = press.free_time + (i + 1) * kTick;
    const auto start = std::chrono::steady_clock::now();
    double force = 0.0;
    if (D > 0.0) {
      force = deflect_in_series(string, press.lambda, D, press.stiffness).force;
      if (vibrates) {
        force += k_v * press.pluck_delta * exponential(-t / string.decay) *
                 sin_cos(2.0 * kPi * string.frequency * t).sin;
      }
    }
    const auto end = std::chrono::steady_clock::now();
    result.force.push_back(force);
    if (D > 0.0) {
      result.nanoseconds.push_back(std::chrono::duration<double, std::nano>(end - start).count());
    }
  }
  return result;
}

/// "rms % / max mN" of a force against the truth.
std::string error_cell(const std::vector<double>& force, const std::vector<double>& truth) {
  double error = 0.0;
  double size = 0.0;
  double greatest = 0.0;
  for (std::size_t i = 0; i < truth.size(); ++i) {
    error += (force[i] - truth[i]) * (force[i] - truth[i]);
    size += truth[i] * truth[i];
    greatest = std::max(greatest, std::abs(force[i] - truth[i]));
  }
  const double percent = 100.0 * std::sqrt(error / size);
  char text[40];
  std::snprintf(text, sizeof text, percent >= 100.0 ? " %.0f / %.0f |" : " %.2g / %.2g |", percent,
                1e3 * greatest);
  return text;
}

template <typename Play>
void print_row(const std::vector<Case>& cases, const std::string& name, const Play& play) {
  std::string line = "| " + name + " |";
  std::vector<double> nanoseconds;
  for (const Case& played : cases) {
    for (int i = 0; i < kRepeats; ++i) {
      const Played result = play(played);
      nanoseconds.insert(nanoseconds.end(), result.nanoseconds.begin(), result.nanoseconds.end());
      if (i == 0) line += error_cell(result.force, played.truth);
    }
  }
  const auto middle = nanoseconds.begin() + static_cast<std::ptrdiff_t>(nanoseconds.size() / 2);
  std::nth_element(nanoseconds.begin(), middle, nanoseconds.end());
  std::printf("%s %.0f |\n", line.c_str(), *middle);
  std::fflush(stdout);
}

void print_table(const std::vector<Case>& cases) {
  std::printf("| model |");
  for (const Case& played : cases) {
    std::printf(" %.1f Hz, plucked at %.1f |", played.string.frequency, played.press.pluck_lambda);
  }
  std::printf(" median ns per touched tick |\n|---|");
  for (std::size_t k = 0; k <= cases.size(); ++k) std::printf("---:|");
  std::printf("\n");

  print_row(cases, "Eq. 9 as printed",
            [](const Case& played) { return play_printed(played, true); });
  print_row(cases, "static force alone",
            [](const Case& played) { return play_printed(played, false); });
  for (const int steps : {4, 16, 64, 256}) {
    for (const int modes : {1, 2, 4, 8, 16, 32, 64}) {
      const std::string name =
          std::to_string(modes) + " modes, " + std::to_string(steps) + " steps";
      print_row(cases, name, [&](const Case& played) { return play_levels(played, modes, steps); });
    }
  }
}

}  // namespace
}  // namespace hapticd::test

int main(int argc, char** argv) {
  using namespace hapticd::test;
  const bool quick = argc > 1 && std::strcmp(argv[1], "--quick") == 0;
  std::vector<Case> cases;
  for (const double frequency : {65.4, 146.8}) {
    for (const double pluck_lambda : {0.1, 0.5}) {
      if (!quick || cases.empty()) cases.push_back(make_case(frequency, pluck_lambda));
    }
  }
  print_table(cases);
}
