// The pose against the integral of a constant velocity, by hand: 1 unit is 1 mm/s, or 1 mrad/s.
#include "device/spacemouse/spacemouse_device.h"

#include <doctest/doctest.h>

#include <thread>

#include "tests/device/api/device_contract.h"
#include "tests/device/spacemouse/report_queue.h"
#include "tests/support/spacemouse_axes.h"
#include "tests/support/within.h"

namespace hapticd::test {
namespace {

using spacemouse::SpacemouseDevice;
using spacemouse::SpacemouseSettings;

constexpr std::int64_t kMs = 1'000'000;

DeviceProfile mouse_profile() {
  DeviceProfile profile;
  profile.name = {'m', 'o', 'u', 's', 'e'};
  profile.driver = DeviceDriver::kSpacemouse;
  profile.actuated_axes = 0;
  profile.workspace_lower = {-0.1, -0.05, -0.2};
  profile.workspace_upper = {0.1, 0.05, 0.2};
  return profile;
}

SpacemouseSettings settings() {
  SpacemouseSettings made;
  made.axes = test::family_axes(0.35, 0.35);
  made.axes.dead_zone = 4.0;
  return made;
}

Bytes report(std::uint8_t id, int x, int y, int z) {
  Bytes bytes{id};
  for (const int value : {x, y, z}) {
    bytes.push_back(static_cast<std::uint8_t>(value & 0xFF));
    bytes.push_back(static_cast<std::uint8_t>(value >> 8 & 0xFF));
  }
  return bytes;
}
Bytes translation(int x, int y, int z) { return report(1, x, y, z); }
Bytes rotation(int x, int y, int z) { return report(2, x, y, z); }

struct Mouse {
  explicit Mouse(const SpacemouseSettings& how = settings()) : device(mouse_profile(), how) {
    device.attach(queue.channel());
  }
  /// Reads at this time; what was read.
  DeviceSample at(std::int64_t now_ns) {
    DeviceSample sample;
    REQUIRE(device.read(now_ns, sample) == ReadOutcome::kFresh);
    return sample;
  }
  /// A report, and then one tick after the other until `end_ms` with the same report every 8 ms.
  DeviceSample hold(const Bytes& bytes, int end_ms) {
    DeviceSample sample;
    for (int ms = 0; ms <= end_ms; ++ms) {
      if (ms % 8 == 0) queue.reports.push_back(bytes);
      sample = at(ms * kMs);
    }
    return sample;
  }

  ReportQueue queue;
  SpacemouseDevice device;
};

void check_near(const Array3& value, const Array3& expected) {
  for (std::size_t i = 0; i < 3; ++i) CHECK(value[i] == within(expected[i], 1e-9));
}

}  // namespace

TEST_CASE("right is x, down is minus y, toward the user is z, with the speed of the deflection") {
  check_near(Mouse().hold(translation(100, 0, 0), 500).p_DH, {0.05, 0.0, 0.0});
  check_near(Mouse().hold(translation(0, 100, 0), 500).p_DH, {0.0, 0.0, 0.05});
  check_near(Mouse().hold(translation(0, 0, 50), 500).p_DH, {0.0, -0.025, 0.0});
  check_near(Mouse().hold(translation(100, 0, 0), 500).v_DH_D, {0.1, 0.0, 0.0});
}

TEST_CASE("a twist turns about the same axis, and both halves of a long report count") {
  const DeviceSample turned = Mouse().hold(rotation(0, 0, 200), 500);
  // Raw z is minus y of D; 0.1 rad.
  CHECK(turned.q_DH[0] == doctest::Approx(std::cos(0.05)));
  CHECK(turned.q_DH[2] == doctest::Approx(-std::sin(0.05)));
  check_near(turned.w_DH_D, {0.0, -0.2, 0.0});
  Bytes both = translation(100, 0, 0);
  both.insert(both.end(), {0xC8, 0, 0, 0, 0, 0});
  const DeviceSample sample = Mouse().hold(both, 500);
  CHECK(sample.p_DH[0] == doctest::Approx(0.05));
  CHECK(sample.q_DH[1] == doctest::Approx(std::sin(0.05)));
}

TEST_CASE("the position stays within the workspace and comes back from its edge at once") {
  Mouse mouse;
  const DeviceSample edge = mouse.hold(translation(350, 0, 0), 1000);
  CHECK(edge.p_DH[0] == 0.1);
  CHECK(edge.v_DH_D[0] == 0.0);
  mouse.queue.reports.push_back(translation(-100, 0, 0));
  mouse.at(1001 * kMs);
  CHECK(mouse.at(1011 * kMs).p_DH[0] == doctest::Approx(0.099));
}

TEST_CASE("orientation stays unit through minutes of turning") {
  Mouse mouse;
  DeviceSample sample;
  for (int ms = 0; ms < 60'000; ++ms) {
    if (ms % 16 == 0) mouse.queue.reports.push_back(rotation(350, -200, 111));
    sample = mouse.at(ms * kMs);
  }
  double square = 0.0;
  for (const double q : sample.q_DH) square += q * q;
  CHECK(std::abs(square - 1.0) < 1e-12);
}

TEST_CASE("at rest the pose stands, every read is fresh, and counters grow") {
  Mouse mouse;
  const DeviceSample moved = mouse.hold(translation(100, 0, 0), 8);
  for (int k = 0; k < 3; ++k) mouse.queue.reports.push_back(translation(0, 0, 0));
  DeviceSample before = mouse.at(9 * kMs);
  CHECK(before.p_DH[0] == doctest::Approx(moved.p_DH[0] + 1e-4));
  for (int ms = 10; ms < 5000; ++ms) {
    const DeviceSample sample = mouse.at(ms * kMs);
    REQUIRE(sample.counter == before.counter + 1);
    REQUIRE(sample.t_ns == ms * kMs);
    REQUIRE(sample.p_DH == before.p_DH);
    before = sample;
  }
  CHECK(before.v_DH_D == Array3{});
}

TEST_CASE("a device that falls silent while displaced moves on for 100 ms and no longer") {
  Mouse mouse;
  mouse.queue.reports.push_back(translation(100, 0, 0));
  mouse.at(0);
  CHECK(mouse.at(99 * kMs).p_DH[0] == doctest::Approx(0.0099));
  CHECK(mouse.at(100 * kMs).p_DH[0] == doctest::Approx(0.01));
  CHECK(mouse.at(900 * kMs).p_DH[0] == doctest::Approx(0.01));
}

TEST_CASE("a loop that was away for a second does not carry the tool off") {
  Mouse mouse;
  mouse.queue.reports.push_back(translation(100, 0, 0));
  mouse.at(0);
  CHECK(mouse.at(1000 * kMs).p_DH[0] == doctest::Approx(0.01));
}

TEST_CASE("a full queue, whose newest reports were dropped, moves nothing until the next report") {
  Mouse mouse;
  mouse.at(0);
  for (int k = 0; k < 63; ++k) mouse.queue.reports.push_back(translation(100, 0, 0));
  mouse.at(1 * kMs);
  CHECK(mouse.device.counters().overflows == 1);
  CHECK(mouse.at(11 * kMs).p_DH == Array3{});
  mouse.queue.reports.push_back(translation(100, 0, 0));
  mouse.at(12 * kMs);
  CHECK(mouse.at(22 * kMs).p_DH[0] == doctest::Approx(0.001));
}

TEST_CASE("what is within the dead zone is no motion, what is beyond counts whole") {
  CHECK(Mouse().hold(translation(4, -4, 3), 500).p_DH == Array3{});
  CHECK(Mouse().hold(translation(5, 0, 0), 100).p_DH[0] == doctest::Approx(0.0005));
}

TEST_CASE("buttons are those the settings name") {
  SpacemouseSettings how = settings();
  how.button.fill(spacemouse::kNoButton);
  how.button[0] = 1;
  how.button[15] = 24;
  Mouse mouse(how);
  mouse.queue.reports.push_back({3, 0x02, 0, 0, 0x01});
  CHECK(mouse.at(0).buttons == 0x8001);
  mouse.queue.reports.push_back({3, 0x01, 0, 0, 0});
  CHECK(mouse.at(kMs).buttons == 0);
}

TEST_CASE("a button beyond the sixteenth is seen as itself") {
  Mouse mouse;
  mouse.queue.reports.push_back({3, 0x01, 0, 0x40, 0x84});
  CHECK(mouse.at(0).buttons == 0x84400001U);
  mouse.queue.reports.push_back({3, 0, 0, 0, 0x80});
  CHECK(mouse.at(kMs).buttons == 0x80000000U);
}

TEST_CASE("a lost device is lost until it is attached again, and goes on from where it stood") {
  Mouse mouse;
  const DeviceSample stood = mouse.hold(translation(100, 0, 0), 80);
  mouse.queue.gone = true;
  DeviceSample sample;
  CHECK(mouse.device.read(81 * kMs, sample) == ReadOutcome::kLost);
  CHECK(mouse.device.failed());
  mouse.queue.gone = false;
  CHECK(mouse.device.read(82 * kMs, sample) == ReadOutcome::kLost);
  mouse.device.attach(mouse.queue.channel());
  CHECK_FALSE(mouse.device.failed());
  const DeviceSample again = mouse.at(120 * kMs);
  // The tick in which it was lost still moved.
  CHECK(again.p_DH[0] == doctest::Approx(stood.p_DH[0] + 1e-4));
  CHECK(mouse.at(200 * kMs).p_DH == again.p_DH);
  CHECK(again.counter > stood.counter);
  mouse.device.detach();
  CHECK(mouse.device.read(201 * kMs, sample) == ReadOutcome::kLost);
}

TEST_CASE("malformed reports move nothing and are counted") {
  Mouse mouse;
  mouse.queue.reports = {{1, 0xFF}, {}, {2, 1, 1, 1}, {0x17, 50}};
  mouse.queue.reports.erase(mouse.queue.reports.begin() + 1);
  mouse.at(0);
  CHECK(mouse.at(50 * kMs).p_DH == Array3{});
  CHECK(mouse.device.counters().malformed == 2);
  CHECK(mouse.device.counters().reports == 1);
}

TEST_CASE("a workspace without the origin begins at its nearest place") {
  DeviceProfile profile = mouse_profile();
  profile.workspace_lower = {0.02, -0.05, -0.2};
  profile.workspace_upper = {0.1, -0.01, 0.2};
  SpacemouseDevice device(profile, settings());
  ReportQueue queue;
  device.attach(queue.channel());
  DeviceSample sample;
  REQUIRE(device.read(0, sample) == ReadOutcome::kFresh);
  CHECK(sample.p_DH == Array3{0.02, -0.01, 0.0});
}

TEST_CASE("a SpaceMouse keeps the contract of devices") {
  Mouse mouse;
  check_device_contract(mouse.device, virtual_ticks(kMs), 1000);
}

}  // namespace hapticd::test
