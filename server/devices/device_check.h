// The guided check of a device: pushed along each direction it can push in, a person says where it
// was felt; once all are right it may give full force. What was felt wrong begins it anew and names
// the line of the profile to change. One thread. Not RT.
#pragma once

#include <array>
#include <cstdint>
#include <filesystem>
#include <memory>
#include <span>
#include <string>
#include <vector>

#include "hapticd/v1/answer.pb.h"
#include "server/devices/check_record.h"
#include "server/scene_io/profile_loader.h"

namespace hapticd {

/// Force of a device whose axes, signs and directions nobody has checked, N: to be felt, no more.
inline constexpr double kUncheckedForce = 0.3;

/// What is checked.
struct CheckSubject {
  CheckedDevice device;
  std::string profile;             ///< its name
  AxisMapping axes;                ///< of the profile
  std::array<bool, 3> can_push{};  ///< along x, y, z of D
};

/// Axes of D along which a device pushes that can along `raw` ones of its own.
[[nodiscard]] std::array<bool, 3> pushing_axes(const std::array<bool, 3>& raw,
                                               const AxisMapping& axes);

class DeviceCheck;

/// The check of the device of `node`. `stated` as for checked_device(), `raw` as above; `folder`:
/// where passed checks are kept.
[[nodiscard]] std::unique_ptr<DeviceCheck> check_of(const HidrawNode& node,
                                                    std::span<const std::uint8_t> stated,
                                                    const std::array<bool, 3>& raw,
                                                    const LoadedProfile& profile,
                                                    const std::filesystem::path& folder);

class DeviceCheck {
 public:
  /// `folder`: where passed checks are kept; looked into once, here.
  DeviceCheck(CheckSubject subject, std::filesystem::path folder);

  /// Passed, now or before.
  [[nodiscard]] bool passed() const noexcept { return passed_; }
  /// Directions that were confirmed since the check began.
  [[nodiscard]] const std::vector<v1::Axis>& confirmed() const noexcept { return confirmed_; }
  /// A direction it can push in.
  [[nodiscard]] bool has(v1::Axis axis) const noexcept;

  /// A push began at `t_ns` on the loop's clock.
  void note_push(v1::Axis axis, std::int64_t t_ns) noexcept;
  /// The loop was not engaged at `t_ns`: a push under way was cut, and cannot be confirmed.
  void note_no_force(std::int64_t t_ns) noexcept;
  /// The last push was felt along `felt`. OK, or what was wrong and what to do.
  [[nodiscard]] v1::Result confirm(v1::Axis felt);

 private:
  [[nodiscard]] v1::Result begin_anew(v1::Axis pushed, v1::Axis felt);
  [[nodiscard]] v1::Result finish();
  [[nodiscard]] std::string remedy(v1::Axis pushed, v1::Axis felt) const;

  CheckSubject subject_;
  std::filesystem::path folder_;
  bool passed_ = false;
  bool passed_before_ = false;  ///< when hapticd started: full force is given
  std::vector<v1::Axis> confirmed_;
  v1::Axis pushed_ = v1::AXIS_UNSPECIFIED;  ///< not yet confirmed
  std::int64_t pushed_ns_ = 0;
};

}  // namespace hapticd
