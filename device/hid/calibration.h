// The calibration of a device of the HID profile (feature 0x12): what is asked for is handed to the
// thread that keeps the device attached, which speaks to the device and looks how far it is. Not
// RT.
#pragma once

#include <cstdint>
#include <functional>
#include <mutex>
#include <optional>
#include <string>

#include "device/api/calibration.h"
#include "device/api/report_channel.h"
#include "device/hid/profile_v1.h"

namespace hapticd::hid {

class DeviceCalibration final : public hapticd::Calibration {
 public:
  /// `needed`: the device says that it has to be calibrated.
  explicit DeviceCalibration(bool needed) : needed_(needed) {}

  [[nodiscard]] bool needed() const noexcept override { return needed_; }
  [[nodiscard]] CalibrationStatus status() const override;
  [[nodiscard]] bool ask(CalibrationStep step) override;
  [[nodiscard]] std::optional<std::string> take_answer() override;

  // The thread that keeps the device attached.
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
  std::int64_t look_due_ns_ = 0;  ///< that thread's
  mutable std::mutex mutex_;      ///< of all below; never held while the device is spoken to
  Request request_ = Request::kNone;
  CalibrationOp op_ = CalibrationOp::kNone;
  std::string error_;
  CalibrationStatus status_;
  bool present_ = false;
};

}  // namespace hapticd::hid
