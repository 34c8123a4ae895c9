// A device of HID profile v1 as the loop sees it. Reading: everything that waits is drained and the
// newest sample kept; what the system queued while nothing was read is thrown away whole, since
// such a queue keeps its oldest reports. Writing: the command goes to a separate thread
// (report_writer.h); ENABLE is asked for as the profile demands, and dropped when the device drops
// it. Outlives unplugging: detached it is lost, attached again it goes on. Frames: device_sample.h.
// RT: the functions of HapticDevice.
#pragma once

#include <algorithm>
#include <array>
#include <atomic>
#include <cstdint>

#include "core/safety/echo_watch.h"
#include "device/api/axis_mapping.h"
#include "device/api/haptic_device.h"
#include "device/api/pace_source.h"
#include "device/api/report_channel.h"
#include "device/hid/counter_unwrap.h"
#include "device/hid/device_clock.h"
#include "device/hid/profile_v1.h"
#include "device/report_io/drained_queue.h"
#include "device/report_io/reader_gate.h"
#include "device/report_io/report_writer.h"

namespace hapticd::hid {

/// Time to read a sample, and the bounds of the age below, ns. Longer: a device that falls silent
/// shows later; shorter: a tick that comes late goes without a sample.
inline constexpr std::int64_t kReadingTime_ns = 500'000;
inline constexpr std::int64_t kOldestAtAnyRate_ns = 2'500'000;

/// From one report of a device of `in_rate` Hz to the next.
[[nodiscard]] constexpr std::int64_t frame_ns(std::uint16_t in_rate) noexcept {
  return 1'000'000'000 / std::max<std::int64_t>(in_rate, 1);
}

/// A sample older than this is not used, ns: two frames of a device of `in_rate` Hz, and the time
/// to read them.
[[nodiscard]] constexpr std::int64_t oldest_sample_ns(std::uint16_t in_rate) noexcept {
  return std::min(2 * frame_ns(in_rate) + kReadingTime_ns, kOldestAtAnyRate_ns);
}

/// What went on, since the construction. Any thread.
struct HidCounters {
  std::uint64_t samples = 0;     ///< used
  std::uint64_t superseded = 0;  ///< read together with a newer one
  std::uint64_t lost = 0;        ///< by the device's count of samples
  std::uint64_t overflows = 0;   ///< queues thrown away
  std::uint64_t too_old = 0;     ///< newest ones that were older than oldest_sample_ns
  std::uint64_t malformed = 0;   ///< reports that are none
};

class HidDevice final : public HapticDevice {
 public:
  /// Not attached yet. `profile`: what the device is, its capabilities applied; `axes`: how its own
  /// axes lie in D. Throws as ReportWriter does.
  HidDevice(const DeviceProfile& profile, const Capabilities& capabilities,
            ReportWriter::Clock clock, const AxisMapping& axes = {});
  ~HidDevice() override;

  [[nodiscard]] const DeviceProfile& profile() const noexcept override { return profile_; }
  HD_REALTIME ReadOutcome read(std::int64_t now_ns, DeviceSample& sample) noexcept override;
  HD_REALTIME bool write(std::int64_t now_ns, const DeviceCommand& command) noexcept override;
  HD_REALTIME void write_zero(std::int64_t now_ns) noexcept override;

  /// Its reports as the beat of the loop. A wait is that of the loop's thread, and detach() waits
  /// for its end.
  [[nodiscard]] PaceSource pace() noexcept;

  /// Goes on with this channel. Not RT; one thread attaches and detaches.
  void attach(const ReportChannel& channel);
  /// Ends the use of the channel: returns when neither thread is in it. Not RT.
  void detach();
  /// Reading or writing has failed: the channel is of no more use. Any thread.
  [[nodiscard]] bool failed() const noexcept { return gate_.failed() || writer_.failed(); }
  [[nodiscard]] HidCounters counters() const noexcept;
  [[nodiscard]] ReportWriter& writer() noexcept { return writer_; }

 private:
  /// How far the force is asked for.
  enum class Enabling : std::uint8_t {
    kOff,      ///< no ENABLE
    kAsking,   ///< ENABLE and zeros, until the device says ENABLED
    kOn,       ///< ENABLE and the wrench
    kDropped,  ///< the device took it back: nothing until the loop has let go
  };

  [[nodiscard]] Waited wait(std::int64_t until_ns) noexcept;
  HD_REALTIME Drained gather() noexcept;
  HD_REALTIME ReadOutcome drain(std::int64_t now_ns, DeviceSample& sample) noexcept;
  HD_REALTIME ReadOutcome take(const StateReport& state, std::uint64_t superseded,
                               std::int64_t now_ns, DeviceSample& sample) noexcept;
  HD_REALTIME void add_flags(DeviceSample& sample) const noexcept;
  HD_REALTIME void note_echo_of(const StateReport& state, std::int64_t device_ns) noexcept;
  HD_REALTIME void advance_enabling(bool wanted) noexcept;
  HD_REALTIME void begin_anew() noexcept;
  [[nodiscard]] HD_REALTIME bool told_as_spring(const DeviceCommand& command,
                                                const CommandReport& base,
                                                AffineReport& report) const noexcept;

  DeviceProfile profile_;
  Capabilities capabilities_;
  AxisMapping axes_;
  std::int64_t oldest_ns_;  ///< age of a sample that is not used
  ReportChannel channel_;
  ReaderGate gate_;

  // The loop's.
  std::uint32_t attachment_ = 0;
  CounterUnwrap<std::uint16_t> seq_;
  CounterUnwrap<std::uint32_t> clock_us_;
  ClockMatch clock_;
  EchoWatch echo_;
  StateReport newest_;       ///< of those read and not yet used
  std::uint64_t fresh_ = 0;  ///< their number
  StateReport state_;
  bool has_state_ = false;
  std::uint64_t counter_ = 0;   ///< of the newest sample
  std::uint64_t seq_base_ = 0;  ///< unwrapped seq less counter
  std::int64_t t_ns_ = 0;       ///< of the newest sample
  bool echoed_ = false;         ///< the device has reported a command of ours
  Enabling enabling_ = Enabling::kOff;

  std::array<std::atomic<std::uint64_t>, 6> counts_{};  ///< as HidCounters
  ReportWriter writer_;
};

}  // namespace hapticd::hid
