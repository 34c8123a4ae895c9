"""Every fault that --inject knows, from outside: the cause is named, the wrench is zero in time, and Clear goes on once it is gone.

The fault is found by comparing with a session of the same poses that nobody disturbs: under the virtual clock both have the same bits
up to the tick in which something is wrong."""
import pathlib
import sys
import tempfile
import time
import unittest

import daemon
import hapticd

STATE = hapticd.v1.state_pb2
CAUSE = hapticd.v1.event_pb2
SCENE = ("--scene", "single_string")
# The same string, which does not ring: else it shakes the hand long after a fault that nobody has noticed.
FOLDER = tempfile.TemporaryDirectory()
QUIET = pathlib.Path(FOLDER.name, "quiet.textproto")
QUIET.write_text((pathlib.Path(__file__).resolve().parents[2] / "deploy/scenes/single_string.textproto").read_text(encoding="utf-8")
                 .replace("vibration {}\ntones {}\n", ""), encoding="utf-8")
VIRTUAL = ("--clock", "virtual", "--device", "scripted", "--scene", str(QUIET))
# Poses repeat after so many ticks: down on the string, held for longer than a stuck sensor may be, up again.
CYCLE = 1200
# The last fault of the schedule's first two must have begun by then.
LONGEST = 6000
# Ticks from the first wrong bit to the fault: samples are bridged for two, a repeated pose is suspect for 250 ms under force.
BOUNDS = {
    "lost": ("CAUSE_INPUT_STALE", 2), "delay": ("CAUSE_INPUT_STALE", 2), "detach": ("CAUSE_DEVICE_LOST", 0),
    "nan": ("CAUSE_NOT_FINITE", 2), "inf": ("CAUSE_NOT_FINITE", 2), "quaternion": ("CAUSE_NOT_FINITE", 2),
    "jump": ("CAUSE_VELOCITY_TRIP", 0), "write": ("CAUSE_DEVICE_WRITE", 2), "frozen": ("CAUSE_INPUT_STUCK", 700),
}


def pose(tick):
    """A finger that comes down on the string, presses, and lifts; never the same twice in a row."""
    t = tick % CYCLE
    down = min(max(t - 150, 0), 90) - min(max(t - 1000, 0), 90)
    return (0.0, 0.012 - 1e-4 * down + 1e-6 * (tick * 7 % 5), 0.0)


class Lockstep:
    """A session that knows which tick is next."""

    def __init__(self, session):
        self.session = session
        session.acquire("test")
        session.subscribe(divisor=1, sections=["TOOLS", "DEVICES"])
        self.tick = 0

    def step(self, ticks):
        """States of up to so many ticks; fewer at a fault."""
        self.session.poses([pose(self.tick + k) for k in range(ticks)], first_tick=self.tick)
        result = self.session.run(steps=ticks)
        self.tick += result.steps
        return result.states

    def steps(self, ticks):
        """States of so many ticks without a fault; the queue of poses holds fewer."""
        states = []
        while len(states) < ticks:
            states += self.step(500)
        return states


def wrench(state):
    return tuple(state.tools[0].wrench_h_w)


def zero(state):
    return not any(wrench(state))


def bits(state):
    same = type(state)()
    same.CopyFrom(state)
    same.ClearField("scene_id")
    return same.SerializeToString(deterministic=True)


class Injected(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        with daemon.Daemon(*VIRTUAL) as played, hapticd.Session(played.address) as session:
            cls.undisturbed = Lockstep(session).steps(LONGEST)
        cls.pushing = sum(not zero(state) for state in cls.undisturbed)

    def test_undisturbed_the_finger_is_pushed_most_of_the_time(self):
        self.assertGreater(self.pushing, LONGEST // 2)
        self.assertTrue(all(state.loop_state == STATE.LOOP_STATE_ENGAGED for state in self.undisturbed[10:]))

    def until_fault(self, lockstep):
        states = []
        while lockstep.tick < LONGEST:
            states += lockstep.step(500)
            if states[-1].loop_state == STATE.LOOP_STATE_FAULT:
                return states
        self.fail(f"no fault in {LONGEST} ticks")

    def resume(self, lockstep):
        """Clears as soon as that is permitted; returns how often it was not."""
        for refused in range(LONGEST):
            try:
                lockstep.session.clear()
                return refused
            except hapticd.RequestError as error:
                self.assertEqual(error.code, "WRONG_STATE")
            self.assertTrue(all(zero(state) for state in lockstep.step(1)))
        self.fail("Clear is never permitted")

    def check(self, kind):
        cause, bound = BOUNDS[kind]
        with daemon.Daemon(*VIRTUAL, "--inject", f"{kind}:3") as played, hapticd.Session(played.address) as session:
            lockstep = Lockstep(session)
            states = self.until_fault(lockstep)
            fault = states[-1]
            wrong = next(k for k, state in enumerate(states) if bits(state) != bits(self.undisturbed[k]))
            self.assertGreaterEqual(wrong, 1000)
            self.assertEqual(CAUSE.Cause.Name(fault.cause), cause)
            self.assertTrue(zero(fault))
            self.assertLessEqual(fault.tick - wrong, bound)
            refused = self.resume(lockstep)
            # Delayed samples arrive again after 30 reads; a fault itself lasts for 400 ticks and more.
            if kind not in ("jump", "delay", "frozen"):
                self.assertGreater(refused, 100)
            again = []
            for _ in range(2 * CYCLE):
                again += lockstep.step(1)
                if not zero(again[-1]):
                    break
            self.assertFalse(zero(again[-1]), "no force after Clear")
            self.assertEqual(again[-1].loop_state, STATE.LOOP_STATE_ENGAGED)
            self.assertEqual(played.end(), 0, played.log)

    def test_a_flipped_quaternion_is_the_same_pose_and_nothing_is_felt(self):
        with daemon.Daemon(*VIRTUAL, "--inject", "flip:3") as played, hapticd.Session(played.address) as session:
            states = Lockstep(session).steps(LONGEST // 2)
        flipped = sum(bits(a) != bits(b) for a, b in zip(states, self.undisturbed))
        self.assertGreater(flipped, 100)
        self.assertEqual([wrench(state) for state in states], [wrench(state) for state in self.undisturbed[:LONGEST // 2]])

    def test_a_delay_that_comes_is_measured_and_the_stiffness_falls(self):
        with daemon.Daemon("--clock", "virtual", *SCENE, "--inject", "delay:3") as played, hapticd.Session(played.address) as session:
            session.acquire("test")
            session.subscribe(divisor=1, sections=["STIFFNESS"])
            before = session.run(steps=500).states[-1].stiffness[0]
            declared = session.devices()[0].profile.delay_s.value[0]
            self.assertAlmostEqual(before.delay_s, declared, delta=2e-4)
            done = 0
            while done < 4000:
                done += session.run(steps=500).steps
                try:
                    session.clear()
                except hapticd.RequestError:
                    pass
            after = session.run(steps=1).states[-1].stiffness[0]
            # 30 reads of 1 ms more.
            self.assertAlmostEqual(after.delay_s, declared + 0.030, delta=2e-4)
            self.assertLess(after.bound_n_per_m, before.bound_n_per_m)
            self.assertAlmostEqual(session.devices()[0].measured_delay_s, after.delay_s, places=6)

    def test_what_is_no_fault_is_refused_with_the_list(self):
        for bad in ("gremlin:1", "nan:x", ":"):
            code, text = daemon.run(f"--inject={bad}")
            self.assertEqual(code, 2)
            for word in ("--inject", "frozen", "stall"):
                self.assertIn(word, text)

    def test_help_lists_every_kind(self):
        text = daemon.run("--help")[1]
        for kind in [*BOUNDS, "flip", "stall", "late"]:
            self.assertIn(kind, text)


def add_kind(kind):
    name = f"test_{kind}_is_{BOUNDS[kind][0][6:].lower()}_without_force_in_time_and_clear_goes_on"
    setattr(Injected, name, lambda self: self.check(kind))


for each in BOUNDS:
    add_kind(each)


class RealClock(unittest.TestCase):
    """The loop itself held up: there is no such thing under the virtual clock."""

    def check(self, kind, cause):
        with daemon.Daemon(*SCENE, "--inject", f"{kind}:5") as played, hapticd.Session(played.address) as session:
            session.acquire("test")
            session.subscribe(divisor=5, sections=["TOOLS"])
            end = time.monotonic() + 60.0
            seen = []
            while cause not in seen:
                self.assertLess(time.monotonic(), end, f"{cause} never came, {seen} did")
                state = next(session.states(1))
                if state.loop_state == STATE.LOOP_STATE_FAULT:
                    # This machine may be late by itself; what was injected comes too.
                    self.assertTrue(zero(state))
                    seen.append(CAUSE.Cause.Name(state.cause))
                    self.clear(session, end)
            while session.latest.loop_state != STATE.LOOP_STATE_ENGAGED:
                self.assertLess(time.monotonic(), end, "not engaged after Clear")
                next(session.states(1))
            self.assertEqual(played.end(), 0, played.log)

    def clear(self, session, end):
        while session.latest.loop_state == STATE.LOOP_STATE_FAULT:
            self.assertLess(time.monotonic(), end, "Clear is never permitted")
            try:
                session.clear()
            except hapticd.RequestError:
                pass
            list(session.states(2))

    def test_a_loop_that_stands_still_is_the_guardians(self):
        self.check("stall", "CAUSE_GUARDIAN")

    def test_ticks_that_are_late_are_an_overrun(self):
        self.check("late", "CAUSE_OVERRUN")


if __name__ == "__main__":
    sys.exit(unittest.main(verbosity=2))
