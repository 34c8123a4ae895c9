// What every driver promises, as one check that the tests of each driver run: samples are newer one
// by one, calls leave the heap alone, every legal and illegal command is survived, and zero can be
// written from another thread while the loop reads. Time is the caller's, so that a driver with a
// clock of its own can be checked too. Not RT.
#pragma once

#include <doctest/doctest.h>

#include <atomic>
#include <cmath>
#include <cstdint>
#include <functional>
#include <limits>
#include <thread>

#include "device/api/haptic_device.h"
#include "tests/support/no_heap.h"

namespace hapticd::test {

/// Instants of reads: returns the time to read at, waiting for it first where the driver needs real
/// time. Never decreases.
using NextTick = std::function<std::int64_t()>;

/// Consecutive instants `period_ns` apart from 0, for drivers that live in injected time.
inline NextTick virtual_ticks(std::int64_t period_ns) {
  return [now_ns = -period_ns, period_ns]() mutable { return now_ns += period_ns; };
}

/// True when every number of the sample is finite and the orientation is unit to 1e-6.
inline bool sound(const DeviceSample& sample) {
  double norm_squared = 0.0;
  for (const double q : sample.q_DH) norm_squared += q * q;
  bool finite = std::abs(norm_squared - 1.0) < 2e-6;
  for (const Array3& vector : {sample.p_DH, sample.v_DH_D, sample.w_DH_D})
    for (const double value : vector) finite = finite && std::isfinite(value);
  return finite;
}

/// Reads and writes zero for `ticks` ticks: counters grow, time does not run back, samples are
/// sound. Counts heap calls of the device. Returns the fresh samples seen.
inline int check_zero_session(HapticDevice& device, const NextTick& next_tick, int ticks) {
  DeviceSample last;
  std::int64_t heap_calls = 0;
  int fresh = 0;
  for (int tick = 0; tick < ticks; ++tick) {
    const std::int64_t now_ns = next_tick();
    DeviceSample sample = last;
    const NoHeapScope scope;
    const ReadOutcome outcome = device.read(now_ns, sample);
    device.write(now_ns, {.sample_counter = sample.counter, .enable = true});
    heap_calls += scope.count();
    if (outcome != ReadOutcome::kFresh) {
      REQUIRE(sample.counter == last.counter);
      continue;
    }
    REQUIRE((fresh == 0 || sample.counter > last.counter));
    REQUIRE((fresh == 0 || sample.t_ns >= last.t_ns));
    REQUIRE(sample.t_ns <= now_ns);
    REQUIRE(sound(sample));
    last = sample;
    ++fresh;
  }
  CHECK(heap_calls == 0);
  return fresh;
}

/// Commands no device may choke on: beyond every limit, not finite, expired, disabled.
inline void check_hostile_commands(HapticDevice& device, const NextTick& next_tick) {
  constexpr double kNan = std::numeric_limits<double>::quiet_NaN();
  constexpr double kInf = std::numeric_limits<double>::infinity();
  for (const double value : {1e300, -1e300, kInf, -kInf, kNan, 5e-324, -0.0, 22.0}) {
    for (const bool enable : {true, false}) {
      const std::int64_t now_ns = next_tick();
      DeviceSample sample;
      device.read(now_ns, sample);
      DeviceCommand command{.sample_counter = sample.counter, .enable = enable};
      command.f_H_D = {value, 0.0, -value};
      command.t_H_D = {0.0, value, value};
      const bool sent = device.write(now_ns, command);
      CHECK((!sent || std::isfinite(value)));
      command.expires_ns = now_ns - 1;
      device.write(now_ns, command);
    }
  }
  DeviceSample sample;
  if (device.read(next_tick(), sample) == ReadOutcome::kFresh) CHECK(sound(sample));
}

/// Another thread writes zero while the loop reads and writes.
inline void check_zero_from_another_thread(HapticDevice& device, const NextTick& next_tick) {
  std::atomic<std::int64_t> latest_ns{0};
  std::atomic<bool> over{false};
  std::thread guardian([&] {
    while (!over.load()) device.write_zero(latest_ns.load());
  });
  for (int tick = 0; tick < 200; ++tick) {
    const std::int64_t now_ns = next_tick();
    latest_ns.store(now_ns);
    DeviceSample sample;
    const ReadOutcome outcome = device.read(now_ns, sample);
    DeviceCommand command{.sample_counter = sample.counter, .enable = true};
    command.f_H_D = {0.1, 0.0, 0.0};
    device.write(now_ns, command);
    if (outcome == ReadOutcome::kFresh) CHECK(sound(sample));
  }
  over.store(true);
  guardian.join();
}

/// All of the above, and that the profile is usable.
inline void check_device_contract(HapticDevice& device, const NextTick& next_tick, int ticks) {
  const DeviceProfile& profile = device.profile();
  CHECK(!device_name(profile).empty());
  CHECK(profile.peak_force >= 0.0);
  CHECK(profile.peak_torque >= 0.0);
  CHECK(profile.report_rate > 0.0);
  CHECK(check_zero_session(device, next_tick, ticks) > 0);
  check_hostile_commands(device, next_tick);
  check_zero_from_another_thread(device, next_tick);
}

}  // namespace hapticd::test
