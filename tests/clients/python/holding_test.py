"""How long what a State says may be believed, against instants written down."""
import unittest

import support
from hapticd.conversation import Conversation, Peer
from hapticd.v1 import answer_pb2, config_pb2, event_pb2, state_pb2, stream_pb2

MS = support.MS


def engaged():
    state = state_pb2.State(tick=7, loop_state=state_pb2.LOOP_STATE_ENGAGED)
    state.tools.add(tool_id=3, wrench_h_w=[1, 2, 3, 0.1, 0.2, 0.3], wrench_unlimited_h_w=[9] * 6)
    return state


class Holding(unittest.TestCase):
    def conversation(self, clock):
        made = Conversation(Peer("127.0.0.1:1"))
        self.assertIsNone(made.present(0))
        self.assertFalse(made.force_holds(0))
        made.info["scene_info"] = answer_pb2.SceneInfo(clock=clock)
        made.latest, made.latest_ns = engaged(), 1000 * MS
        return made

    def test_a_force_is_passed_on_for_20_ms_and_no_longer(self):
        made = self.conversation(config_pb2.CLOCK_MODE_REALTIME)
        self.assertTrue(made.force_holds(1000 * MS))
        self.assertTrue(made.force_holds(1020 * MS))
        self.assertFalse(made.force_holds(1020 * MS + 1))

    def test_a_state_that_nothing_follows_ends_without_force(self):
        made = self.conversation(config_pb2.CLOCK_MODE_REALTIME)
        self.assertIs(made.present(1500 * MS), made.latest)
        over = made.present(1500 * MS + 1)
        self.assertEqual(over.loop_state, state_pb2.LOOP_STATE_DETACHED)
        self.assertEqual(over.cause, event_pb2.CAUSE_INPUT_STALE)
        self.assertEqual((over.tick, over.tools[0].tool_id, list(over.tools[0].wrench_h_w)), (7, 3, [0.0] * 6))
        self.assertEqual(len(over.tools[0].wrench_unlimited_h_w), 0)
        self.assertEqual(made.latest, engaged())

    def test_a_slow_subscription_is_waited_for(self):
        made = self.conversation(config_pb2.CLOCK_MODE_REALTIME)
        made.subscription = stream_pb2.Item()
        made.subscription.subscribe.divisor = 100
        self.assertIs(made.present(2200 * MS), made.latest)
        self.assertIsNot(made.present(2200 * MS + 1), made.latest)

    def test_virtual_time_may_stand_still_for_as_long_as_it_likes(self):
        made = self.conversation(config_pb2.CLOCK_MODE_VIRTUAL)
        self.assertIs(made.present(10**15), made.latest)


if __name__ == "__main__":
    unittest.main()
