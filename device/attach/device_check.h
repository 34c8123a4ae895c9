// The guided check of a device: pushed along each direction it can push in, a person says where it
// was felt; once all are right it may give full force. What was felt wrong begins it anew and names
// the line of the profile to change. One thread. Not RT.
#pragma once

#include <array>
#include <cstdint>
#include <filesystem>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "core/tick/push_axis.h"
#include "device/api/driver.h"
#include "device/attach/check_record.h"
#include "device/attach/damping_record.h"

namespace hapticd {

/// Force of a device whose axes, signs and directions nobody has checked, N: to be felt, no more.
inline constexpr double kUncheckedForce = 0.3;

/// Of a device's profile, what its check depends on.
struct CheckedProfile {
  std::string name;
  AxisMapping axes;
};

/// What is checked.
struct CheckSubject {
  CheckedDevice device;
  CheckedProfile profile;
  std::array<bool, 3> can_push{};  ///< along x, y, z of D
};

/// Axes of D along which a device pushes that can along `raw` ones of its own.
[[nodiscard]] std::array<bool, 3> pushing_axes(const std::array<bool, 3>& raw,
                                               const AxisMapping& axes);

/// What came of a confirmation.
enum class CheckVerdict : std::uint8_t {
  kRight,        ///< felt where it was pushed
  kFeltWrong,    ///< felt elsewhere: the check begins anew
  kNoPush,       ///< there is no whole push to confirm
  kNotKept,      ///< all is right, but that cannot be kept
  kNotMeasured,  ///< its damping was not found
};

struct CheckAnswer {
  CheckVerdict verdict = CheckVerdict::kRight;
  std::string words;  ///< how far it is, or what was wrong and what to do; for people
};

class DeviceCheck;

/// The damping that may be counted with: the lowest that was measured, once each axis that the
/// device can push along was; empty before.
[[nodiscard]] std::optional<DampingBounds> counted_damping(const MeasuredDamping& measured,
                                                           const std::array<bool, 3>& can_push);

/// The check of the device of `node`, of which its driver has found out `statement`; `folder`:
/// where passed checks are kept.
[[nodiscard]] std::unique_ptr<DeviceCheck> check_of(const HidrawNode& node,
                                                    const DeviceStatement& statement,
                                                    const std::filesystem::path& folder);

class DeviceCheck {
 public:
  /// `folder`: where passed checks are kept; looked into once, here.
  DeviceCheck(CheckSubject subject, std::filesystem::path folder);

  /// Passed, now or before.
  [[nodiscard]] bool passed() const noexcept { return passed_; }
  /// Directions that were confirmed since the check began.
  [[nodiscard]] const std::vector<PushAxis>& confirmed() const noexcept { return confirmed_; }
  /// Along x, y, z of D.
  [[nodiscard]] const std::array<bool, 3>& can_push() const noexcept { return subject_.can_push; }
  /// A direction it can push in.
  [[nodiscard]] bool has(PushAxis axis) const noexcept;

  /// A push began at `t_ns` on the loop's clock.
  void note_push(PushAxis axis, std::int64_t t_ns) noexcept;
  /// The loop was not engaged at `t_ns`: a push under way was cut, and cannot be confirmed.
  void note_no_force(std::int64_t t_ns) noexcept;
  /// The last push was felt along `felt`.
  [[nodiscard]] CheckAnswer confirm(PushAxis felt);

  /// What is known of its damping, of now or before.
  [[nodiscard]] const MeasuredDamping& damping() const noexcept { return damping_; }
  /// A measuring along `axis` has ended so; what it found is kept.
  [[nodiscard]] CheckAnswer note_damping(PushAxis axis, const DampingFit& fit);

 private:
  [[nodiscard]] CheckAnswer begin_anew(PushAxis pushed, PushAxis felt);
  [[nodiscard]] CheckAnswer finish();
  [[nodiscard]] std::string remedy(PushAxis pushed, PushAxis felt) const;

  CheckSubject subject_;
  std::filesystem::path folder_;
  bool passed_ = false;
  bool passed_before_ = false;  ///< when hapticd started: full force is given
  MeasuredDamping damping_;
  std::vector<PushAxis> confirmed_;
  PushAxis pushed_ = 0;  ///< not yet confirmed
  std::int64_t pushed_ns_ = 0;
};

}  // namespace hapticd
