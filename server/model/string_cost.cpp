// See string_cost.h.
#include "server/model/string_cost.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <iomanip>
#include <sstream>

#include "core/instrument/string_motion.h"

namespace hapticd {
namespace {

/// A row of string_costs.inc.
struct CountedRung {
  StringDetail level;
  bool stretches;
  int modes;
  int substeps;
  double silent;
  double ringing;
  double pressed;
};

constexpr std::array<CountedRung, 9> kCounted{{
#include "server/model/string_costs.inc"
}};

/// Modes and sub-steps of a scene that says nothing of them.
constexpr int kUsual = 32;

/// How the cost of a pressed wave follows from modes N and sub-steps S: a + S (b + c N).
struct Law {
  double a, b, c;

  /// Through what was counted at (32, 32), (16, 16) and (32, 16).
  Law(double at_32_32, double at_16_16, double at_32_16) noexcept
      : a(2.0 * at_32_16 - at_32_32), b(0.0), c((at_32_16 - at_16_16) / 256.0) {
    b = (at_32_16 - a) / 16.0 - 32.0 * c;
  }
  [[nodiscard]] double at(const StringRung& rung) const noexcept {
    return std::max(0.0, a + rung.substeps * (b + c * rung.modes));
  }
};

StringCost cost_of(const CountedRung& row) { return {row.silent, row.ringing, row.pressed}; }

StringCost counted(const StringRung& rung) {
  const auto row = std::find_if(kCounted.begin(), kCounted.end(), [&](const CountedRung& each) {
    return each.level == rung.level && each.stretches == rung.stretches &&
           each.modes == rung.modes && each.substeps == rung.substeps;
  });
  return row == kCounted.end() ? StringCost{} : cost_of(*row);
}

/// In three digits: no more is promised.
std::string in_figures(double count) {
  if (count < 0.0) return "-";
  double unit = 1.0;
  while (count / unit >= 999.5) unit *= 10.0;
  return std::to_string(std::llround(std::round(count / unit) * unit));
}

void print_row(std::ostream& out, const std::string& what, const StringCost& cost) {
  out << "  " << std::left << std::setw(66) << what << std::right << std::setw(9)
      << in_figures(cost.silent) << std::setw(9) << in_figures(cost.ringing) << std::setw(9)
      << in_figures(cost.pressed) << "\n";
}

}  // namespace

StringRung rung_of(const StringParameters& string, const InstrumentOptions& options) {
  const StringConstants constants = derive_string(string);
  StringRung rung{constants.max_level};
  if (rung.level == StringDetail::kModes) {
    rung.modes = mode_table(constants, {}, options.modes, options.substeps).count;
    rung.substeps = options.substeps;
    rung.stretches = axial_stiffness_of(string) > 0.0;
    const bool waves = constants.model == StringContact::kYielding && rung.modes > 0;
    if (!waves) rung = {StringDetail::kFundamental};
  }
  const bool rings = options.vibration && constants.frequency > 0.0;
  if (rung.level >= StringDetail::kFundamental && !rings) rung = {StringDetail::kStatic};
  return rung;
}

std::string rung_name(const StringRung& rung) {
  switch (rung.level) {
    case StringDetail::kLine:
      return "rigid";
    case StringDetail::kStatic:
      return "static";
    case StringDetail::kFundamental:
      return "fundamental";
    case StringDetail::kModes:
      break;
  }
  return "wave of " + std::to_string(rung.modes) + " modes, " + std::to_string(rung.substeps) +
         " sub-steps" + (rung.stretches ? ", that stretches" : "");
}

std::vector<std::pair<StringRung, int>> rungs_of(const SceneDescription& scene) {
  std::vector<std::pair<StringRung, int>> found;
  for (const StringDescription& string : scene.strings) {
    const StringRung rung = rung_of(string.parameters, scene.instrument);
    const auto same = std::find_if(found.begin(), found.end(), [&](const auto& each) {
      return each.first.level == rung.level && each.first.stretches == rung.stretches;
    });
    if (same == found.end()) {
      found.emplace_back(rung, 1);
    } else {
      same->first.modes = std::max(same->first.modes, rung.modes);
      ++same->second;
    }
  }
  return found;
}

StringCost string_cost(const StringRung& rung) {
  if (rung.level != StringDetail::kModes) return counted(rung);
  const auto at = [&](int modes, int substeps) {
    return counted({rung.level, rung.stretches, modes, substeps});
  };
  const StringCost usual = at(32, 32);
  const StringCost few = at(16, 16);
  const Law pressed(usual.pressed, few.pressed, at(32, 16).pressed);
  const double per_mode = (usual.ringing - few.ringing) / 16.0;
  return {usual.silent, usual.ringing + per_mode * (rung.modes - 32), pressed.at(rung)};
}

std::string string_costs(const SceneDescription& scene) {
  if (scene.strings.empty()) return "";
  std::ostringstream out;
  out << "cost of one string, instructions of a tick beyond one with nothing near, counted of a "
         "string of 65.4 Hz\n";
  out << "  " << std::left << std::setw(66) << "rung" << std::right << std::setw(9) << "silent"
      << std::setw(9) << "rings" << std::setw(9) << "pressed"
      << "\n";
  for (const CountedRung& row : kCounted) {
    const bool usual = row.modes == kUsual && row.substeps == kUsual;
    if (row.level == StringDetail::kModes && !usual) continue;
    print_row(out, rung_name({row.level, row.stretches, row.modes, row.substeps}), cost_of(row));
  }
  for (const auto& [rung, count] : rungs_of(scene)) {
    print_row(out,
              "here: " + std::to_string(count) + (count == 1 ? " string, " : " strings, ") +
                  rung_name(rung),
              string_cost(rung));
  }
  return out.str();
}

}  // namespace hapticd
