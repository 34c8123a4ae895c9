// See device_sheet.h.
#include "device/api/device_sheet.h"

#include <algorithm>
#include <cmath>
#include <utility>

namespace hapticd {
namespace {

std::size_t row_of(SheetNumber number) {
  const auto row = std::find_if(kSheetRows.begin(), kSheetRows.end(),
                                [&](const SheetRow& each) { return each.number == number; });
  return static_cast<std::size_t>(row - kSheetRows.begin());
}

template <typename Sheet, typename Number>
auto& place_of(Sheet& sheet, Number DeviceProfile::*number) {
  return sheet.profile.*number;
}
template <typename Sheet, typename Number>
auto& place_of(Sheet& sheet, Number AxisMapping::*number) {
  return sheet.axes.*number;
}

void set(double& number, const std::vector<double>& values) { number = values.front(); }
void set(int& number, const std::vector<double>& values) {
  number = static_cast<int>(values.front());
}
void set(Array3& axes, const std::vector<double>& values) {
  for (std::size_t i = 0; i < axes.size(); ++i) axes[i] = values[values.size() == 3 ? i : 0];
}

/// Lets the profile know which of its dampings are guesses.
void mark_guess(DeviceProfile& profile, SheetNumber number, bool guess) {
  if (number == SheetNumber(&DeviceProfile::damping)) profile.damping_guessed = guess;
  if (number == SheetNumber(&DeviceProfile::rotational_damping)) {
    profile.rotational_damping_guessed = guess;
  }
}

std::vector<double> get(double number) { return {number}; }
std::vector<double> get(int number) { return {static_cast<double>(number)}; }
std::vector<double> get(const Array3& axes) { return {axes.begin(), axes.end()}; }

}  // namespace

const NumberSource& source_of(const DeviceSheet& sheet, SheetNumber number) {
  return sheet.sources.at(row_of(number));
}

bool is_open(const DeviceSheet& sheet, SheetNumber number) {
  return source_of(sheet, number).values == 0;
}

std::vector<double> stated_values(const DeviceSheet& sheet, SheetNumber number) {
  std::vector<double> values =
      std::visit([&](auto member) { return get(place_of(sheet, member)); }, number);
  values.resize(std::min(values.size(), source_of(sheet, number).values));
  return values;
}

void state_number(DeviceSheet& sheet, SheetNumber number, const std::vector<double>& values,
                  NumberSource source) {
  if (values.empty()) return leave_open(sheet, number);
  source.values = values.size();
  mark_guess(sheet.profile, number, source.guess);
  sheet.sources.at(row_of(number)) = std::move(source);
  std::visit([&](auto member) { set(place_of(sheet, member), values); }, number);
}

void fill(DeviceSheet& sheet, SheetNumber number, std::initializer_list<double> values) {
  if (is_open(sheet, number)) state_number(sheet, number, values, {0, kStated, false});
}

void limit(DeviceSheet& sheet, double DeviceProfile::*number, double most, const char* source) {
  if (!std::isfinite(most)) return;
  if (!is_open(sheet, number) && sheet.profile.*number <= most) return;
  state_number(sheet, number, {most}, {0, source, false});
}

void leave_open(DeviceSheet& sheet, SheetNumber number) {
  sheet.sources.at(row_of(number)) = {};
  const DeviceSheet fresh;
  std::visit([&](auto member) { place_of(sheet, member) = place_of(fresh, member); }, number);
  mark_guess(sheet.profile, number, true);
}

}  // namespace hapticd
