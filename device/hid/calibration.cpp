// See calibration.h.
#include "device/hid/calibration.h"

#include <stdexcept>

#include "device/hid/device_features.h"

namespace hapticd::hid {
namespace {

/// Between two looks at a calibration that runs, ns: PROFILE.md allows ten a second.
constexpr std::int64_t kLookEvery_ns = 100'000'000;

constexpr const char* kUnplugged = "it is unplugged";

CalibrationPhase phase_of(CalibrationState state, bool needed) {
  switch (state) {
    case CalibrationState::kRunning:
      return CalibrationPhase::kRunning;
    case CalibrationState::kOk:
      return CalibrationPhase::kDone;
    case CalibrationState::kFailed:
      return CalibrationPhase::kFailed;
    case CalibrationState::kNone:
      break;
  }
  return needed ? CalibrationPhase::kNeeded : CalibrationPhase::kUnknown;
}

CalibrationOp operation_of(CalibrationStep step) {
  switch (step) {
    case CalibrationStep::kStart:
      return CalibrationOp::kStart;
    case CalibrationStep::kZero:
      return CalibrationOp::kZeroHere;
    case CalibrationStep::kAbort:
      return CalibrationOp::kAbort;
    case CalibrationStep::kStore:
      return CalibrationOp::kStore;
  }
  return CalibrationOp::kNone;
}

}  // namespace

CalibrationStatus DeviceCalibration::status() const {
  const std::lock_guard lock(mutex_);
  return status_;
}

bool DeviceCalibration::ask(CalibrationStep step) {
  const std::lock_guard lock(mutex_);
  if (request_ != Request::kNone) return false;
  request_ = present_ ? Request::kWaiting : Request::kAnswered;
  error_ = kUnplugged;
  op_ = operation_of(step);
  return true;
}

std::optional<std::string> DeviceCalibration::take_answer() {
  const std::lock_guard lock(mutex_);
  if (request_ != Request::kAnswered) return std::nullopt;
  request_ = Request::kNone;
  return error_;
}

void DeviceCalibration::answer(const std::string& error) {
  const std::lock_guard lock(mutex_);
  request_ = Request::kAnswered;
  error_ = error;
}

void DeviceCalibration::look(const ReportChannel& channel) {
  hid::Calibration now;
  std::string error;
  if (!get_calibration(channel, now, error)) return;
  const std::lock_guard lock(mutex_);
  status_ = {phase_of(now.state, needed_), 0.01 * now.progress};
}

void DeviceCalibration::begin(const ReportChannel& channel) {
  if (needed_) look(channel);
  const std::lock_guard lock(mutex_);
  present_ = true;
}

void DeviceCalibration::end() {
  const std::lock_guard lock(mutex_);
  status_ = {};
  present_ = false;
  if (request_ == Request::kNone || request_ == Request::kAnswered) return;
  request_ = Request::kAnswered;
  error_ = kUnplugged;
}

void DeviceCalibration::tend(const std::function<ReportChannel()>& open, std::int64_t now_ns) {
  hid::Calibration asked;
  bool runs = false;
  {
    const std::lock_guard lock(mutex_);
    if (request_ == Request::kWaiting) {
      asked.op = op_;
      request_ = Request::kTaken;
    }
    runs = status_.phase == CalibrationPhase::kRunning;
  }
  const bool told = asked.op != CalibrationOp::kNone;
  if (!told && (!runs || now_ns < look_due_ns_)) return;
  look_due_ns_ = now_ns + kLookEvery_ns;
  std::string error;
  try {
    const ReportChannel channel = open();
    const bool taken = !told || calibrate(channel, asked, error);
    look(channel);
    if (taken) error.clear();
  } catch (const std::runtime_error& failure) {
    error = failure.what();
  }
  if (told) answer(error);
}

}  // namespace hapticd::hid
