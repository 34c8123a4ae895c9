// A device's own calibration, for callers that must not wait: one request at a time is handed over,
// and its answer is looked for later. Not RT.
#pragma once

#include <cstdint>
#include <optional>
#include <string>

namespace hapticd {

/// What a device can be asked to do; the same numbers as hapticd::v1::CalibrateStep.
enum class CalibrationStep : std::uint8_t {
  kStart = 1,  ///< begin: the device moves, or is to be moved
  kZero = 2,   ///< take the present pose as its zero
  kAbort = 3,
  kStore = 4,  ///< keep what was found beyond a loss of power
};

/// How far a calibration is; the same numbers as hapticd::v1::CalibrationState.
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

/// Any thread may call all of it.
class Calibration {
 public:
  Calibration() = default;
  Calibration(const Calibration&) = delete;
  Calibration& operator=(const Calibration&) = delete;
  Calibration(Calibration&&) = delete;
  Calibration& operator=(Calibration&&) = delete;
  virtual ~Calibration() = default;

  /// The device has said that it has to be calibrated.
  [[nodiscard]] virtual bool needed() const noexcept = 0;
  [[nodiscard]] virtual CalibrationStatus status() const = 0;
  /// Hands over a request; false when one is under way already.
  [[nodiscard]] virtual bool ask(CalibrationStep step) = 0;
  /// How the request ended, once: empty when the device took it, else why it did not. None: still
  /// under way, or there was none.
  [[nodiscard]] virtual std::optional<std::string> take_answer() = 0;
};

}  // namespace hapticd
