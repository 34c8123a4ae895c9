// See check_verdict.h.
#include "clients/ctl/check_verdict.h"

#include <algorithm>
#include <cctype>
#include <cmath>
#include <random>
#include <utility>

namespace hapticd::ctl {
namespace {

constexpr int kDirections = 6;

bool is_negative(v1::Axis direction) {
  return direction == v1::AXIS_NEGATIVE_X || direction == v1::AXIS_NEGATIVE_Y ||
         direction == v1::AXIS_NEGATIVE_Z;
}

/// Raw directions that become x, y, z of D.
std::array<v1::Axis, 3> raw_axes(const v1::DeviceProfile& profile) {
  std::array<v1::Axis, 3> axes{v1::AXIS_POSITIVE_X, v1::AXIS_POSITIVE_Y, v1::AXIS_POSITIVE_Z};
  const v1::AxisMap& map = profile.axis_map();
  for (int i = 0; i < 3 && map.axes_size() == 3; ++i) {
    axes[static_cast<std::size_t>(i)] = map.axes(i);
  }
  return axes;
}

char first_letter(const std::string& answer) {
  for (const char c : answer) {
    if (std::isspace(static_cast<unsigned char>(c)) == 0) {
      return static_cast<char>(std::tolower(static_cast<unsigned char>(c)));
    }
  }
  return 0;
}

/// Fills the one place that no movement determined with the remaining axis.
bool complete(std::array<v1::Axis, 3>& came) {
  std::array<int, 3> uses{};
  int untried = -1;
  for (int i = 0; i < 3; ++i) {
    const v1::Axis direction = came[static_cast<std::size_t>(i)];
    if (direction == v1::AXIS_UNSPECIFIED) {
      if (untried >= 0) return false;
      untried = i;
    } else {
      ++uses[static_cast<std::size_t>(index_of(direction))];
    }
  }
  if (std::any_of(uses.begin(), uses.end(), [](int count) { return count > 1; })) return false;
  if (untried < 0) return true;
  const auto left = std::find(uses.begin(), uses.end(), 0) - uses.begin();
  came[static_cast<std::size_t>(untried)] = direction_along(static_cast<int>(left), false);
  return true;
}

}  // namespace

int index_of(v1::Axis direction) { return (static_cast<int>(direction) - 1) / 2; }

v1::Axis direction_along(int index, bool negative) {
  return static_cast<v1::Axis>(1 + 2 * index + (negative ? 1 : 0));
}

const char* name_of(v1::Axis direction) {
  constexpr std::array<const char*, kDirections + 1> kNames{
      "nowhere", "right", "left", "up", "down", "toward you", "away from you"};
  return kNames[static_cast<std::size_t>(direction)];
}

std::optional<v1::Axis> direction_of(const std::string& answer) {
  constexpr std::string_view kLetters = "rludta";
  const std::size_t place = kLetters.find(first_letter(answer));
  if (place == std::string_view::npos) return std::nullopt;
  return static_cast<v1::Axis>(place + 1);
}

bool felt_nothing(const std::string& answer) { return first_letter(answer) == 'n'; }

bool skips(const std::string& answer) { return first_letter(answer) == 's'; }

bool needs_measuring(const v1::DeviceInfo& info) {
  const bool plugged = info.driver() == v1::DRIVER_HID || info.driver() == v1::DRIVER_PID;
  const v1::Quantity& damping = info.profile().damping_n_s_per_m();
  if (!plugged || (damping.value_size() > 0 && !damping.guess())) return false;
  const std::array<bool, 3> axes = pushed_axes(info.profile());
  return info.damping_size() < std::count(axes.begin(), axes.end(), true);
}

std::array<bool, 3> axes_of(const v1::DeviceProfile& profile, const v1::Quantity& count) {
  const double axes = count.value_size() > 0 ? count.value(0) : 6.0;
  const std::array<v1::Axis, 3> raw = raw_axes(profile);
  std::array<bool, 3> there{};
  for (std::size_t i = 0; i < 3; ++i) there[i] = index_of(raw[i]) < axes;
  return there;
}

std::array<bool, 3> pushed_axes(const v1::DeviceProfile& profile) {
  return axes_of(profile, profile.actuated_axes());
}

std::array<bool, 3> sensed_axes(const v1::DeviceProfile& profile) {
  return axes_of(profile, profile.sensed_axes());
}

// The order must not depend on the C++ library, so that --seed means the same everywhere: no
// std::shuffle.
std::vector<v1::Axis> push_order(const std::array<bool, 3>& axes, std::uint64_t seed) {
  std::vector<v1::Axis> order;
  order.reserve(kDirections);
  for (int i = 0; i < 3; ++i) {
    if (!axes[static_cast<std::size_t>(i)]) continue;
    order.push_back(direction_along(i, false));
    order.push_back(direction_along(i, true));
  }
  std::mt19937_64 random(seed);
  for (std::size_t i = order.size(); i > 1; --i) std::swap(order[i - 1], order[random() % i]);
  return order;
}

MovementVerdict judge_movement(const std::array<double, 3>& displacement) {
  std::size_t largest = 0;
  for (std::size_t i = 1; i < 3; ++i) {
    if (std::abs(displacement[i]) > std::abs(displacement[largest])) largest = i;
  }
  MovementVerdict verdict;
  verdict.length = std::abs(displacement[largest]);
  if (!(verdict.length >= kMinMovement)) return verdict;
  verdict.movement = Movement::kClear;
  for (std::size_t i = 0; i < 3; ++i) {
    const bool close = std::abs(displacement[i]) * kClearestRatio > verdict.length;
    if (i != largest && close) verdict.movement = Movement::kOblique;
  }
  if (verdict.movement == Movement::kClear) {
    verdict.came = direction_along(static_cast<int>(largest), displacement[largest] < 0.0);
  }
  return verdict;
}

std::optional<std::array<v1::Axis, 3>> mended_axes(const v1::DeviceProfile& profile,
                                                   const std::array<v1::Axis, 3>& came) {
  std::array<v1::Axis, 3> told = came;
  if (!complete(told)) return std::nullopt;
  // The profile made of the raw direction raw[i] the axis i. What a movement along +i came as, an
  // axis of the profile with a sign, is that raw direction with that sign.
  const std::array<v1::Axis, 3> raw = raw_axes(profile);
  std::array<v1::Axis, 3> mended{};
  for (std::size_t i = 0; i < 3; ++i) {
    const v1::Axis behind = raw[static_cast<std::size_t>(index_of(told[i]))];
    mended[i] = direction_along(index_of(behind), is_negative(behind) != is_negative(told[i]));
  }
  return mended;
}

std::string axes_line(const std::array<v1::Axis, 3>& axes) {
  std::string names;
  for (const v1::Axis axis : axes) names += (names.empty() ? "" : ", ") + v1::Axis_Name(axis);
  return "axis_map { axes: [" + names + "] }";
}

std::string push_advice(const v1::DeviceProfile& profile, v1::Axis asked, v1::Axis felt) {
  if (index_of(asked) != index_of(felt)) {
    return "Its motors push along other axes than it senses: the firmware has to be fixed.";
  }
  std::array<int, 3> signs{1, 1, 1};
  const v1::Quantity& present = profile.axis_map().force_sign();
  for (int i = 0; i < 3 && present.value_size() == 3; ++i) {
    signs[static_cast<std::size_t>(i)] = present.value(i) < 0.0 ? -1 : 1;
  }
  signs[static_cast<std::size_t>(index_of(asked))] *= -1;
  std::string values;
  for (const int sign : signs) values += (values.empty() ? "" : ", ") + std::to_string(sign);
  return "Write into its profile: axis_map { force_sign { value: [" + values +
         "] source: \"guided check\" } }";
}

}  // namespace hapticd::ctl
