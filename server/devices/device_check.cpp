// See device_check.h.
#include "server/devices/device_check.h"

#include <algorithm>
#include <stdexcept>
#include <utility>

#include "server/encoding/request_result.h"

namespace hapticd {
namespace {

/// A push, ns.
constexpr std::int64_t kPush_ns = 1'000'000'000;

/// 0, 1, 2 for x, y, z.
std::size_t index_of(v1::Axis axis) { return static_cast<std::size_t>((axis - 1) / 2); }

std::string name_of(v1::Axis axis) {
  return std::string(axis % 2 == 1 ? "+" : "-") + "xyz"[index_of(axis)];
}

}  // namespace

std::array<bool, 3> pushing_axes(const std::array<bool, 3>& raw, const AxisMapping& axes) {
  return {raw[axes.raw_axis[0]], raw[axes.raw_axis[1]], raw[axes.raw_axis[2]]};
}

std::unique_ptr<DeviceCheck> check_of(const HidrawNode& node, std::span<const std::uint8_t> stated,
                                      const std::array<bool, 3>& raw, const LoadedProfile& profile,
                                      const std::filesystem::path& folder) {
  CheckSubject subject;
  subject.device = checked_device(node, stated, profile.axes);
  subject.profile = profile.message.name();
  subject.axes = profile.axes;
  subject.can_push = pushing_axes(raw, profile.axes);
  return std::make_unique<DeviceCheck>(std::move(subject), folder);
}

DeviceCheck::DeviceCheck(CheckSubject subject, std::filesystem::path folder)
    : subject_(std::move(subject)), folder_(std::move(folder)) {
  passed_ = passed_before_ = is_remembered(folder_, subject_.device);
}

bool DeviceCheck::has(v1::Axis axis) const noexcept {
  return axis >= v1::AXIS_POSITIVE_X && axis <= v1::AXIS_NEGATIVE_Z &&
         subject_.can_push[index_of(axis)];
}

void DeviceCheck::note_push(v1::Axis axis, std::int64_t t_ns) noexcept {
  pushed_ = axis;
  pushed_ns_ = t_ns;
}

void DeviceCheck::note_no_force(std::int64_t t_ns) noexcept {
  if (t_ns > pushed_ns_ && t_ns - pushed_ns_ < kPush_ns) pushed_ = v1::AXIS_UNSPECIFIED;
}

v1::Result DeviceCheck::confirm(v1::Axis felt) {
  const v1::Axis pushed = std::exchange(pushed_, v1::AXIS_UNSPECIFIED);
  if (pushed == v1::AXIS_UNSPECIFIED) {
    return result_of(v1::RESULT_CODE_WRONG_STATE, "calibrate.step",
                     "There is no push to confirm: each one can be confirmed once, when it was not "
                     "cut short. Push first.");
  }
  if (felt != pushed) return begin_anew(pushed, felt);
  if (std::find(confirmed_.begin(), confirmed_.end(), felt) == confirmed_.end()) {
    confirmed_.push_back(felt);
  }
  const auto wanted = static_cast<std::size_t>(
      2 * std::count(subject_.can_push.begin(), subject_.can_push.end(), true));
  if (confirmed_.size() >= wanted) return finish();
  return result_of(v1::RESULT_CODE_OK, "",
                   std::to_string(confirmed_.size()) + " of " + std::to_string(wanted) +
                       " directions are confirmed.");
}

v1::Result DeviceCheck::finish() {
  if (subject_.device.serial.empty()) {
    return result_of(v1::RESULT_CODE_FAILED, "calibrate",
                     "All directions are right, but the device has no serial number by which it "
                     "could be known again: it gets 0.3 N at most. Ask its maker for one.");
  }
  try {
    remember_check(folder_, subject_.device);
  } catch (const std::runtime_error& error) {
    return result_of(
        v1::RESULT_CODE_FAILED, "calibrate",
        std::string("All directions are right, but that cannot be kept: ") + error.what());
  }
  passed_ = true;
  return result_of(v1::RESULT_CODE_OK, "",
                   passed_before_ ? "Checked anew: full force as before."
                                  : "Checked: full force from the next start of hapticd on.");
}

// A device that was felt to push wrongly is not a checked one, whatever it was before.
v1::Result DeviceCheck::begin_anew(v1::Axis pushed, v1::Axis felt) {
  confirmed_.clear();
  std::string message = "Pushed along " + name_of(pushed) + ", felt along " + name_of(felt) +
                        ": the check begins anew. " + remedy(pushed, felt);
  if (passed_) {
    passed_ = false;
    try {
      forget_check(folder_, subject_.device);
    } catch (const std::runtime_error& error) {
      message += " It still counts as checked: " + std::string(error.what());
    }
  }
  return result_of(v1::RESULT_CODE_INVALID, "calibrate.axis", message);
}

std::string DeviceCheck::remedy(v1::Axis pushed, v1::Axis felt) const {
  if (index_of(pushed) != index_of(felt)) {
    return "In the profile " + subject_.profile +
           ", correct the order of axis_map { axes: ... }, which positions follow too; if those "
           "are "
           "right, it is the device that mixes up its motors.";
  }
  Array3 sign = subject_.axes.force_sign;
  sign[index_of(pushed)] = -sign[index_of(pushed)];
  std::string values;
  for (const double one : sign)
    values += (values.empty() ? "" : ", ") + std::string(one < 0.0 ? "-1" : "1");
  return "In the profile " + subject_.profile + ", set axis_map { force_sign { value: [" + values +
         "] source: \"guided check\" } }, and start hapticd anew.";
}

}  // namespace hapticd
