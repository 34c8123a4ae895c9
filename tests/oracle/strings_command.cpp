// hapticd-oracle strings: what the levels of a string err, in pitch and under a finger. Not RT.
#include <algorithm>
#include <cmath>
#include <cstdint>
#include <map>
#include <memory>
#include <string>
#include <vector>

#include "core/math/elementary.h"
#include "tests/oracle/commands.h"
#include "tests/oracle/json.h"
#include "tests/oracle/press_models.h"
#include "tests/oracle/table.h"
#include "tests/truth/pitch_truth.h"
#include "tests/truth/press_run.h"

namespace hapticd {
namespace {

constexpr int kTruthRate = 800'000;
constexpr int kTruthModes = 96;
/// How long the pitch is listened to, s.
constexpr double kHeard = 0.1;
/// How far a string was drawn aside that a finger comes back to, m.
constexpr double kTouchedPluck = 5e-3;
/// A Guqin's string, m and Pa.
constexpr double kRadius = 0.34e-3;
constexpr double kSteel = 1.9e11;
constexpr double kFrequencies[] = {65.4, 146.8};
constexpr double kPlucks[] = {0.1, 0.5};

/// A setting of a string.
struct StringSetting {
  std::string name;
  StringDetail level = StringDetail::kModes;
  InstrumentOptions options;
};

std::vector<StringSetting> all_settings() {
  std::vector<StringSetting> settings{{"static", StringDetail::kStatic, {}},
                                      {"fundamental", StringDetail::kFundamental, {}}};
  for (const int modes : {4, 8, 16, 32, 64}) {
    StringSetting& setting = settings.emplace_back();
    setting.name = std::to_string(modes) + " modes";
    setting.options.modes = modes;
  }
  return settings;
}

/// A string plucked so; the finger that comes back to it does not damp it.
PressCase case_of(double frequency, double pluck_lambda, double deflection) {
  TruthString string;
  string.frequency = frequency;
  string.touch_decay = string.decay;
  TruthPress press;
  press.pluck_lambda = pluck_lambda;
  press.pluck_delta = deflection;
  return press_case_of(string, press);
}

/// Sums over the plucks.
struct TouchError {
  double square = 0.0, truth_square = 0.0, largest = 0.0;
  std::vector<double> nanoseconds;

  [[nodiscard]] double share() const { return std::sqrt(square / truth_square); }

  void add(const PressRun& run, const PressCase& press_case) {
    const PressError error = press_error(run, press_case);
    double size = 0.0;
    for (const double force : press_case.truth) size += force * force;
    square += error.rms_percent * error.rms_percent * 1e-4 * size;
    truth_square += size;
    largest = std::max(largest, error.max_newton);
    nanoseconds.insert(nanoseconds.end(), run.nanoseconds.begin(), run.nanoseconds.end());
  }

  double median_ns() {
    const auto middle = nanoseconds.begin() + static_cast<std::ptrdiff_t>(nanoseconds.size() / 2);
    std::nth_element(nanoseconds.begin(), middle, nanoseconds.end());
    return *middle;
  }
};

/// The model alone, whatever work it does.
PressRun play_model(const StringSetting& setting, const PressCase& press_case) {
  if (setting.level != StringDetail::kModes) {
    return play_printed(press_case, setting.level == StringDetail::kFundamental);
  }
  return play_wave(press_case, setting.options.modes);
}

std::string touch_line(const StringSetting& setting, std::vector<PressCase> cases) {
  TouchError model, played;
  for (PressCase& press_case : cases) {
    press_case.string.max_level = setting.level;
    model.add(play_model(setting, press_case), press_case);
    played.add(play_ladder(press_case, setting.options), press_case);
  }
  return text_of({{"measured", "touch"},
                  {"name", setting.name},
                  {"modes", setting.options.modes},
                  {"model_error", model.share()},
                  {"model_max_n", model.largest},
                  {"played_error", played.share()},
                  {"played_max_n", played.largest},
                  {"timing", {{"median_ns", played.median_ns()}}}});
}

double cents(double frequency, double other) { return 1200.0 * std::log2(frequency / other); }

/// A pluck of a string that tightens: pitch of the truth and of the ladder with and without glide.
std::string pitch_line(double frequency, double pluck_lambda, double deflection) {
  PressCase press_case = case_of(frequency, pluck_lambda, deflection);
  press_case.string.axial_stiffness = kSteel * kPi * kRadius * kRadius;
  GlidingString string;
  string.axial_stiffness = press_case.string.axial_stiffness;
  string.frequency = frequency;
  string.decay = press_case.string.decay;
  string.pluck_lambda = pluck_lambda;
  string.pluck_deflection = deflection;
  const double truth = mean_frequency(string, kHeard, kTruthModes, kTruthRate);
  InstrumentOptions options;
  const double plain = ladder_frequency(press_case, options, kHeard);
  options.pitch_glide = true;
  const double gliding = ladder_frequency(press_case, options, kHeard);
  return text_of({{"measured", "pitch"},
                  {"frequency_hz", frequency},
                  {"pluck_lambda", pluck_lambda},
                  {"deflection_m", deflection},
                  {"truth_cents", cents(truth, frequency)},
                  {"error_cents", cents(plain, truth)},
                  {"error_with_glide_cents", cents(gliding, truth)}});
}

std::string press_line(const PressModel& model) {
  return text_of({{"measured", "press"},
                  {"strings", static_cast<std::size_t>(model.strings)},
                  {"solved", model.coupled ? "coupled" : "series"},
                  {"error", model.error},
                  {"max_n", model.max_newton},
                  {"timing", {{"median_ns", model.median_ns}}}});
}

std::string all_lines() {
  std::vector<PressCase> cases;
  for (const double frequency : kFrequencies) {
    for (const double pluck : kPlucks) {
      find_truth(kTruthRate, cases.emplace_back(case_of(frequency, pluck, kTouchedPluck)));
    }
  }
  std::string text;
  for (const StringSetting& setting : all_settings()) text += touch_line(setting, cases) + "\n";
  for (const double frequency : kFrequencies) {
    for (const double pluck : kPlucks) {
      for (const double deflection : {1e-3, 2e-3, 5e-3}) {
        text += pitch_line(frequency, pluck, deflection) + "\n";
      }
    }
  }
  for (const PressModel& model : compare_press_models()) text += press_line(model) + "\n";
  return text;
}

}  // namespace

void add_strings_command(CLI::App& app) {
  CLI::App* command = app.add_subcommand(
      "strings",
      "what the levels of a plucked string err: its force on a finger that comes back to it, of "
      "the model and as it is played, with no more work than the string has left, against 256 "
      "modes at 800 kHz; its pitch, against a string that tightens as it swings; and strings under "
      "a press, solved with the tool or each by itself, against Eq. 10 to 12; a line of JSON each");
  const auto output = std::make_shared<std::string>();
  add_output_option(*command, *output);
  command->callback([output] { write_output(*output, all_lines()); });
}

}  // namespace hapticd
