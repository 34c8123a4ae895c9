// Truth: every state that can be reached, met with every combination of inputs, must keep the laws
// of loop_state.h; ramps in closed form.
#include "core/safety/loop_state.h"

#include <doctest/doctest.h>

#include <cmath>
#include <deque>
#include <limits>
#include <set>
#include <tuple>
#include <vector>

namespace hapticd::test {
namespace {

bool bears_force(LoopState state) {
  return state == LoopState::kEngaged || state == LoopState::kReleasing;
}

using Key = std::tuple<int, int, long, bool, bool, bool>;

Key key_of(const LoopMachine& m) {
  return {static_cast<int>(m.state),
          static_cast<int>(m.cause),
          std::lround(m.gain * 1e3),
          m.wanted,
          m.started,
          m.ending};
}

/// All inputs with this device: 2^9 requests and conditions, faults, blocks and two lengths of
/// tick.
std::vector<LoopInput> all_inputs(bool engages_itself) {
  std::vector<LoopInput> inputs;
  for (unsigned bits = 0; bits < 1U << 10U; ++bits) {
    LoopInput in;
    in.engages_itself = engages_itself;
    in.attached = (bits & 1U) != 0;
    in.calibrated = (bits & 2U) != 0;
    in.contact_free = (bits & 4U) != 0;
    in.lease_lost = (bits & 8U) != 0;
    in.scene_waits = (bits & 16U) != 0;
    in.engage = (bits & 32U) != 0;
    in.disengage = (bits & 64U) != 0;
    in.stop = (bits & 128U) != 0;
    in.clear = (bits & 256U) != 0;
    in.end = (bits & 512U) != 0;
    for (const Cause fault : {Cause::kNone, Cause::kNotFinite}) {
      for (const Cause block : {Cause::kNone, Cause::kNotChecked}) {
        for (const double dt_s : {0.005, 0.02}) {
          in.fault = fault;
          in.block = block;
          in.dt_s = dt_s;
          inputs.push_back(in);
        }
      }
    }
  }
  return inputs;
}

/// What is wrong with the step from `before` to `after`; nullptr: nothing.
const char* broken_law(const LoopInput& in, const LoopMachine& before, const LoopMachine& after,
                       const LoopOutput& out) {
  const bool force_before = bears_force(before.state);
  const bool device_gone = force_before && (!in.attached || !in.calibrated);
  const bool wrong = in.fault != Cause::kNone || in.stop || device_gone;
  const bool engaged_now =
      after.state == LoopState::kEngaged && before.state != LoopState::kEngaged;
  if (out.state != after.state || out.cause != after.cause || out.gain != after.gain) {
    return "the output is not the machine";
  }
  if (!(after.gain >= 0.0 && after.gain <= 1.0)) return "gain outside [0, 1]";
  if (after.gain > 0.0 && !bears_force(after.state)) return "force where there is none";
  if (before.state == LoopState::kOver) {
    return after.state == LoopState::kOver && after.gain == 0.0 ? nullptr : "kOver is final";
  }
  if (wrong && (bears_force(after.state) || after.gain > 0.0)) return "force in a fault";
  if (wrong && !in.end && !before.ending && after.state != LoopState::kFault) {
    return "a fault was not latched";
  }
  if (before.state == LoopState::kFault) {
    if (after.state != LoopState::kFault && after.state != LoopState::kOver &&
        !(in.clear && !wrong)) {
      return "a fault ended by itself";
    }
    if (after.state == LoopState::kFault && after.cause != before.cause)
      return "not the first cause";
    if (bears_force(after.state)) return "from a fault to force";
  }
  if (engaged_now) {
    if (before.state == LoopState::kFault || before.state == LoopState::kReleasing) {
      return "engaged without being ready";
    }
    if (!in.contact_free || !in.attached || !in.calibrated || in.lease_lost || in.scene_waits ||
        in.block != Cause::kNone || in.disengage || in.end || before.ending) {
      return "engaged in spite of a reason not to";
    }
    if (after.gain != 0.0) return "engaged with force";
  }
  if (after.gain > before.gain + 0.005 / 0.2 + 1e-12) return "the gain jumped up";
  if (after.state == LoopState::kReleasing &&
      std::abs(before.gain - in.dt_s / 0.05 - after.gain) > 1e-12) {
    return "the release is not the ramp";
  }
  if (out.scene_allowed && (after.gain > 0.0 || bears_force(after.state)))
    return "scene under force";
  if (!out.scene_allowed && !bears_force(after.state) && after.state != LoopState::kOver) {
    return "a scene is kept waiting without force";
  }
  if (after.wanted && !before.wanted && !in.engage && !in.engages_itself) {
    return "force wanted by nobody";
  }
  if (after.state == LoopState::kEngaged && after.cause != Cause::kNone)
    return "engaged with a cause";
  if (after.state == LoopState::kFault && after.cause == Cause::kNone)
    return "a fault without a cause";
  if (out.cleared != (before.state == LoopState::kFault && in.clear && !wrong &&
                      (before.cause != Cause::kDeviceLost || in.attached))) {
    return "Clear is not what was granted";
  }
  return nullptr;
}

/// A ready device that is held.
LoopInput ready_input(bool engages_itself) {
  LoopInput in;
  in.dt_s = 1e-3;
  in.attached = in.calibrated = in.contact_free = true;
  in.engages_itself = engages_itself;
  return in;
}

LoopMachine engaged_machine(LoopInput in) {
  LoopMachine machine;
  for (int k = 0; k < 300; ++k) (void)advance(in, machine);
  REQUIRE(machine.state == LoopState::kEngaged);
  REQUIRE(machine.gain == 1.0);
  return machine;
}

}  // namespace

TEST_CASE("every reachable state keeps every law under every input") {
  for (const bool engages_itself : {true, false}) {
    const std::vector<LoopInput> inputs = all_inputs(engages_itself);
    std::set<Key> seen;
    std::deque<LoopMachine> open{LoopMachine{}};
    seen.insert(key_of(open.front()));
    while (!open.empty()) {
      const LoopMachine before = open.front();
      open.pop_front();
      for (const LoopInput& in : inputs) {
        LoopMachine after = before;
        const LoopOutput out = advance(in, after);
        const char* const broken = broken_law(in, before, after, out);
        if (broken != nullptr) {
          FAIL(broken << ", from state " << static_cast<int>(before.state) << " to "
                      << static_cast<int>(after.state));
        }
        if (seen.insert(key_of(after)).second) open.push_back(after);
      }
    }
    CHECK(seen.size() > 400);  // all seven states with their causes and gains
  }
}

TEST_CASE("force comes in 200 ms, as a straight line from zero") {
  const LoopInput in = ready_input(true);
  LoopMachine machine;
  (void)advance(in, machine);
  REQUIRE(machine.state == LoopState::kEngaged);
  for (int k = 1; k <= 200; ++k) {
    CHECK(advance(in, machine).gain == doctest::Approx(k / 200.0));
  }
  CHECK(advance(in, machine).gain == 1.0);
}

TEST_CASE("force goes within 50 ms of Disengage, and does not come back by itself") {
  LoopInput in = ready_input(true);
  LoopMachine machine = engaged_machine(in);
  in.disengage = true;
  CHECK(advance(in, machine).gain == doctest::Approx(0.98));
  in.disengage = false;
  for (int k = 2; k < 50; ++k) CHECK(advance(in, machine).gain == doctest::Approx(1 - k / 50.0));
  for (int k = 0; k < 500; ++k) (void)advance(in, machine);
  CHECK(machine.state == LoopState::kReady);
  CHECK(machine.cause == Cause::kReleased);
  in.engage = true;
  CHECK(advance(in, machine).state == LoopState::kEngaged);
}

TEST_CASE("a pause while engaging is no jump, a pause while releasing ends the force") {
  LoopInput in = ready_input(true);
  LoopMachine machine;
  (void)advance(in, machine);
  in.dt_s = 10.0;
  CHECK(advance(in, machine).gain == doctest::Approx(0.025));
  in.disengage = true;
  CHECK(advance(in, machine).state == LoopState::kReady);
}

TEST_CASE("times that are no times move no ramp") {
  LoopInput in = ready_input(true);
  LoopMachine machine;
  (void)advance(in, machine);
  for (const double bad :
       {-1.0, std::numeric_limits<double>::quiet_NaN(), std::numeric_limits<double>::infinity()}) {
    in.dt_s = bad;
    CHECK(advance(in, machine).gain == 0.0);
  }
}

TEST_CASE("a scene is exchanged without force, which then returns by itself") {
  for (const bool engages_itself : {true, false}) {
    LoopInput in = ready_input(engages_itself);
    in.engage = true;
    LoopMachine machine = engaged_machine(in);
    in.engage = false;
    in.scene_waits = true;
    int ticks = 0;
    while (!advance(in, machine).scene_allowed) ++ticks;
    CHECK(ticks < 50);
    CHECK(machine.cause == Cause::kNone);
    in.scene_waits = false;
    CHECK(advance(in, machine).state == LoopState::kEngaged);
  }
}

TEST_CASE("a scene that overlaps the tool keeps the loop ready, with the reason") {
  for (const bool engages_itself : {true, false}) {
    LoopInput in = ready_input(engages_itself);
    in.engage = true;
    LoopMachine machine = engaged_machine(in);
    in.engage = false;
    in.scene_waits = true;
    while (!advance(in, machine).scene_allowed) {
    }
    in.scene_waits = false;
    in.contact_free = false;
    for (int k = 0; k < 10; ++k) {
      CHECK(advance(in, machine).state == LoopState::kReady);
      CHECK(machine.cause == Cause::kOverlap);
    }
    // Once it is free a simulated hand goes on; a person must ask.
    in.contact_free = true;
    CHECK(advance(in, machine).state == (engages_itself ? LoopState::kEngaged : LoopState::kReady));
    in.engage = true;
    CHECK(advance(in, machine).state == LoopState::kEngaged);
  }
}

TEST_CASE("a lost lease fades the force, and a simulated hand goes on with the next one") {
  LoopInput in = ready_input(true);
  LoopMachine machine = engaged_machine(in);
  in.lease_lost = true;
  CHECK(advance(in, machine).state == LoopState::kReleasing);
  CHECK(machine.cause == Cause::kLeaseLost);
  for (int k = 0; k < 100; ++k) (void)advance(in, machine);
  CHECK(machine.state == LoopState::kReady);
  CHECK(machine.cause == Cause::kLeaseLost);
  in.lease_lost = false;
  CHECK(advance(in, machine).state == LoopState::kEngaged);
}

TEST_CASE("a person who could not be engaged, or was let go, is not engaged later without asking") {
  LoopInput in = ready_input(false);
  LoopMachine machine;
  (void)advance(in, machine);
  in.engage = true;
  in.block = Cause::kNotChecked;
  CHECK(advance(in, machine).cause == Cause::kNotChecked);
  in.engage = false;
  in.block = Cause::kNone;
  for (int k = 0; k < 10; ++k) CHECK(advance(in, machine).state == LoopState::kReady);
  in.engage = true;
  machine = engaged_machine(in);
  in.engage = false;
  in.lease_lost = true;
  for (int k = 0; k < 100; ++k) (void)advance(in, machine);
  in.lease_lost = false;
  for (int k = 0; k < 10; ++k) CHECK(advance(in, machine).state == LoopState::kReady);
}

TEST_CASE("a lost device is a fault under force, and only its return lets Clear pass") {
  LoopInput in = ready_input(true);
  LoopMachine machine = engaged_machine(in);
  in.attached = false;
  CHECK(advance(in, machine).latched);
  CHECK(machine.gain == 0.0);
  CHECK(machine.cause == Cause::kDeviceLost);
  in.clear = true;
  CHECK_FALSE(advance(in, machine).cleared);
  in.attached = true;
  CHECK(advance(in, machine).cleared);
  CHECK(machine.state == LoopState::kReady);
}

TEST_CASE("the end fades the force and is final; without force it is at once") {
  LoopInput in = ready_input(true);
  LoopMachine machine = engaged_machine(in);
  in.end = true;
  CHECK(advance(in, machine).state == LoopState::kReleasing);
  in.end = false;
  in.engage = true;
  for (int k = 0; k < 60; ++k) (void)advance(in, machine);
  CHECK(machine.state == LoopState::kOver);
  LoopMachine idle;
  in.end = true;
  CHECK(advance(in, idle).state == LoopState::kOver);
}

TEST_CASE("while time stands still force can be taken away for a new scene, and returns after it") {
  const LoopInput in = ready_input(true);
  LoopMachine machine = engaged_machine(in);
  release_at_once(machine);
  CHECK(machine.gain == 0.0);
  CHECK(machine.state == LoopState::kReady);
  CHECK(advance(in, machine).state == LoopState::kEngaged);
  LoopMachine fault = engaged_machine(in);
  LoopInput stop = in;
  stop.stop = true;
  (void)advance(stop, fault);
  release_at_once(fault);
  CHECK(fault.state == LoopState::kFault);
}

TEST_CASE("late loops and fast hands are faults only where a person can be pushed, or when armed") {
  for (int i = 0; i <= kMaxCause; ++i) {
    const auto cause = static_cast<Cause>(i);
    const bool counted =
        cause == Cause::kGuardian || cause == Cause::kOverrun || cause == Cause::kVelocityTrip;
    CHECK(latches(cause, true, false) == (cause != Cause::kNone));
    CHECK(latches(cause, false, true) == (cause != Cause::kNone));
    CHECK(latches(cause, false, false) == (cause != Cause::kNone && !counted));
  }
}

}  // namespace hapticd::test
