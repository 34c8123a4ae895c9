// Devices that follow data. Truth: the data.
#include <doctest/doctest.h>

#include <cmath>
#include <limits>
#include <vector>

#include "core/math/rotation.h"
#include "device/replay/replay_device.h"
#include "device/scripted/scripted_device.h"
#include "tests/device/api/device_contract.h"
#include "tests/support/within.h"

namespace hapticd::test {
namespace {

constexpr std::int64_t kMs = 1'000'000;

DeviceProfile named() {
  DeviceProfile profile;
  profile.name = {'d', 'a', 't', 'a'};
  profile.peak_force = 22.0;
  return profile;
}

QueuedPose at(double x) { return {.p_DH = {x, 0.0, 0.0}}; }

std::vector<DeviceSample> recording(int count) {
  std::vector<DeviceSample> samples;
  for (int i = 0; i < count; ++i) {
    DeviceSample sample;
    sample.t_ns = i * kMs;
    sample.counter = static_cast<std::uint64_t>(i) + 1;
    sample.p_DH = {0.001 * i, 0.0, 0.0};
    samples.push_back(sample);
  }
  return samples;
}

}  // namespace

TEST_CASE("scripted and replayed devices keep the contract of devices") {
  ScriptedDevice scripted(named(), {});
  for (std::uint64_t i = 0; i < 100; ++i) scripted.push(i, at(1e-3 * static_cast<double>(i)));
  check_device_contract(scripted, virtual_ticks(kMs), 200);
  ReplayDevice replay(named());
  for (const DeviceSample& sample : recording(50)) {
    replay.put({ReadOutcome::kFresh, sample, true});
  }
  check_device_contract(replay, virtual_ticks(kMs), 40);
}

TEST_CASE(
    "a scripted device gives each tick its pose to the bit, with velocity from the difference") {
  ScriptedDevice device(named(), {});
  for (std::uint64_t i = 0; i < 3; ++i) {
    CHECK(device.push(i, at(0.1 * static_cast<double>(i * i))) == PosePush::kQueued);
  }
  CHECK(device.next_tick() == 3);
  DeviceSample sample;
  for (int i = 0; i < 3; ++i) {
    REQUIRE(device.read(i * kMs, sample) == ReadOutcome::kFresh);
    CHECK(sample.p_DH[0] == 0.1 * i * i);
  }
  CHECK(std::abs(sample.v_DH_D[0] - 300.0) < 1e-9);
  CHECK(!sample.has_velocity);
  QueuedPose pose = at(0.0);
  pose.has_velocity = true;
  pose.v_DH_D = {7.0, 8.0, 9.0};
  pose.w_DH_D = {1.0, 2.0, 3.0};
  pose.buttons = 5;
  device.push(3, pose);
  device.read(3 * kMs, sample);
  CHECK(sample.v_DH_D == Array3{7.0, 8.0, 9.0});
  CHECK(sample.w_DH_D == Array3{1.0, 2.0, 3.0});
  CHECK(sample.buttons == 5);
  CHECK(sample.has_velocity);
}

TEST_CASE("a tick without a pose is counted, and holds the last one or brings no sample") {
  for (const bool hold : {true, false}) {
    ScriptedDevice device(named(), {.p_DH = {1.0, 2.0, 3.0}, .hold = hold});
    DeviceSample sample;
    CHECK(device.read(0, sample) == (hold ? ReadOutcome::kFresh : ReadOutcome::kNothing));
    if (hold) CHECK(sample.p_DH == Array3{1.0, 2.0, 3.0});
    device.push(1, at(0.5));
    CHECK(device.read(kMs, sample) == ReadOutcome::kFresh);
    CHECK(device.read(2 * kMs, sample) == (hold ? ReadOutcome::kFresh : ReadOutcome::kNothing));
    CHECK(sample.p_DH[0] == 0.5);
    CHECK(device.held() == 2);
    if (hold) CHECK(sample.v_DH_D[0] == 0.0);
  }
}

TEST_CASE("poses for ticks already run are dropped, those too far ahead refused") {
  ScriptedDevice device(named(), {});
  DeviceSample sample;
  device.read(0, sample);
  device.read(kMs, sample);
  CHECK(device.push(1, at(9.0)) == PosePush::kDropped);
  CHECK(device.dropped() == 1);
  CHECK(device.push(2 + kPoseQueue, at(9.0)) == PosePush::kFull);
  CHECK(device.push(1 + kPoseQueue, at(8.0)) == PosePush::kQueued);
  CHECK(device.push(2, at(3.0)) == PosePush::kQueued);
  device.read(2 * kMs, sample);
  CHECK(sample.p_DH[0] == 3.0);
  CHECK(device.next_tick() == 2 + kPoseQueue);
  for (std::uint64_t i = 3; i < 1 + kPoseQueue; ++i) device.read(kMs, sample);
  CHECK(sample.p_DH[0] == 3.0);
  device.read(kMs, sample);
  CHECK(sample.p_DH[0] == 8.0);
}

TEST_CASE("on the real clock a late pose that is newer than the last is used in the next tick") {
  ScriptedDevice device(named(), {.hold = false});
  DeviceSample sample;
  for (int i = 0; i < 3; ++i) device.read(i * kMs, sample);
  CHECK(device.push(1, at(1.0)) == PosePush::kQueued);
  CHECK(device.read(3 * kMs, sample) == ReadOutcome::kFresh);
  CHECK(sample.p_DH[0] == 1.0);
  CHECK(device.push(1, at(9.0)) == PosePush::kDropped);
  CHECK(device.push(0, at(9.0)) == PosePush::kDropped);
}

TEST_CASE(
    "where force reaches a hand, what poses wait in the queue beyond the stated delay counts") {
  for (const int ahead : {0, 4, 5, 10, 40}) {
    CAPTURE(ahead);
    DeviceProfile profile = named();
    profile.force_reaches_hand = true;
    profile.delay = 3e-3;
    ScriptedDevice device(profile, {.hold = false});
    DeviceSample sample;
    for (std::uint64_t i = 0; i < 600; ++i) {
      device.push(i + static_cast<std::uint64_t>(ahead), at(1e-5 * static_cast<double>(i)));
      device.read(static_cast<std::int64_t>(i) * kMs, sample);
    }
    // It is pushed between two reads: after the one before, and a tick for that.
    const double waited_s = 1e-3 * (ahead + 1);
    if (waited_s > 5e-3 + 1e-9) {
      CHECK(sample.measured_delay_s == within(waited_s, 1e-9));
    } else {
      CHECK(std::isnan(sample.measured_delay_s));
    }
    // Less of a wait later does not make it less.
    const double before = sample.measured_delay_s;
    for (std::uint64_t i = 700; i < 1400; ++i) {
      device.set_tick(i);
      device.push(i, at(1e-5 * static_cast<double>(i)));
      device.read(static_cast<std::int64_t>(i) * kMs, sample);
    }
    if (!std::isnan(before)) CHECK(sample.measured_delay_s == before);
  }
}

TEST_CASE("skipped ticks skip their poses, and going back begins anew") {
  ScriptedDevice device(named(), {});
  for (std::uint64_t i = 0; i < 20; ++i) device.push(i, at(static_cast<double>(i)));
  DeviceSample sample;
  device.read(0, sample);
  device.set_tick(10);
  device.read(kMs, sample);
  CHECK(sample.p_DH[0] == 10.0);
  CHECK(device.waiting());
  device.set_tick(0);
  CHECK(!device.waiting());
  CHECK(device.next_tick() == 0);
  device.read(2 * kMs, sample);
  CHECK(sample.p_DH[0] == 10.0);
  CHECK(device.held() == 1);
}

TEST_CASE("a pose that was skipped over is not taken for a tick a whole queue later") {
  ScriptedDevice device(named(), {});
  device.push(5, at(1.0));
  device.set_tick(5 + kPoseQueue);
  DeviceSample sample;
  device.read(0, sample);
  CHECK(sample.p_DH[0] == 0.0);
  CHECK(device.held() == 1);
}

TEST_CASE("a controller that is gone leaves no pose behind") {
  ScriptedDevice device(named(), {});
  device.push(0, at(1.0));
  device.push(5, at(2.0));
  device.clear();
  CHECK(!device.waiting());
  DeviceSample sample;
  for (int i = 0; i < 10; ++i) device.read(i * kMs, sample);
  CHECK(sample.p_DH[0] == 0.0);
  CHECK(device.held() == 10);
}

TEST_CASE("poses that are not finite are passed on as they came, their velocity as zero") {
  ScriptedDevice device(named(), {});
  device.push(0, at(0.0));
  device.push(1, at(std::numeric_limits<double>::quiet_NaN()));
  DeviceSample sample;
  device.read(0, sample);
  device.read(kMs, sample);
  CHECK(std::isnan(sample.p_DH[0]));
  CHECK(sample.v_DH_D == Array3{});
}

TEST_CASE("a replay gives every sample as recorded, nothing where nothing came, and then is lost") {
  const std::vector<DeviceSample> samples = recording(3);
  ReplayDevice device(named());
  for (const DeviceSample& sample : samples) CHECK(device.put({ReadOutcome::kFresh, sample, true}));
  CHECK(device.put({ReadOutcome::kNothing, {}, true}));
  CHECK(device.put({ReadOutcome::kLost, {}, true}));
  DeviceSample sample;
  for (const DeviceSample& recorded : samples) {
    CHECK(device.read(0, sample) == ReadOutcome::kFresh);
    CHECK(sample.p_DH[0] == recorded.p_DH[0]);
    CHECK(sample.counter == recorded.counter);
  }
  CHECK(device.read(0, sample) == ReadOutcome::kNothing);
  CHECK(sample.counter == samples.back().counter);
  CHECK(device.read(0, sample) == ReadOutcome::kLost);
  CHECK(device.read(0, sample) == ReadOutcome::kLost);
}

TEST_CASE("a replayed command reaches the device in just the ticks in which it did") {
  ReplayDevice device(named());
  DeviceSample sample;
  for (const bool good : {true, false, true}) {
    device.put({ReadOutcome::kFresh, {}, good});
    device.read(0, sample);
    CHECK(device.write(0, {}) == good);
  }
}

TEST_CASE("a replay holds as many ticks as it says, and refuses more") {
  ReplayDevice device(named());
  for (std::size_t k = 0; k < ReplayDevice::kQueue; ++k) REQUIRE(device.put({}));
  CHECK(!device.put({}));
  DeviceSample sample;
  device.read(0, sample);
  CHECK(device.put({}));
}

}  // namespace hapticd::test
