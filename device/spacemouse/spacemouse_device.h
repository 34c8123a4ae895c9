// A SpaceMouse as a device without force: its deflection is a velocity, which is integrated to the
// pose of the handle H, a proxy tool. Position stays within the workspace of the profile;
// orientation has no bounds. Between reports the last deflection holds; a device that falls silent
// while displaced is at rest. At rest it sends nothing, and every read gives the last
// pose: a rate device at rest is not stale. Rotation is about the axes of D. Frames:
// device_sample.h. RT: the functions of HapticDevice.
#pragma once

#include <array>
#include <atomic>
#include <cstdint>

#include "core/math/pose.h"
#include "device/api/axis_mapping.h"
#include "device/api/haptic_device.h"
#include "device/api/report_channel.h"
#include "device/report_io/reader_gate.h"
#include "device/spacemouse/spacemouse_report.h"

namespace hapticd::spacemouse {

/// A deflection without a report for this long is over, ns: six reports of a wireless device,
/// twelve of one with a cable. Less: the tool stutters with the radio; more: it moves on that much
/// longer after the device hung.
inline constexpr std::int64_t kSilence_ns = 100'000'000;
/// No button, in SpacemouseSettings::button.
inline constexpr std::uint8_t kNoButton = 0xFF;

/// How it is used.
struct SpacemouseSettings {
  AxisMapping axes;  ///< position_scale and rotation_scale per second; of forces nothing
  /// Button i of the sample is this one of the device, 0..31, or kNoButton.
  std::array<std::uint8_t, 32> button{0,  1,  2,  3,  4,  5,  6,  7,  8,  9,  10,
                                      11, 12, 13, 14, 15, 16, 17, 18, 19, 20, 21,
                                      22, 23, 24, 25, 26, 27, 28, 29, 30, 31};
};

/// What went on, since the construction. Any thread.
struct SpacemouseCounters {
  std::uint64_t reports = 0;    ///< read, malformed ones not included
  std::uint64_t malformed = 0;  ///< reports that are none
  std::uint64_t overflows = 0;  ///< queues of old reports, thrown away
};

class SpacemouseDevice final : public HapticDevice {
 public:
  /// Not attached yet; the pose is the place of the workspace nearest to the origin of D.
  SpacemouseDevice(const DeviceProfile& profile, const SpacemouseSettings& settings);
  ~SpacemouseDevice() override { detach(); }

  [[nodiscard]] const DeviceProfile& profile() const noexcept override { return profile_; }
  HD_REALTIME ReadOutcome read(std::int64_t now_ns, DeviceSample& sample) noexcept override;
  /// Goes nowhere; false for a command that is not finite.
  HD_REALTIME bool write(std::int64_t now_ns, const DeviceCommand& command) noexcept override;
  HD_REALTIME void write_zero(std::int64_t now_ns) noexcept override;

  /// Goes on with this channel, from the pose where it is. Not RT; one thread attaches and
  /// detaches.
  void attach(const ReportChannel& channel);
  /// Ends the use of the channel: returns when the loop is not in it. Not RT.
  void detach() { gate_.close(); }
  /// The channel is of no more use. Any thread.
  [[nodiscard]] bool failed() const noexcept { return gate_.failed(); }
  [[nodiscard]] SpacemouseCounters counters() const noexcept;

 private:
  /// A velocity and until when it holds.
  struct Rate {
    Array3 value{};
    std::int64_t until_ns = 0;
  };

  HD_REALTIME void begin_anew(std::int64_t now_ns) noexcept;
  HD_REALTIME void advance(std::int64_t now_ns) noexcept;
  /// False: the device is gone.
  HD_REALTIME bool drain(std::int64_t now_ns) noexcept;
  HD_REALTIME void take(const Report& report, std::int64_t now_ns) noexcept;

  DeviceProfile profile_;
  SpacemouseSettings settings_;
  ReportChannel channel_;
  ReaderGate gate_;

  // The loop's.
  std::uint32_t attachment_ = 0;
  Pose X_DH_;
  Rate v_, w_;  ///< in D, m/s and rad/s
  std::int64_t last_ns_ = 0;
  std::uint64_t counter_ = 0;
  std::uint32_t buttons_ = 0;
  DeviceSample last_;

  std::array<std::atomic<std::uint64_t>, 3> counts_{};  ///< as SpacemouseCounters
};

}  // namespace hapticd::spacemouse
