"""Every fault that a client can bring about latches with its cause and without force, and ends with a Clear once the cause is gone: the same press
as before is felt again."""
import sys
import unittest

import daemon
import hapticd

STATE = hapticd.v1.state_pb2
CAUSE = hapticd.v1.event_pb2.Cause
HOME = (0.0, 0.0153, 0.0)
# The hand of the first press, 4 mm into the string, feels more than this.
FELT_N = 0.1
PRESS = [HOME] * 260 + [(0.0, 0.0153 - 0.0001 * k, 0.0) for k in range(1, 140)] + [(0.0, 0.0014, 0.0)] * 40


def largest(states):
    return max(sum(f * f for f in state.tools[0].wrench_h_w[:3]) ** 0.5 for state in states)


class Latches(daemon.LockstepCase):
    def setUp(self):
        self.session.load_scene("single_string")
        self.session.subscribe(divisor=1, sections=["TOOLS"])
        self.felt = self.press()
        self.assertGreater(self.felt, FELT_N)

    def play(self, poses):
        """States of these poses, one a tick from the next on."""
        return self.session.run(poses=poses).states

    def press(self):
        return largest(self.play(PRESS))

    def check(self, cause, clear=True):
        """FAULT with this cause and no force, for as long as nobody clears; then all is as it was."""
        states = self.play([HOME] * 300)
        self.assertEqual({state.loop_state for state in states}, {STATE.LOOP_STATE_FAULT})
        self.assertEqual({CAUSE.Name(state.cause) for state in states}, {cause})
        self.assertEqual(self.press(), 0.0)
        self.play([HOME] * 10)
        if clear:
            self.session.clear()
        self.assertAlmostEqual(self.press(), self.felt, delta=1e-3 * self.felt)

    def test_a_stop(self):
        self.session.stop()
        self.check("CAUSE_STOPPED")

    def test_poses_that_the_daemon_cannot_use(self):
        for pose in ((2e7, 0, 0), (1e300, 0, 0)):
            with self.subTest(pose=pose):
                self.assertEqual(self.play([pose] * 10)[-1].loop_state, STATE.LOOP_STATE_FAULT)
                self.check("CAUSE_NOT_FINITE")

    def test_poses_out_of_range_through_the_scale_of_the_workspace(self):
        scale = "tools[0].workspace.scale"
        for far in (2e5, 1.1e5, 9e6):
            with self.subTest(far=far):
                self.session.set(scale, 100.0)
                self.play([HOME] * 100)
                self.assertEqual(self.play([(far, 0, 0)] * 10)[-1].loop_state, STATE.LOOP_STATE_FAULT)
                self.session.set(scale, 1.0)
                self.play([HOME] * 100)
                self.check("CAUSE_NOT_FINITE")

    def test_a_pose_within_range_that_a_larger_scale_puts_out_of_it(self):
        scale = "tools[0].workspace.scale"
        self.play([HOME, (9e6, 0, 0)])
        self.session.set(scale, 100.0)
        states = self.play([(9e6, 0, 0)] * 100)
        self.assertEqual(states[-1].loop_state, STATE.LOOP_STATE_FAULT)
        self.session.set(scale, 1.0)
        self.play([HOME] * 100)
        self.check("CAUSE_NOT_FINITE")

    def test_a_clutch_that_has_brought_the_tool_out_of_range_of_every_pose(self):
        session = self.session
        session.set("tools[0].workspace.scale", 100.0)
        self.play([HOME] * 100)
        self.play([HOME, (9e4, 0, 0)])
        self.clutch(True)
        self.play([(9e4, 0, 0), (-9e4, 0, 0)])
        self.clutch(False)
        self.play([(-9e4, 0, 0)] * 10)
        session.set("tools[0].workspace.scale", 1.0)
        states = self.play([HOME] * 100)
        self.assertEqual(states[-1].loop_state, STATE.LOOP_STATE_FAULT)
        self.check("CAUSE_NOT_FINITE")

    def clutch(self, open_):
        item = hapticd.v1.stream_pb2.Item()
        item.clutch.open = open_
        self.session.request(item)

    def test_after_any_of_them_a_clear_changes_no_bit_of_a_session_that_begins_anew(self):
        self.session.load_scene("single_string")
        first = self.session.run(poses=PRESS).states
        self.session.stop()
        self.play([HOME] * 10)
        self.session.clear()
        self.session.load_scene("single_string")
        again = self.session.run(poses=PRESS).states
        for a, b in zip(first, again):
            b.scene_id = a.scene_id
            self.assertEqual(a, b)

    def test_a_clear_while_the_cause_lasts_is_refused_and_changes_nothing(self):
        self.play([(2e7, 0, 0)] * 10)
        with self.assertRaises(hapticd.RequestError) as refused:
            self.session.clear()
        self.assertEqual(refused.exception.code, "WRONG_STATE")
        self.check("CAUSE_NOT_FINITE")


if __name__ == "__main__":
    sys.exit(unittest.main(verbosity=2))
