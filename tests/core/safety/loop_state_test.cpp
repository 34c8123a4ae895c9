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

/// One step of the machine.
struct Step {
  const LoopInput& in;
  const LoopMachine& before;
  const LoopMachine& after;
  const LoopOutput& out;
  /// A fault, a stop, or a device that is gone while force may be on.
  bool wrong = false;
};

/// Each of the following says what is wrong with a step; nullptr: nothing.
const char* broken_gain(const Step& s) {
  if (s.out.state != s.after.state || s.out.cause != s.after.cause || s.out.gain != s.after.gain) {
    return "the output is not the machine";
  }
  if (!(s.after.gain >= 0.0 && s.after.gain <= 1.0)) return "gain outside [0, 1]";
  if (s.after.gain > 0.0 && !bears_force(s.after.state)) return "force where there is none";
  if (s.after.gain > s.before.gain + 0.005 / 0.2 + 1e-12) return "the gain jumped up";
  if (s.after.state == LoopState::kReleasing &&
      std::abs(s.before.gain - s.in.dt_s / 0.05 - s.after.gain) > 1e-12) {
    return "the release is not the ramp";
  }
  return nullptr;
}

const char* broken_fault(const Step& s) {
  if (s.wrong && (bears_force(s.after.state) || s.after.gain > 0.0)) return "force in a fault";
  if (s.wrong && !s.in.end && !s.before.ending && s.after.state != LoopState::kFault) {
    return "a fault was not latched";
  }
  if (s.after.state == LoopState::kFault && s.after.cause == Cause::kNone) return "without a cause";
  const bool was_fault = s.before.state == LoopState::kFault;
  const bool granted = was_fault && s.in.clear && !s.wrong &&
                       (s.before.cause != Cause::kDeviceLost || s.in.attached);
  if (s.out.cleared != granted) return "Clear is not what was granted";
  if (!was_fault) return nullptr;
  const bool stays = s.after.state == LoopState::kFault;
  if (!stays && s.after.state != LoopState::kOver && !granted) return "a fault ended by itself";
  if (stays && s.after.cause != s.before.cause) return "not the first cause";
  return bears_force(s.after.state) ? "from a fault to force" : nullptr;
}

const char* broken_start(const Step& s) {
  if (s.after.wanted && !s.before.wanted && !s.in.engage && !s.in.engages_itself) {
    return "force wanted by nobody";
  }
  if (s.after.state != LoopState::kEngaged) return nullptr;
  if (s.after.cause != Cause::kNone) return "engaged with a cause";
  if (s.before.state == LoopState::kEngaged) return nullptr;
  if (s.before.state == LoopState::kReleasing) return "engaged without being ready";
  const bool device = s.in.attached && s.in.calibrated && s.in.block == Cause::kNone;
  const bool allowed = s.in.contact_free && !s.in.lease_lost && !s.in.scene_waits;
  const bool unasked = s.in.disengage || s.in.end || s.before.ending;
  if (!device || !allowed || unasked) return "engaged in spite of a reason not to";
  return s.after.gain != 0.0 ? "engaged with force" : nullptr;
}

const char* broken_scene(const Step& s) {
  const bool force = s.after.gain > 0.0 || bears_force(s.after.state);
  if (s.out.scene_allowed && force) return "scene under force";
  if (!s.out.scene_allowed && !force && s.after.state != LoopState::kOver) {
    return "a scene is kept waiting without force";
  }
  return nullptr;
}

const char* broken_law(const LoopInput& in, const LoopMachine& before, const LoopMachine& after,
                       const LoopOutput& out) {
  if (before.state == LoopState::kOver) {
    return after.state == LoopState::kOver && after.gain == 0.0 ? nullptr : "kOver is final";
  }
  Step step{in, before, after, out};
  step.wrong = in.fault != Cause::kNone || in.stop ||
               (bears_force(before.state) && (!in.attached || !in.calibrated));
  for (const auto law : {broken_gain, broken_fault, broken_start, broken_scene}) {
    if (const char* const broken = law(step)) return broken;
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

TEST_CASE("while poses are stale force fades as if let go, and climbs again once they come") {
  LoopMachine m;
  LoopInput in;
  in.dt_s = 1e-3;
  in.attached = in.calibrated = in.contact_free = in.engages_itself = true;
  for (int tick = 0; tick < 300; ++tick) static_cast<void>(advance(in, m));
  REQUIRE(m.gain == 1.0);
  // In touch from now on: force that has come to nothing would not be switched on again.
  in.contact_free = false;
  in.stale = true;
  for (int tick = 1; tick <= 8; ++tick) {
    const LoopOutput out = advance(in, m);
    CHECK(out.state == LoopState::kEngaged);
    CHECK(out.cause == Cause::kInputStale);
    CHECK(out.gain == doctest::Approx(1.0 - tick / 50.0));
  }
  in.stale = false;
  LoopOutput out = advance(in, m);
  CHECK(out.cause == Cause::kNone);
  CHECK(out.gain == doctest::Approx(1.0 - 8 / 50.0 + 1 / 200.0));
  for (int tick = 0; tick < 40; ++tick) out = advance(in, m);
  CHECK(out.gain == 1.0);
  in.stale = true;
  for (int tick = 0; tick < 60; ++tick) out = advance(in, m);
  CHECK(out.state == LoopState::kReady);
  CHECK(out.gain == 0.0);
  CHECK(out.cause == Cause::kInputStale);
  // Never while poses are stale, nor while the tool is in something.
  in.contact_free = true;
  for (int tick = 0; tick < 60; ++tick) CHECK(advance(in, m).state == LoopState::kReady);
  in.stale = false;
  CHECK(advance(in, m).state == LoopState::kEngaged);
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
