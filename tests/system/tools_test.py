"""Several tools against the daemon: five fingers with a device each, on the strings of one instrument."""
import sys
import unittest

import daemon
import hapticd

FINGERS = 'tools {{ tool_id: {0} name: "finger_{0}" parts {{ name: "tip" shape {{ spheres {{ centre_m: [0, 0, 0] radius_m: 0.005 }} }} }} pose_wg {{ p_m: [{1}, 0.0155, 0] }} }}\n'
SCENE = 'name: "fingers"\n' + "".join(FINGERS.format(3 * k, 0.1 * k) for k in range(5)) + \
    'strings { name: "C2" p_wa_m: [-0.55, 0, 0] p_wb_m: [0.55, 0, 0] frequency_hz: 65.4 }\nvibration {}\ntones {}\n'


class Hands(unittest.TestCase):
    def test_the_hands_of_a_gesture_pluck_each_its_own_string_in_order(self):
        with daemon.Daemon("--clock", "virtual", "--scene", "five_fingers", "--gesture", "roll") as played:
            with hapticd.Session(played.address) as session:
                session.acquire("test")
                session.subscribe(divisor=100, sections=["TOOLS", "GESTURES", "DEVICES"])
                session.run(1600)
                tones = [event.body for event in session.events(timeout=0) if event.kind == "tone"]
                self.assertEqual([(tone.tool_id, tone.string_index) for tone in tones], [(k, k + 1) for k in range(5)])
                self.assertEqual(sorted(tones, key=lambda tone: tone.t_ns), tones)
                for part in (session.latest.tools, session.latest.gestures, session.latest.devices):
                    self.assertEqual([each.tool_id for each in part], [0, 1, 2, 3, 4])
                self.assertEqual(len(session.devices()), 5)


class Poses(daemon.LockstepCase):
    def press(self, tools):
        """Tools by number press the shared string down along a parabola of 4 mm, so that each bends it; the others stay 10 mm above it."""
        session = self.session
        session.load_scene(SCENE)
        session.subscribe(divisor=1, sections=["TOOLS", "CONTACTS", "STRINGS"], max_contacts=256)
        for k in range(5):
            depth = 0.01016 + 0.004 * (1 - (0.1 * k / 0.55) ** 2) if k in tools else 0.0
            session.poses([(0.1 * k, 0.0155 - depth * max(0, min(tick - 250, 100)) / 100, 0) for tick in range(500)], first_tick=0, tool_id=3 * k)
        return session.run(500).states

    def test_every_tool_has_a_wrench_of_its_own_and_none_sinks_into_the_string(self):
        for tools in ([0], [0, 4], [1, 2, 3], [0, 1, 2, 3, 4]):
            states = self.press(tools)
            last = states[-1]
            for state in states:
                self.assertGreater(min(tool.minimum_gap_m for tool in state.tools), -1e-6)
            self.assertEqual([tool.tool_id for tool in last.tools], [0, 3, 6, 9, 12])
            pushed = [k for k, tool in enumerate(last.tools) if tool.wrench_h_w[1] > 0.05]
            self.assertEqual(pushed, tools)
            self.assertEqual(sorted({patch.tool_id for patch in last.contacts}), [3 * k for k in tools])
            # What the string does to each tool is told as its own patch; about that it swings.
            for patch in last.contacts:
                told = [state.tools[patch.tool_id // 3] for state in states[-90:]]
                felt = [tool.wrench_unlimited_h_w[1] if tool.wrench_unlimited_h_w else tool.wrench_h_w[1] for tool in told]
                self.assertAlmostEqual(patch.force_w_n[1], sum(felt) / len(felt), delta=0.02 * patch.force_w_n[1])

    def test_the_same_poses_of_all_tools_give_the_same_bits(self):
        first = self.press([0, 2, 4])
        second = self.press([0, 2, 4])
        for a, b in zip(first, second):
            b.scene_id = a.scene_id
            self.assertEqual(a, b)

    def test_a_tool_that_the_scene_has_not_is_refused_by_name(self):
        self.session.load_scene(SCENE)
        with self.assertRaises(hapticd.RequestError) as refused:
            self.session.poses([(0, 0, 0)], tool_id=1)
            self.session.ping()
        self.assertEqual(refused.exception.path, "pose_batch.poses[0].tool_id")


if __name__ == "__main__":
    sys.exit(unittest.main(verbosity=2))
