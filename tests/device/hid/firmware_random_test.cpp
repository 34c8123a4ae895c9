// The reference firmware under long random sequences of everything that can happen to it, against a
// model written from the words of PROFILE.md, section 7: 64-bit time, no shared line.
#include <doctest/doctest.h>

#include <algorithm>
#include <cmath>
#include <optional>

#include "tests/device/hid/firmware_bench.h"
#include "tests/support/random.h"
#include "tests/support/scale.h"

namespace hapticd::test {
namespace {

using hid::kCommandClearFault;
using hid::kCommandEnable;

/// What a device must be, by the specification.
struct Model {
  std::int64_t t_us = 0;
  bool enabled = false;
  bool enable_before = false;  ///< the command before had ENABLE, and not CLEAR_FAULT
  bool watchdog = false;
  unsigned faults = 0;
  std::optional<hid::CommandReport> command;  ///< since the bus was reset
  hid::CommandReport in_force;
  std::int64_t accepted_us = 0;
  std::int64_t wd_ms = 20;
  std::int64_t f_cap_un = 9'000'000;
  std::int64_t tau_cap_unm = 300'000;
  bool calibrated = false;
  bool calibrating = false;
  bool bus = false;
  HapMeasurement sensors{};

  [[nodiscard]] bool something_against() const {
    return watchdog || (faults & ~unsigned{hid::kFaultBadCommand}) != 0 || !bus ||
           sensors.emergency_stop || !sensors.dead_man_held || !calibrated || calibrating;
  }
  void look_at_clock() {
    if (!enabled || t_us - accepted_us < wd_ms * 1000) return;
    enabled = false;
    watchdog = true;
  }
  void lose_bus() {
    if (enabled) {
      watchdog = true;
      faults |= hid::kFaultUsb;
    }
    enabled = false;
  }
  void reset() {
    lose_bus();
    enable_before = false;
    command.reset();
    wd_ms = 20;
    f_cap_un = 9'000'000;
    tau_cap_unm = 300'000;
  }
  void servo(const HapMeasurement& measured) {
    const bool bus_before = bus;
    sensors = measured;
    bus = measured.bus_ready;
    if (bus_before && !bus) lose_bus();
    look_at_clock();
    faults |= measured.faults;
    if (something_against()) enabled = false;
  }
  void accept(const hid::CommandReport& next) {
    look_at_clock();
    if (command && command->seq == next.seq) return;
    command = in_force = next;
    accepted_us = t_us;
    const bool clear = (next.flags & kCommandClearFault) != 0;
    const bool wants = (next.flags & kCommandEnable) != 0 && !clear;
    if (clear) {
      watchdog = false;
      faults = sensors.faults;
    }
    hid::CommandReport zero;
    zero.flags = next.flags;
    zero.seq = next.seq;
    zero.ref_seq = next.ref_seq;
    if (!wants) enabled = false;
    if (wants && !enable_before && next == zero && !something_against()) enabled = true;
    enable_before = wants;
  }
};

/// Device and model side by side.
struct Pair {
  explicit Pair(std::uint64_t seed)
      : random(seed), bench(hid::kNeedsCalibration | hid::kHasDeadMan) {
    // Starts close to where the clock wraps, so that it does early on.
    bench.now_us = 0xFFFFFFFF - 100'000;
    bench.sensors.dead_man_held = true;
  }
  SplitMix64 random;
  Bench bench;
  Model model;
  std::int64_t wrong = 0;
  std::int64_t steps = 0;
  std::int64_t enabled = 0;
  std::int64_t trips = 0;

  void expect(bool condition) { wrong += condition ? 0 : 1; }
};

std::int64_t square_of(const std::int32_t (&v)[3]) {
  std::int64_t square = 0;
  for (const std::int32_t component : v) square += std::int64_t{component} * component;
  return square;
}

/// What came out is the command shortened: exact within the limit, never above it, never more than
/// the command along any axis nor against it.
void check_vector(Pair& pair, const std::array<std::int32_t, 3>& told, const std::int32_t (&out)[3],
                  std::int64_t cap) {
  double square = 0.0;
  for (const std::int32_t component : told) square += static_cast<double>(component) * component;
  const bool within = square <= static_cast<double>(cap) * static_cast<double>(cap);
  pair.expect(square_of(out) <= cap * cap);
  for (std::size_t i = 0; i < 3; ++i) {
    if (within) {
      pair.expect(out[i] == told[i]);
    } else {
      pair.expect(std::int64_t{out[i]} * told[i] >= 0);
      pair.expect(std::abs(std::int64_t{out[i]}) <= std::abs(std::int64_t{told[i]}));
    }
  }
}

void advance(Pair& pair) {
  const bool long_pause = pair.random.chance(0.01);
  const auto later_us = static_cast<std::uint32_t>(pair.random.below(long_pause ? 40'000 : 2'000));
  pair.model.t_us += later_us;
  pair.model.servo(pair.bench.sensors);
  const HapOutput out = pair.bench.servo(later_us);
  pair.expect(out.motors_on == pair.model.enabled);
  if (!pair.model.enabled) {
    pair.expect(is_zero(out));
    return;
  }
  ++pair.enabled;
  check_vector(pair, pair.model.in_force.force_un, out.force_un, pair.model.f_cap_un);
  check_vector(pair, pair.model.in_force.torque_unm, out.torque_unm, pair.model.tau_cap_unm);
}

void command(Pair& pair) {
  SplitMix64& random = pair.random;
  hid::CommandReport next;
  next.flags = random.chance(0.97) ? kCommandEnable : 0;
  if (random.chance(0.04)) next.flags |= kCommandClearFault;
  next.seq = random.chance(0.9) ? ++pair.bench.seq : pair.bench.seq;
  // Mostly as a host that knows how to begin.
  const bool begins = !pair.model.enable_before && random.chance(0.7);
  if (!begins && random.chance(0.8)) {
    const std::uint64_t reach = std::uint64_t{1} << (8 + random.below(24));
    for (std::size_t i = 0; i < 3; ++i) {
      next.force_un[i] = static_cast<std::int32_t>(static_cast<std::int64_t>(random.below(reach)) -
                                                   static_cast<std::int64_t>(reach / 2));
      next.torque_unm[i] = next.force_un[i] / 64;
    }
  }
  pair.model.accept(next);
  pair.expect(pair.bench.receive(hid::encode(next)));
}

void junk(Pair& pair) {
  std::vector<std::uint8_t> bytes(pair.random.below(80));
  for (std::uint8_t& byte : bytes) byte = static_cast<std::uint8_t>(pair.random.next());
  if (!bytes.empty() && pair.random.chance(0.5)) bytes[0] = 0x02;
  const bool sized = !bytes.empty() && ((bytes[0] == 0x02 && bytes.size() == 32) ||
                                        (bytes[0] == 0x11 && bytes.size() == 16) ||
                                        (bytes[0] == 0x12 && bytes.size() == 8));
  if (sized) return;
  pair.model.faults |= hid::kFaultBadCommand;
  pair.expect(!pair.bench.receive(bytes));
}

void configure(Pair& pair) {
  const hid::Config config{.wd_ms = static_cast<std::uint16_t>(pair.random.below(120)),
                           .f_cap_cn = static_cast<std::uint16_t>(pair.random.below(1000)),
                           .tau_cap_mnm = static_cast<std::uint16_t>(pair.random.below(400))};
  Model& model = pair.model;
  const Model before = model;
  model.wd_ms = std::clamp<std::int64_t>(config.wd_ms, 2, 100);
  model.f_cap_un = std::min<std::int64_t>(config.f_cap_cn, 900) * 10'000;
  model.tau_cap_unm = std::min<std::int64_t>(config.tau_cap_mnm, 300) * 1000;
  if (model.enabled) {
    model.wd_ms = std::min(model.wd_ms, before.wd_ms);
    model.f_cap_un = std::min(model.f_cap_un, before.f_cap_un);
    model.tau_cap_unm = std::min(model.tau_cap_unm, before.tau_cap_unm);
  }
  pair.expect(pair.bench.send(config));
}

void calibrate(Pair& pair) {
  Model& model = pair.model;
  if (model.calibrating) {
    const bool ok = pair.random.chance(0.9);
    hap_calibration_end(&pair.bench.device, ok);
    model.calibrating = false;
    model.calibrated = ok;
    return;
  }
  const bool start = pair.random.chance(0.5);
  pair.bench.send(start ? hid::CalibrationOp::kStart : hid::CalibrationOp::kZeroHere);
  model.enabled = false;
  model.calibrating = start;
  model.calibrated = model.calibrated || !start;
}

/// Sensors that go wrong now and then, and right again soon.
void disturb(Pair& pair) {
  HapMeasurement& sensors = pair.bench.sensors;
  const auto flips = [&pair](bool bad) { return pair.random.chance(bad ? 0.5 : 0.1); };
  if (flips(sensors.emergency_stop)) sensors.emergency_stop = !sensors.emergency_stop;
  if (flips(!sensors.dead_man_held)) sensors.dead_man_held = !sensors.dead_man_held;
  if (flips(!sensors.bus_ready)) sensors.bus_ready = !sensors.bus_ready;
  const unsigned fault = pair.random.chance(0.1) ? 1U << pair.random.below(8) : 0U;
  sensors.faults = static_cast<std::uint16_t>(fault);
}

void look(Pair& pair) {
  const hid::StateReport state = pair.bench.state();
  const Model& model = pair.model;
  const auto shows = [&state](unsigned bit) { return (state.status & bit) != 0; };
  pair.expect(shows(hid::kStatusEnabled) == model.enabled);
  pair.expect(shows(hid::kStatusWatchdog) == model.watchdog);
  pair.expect(shows(hid::kStatusCalibrated) == (model.calibrated && !model.calibrating));
  pair.expect(shows(hid::kStatusFault) == ((model.faults & 0xFF) != 0));
  pair.expect(state.fault == model.faults);
  pair.expect(state.cmd_seq == (model.command ? model.command->seq : 0));
  pair.trips += model.watchdog ? 1 : 0;
}

void step(Pair& pair) {
  const std::uint64_t choice = pair.random.below(1000);
  ++pair.steps;
  if (choice < 500) {
    advance(pair);
  } else if (choice < 900) {
    command(pair);
  } else if (choice < 970) {
    look(pair);
  } else if (choice < 980) {
    junk(pair);
  } else if (choice < 985) {
    configure(pair);
  } else if (choice < 988) {
    calibrate(pair);
  } else if (choice < 999) {
    disturb(pair);
  } else {
    pair.model.reset();
    hap_bus_reset(&pair.bench.device);
  }
}

TEST_CASE("whatever happens, there is force only when the specification allows it, and no more") {
  Pair pair(6);
  const std::int64_t steps = scaled(3'000'000);
  while (pair.steps < steps) step(pair);
  CHECK(pair.wrong == 0);
  MESSAGE(pair.steps << " steps, " << pair.enabled << " servo cycles with force allowed, "
                     << pair.trips << " looks at a watchdog that fired");
  // Neither never nor always enabled, or the test says nothing.
  if (steps >= 100'000) {
    CHECK(pair.enabled > steps / 50);
    CHECK(pair.enabled < steps / 3);
    CHECK(pair.trips > 0);
  }
}

}  // namespace
}  // namespace hapticd::test
