// What the guided check of a device makes of a movement and of an answer: directions in the base
// frame D (x right, y up, z toward the user), and the lines of a profile that correct what is
// wrong. Pure. Not RT.
#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "hapticd/v1/answer.pb.h"
#include "hapticd/v1/device_profile.pb.h"

namespace hapticd::ctl {

/// A smaller displacement of the handle is not a movement, m.
inline constexpr double kMinMovement = 0.01;
/// The largest component must be this many times the second one. 1.5 lets a hand be 33 degrees off.
inline constexpr double kClearestRatio = 1.5;

/// Place of a direction's axis in x, y, z.
[[nodiscard]] int index_of(v1::Axis direction);
/// The direction along that axis.
[[nodiscard]] v1::Axis direction_along(int index, bool negative);
/// "right", "left", "up", "down", "toward you" or "away from you".
[[nodiscard]] const char* name_of(v1::Axis direction);
/// Of "r", "l", "u", "d", "t" or "a", or of a word that begins so, whatever its case; none: another
/// answer.
[[nodiscard]] std::optional<v1::Axis> direction_of(const std::string& answer);
/// "n" or a word that begins so: nothing was felt.
[[nodiscard]] bool felt_nothing(const std::string& answer);

/// "s" or a word that begins so: this is not wanted.
[[nodiscard]] bool skips(const std::string& answer);

/// It pushes, its damping is a guess or not stated, and not all of its axes have been measured.
/// A device that is inside the daemon cannot be measured.
[[nodiscard]] bool needs_measuring(const v1::DeviceInfo& info);

/// Which axes of D a device has that senses or pushes along `count` of its own axes: those that its
/// first raw axes become.
[[nodiscard]] std::array<bool, 3> axes_of(const v1::DeviceProfile& profile,
                                          const v1::Quantity& count);
/// Axes along which it is asked to push.
[[nodiscard]] std::array<bool, 3> pushed_axes(const v1::DeviceProfile& profile);
/// Axes along which the handle can be led.
[[nodiscard]] std::array<bool, 3> sensed_axes(const v1::DeviceProfile& profile);

/// Both directions of each axis, each once, in an order that `seed` alone decides.
[[nodiscard]] std::vector<v1::Axis> push_order(const std::array<bool, 3>& axes, std::uint64_t seed);

/// What a displacement was.
enum class Movement : std::uint8_t { kClear, kTooShort, kOblique };

struct MovementVerdict {
  Movement movement = Movement::kTooShort;
  v1::Axis came = v1::AXIS_UNSPECIFIED;  ///< of kClear
  double length = 0.0;                   ///< m
};

/// `displacement`: p_DH after the movement less that before it, m.
[[nodiscard]] MovementVerdict judge_movement(const std::array<double, 3>& displacement);

/// The raw directions that should become x, y and z of D, where `came[i]` is what the device
/// reported of a movement along +x, +y, +z, and AXIS_UNSPECIFIED of an axis that was not tried.
/// None: the movements contradict each other.
[[nodiscard]] std::optional<std::array<v1::Axis, 3>> mended_axes(
    const v1::DeviceProfile& profile, const std::array<v1::Axis, 3>& came);

/// A line of a profile: axis_map { axes: [AXIS_POSITIVE_X, ...] }
[[nodiscard]] std::string axes_line(const std::array<v1::Axis, 3>& axes);

/// What a push felt elsewhere says of the profile, and what to write into it.
[[nodiscard]] std::string push_advice(const v1::DeviceProfile& profile, v1::Axis asked,
                                      v1::Axis felt);

}  // namespace hapticd::ctl
