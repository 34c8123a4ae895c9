// The driver against a device that keeps what it is sent: 1 raw unit is 1 mm in, 1 mN out.
#include "device/pid/pid_device.h"

#include <doctest/doctest.h>

#include <cmath>

#include "tests/device/api/device_contract.h"
#include "tests/device/pid/force_device.h"
#include "tests/support/late_readings.h"
#include "tests/support/random.h"
#include "tests/support/scale.h"

namespace hapticd::test {
namespace {

constexpr std::int64_t kMs = 1'000'000;
constexpr double kPeak = 1.0;

std::int64_t zero_clock() noexcept { return 0; }

DeviceProfile pid_profile() {
  DeviceProfile profile;
  profile.name = {'s', 't', 'i', 'c', 'k'};
  profile.driver = DeviceDriver::kPid;
  profile.sensed_axes = profile.actuated_axes = 2;
  profile.peak_force = kPeak;
  return profile;
}

/// x of D is raw x, z (toward the user) raw y.
pid::PidSettings settings() {
  pid::PidSettings made;
  made.axes.raw_axis = {0, 2, 1};
  made.axes.sign = {1.0, -1.0, 1.0};
  made.axes.position_scale = {1e-3, 1e-3, 1e-3};
  made.axes.force_scale = {1e-3, 1e-3, 1e-3};
  made.layout = pid::find_layout(DescriptorParts().joined()).layout;
  return made;
}

/// An input report 1 with these axes and the first two bytes of buttons.
Bytes input(int x, int y, int buttons = 0) {
  Bytes report(25, 0);
  report[0] = 1;
  report[1] = static_cast<std::uint8_t>(buttons & 0xFF);
  report[2] = static_cast<std::uint8_t>(buttons >> 8 & 0xFF);
  report[9] = static_cast<std::uint8_t>(x & 0xFF);
  report[10] = static_cast<std::uint8_t>(x >> 8 & 0xFF);
  report[11] = static_cast<std::uint8_t>(y & 0xFF);
  report[12] = static_cast<std::uint8_t>(y >> 8 & 0xFF);
  return report;
}

struct Stick {
  Stick() : device(pid_profile(), settings(), zero_clock) { attach(); }
  /// The loop reads before it writes.
  void attach() {
    device.attach(hardware.channel(), {3, 4});
    DeviceSample none;
    device.read(0, none);
  }
  bool push(const Array3& f_H_D, std::int64_t now_ns, bool enable = true) {
    DeviceCommand command{.enable = enable};
    command.f_H_D = f_H_D;
    return device.write(now_ns, command);
  }
  /// Waits for a command with these magnitudes.
  void wait_for(int x, int y) { hardware.wait_until_sent({force(3, x), force(4, y)}); }
  static Bytes force(std::uint8_t block, int magnitude) {
    return {5, block, static_cast<std::uint8_t>(magnitude & 0xFF),
            static_cast<std::uint8_t>(magnitude >> 8 & 0xFF)};
  }

  ForceDevice hardware;
  pid::PidDevice device;
};

}  // namespace

TEST_CASE("the newest reading is the position, from the middle of the range, with its buttons") {
  Stick stick;
  stick.hardware.push(input(100, 100));
  stick.hardware.push(input(50, -20, 0x8001));
  DeviceSample sample;
  REQUIRE(stick.device.read(5 * kMs, sample) == ReadOutcome::kFresh);
  CHECK(sample.p_DH[0] == doctest::Approx(0.05));
  CHECK(sample.p_DH[1] == 0.0);
  CHECK(sample.p_DH[2] == doctest::Approx(-0.02));
  CHECK(sample.q_DH == Array4{1.0, 0.0, 0.0, 0.0});
  CHECK(sample.buttons == 0x8001);
  CHECK(sample.counter == 2);
  CHECK(sample.t_ns <= 5 * kMs);
  CHECK(sample.t_ns >= 3 * kMs);
  CHECK(sample.v_DH_D == Array3{});
  CHECK(stick.device.counters().superseded == 1);
  stick.hardware.push(input(52, -20));
  REQUIRE(stick.device.read(6 * kMs, sample) == ReadOutcome::kFresh);
  CHECK(sample.v_DH_D[0] == doctest::Approx(2.0));
}

namespace {

/// The raw position of a hand that goes to and fro by 30 m, in mm as the device counts it, and how
/// far it is from there to the one before.
int raw_at(double speed, std::int64_t made_ns) {
  constexpr double kSpan_m = 30.0;
  const double way = std::fmod(speed * 1e-9 * static_cast<double>(made_ns), 2.0 * kSpan_m);
  return static_cast<int>(std::lround(1e3 * (kSpan_m - std::abs(way - kSpan_m))));
}

}  // namespace

TEST_CASE("however ticks come late, a hand looks no faster than it is, and times do not drift") {
  SplitMix64 random(9);
  for (std::int64_t k = 0; k < scaled(200); ++k) {
    ReadingTrouble trouble;
    trouble.late = random.uniform();
    trouble.interval_ns = random.chance(0.5) ? 4 * kMs : kMs;
    trouble.pause = random.chance(0.5) ? 0.01 : 0.0;
    DeviceProfile profile = pid_profile();
    profile.report_rate = 1e9 / static_cast<double>(trouble.interval_ns);
    ForceDevice hardware;
    pid::PidDevice device(profile, settings(), zero_clock);
    device.attach(hardware.channel(), {3, 4});
    LateReadings readings(trouble, random.next());
    // Steps of at least 100 raw units, of which rounding makes at most one more.
    const double speed = random.uniform(100.0, 200.0);
    const double most = speed * 1.01;
    double sum = 0.0;
    int fresh = 0;
    std::int64_t last_ns = 0;
    for (int tick = 0; tick < 500; ++tick) {
      const Reading reading = readings.next();
      for (const std::int64_t made_ns : reading.made_ns)
        hardware.push(input(raw_at(speed, made_ns), 0));
      DeviceSample sample;
      if (device.read(reading.now_ns, sample) != ReadOutcome::kFresh) continue;
      REQUIRE(std::abs(sample.v_DH_D[0]) <= most);
      REQUIRE(sample.t_ns >= last_ns);
      REQUIRE(sample.t_ns <= reading.now_ns);
      REQUIRE(sample.t_ns >= reading.now_ns - 2 * trouble.interval_ns);
      last_ns = sample.t_ns;
      if (++fresh > 20) sum += std::abs(sample.v_DH_D[0]);
    }
    // It turns round a few times, and a late tick comes once as a surprise.
    if (trouble.pause == 0.0) CHECK(sum / (fresh - 20) >= 0.9 * speed);
  }
}

TEST_CASE("positions count from the middle where the range has none of its own") {
  DescriptorParts parts;
  // X and Y from 0 to 4094.
  parts.axes = {0x05, 0x01, 0x09, 0x30, 0x09, 0x31, 0x15, 0x00, 0x26, 0xFE, 0x0F, 0x75,
                0x10, 0x95, 0x02, 0x81, 0x02, 0x75, 0x60, 0x95, 0x01, 0x81, 0x03};
  pid::PidSettings from_zero = settings();
  from_zero.layout = pid::find_layout(parts.joined()).layout;
  ForceDevice hardware;
  pid::PidDevice device(pid_profile(), from_zero, zero_clock);
  device.attach(hardware.channel(), {3, 4});
  hardware.push(input(2047, 2057));
  DeviceSample sample;
  REQUIRE(device.read(0, sample) == ReadOutcome::kFresh);
  CHECK(sample.p_DH[0] == 0.0);
  CHECK(sample.p_DH[2] == doctest::Approx(0.01));
}

TEST_CASE("no report, another report, or a cut one is no sample") {
  Stick stick;
  DeviceSample sample;
  CHECK(stick.device.read(0, sample) == ReadOutcome::kNothing);
  stick.hardware.push({2, 0, 0});
  Bytes other = input(5, 5);
  other[0] = 3;
  stick.hardware.push(other);
  CHECK(stick.device.read(1, sample) == ReadOutcome::kNothing);
  Bytes cut = input(5, 5);
  cut.pop_back();
  stick.hardware.push(cut);
  CHECK(stick.device.read(2, sample) == ReadOutcome::kNothing);
  CHECK(sample.counter == 0);
}

TEST_CASE("a full queue, whose newest reports were dropped, is thrown away") {
  Stick stick;
  for (int k = 0; k < 63; ++k) stick.hardware.push(input(k, 0));
  DeviceSample sample;
  CHECK(stick.device.read(0, sample) == ReadOutcome::kNothing);
  CHECK(stick.device.counters().overflows == 1);
  stick.hardware.push(input(7, 0));
  CHECK(stick.device.read(1, sample) == ReadOutcome::kFresh);
}

TEST_CASE("a force goes to the two axes with their signs, and what has no motor goes nowhere") {
  Stick stick;
  CHECK(stick.push({0.5, 0.7, -0.25}, 1));
  stick.wait_for(500, -250);
  CHECK(stick.push({0.0, 5.0, 0.0}, 2));
  stick.wait_for(0, 0);
  CHECK(stick.device.counters().cut == 0);
}

TEST_CASE("no force beyond the peak leaves, and its direction stays") {
  Stick stick;
  stick.push({30.0, 0.0, 40.0}, 1);
  stick.wait_for(600, 800);
  stick.push({-1e308, 0.0, 1e308}, 2);
  stick.wait_for(-707, 707);
  CHECK(stick.device.counters().cut == 2);
  SplitMix64 random(5);
  for (std::int64_t k = 0; k < scaled(2000); ++k) {
    const double size = random.uniform(0.0, 10.0);
    stick.push(
        {random.uniform(-size, size), random.uniform(-size, size), random.uniform(-size, size)},
        3 + k);
  }
  stick.push({0.001, 0.0, 0.002}, 1'000'000);
  stick.wait_for(1, 2);
  const std::vector<Bytes> sent = stick.hardware.sent();
  double x = 0.0;
  for (const Bytes& report : sent) {
    REQUIRE(report.size() == 4);
    const int both = report[2] | report[3] << 8;
    const double magnitude = both < 0x8000 ? both : both - 0x10000;
    if (report[1] == 3) x = magnitude;
    if (report[1] == 4) CHECK(x * x + magnitude * magnitude <= 1e6);
  }
}

TEST_CASE("a force sign found at the device is obeyed") {
  pid::PidSettings turned = settings();
  turned.axes.force_sign = {-1.0, 1.0, 1.0};
  ForceDevice hardware;
  pid::PidDevice device(pid_profile(), turned, zero_clock);
  device.attach(hardware.channel(), {3, 4});
  DeviceSample none;
  device.read(0, none);
  DeviceCommand command{.enable = true};
  command.f_H_D = {0.25, 0.0, 0.5};
  device.write(1, command);
  hardware.wait_until_sent({Stick::force(3, -250), Stick::force(4, 500)});
}

TEST_CASE("not enabled, not finite, expired and revoked commands are zero") {
  Stick stick;
  stick.push({0.5, 0.0, 0.5}, 1);
  stick.wait_for(500, 500);
  CHECK(stick.push({0.5, 0.0, 0.5}, 2, false));
  stick.wait_for(0, 0);
  stick.push({0.5, 0.0, 0.5}, 3);
  stick.wait_for(500, 500);
  CHECK_FALSE(stick.push({std::numeric_limits<double>::quiet_NaN(), 0.0, 0.0}, 4));
  stick.wait_for(0, 0);
  stick.push({0.5, 0.0, 0.5}, 5);
  stick.wait_for(500, 500);
  DeviceCommand late{.expires_ns = -1, .enable = true};
  late.f_H_D = {0.4, 0.0, 0.0};
  stick.device.write(6, late);
  stick.wait_for(0, 0);
  stick.push({0.5, 0.0, 0.5}, 7);
  stick.wait_for(500, 500);
  stick.device.write_zero(7);
  stick.wait_for(0, 0);
}

TEST_CASE("detaching leaves the device without force and its motors off") {
  Stick stick;
  stick.push({0.5, 0.0, 0.0}, 1);
  stick.wait_for(500, 0);
  stick.device.detach();
  stick.hardware.wait_until_sent({{5, 3, 0, 0}, {5, 4, 0, 0}, {12, 3}, {12, 2}});
  const std::size_t sent = stick.hardware.sent().size();
  stick.push({0.5, 0.0, 0.0}, 2);
  stick.device.detach();
  CHECK(stick.hardware.sent().size() == sent);
  DeviceSample sample;
  CHECK(stick.device.read(3, sample) == ReadOutcome::kLost);
}

TEST_CASE("a lost device is lost until it is attached again") {
  ForceDevice again;  // outlives the driver
  Stick stick;
  stick.hardware.push(input(1, 1));
  DeviceSample sample;
  REQUIRE(stick.device.read(0, sample) == ReadOutcome::kFresh);
  stick.hardware.lose();
  CHECK(stick.device.read(1, sample) == ReadOutcome::kLost);
  CHECK(stick.device.failed());
  stick.device.attach(again.channel(), {7, 9});
  again.push(input(40, 1));
  REQUIRE(stick.device.read(2, sample) == ReadOutcome::kFresh);
  CHECK(sample.counter == 2);
  CHECK(sample.v_DH_D == Array3{});
  stick.push({0.5, 0.0, 0.25}, 3);
  again.wait_until_sent({Stick::force(7, 500), Stick::force(9, 250)});
}

TEST_CASE("what was asked for and what was cut shows in the next sample") {
  Stick stick;
  const auto flags = [&](std::int64_t now_ns) {
    stick.hardware.push(input(0, 0));
    DeviceSample sample;
    REQUIRE(stick.device.read(now_ns, sample) == ReadOutcome::kFresh);
    return sample.flags & (kDeviceEnabled | kDeviceSaturated);
  };
  CHECK(flags(0) == 0);
  stick.push({0.5, 0.0, 0.0}, 1);
  CHECK(flags(2) == kDeviceEnabled);
  stick.push({1.5, 0.0, 0.0}, 3);
  CHECK(flags(4) == (kDeviceEnabled | kDeviceSaturated));
  stick.push({0.0, 0.0, 0.0}, 5, false);
  CHECK(flags(6) == 0);
}

TEST_CASE("a PID device keeps the contract of devices") {
  // Has a report at every second read, so that each tick finds one; allocates nothing itself.
  struct Hardware {
    Bytes report = input(10, 20);
    bool waiting = false;
  } hardware;
  ReportChannel channel;
  channel.input = channel.output = &hardware;
  channel.read = [](void* input, std::uint8_t* bytes, std::size_t /*room*/) noexcept -> int {
    auto& self = *static_cast<Hardware*>(input);
    self.waiting = !self.waiting;
    if (!self.waiting) return 0;
    std::copy(self.report.begin(), self.report.end(), bytes);
    return static_cast<int>(self.report.size());
  };
  channel.write = [](void*, const std::uint8_t*, std::size_t length) noexcept -> int {
    return static_cast<int>(length);
  };
  pid::PidDevice device(pid_profile(), settings(), zero_clock);
  device.attach(channel, {3, 4});
  check_device_contract(device, virtual_ticks(kMs), 200);
}

}  // namespace hapticd::test
