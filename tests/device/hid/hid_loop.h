// The driver and the reference firmware, tick by tick in the test's own time.
#pragma once

#include <atomic>
#include <optional>

#include "device/hid/hid_device.h"
#include "device/hid/profile_units.h"
#include "tests/device/hid/plugged_bench.h"

namespace hapticd::test {

inline constexpr std::int64_t kTick_ns = 1'000'000;
/// From the frame to the tick that reads it.
inline constexpr std::int64_t kReadLate_ns = 300'000;

inline std::atomic<std::int64_t> clock_ns{0};
inline std::int64_t clock() noexcept { return clock_ns; }

/// A device and the loop at 1 kHz.
struct Loop {
  explicit Loop(std::uint32_t caps = kHapHasVelocity, const AxisMapping& axes = {},
                std::uint16_t in_rate_hz = 1000)
      : plugged(caps) {
    clock_ns = 10'000'000'000;
    DeviceProfile profile;
    profile.driver = DeviceDriver::kHid;
    profile.affine = true;
    hid::Capabilities capabilities = kCapabilities;
    capabilities.caps = caps;
    capabilities.in_rate_hz = in_rate_hz;
    device.emplace(profile, capabilities, clock, axes);
    device->attach(plugged.channel());
  }
  ~Loop() { device->detach(); }

  /// A frame of the device and a tick of the loop; gives what the motors gave in the frame.
  HapOutput tick(double force, bool enable) {
    const HapOutput output = plugged.frame();
    clock_ns += kTick_ns;
    if (late_us > 0) plugged.bench.servo(late_us);
    step(force, enable);
    return output;
  }
  void step(double force, bool enable) {
    outcome = device->read(clock_ns + kReadLate_ns, sample);
    DeviceCommand command;
    command.f_H_D = {0.0, force, 0.0};
    command.enable = enable;
    command.sample_counter = sample.counter - made_from_older;
    command.spring = spring;
    command.expires_ns = clock_ns + kReadLate_ns + lives_for_ns;
    good = device->write(clock_ns + kReadLate_ns, command);
    if (outcome != ReadOutcome::kLost) plugged.wait_for(++commands);
  }
  HapOutput ticks(int count, double force = 0.0, bool enable = false) {
    HapOutput output{};
    for (int k = 0; k < count; ++k) output = tick(force, enable);
    return output;
  }

  PluggedBench plugged;
  std::optional<hid::HidDevice> device;
  DeviceSample sample;
  ReadOutcome outcome = ReadOutcome::kNothing;
  bool good = true;
  std::size_t commands = 0;
  DeviceSpring spring;
  std::uint64_t made_from_older = 0;  ///< samples before the newest that commands are made from
  std::int64_t lives_for_ns = 1'000'000'000;
  std::uint32_t late_us = 0;  ///< device time from its sample to its taking of the command
};

}  // namespace hapticd::test
