// A HID device's own calibration (feature 0x12), for who must not wait: one request at a time is
// handed to the keeper's thread, which speaks to the device and looks how far it is. Not RT.
#pragma once

#include <cstdint>
#include <functional>
#include <mutex>
#include <optional>
#include <string>

#include "device/hid/profile_v1.h"
#include "device/report_io/report_channel.h"

namespace hapticd {

enum class CalibrationPhase : std::uint8_t {
  kUnknown,  ///< the device does not say
  kNeeded,   ///< its zero is not known: no force until it is calibrated
  kRunning,
  kDone,
  kFailed,
};

/// How far it is.
struct CalibrationStatus {
  CalibrationPhase phase = CalibrationPhase::kUnknown;
  double progress = 0.0;  ///< [0, 1]
};

class DeviceCalibration {
 public:
  /// `needed`: the device says that it has to be calibrated.
  explicit DeviceCalibration(bool needed) : needed_(needed) {}

  // Any thread.
  [[nodiscard]] bool needed() const noexcept { return needed_; }
  [[nodiscard]] CalibrationStatus status() const;
  /// Hands over a request; false when one is under way already.
  [[nodiscard]] bool ask(hid::CalibrationOp op);
  /// How the request ended, once: empty when the device took it, else why it did not. None: still
  /// under way, or there was none.
  [[nodiscard]] std::optional<std::string> take_answer();

  // The keeper's thread.
  /// The device is there: `channel` is nobody else's yet.
  void begin(const ReportChannel& channel);
  /// It is gone; so is what was asked for.
  void end();
  /// Sees to what was asked for, and to a calibration that runs. `open` gives a channel for
  /// features that no other thread uses, or throws std::runtime_error; it is only called when there
  /// is something to do. May wait for seconds.
  void tend(const std::function<ReportChannel()>& open, std::int64_t now_ns);

 private:
  enum class Request : std::uint8_t { kNone, kWaiting, kTaken, kAnswered };

  void look(const ReportChannel& channel);
  void answer(const std::string& error);

  const bool needed_;
  std::int64_t look_due_ns_ = 0;  ///< keeper's
  mutable std::mutex mutex_;      ///< of all below; never held while the device is spoken to
  Request request_ = Request::kNone;
  hid::CalibrationOp op_ = hid::CalibrationOp::kNone;
  std::string error_;
  CalibrationStatus status_;
  bool present_ = false;
};

}  // namespace hapticd
