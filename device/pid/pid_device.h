// A two-axis force device of the HID PID class (OpenFFBoard, VPforce Rhino and others that their
// descriptor says), as the loop sees it. Experimental: no such device was tried. The class has
// no watchdog: when this process dies while a force is on, the device keeps pushing. Therefore no
// force beyond the peak of the profile leaves here, whatever is asked for, and detach() and every
// end of the loop send zero. It reports neither time nor which command it obeys: when a sample was
// made is derived from when it was read (report_time.h), and there is no measured delay. What its
// PID State report says is obeyed in the same tick: paused, motors off or without power, a switch
// that is off. Frames:
// device_sample.h; the axes by AxisMapping, raw z does not exist and stays 0. RT: the functions of
// HapticDevice.
#pragma once

#include <array>
#include <atomic>
#include <cstdint>

#include "device/api/axis_mapping.h"
#include "device/api/haptic_device.h"
#include "device/api/report_channel.h"
#include "device/pid/pid_layout.h"
#include "device/pid/pid_reports.h"
#include "device/pid/report_time.h"
#include "device/report_io/reader_gate.h"
#include "device/report_io/report_writer.h"

namespace hapticd::pid {

/// How it is used.
struct PidSettings {
  AxisMapping axes;  ///< positions count from the middle of their logical range
  PidLayout layout;
  bool has_switches = true;  ///< what its PID State report says of its switches is so
};

/// What went on, since the construction. Any thread.
struct PidCounters {
  std::uint64_t samples = 0;     ///< used
  std::uint64_t superseded = 0;  ///< read together with a newer one
  std::uint64_t overflows = 0;   ///< queues of old reports, thrown away
  std::uint64_t cut = 0;         ///< commands beyond the peak
  std::uint64_t states = 0;      ///< PID State reports
};

class PidDevice final : public HapticDevice {
 public:
  /// Not attached yet. Throws as ReportWriter does.
  PidDevice(const DeviceProfile& profile, const PidSettings& settings, ReportWriter::Clock clock);
  ~PidDevice() override { detach(); }

  [[nodiscard]] const DeviceProfile& profile() const noexcept override { return profile_; }
  HD_REALTIME ReadOutcome read(std::int64_t now_ns, DeviceSample& sample) noexcept override;
  HD_REALTIME bool write(std::int64_t now_ns, const DeviceCommand& command) noexcept override;
  HD_REALTIME void write_zero(std::int64_t now_ns) noexcept override;

  /// Goes on with this channel, whose effects were started with these numbers. Not RT; one thread
  /// attaches and detaches.
  void attach(const ReportChannel& channel, const EffectBlocks& blocks);
  /// Ends the use of the channel, and of the device's motors if it is still there. May wait for
  /// seconds. Not RT.
  void detach();
  /// Reading or writing has failed: the channel is of no more use. Any thread.
  [[nodiscard]] bool failed() const noexcept { return gate_.failed() || writer_.failed(); }
  [[nodiscard]] PidCounters counters() const noexcept;
  [[nodiscard]] ReportWriter& writer() noexcept { return writer_; }

 private:
  HD_REALTIME ReadOutcome drain(std::int64_t now_ns, DeviceSample& sample) noexcept;
  HD_REALTIME void take(std::span<const std::uint8_t> report, DeviceSample& sample) noexcept;
  HD_REALTIME void obey_state(std::span<const std::uint8_t> report) noexcept;
  HD_REALTIME Array3 magnitudes(const DeviceCommand& command) noexcept;

  DeviceProfile profile_;
  PidSettings settings_;
  std::int64_t interval_ns_;  ///< from one report to the next
  ReportChannel channel_;
  ReaderGate gate_;
  bool attached_ = false;                 ///< of the thread that attaches
  std::atomic<std::uint16_t> blocks_{0};  ///< that of X in the low byte, of Y in the high one

  // The loop's.
  std::uint32_t attachment_ = 0;
  bool has_sample_ = false;
  bool enabled_ = false;
  bool saturated_ = false;
  bool let_go_ = false;  ///< as its last PID State report has it, no force may be on
  std::array<std::uint8_t, kMaxReport> newest_{};  ///< report of its position
  ReportTime report_time_;
  DeviceSample last_;

  std::array<std::atomic<std::uint64_t>, 5> counts_{};  ///< as PidCounters
  ReportWriter writer_;
};

}  // namespace hapticd::pid
