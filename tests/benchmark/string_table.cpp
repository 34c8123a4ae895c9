// What the models of a touched string err and cost. A string is plucked by 5 mm; 50 ms later a
// finger of 1 kN/m at lambda 0.3 comes down on it through the envelope it vibrates in, from 6 mm
// above it to 2 mm into it within 40 ms, and stays for 60 ms. Two tunings, plucked close to the end
// and in the middle. Prints a markdown table: error of the force of each tick against the truth
// (tests/truth/string_truth.h), rms in percent of the truth's rms force and the greatest in
// mN, and the median time of a tick in which the finger presses. Then stiffer fingers. --quick: the
// first string only.
#include <algorithm>
#include <cstddef>
#include <cstdio>
#include <cstring>
#include <string>
#include <vector>

#include "tests/truth/press_run.h"

namespace hapticd::test {
namespace {

constexpr int kTruthRate = 800'000;
/// Times each case is played, so that the median time has some thousand ticks to choose from.
constexpr int kRepeats = 20;

/// "rms % / max mN".
std::string error_cell(const PressError& error) {
  char text[40];
  std::snprintf(text, sizeof text, error.rms_percent >= 100.0 ? " %.0f / %.0f |" : " %.2g / %.0f |",
                error.rms_percent, 1e3 * error.max_newton);
  return text;
}

/// One line: play(press_case) against the truth of each case.
template <typename Play>
void print_row(const std::vector<PressCase>& cases, const std::string& name, const Play& play) {
  std::string line = "| " + name + " |";
  std::vector<double> nanoseconds;
  for (const PressCase& press_case : cases) {
    for (int i = 0; i < kRepeats; ++i) {
      const PressRun run = play(press_case);
      nanoseconds.insert(nanoseconds.end(), run.nanoseconds.begin(), run.nanoseconds.end());
      if (i == 0) line += error_cell(press_error(run, press_case));
    }
  }
  const auto middle = nanoseconds.begin() + static_cast<std::ptrdiff_t>(nanoseconds.size() / 2);
  std::nth_element(nanoseconds.begin(), middle, nanoseconds.end());
  std::printf("%s %.0f |\n", line.c_str(), *middle);
  std::fflush(stdout);
}

void print_header(const std::vector<PressCase>& cases) {
  std::printf("| model |");
  for (const PressCase& press_case : cases) {
    std::printf(" %.1f Hz, plucked at %.1f |", press_case.string.frequency,
                press_case.press.pluck_lambda);
  }
  std::printf(" median ns per touched tick |\n|---|");
  for (std::size_t k = 0; k <= cases.size(); ++k) std::printf("---:|");
  std::printf("\n");
}

void print_wave(const std::vector<PressCase>& cases, int modes, const std::string& remark) {
  print_row(cases, std::to_string(modes) + " modes" + remark,
            [&](const PressCase& press_case) { return play_wave(press_case, modes); });
}

std::vector<PressCase> make_cases(double stiffness, bool quick) {
  std::vector<PressCase> cases;
  for (const double frequency : {65.4, 146.8}) {
    for (const double pluck_lambda : {0.1, 0.5}) {
      if (quick && !cases.empty()) continue;
      cases.push_back(make_press_case(frequency, pluck_lambda, stiffness, kTruthRate));
    }
  }
  return cases;
}

void print_table(bool quick) {
  const std::vector<PressCase> cases = make_cases(1e3, quick);
  print_header(cases);
  for (const bool vibrates : {true, false}) {
    print_row(cases, vibrates ? "Eq. 9 as printed" : "static force alone",
              [&](const PressCase& press_case) { return play_printed(press_case, vibrates); });
  }
  for (const int modes : {4, 8, 16, 32, 64}) print_wave(cases, modes, "");
  for (const int kilo : {10, 100}) {
    const std::vector<PressCase> stiff = make_cases(1e3 * kilo, quick);
    const std::string remark = ", finger of " + std::to_string(kilo) + " kN/m";
    for (const int modes : {8, 16, 32, 64}) print_wave(stiff, modes, remark);
  }
}

}  // namespace
}  // namespace hapticd::test

int main(int argc, char** argv) {
  hapticd::test::print_table(argc > 1 && std::strcmp(argv[1], "--quick") == 0);
}
