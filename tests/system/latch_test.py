"""Every fault that can be brought about from outside latches with its cause and without force, and ends with a Clear once the cause is gone: the
same press as before is felt, and told in events, again. What a scripted device cannot do, --inject does. The other causes, flags of a device
among them, are in tests/server/haptic_loop/latch_test.cpp."""
import sys
import unittest

import daemon
import hapticd

STATE = hapticd.v1.state_pb2
CAUSE = hapticd.v1.event_pb2.Cause
SCALE = "tools[0].workspace.scale"
HOME = (0.0, 0.0153, 0.0)
# The hand of the press, 4 mm into the string, feels more than this.
FELT_N = 0.1
# Its events: a touch begins and ends, the string is drawn, and sounds.
TOLD = {"contact", "string_radius", "tone"}
# What --inject spoils under the virtual clock, and how it is called.
INJECTED = {"lost": "CAUSE_INPUT_STALE", "delay": "CAUSE_INPUT_STALE", "detach": "CAUSE_DEVICE_LOST", "nan": "CAUSE_NOT_FINITE",
            "inf": "CAUSE_NOT_FINITE", "quaternion": "CAUSE_NOT_FINITE", "jump": "CAUSE_VELOCITY_TRIP", "write": "CAUSE_DEVICE_WRITE",
            "frozen": "CAUSE_INPUT_STUCK"}
# Where these end, the hand is suddenly where it has really gone to, which is a fault of its own.
JUMPING = {"delay", "frozen"}
# Of the schedule of --inject: no fault is longer, in ticks.
LONGEST_FAULT = 700
MOST_PRESSES = 60
# Share by which a press feels as before.
SAME = 0.05


def line(a, b, ticks):
    return [tuple(p + (q - p) * k / ticks for p, q in zip(a, b)) for k in range(1, ticks + 1)]


def press(depth=0.004):
    """Home, onto the string, past it, and home again; a hand trembles."""
    low, past = (0.0, HOME[1] - 0.0099 - depth, 0.0), (0.0, HOME[1] - 0.0099 - depth, 0.03)
    rows = [HOME] * 210 + line(HOME, low, 140) + [low] * 40 + line(low, past, 150) + line(past, (0.0, HOME[1], 0.03), 60) + \
        line((0.0, HOME[1], 0.03), HOME, 60)
    return [(x + 1e-7 * (k % 7), y, z) for k, (x, y, z) in enumerate(rows)]


HELD = slice(350, 390)


class Press:
    """One press, and what came of it."""

    def __init__(self, session):
        list(session.events(timeout=0))
        self.states = session.run(poses=press()).states
        self.kinds = {event.kind for event in session.events(timeout=0)}
        forces = [sum(f * f for f in state.tools[0].wrench_h_w[:3]) ** 0.5 for state in self.states]
        self.force = max(forces, default=0.0)
        # While it is held: a string that rings from the press before swings about that.
        self.held = sum(forces[HELD]) / 40


class Judge:
    """What every latch has to do."""

    def check_latched(self, session, cause):
        """FAULT with this cause, without force or events, for as long as nobody clears."""
        for _ in range(2):
            pressed = Press(session)
            self.assertEqual(len(pressed.states), len(press()))
            self.assertEqual({state.loop_state for state in pressed.states}, {STATE.LOOP_STATE_FAULT})
            self.assertEqual({CAUSE.Name(state.cause) for state in pressed.states}, {cause})
            self.assertEqual(pressed.force, 0.0)

    def check_mended(self, session, before):
        after = Press(session)
        self.assertAlmostEqual(after.held, before.held, delta=SAME * before.held)
        self.assertEqual(after.states[-1].loop_state, STATE.LOOP_STATE_ENGAGED)
        self.assertEqual(after.states[-1].cause, CAUSE.Value("CAUSE_UNSPECIFIED"))
        self.assertLessEqual(TOLD, after.kinds)


class Latches(Judge, daemon.LockstepCase):
    def setUp(self):
        self.session.load_scene("single_string")
        self.session.subscribe(divisor=1, sections=["TOOLS"])
        self.play([HOME] * 10)
        self.before = Press(self.session)
        self.assertGreater(self.before.force, FELT_N)
        self.assertLessEqual(TOLD, self.before.kinds)

    def tearDown(self):
        # A test that fails leaves nothing to the next.
        self.session.set(SCALE, 1.0)
        self.session.run(poses=[HOME] * 100)
        self.session.clear()

    def play(self, poses):
        return self.session.run(poses=poses).states

    def check(self, cause):
        self.check_latched(self.session, cause)
        self.session.clear()
        self.check_mended(self.session, self.before)

    def test_a_stop(self):
        self.session.stop()
        self.assertEqual(len(self.play([HOME] * 10)), 1)
        self.check("CAUSE_STOPPED")

    def test_poses_that_the_daemon_cannot_use(self):
        for pose in ((2e7, 0, 0), (-1e7, 1e7, 0), (1e300, 0, 0)):
            with self.subTest(pose=pose):
                states = self.play([pose] * 10)
                # The last is of the tick that latches, and what was left of the poses is gone with it.
                self.assertEqual([state.loop_state for state in states], [STATE.LOOP_STATE_ENGAGED] * 2 + [STATE.LOOP_STATE_FAULT])
                self.check("CAUSE_NOT_FINITE")

    def test_a_single_good_pose_is_enough_for_a_clear(self):
        self.play([(2e7, 0, 0)] * 2048)
        self.play([HOME])
        self.session.clear()
        self.check_mended(self.session, self.before)

    def test_poses_out_of_range_through_the_scale_of_the_workspace(self):
        for far in (2e5, 1.1e5, 9e6):
            with self.subTest(far=far):
                self.session.set(SCALE, 100.0)
                self.play([HOME] * 100)
                self.assertEqual(self.play([(far, 0, 0)] * 10)[-1].loop_state, STATE.LOOP_STATE_FAULT)
                self.session.set(SCALE, 1.0)
                self.play([HOME] * 100)
                self.check("CAUSE_NOT_FINITE")

    def test_a_pose_within_range_that_a_larger_scale_puts_out_of_it(self):
        self.play([HOME, (9e6, 0, 0)])
        self.session.set(SCALE, 100.0)
        self.assertEqual(self.play([(9e6, 0, 0)] * 100)[-1].loop_state, STATE.LOOP_STATE_FAULT)
        self.session.set(SCALE, 1.0)
        self.play([HOME] * 100)
        self.check("CAUSE_NOT_FINITE")

    def test_a_clutch_that_has_brought_the_tool_out_of_range_of_every_pose(self):
        self.session.set(SCALE, 100.0)
        self.play([HOME] * 100)
        self.play([HOME, (9e4, 0, 0)])
        self.clutch(True)
        self.play([(9e4, 0, 0), (-9e4, 0, 0)])
        self.clutch(False)
        self.play([(-9e4, 0, 0)] * 10)
        self.session.set(SCALE, 1.0)
        self.assertEqual(self.play([HOME] * 100)[-1].loop_state, STATE.LOOP_STATE_FAULT)
        self.check("CAUSE_NOT_FINITE")

    def clutch(self, open_):
        item = hapticd.v1.stream_pb2.Item()
        item.clutch.open = open_
        self.session.request(item)

    def test_one_fault_after_another_without_a_clear_between(self):
        self.session.stop()
        self.play([HOME])
        self.play([(2e7, 0, 0)] * 10)
        self.play([HOME] * 10)
        self.check("CAUSE_STOPPED")

    def test_a_clear_changes_no_bit_of_a_session_that_begins_anew(self):
        self.session.load_scene("single_string")
        first = Press(self.session).states
        self.session.stop()
        self.play([HOME] * 10)
        self.session.clear()
        self.session.load_scene("single_string")
        again = Press(self.session).states
        for a, b in zip(first, again):
            b.scene_id = a.scene_id
            self.assertEqual(a, b)

    def test_a_clear_while_the_cause_lasts_is_refused_and_changes_nothing(self):
        self.play([(2e7, 0, 0)] * 10)
        with self.assertRaises(hapticd.RequestError) as refused:
            self.session.clear()
        self.assertEqual(refused.exception.code, "WRONG_STATE")
        self.check("CAUSE_NOT_FINITE")


class Injected(Judge, unittest.TestCase):
    """Causes that are behind the device, which come and go by a schedule."""

    def check(self, kind):
        options = ("--clock", "virtual", "--device", "scripted", "--scene", "single_string", "--inject", f"{kind}:3")
        with daemon.Daemon(*options) as played, hapticd.Session(played.address) as session:
            session.acquire("test")
            session.subscribe(divisor=1, sections=["TOOLS"])
            # Within the first quiet time.
            before = Press(session)
            self.assertGreater(before.force, FELT_N)
            causes = {INJECTED[kind]} | ({"CAUSE_VELOCITY_TRIP"} if kind in JUMPING else set())
            faults = []
            for _ in range(MOST_PRESSES):
                pressed = Press(session)
                if pressed.states[-1].loop_state == STATE.LOOP_STATE_FAULT:
                    faults.append(self.check_silent(pressed.states[-1], causes))
                    self.clear(session, causes)
                elif faults.count(INJECTED[kind]) > 1 and self.is_mended(pressed, before):
                    return
            self.fail(f"never as before after {faults}")

    def is_mended(self, pressed, before):
        """What is spoiled may have no fault in it for a while, such as a pose that is frozen out of touch."""
        return abs(pressed.held - before.held) < SAME * before.held and TOLD <= pressed.kinds

    def check_silent(self, state, causes):
        cause = CAUSE.Name(state.cause)
        self.assertIn(cause, causes)
        self.assertFalse(any(state.tools[0].wrench_h_w))
        return cause

    def clear(self, session, causes):
        """As soon as that is obeyed; latched and silent until then."""
        for _ in range(LONGEST_FAULT):
            try:
                session.clear()
            except hapticd.RequestError as refused:
                self.assertEqual(refused.code, "WRONG_STATE")
            state = session.run(poses=[HOME]).states[-1]
            if state.loop_state != STATE.LOOP_STATE_FAULT:
                return
            self.check_silent(state, causes)
        self.fail("Clear is never obeyed")


def add_kind(kind):
    setattr(Injected, f"test_{kind}_is_{INJECTED[kind][6:].lower()}_until_a_clear", lambda self: self.check(kind))


for each in INJECTED:
    add_kind(each)

if __name__ == "__main__":
    sys.exit(unittest.main(verbosity=2))
