// See device_check.h.
#include "device/attach/device_check.h"

#include <algorithm>
#include <array>
#include <charconv>
#include <stdexcept>
#include <utility>

namespace hapticd {
namespace {

/// A push, ns.
constexpr std::int64_t kPush_ns = 1'000'000'000;

/// 0, 1, 2 for x, y, z.
std::size_t index_of(PushAxis axis) { return (axis - std::size_t{1}) / 2; }

std::string name_of(PushAxis axis) {
  return std::string(axis % 2 == 1 ? "+" : "-") + "xyz"[index_of(axis)];
}

/// What to do about a measuring that has found nothing.
std::string remedy_of(RingVerdict verdict) {
  switch (verdict) {
    case RingVerdict::kMeasured:
      break;
    case RingVerdict::kNoRing:
      return "The handle has not rung. Let it hang or stand free, away from its stops; with much "
             "dry friction, or a force limit below 1 N, its damping cannot be measured.";
    case RingVerdict::kHeld:
      return "Something held on to the handle. Let it hang free: hands off, and its cable out of "
             "the way.";
    case RingVerdict::kUnclear:
      return "The handle did not ring clearly. Nothing may touch it; fasten the device.";
    case RingVerdict::kTooLittle:
      return "No damping was found that could be counted. State delay_s in its profile if it has "
             "a delay; friction that is dry counts none.";
    case RingVerdict::kMoved:
      return "The handle went more than 15 mm away. Put it where it stays by itself, and take the "
             "hands off.";
    case RingVerdict::kLimited:
      return "A limit of force, heat or energy interfered. Put the handle where its weight is "
             "borne; a device that was just checked has its full force after hapticd is "
             "restarted.";
    case RingVerdict::kCut:
      return "It was cut short: the force went off, or the scene or the clutch changed.";
    case RingVerdict::kTicksLost:
      return "Ticks were missing. See hapticctl doctor, then try again.";
  }
  return {};
}

/// Short, for people.
std::string short_text(double number) {
  std::array<char, 32> text{};
  const auto end =
      std::to_chars(text.data(), text.data() + text.size(), number, std::chars_format::general, 2);
  return {text.data(), end.ptr};
}

}  // namespace

std::array<bool, 3> pushing_axes(const std::array<bool, 3>& raw, const AxisMapping& axes) {
  return {raw[axes.raw_axis[0]], raw[axes.raw_axis[1]], raw[axes.raw_axis[2]]};
}

std::optional<DampingBounds> counted_damping(const MeasuredDamping& measured,
                                             const std::array<bool, 3>& can_push) {
  std::optional<DampingBounds> lowest;
  for (std::size_t i = 0; i < measured.size(); ++i) {
    if (!can_push[i]) continue;
    if (!measured[i]) return std::nullopt;
    if (!lowest) lowest = measured[i];
    lowest->lower = std::min(lowest->lower, measured[i]->lower);
    lowest->upper = std::min(lowest->upper, measured[i]->upper);
  }
  return lowest;
}

std::unique_ptr<DeviceCheck> check_of(const HidrawNode& node, const DeviceStatement& statement,
                                      const std::filesystem::path& folder) {
  const DeviceSheet& sheet = statement.sheet;
  CheckSubject subject;
  subject.device = checked_device(node, statement.identity, sheet.axes);
  subject.profile = {std::string(device_name(sheet.profile)), sheet.axes};
  subject.can_push = pushing_axes(statement.push_axes, sheet.axes);
  return std::make_unique<DeviceCheck>(std::move(subject), folder);
}

DeviceCheck::DeviceCheck(CheckSubject subject, std::filesystem::path folder)
    : subject_(std::move(subject)), folder_(std::move(folder)) {
  passed_ = passed_before_ = is_remembered(folder_, subject_.device);
  damping_ = read_damping(folder_, subject_.device);
}

bool DeviceCheck::has(PushAxis axis) const noexcept {
  return axis >= 1 && axis <= kPushAxes && subject_.can_push[index_of(axis)];
}

void DeviceCheck::note_push(PushAxis axis, std::int64_t t_ns) noexcept {
  pushed_ = axis;
  pushed_ns_ = t_ns;
}

void DeviceCheck::note_no_force(std::int64_t t_ns) noexcept {
  if (t_ns > pushed_ns_ && t_ns - pushed_ns_ < kPush_ns) pushed_ = 0;
}

CheckAnswer DeviceCheck::confirm(PushAxis felt) {
  const PushAxis pushed = std::exchange(pushed_, PushAxis{0});
  if (pushed == 0) {
    return {CheckVerdict::kNoPush,
            "There is no push to confirm. Each push can be confirmed once, unless it was "
            "cut short. Push first."};
  }
  if (felt != pushed) return begin_anew(pushed, felt);
  if (std::find(confirmed_.begin(), confirmed_.end(), felt) == confirmed_.end()) {
    confirmed_.push_back(felt);
  }
  const auto wanted = static_cast<std::size_t>(
      2 * std::count(subject_.can_push.begin(), subject_.can_push.end(), true));
  if (confirmed_.size() >= wanted) return finish();
  return {CheckVerdict::kRight, std::to_string(confirmed_.size()) + " of " +
                                    std::to_string(wanted) + " directions are confirmed."};
}

CheckAnswer DeviceCheck::finish() {
  if (subject_.device.serial.empty()) {
    return {CheckVerdict::kNotKept,
            "All directions are right, but the device has no serial number by which it "
            "could be known again: it gets 0.3 N at most. Ask its maker for one."};
  }
  try {
    remember_check(folder_, subject_.device);
  } catch (const std::runtime_error& error) {
    return {
        CheckVerdict::kNotKept,
        std::string("All directions are right, but the result cannot be saved: ") + error.what()};
  }
  passed_ = true;
  return {CheckVerdict::kRight, passed_before_
                                    ? "Checked again: full force as before."
                                    : "Checked: full force from the next start of hapticd on."};
}

// A device that was felt to push wrongly is not a checked one, whatever it was before.
CheckAnswer DeviceCheck::begin_anew(PushAxis pushed, PushAxis felt) {
  confirmed_.clear();
  std::string message = "Pushed along " + name_of(pushed) + ", felt along " + name_of(felt) +
                        ": the check starts again. " + remedy(pushed, felt);
  if (passed_) {
    passed_ = false;
    try {
      forget_check(folder_, subject_.device);
    } catch (const std::runtime_error& error) {
      message += " It still counts as checked: " + std::string(error.what());
    }
  }
  return {CheckVerdict::kFeltWrong, message};
}

CheckAnswer DeviceCheck::note_damping(PushAxis axis, const DampingFit& fit) {
  if (fit.verdict != RingVerdict::kMeasured) {
    return {CheckVerdict::kNotMeasured, remedy_of(fit.verdict)};
  }
  const std::size_t along = index_of(axis);
  const std::string found = std::string("Damping along ") + "xyz"[along] + ": at least " +
                            short_text(fit.bounds.lower) + ", at most " +
                            short_text(fit.bounds.upper) + " N s/m, with " +
                            short_text(fit.bounds.mass) + " kg.";
  if (subject_.device.serial.empty()) {
    return {CheckVerdict::kNotKept,
            found +
                " It cannot be kept: the device has no serial number by which it could be "
                "known again."};
  }
  MeasuredDamping known = damping_;
  known[along] = fit.bounds;
  try {
    keep_damping(folder_, subject_.device, known);
  } catch (const std::runtime_error& error) {
    return {CheckVerdict::kNotKept, found + " It cannot be saved: " + error.what()};
  }
  damping_ = known;
  const bool whole = counted_damping(damping_, subject_.can_push).has_value();
  return {CheckVerdict::kRight, found + (whole ? " It counts from the next start of hapticd on."
                                               : " The other axes are still to be measured.")};
}

std::string DeviceCheck::remedy(PushAxis pushed, PushAxis felt) const {
  if (index_of(pushed) != index_of(felt)) {
    return "In the profile " + subject_.profile.name +
           ", correct the order of axis_map { axes: ... }, which positions follow too; if those "
           "are right, the device mixes up its motors.";
  }
  Array3 sign = subject_.profile.axes.force_sign;
  sign[index_of(pushed)] = -sign[index_of(pushed)];
  std::string values;
  for (const double one : sign)
    values += (values.empty() ? "" : ", ") + std::string(one < 0.0 ? "-1" : "1");
  return "In the profile " + subject_.profile.name + ", set axis_map { force_sign { value: [" +
         values + "] source: \"guided check\" } }, and restart hapticd.";
}

}  // namespace hapticd
