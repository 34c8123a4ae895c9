// What the driver sends to the reference firmware: how commands are numbered, and the springs that
// go with them. Truth: what the firmware was told and gives.
#include <doctest/doctest.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <vector>

#include "tests/device/hid/hid_loop.h"
#include "tests/support/random.h"
#include "tests/support/scale.h"

namespace hapticd::test {

TEST_CASE("whatever is sent, its seq is one more than that of the command before it") {
  SplitMix64 random(12);
  Loop loop(kHapHasVelocity | kHapCanAffine);
  loop.spring = {{300.0, 500.0, 100.0, 20.0, 0.0, 0.0}, {0.2, 0.2, 0.2}};
  bool enable = false;
  std::int64_t measured = 0;
  // Enough for a device's echoes to tell the delay.
  for (std::int64_t k = std::max<std::int64_t>(scaled(20'000), 2'000); k > 0; --k) {
    if (random.chance(0.02)) enable = random.chance(0.8);
    for (std::uint64_t zeros = random.chance(0.05) ? random.below(3) : 0; zeros > 0; --zeros) {
      loop.device->write_zero(clock_ns + kReadLate_ns);
    }
    loop.lives_for_ns = random.chance(0.05) ? -kTick_ns : kTick_ns;
    if (random.chance(0.001)) {
      loop.device->detach();
      loop.device->attach(loop.plugged.channel());
    }
    loop.tick(0.5, enable);
    loop.commands = loop.plugged.commands().size();
    if (std::isnan(loop.sample.measured_delay_s)) continue;
    ++measured;
    CHECK(loop.sample.measured_delay_s >= 0.0);
    CHECK(loop.sample.measured_delay_s < 2e-3);
  }
  CHECK(measured > 0);
  const std::vector<hid::CommandReport> sent = loop.plugged.commands();
  for (std::size_t k = 1; k < sent.size(); ++k) {
    REQUIRE(sent[k].seq == static_cast<std::uint16_t>(sent[k - 1].seq + 1));
  }
}

namespace {

constexpr std::uint32_t kAffineCaps = kHapHasVelocity | kHapCanAffine;
/// 0.4 mm along y, in nm.
constexpr std::int32_t kWay_nm = 400'000;
constexpr DeviceSpring kSpring{{300.0, 500.0, 100.0, 20.0, 0.0, 0.0}, {0.2, 0.2, 0.2}};

/// What the motors give when the handle has moved by kWay_nm since the State of the last command.
HapOutput moved_on(Loop& loop) {
  loop.plugged.bench.sensors.pos_nm[1] += kWay_nm;
  return loop.plugged.bench.servo(200);
}

}  // namespace

TEST_CASE(
    "a spring is told about the pose of its sample, and the device pulls back to it at once") {
  Loop loop(kAffineCaps);
  loop.spring = kSpring;
  loop.ticks(20, 0.5, true);
  const HapOutput output = moved_on(loop);
  // 0.5 N less 500 N/m over 0.4 mm; across it, 20 N/m.
  CHECK(output.force_un[1] == 300'000);
  CHECK(output.force_un[0] == -8'000);
  CHECK(output.force_un[2] == 0);
  CHECK((loop.sample.flags & kDeviceReportsFault) == 0);
}

TEST_CASE(
    "no spring is told by an older sample, to a device without the capability, or beyond it") {
  Loop older(kAffineCaps);
  older.spring = kSpring;
  older.made_from_older = 1;
  older.ticks(20, 0.5, true);
  CHECK(moved_on(older).force_un[1] == 500'000);
  Loop plain;
  plain.spring = kSpring;
  plain.ticks(20, 0.5, true);
  CHECK(moved_on(plain).force_un[1] == 500'000);
  Loop beyond(kAffineCaps);
  beyond.spring.K_D = {0.0, 1.0 + kCapabilities.k_max_npm, 0.0, 0.0, 0.0, 0.0};
  beyond.ticks(20, 0.5, true);
  CHECK(moved_on(beyond).force_un[1] == 500'000);
  for (const Loop* loop : {&older, &plain, &beyond}) {
    CHECK((loop->sample.flags & kDeviceReportsFault) == 0);
  }
}

TEST_CASE("whatever springs are asked for, the device refuses no command and keeps its force") {
  SplitMix64 random(11);
  Loop loop(kAffineCaps);
  loop.ticks(20, 0.5, true);
  for (std::int64_t k = scaled(20'000); k > 0; --k) {
    const double size = random.chance(0.5) ? 500.0 : 5000.0;
    for (std::size_t i = 0; i < 3; ++i) {
      loop.spring.K_D[i] = random.uniform(0.0, size);
      loop.spring.K_D[i + 3] = random.uniform(-0.3, 0.3) * size;
      loop.spring.Kr_D[i] = random.uniform(0.0, 2.0);
    }
    if (random.chance(0.01)) loop.spring.K_D[1] = std::numeric_limits<double>::quiet_NaN();
    loop.plugged.bench.sensors.pos_nm[2] += static_cast<std::int32_t>(random.below(2000)) - 1000;
    loop.tick(0.5, true);
    REQUIRE((loop.sample.flags & kDeviceEnabled) != 0);
    REQUIRE((loop.sample.flags & kDeviceReportsFault) == 0);
  }
}

}  // namespace hapticd::test
