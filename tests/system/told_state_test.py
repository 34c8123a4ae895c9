"""A State says what is: gaps, drawn strings, contacts and their places are those that an exhaustive search over the very State finds
(state_search.py)."""
import sys
import unittest

import daemon
import hapticd
import numpy
from state_search import Stage

CAUSE = hapticd.v1.event_pb2
PHASE = hapticd.v1.event_pb2.ContactPhase
# A float of a quaternion turns a hand 0.2 m long by 12 nm; told numbers are floats too.
ROUNDING_M = 1e-7
# Drawn strings and tools overlap by no more.
DRAWN_M = 1e-6
# Sections of all that is searched.
SECTIONS = ["TOOLS", "STRINGS", "CONTACTS"]
TIP = 'tools {{ tool_id: {0} name: "t{0}" parts {{ name: "p" shape {{ spheres {{ centre_m: [0, 0, 0] radius_m: {1} }} }} }} pose_wg {{ p_m: [{2}, {3}, {4}] }} {5} }}\n'


def tip(tool_id=0, radius=0.005, at=(0, 0.02, 0), more=""):
    return TIP.format(tool_id, radius, *at, more)


def string(z=0.0, more="", radius=0.00034):
    return f'strings {{ name: "s{z}" p_wa_m: [-0.55, 0, {z}] p_wb_m: [0.55, 0, {z}] radius_m: {radius} {more} }}\n'


def step(a, b, ticks):
    return [tuple(p + (q - p) * k / ticks for p, q in zip(a, b)) for k in range(1, ticks + 1)]


class Search:
    """What is asserted of States by searching in them."""

    def check(self, states, stage, margin=0.005):
        for state in states:
            for tool_id, (drawn, nearest) in stage.gaps(state).items():
                told = next(tool for tool in state.tools if tool.tool_id == tool_id)
                where = f"tick {state.tick}, tool {tool_id}, flags {list(told.flags)}"
                if hapticd.v1.state_pb2.TOOL_FLAG_RECOVERING not in told.flags:
                    self.assertGreaterEqual(drawn, -DRAWN_M, where)
                self.assertAlmostEqual(told.minimum_gap_m, min(nearest, margin), delta=ROUNDING_M, msg=where)

    def check_places(self, states, events, stage):
        """Every Contact has a place on a sphere of its tool, and a normal that points to its centre, in the State of its tick."""
        by_tick = {state.tick: state for state in states}
        contacts = [event.body for event in events if event.kind == "contact"]
        for contact in contacts:
            self.assertEqual((len(contact.p_wc_m), len(contact.nhat_og_w)), (3, 3), contact)
            p, n = numpy.array(contact.p_wc_m), numpy.array(contact.nhat_og_w)
            self.assertAlmostEqual(numpy.linalg.norm(n), 1, delta=1e-6)
            ticks = [-(-contact.t_ns // 1_000_000)]
            if contact.phase == PHASE.Value("CONTACT_PHASE_END"):
                # Let go of in an earlier tick, or told where it was last.
                ticks = range(ticks[0] - 1, ticks[0] + 60)
            off = []
            for tick in ticks:
                if tick not in by_tick:
                    continue
                told = next(tool for tool in by_tick[tick].tools if tool.tool_id == contact.tool_id)
                spheres = stage.tool(told)
                off.append(numpy.linalg.norm(p + spheres[:, 3:] * n - spheres[:, :3], axis=1).min())
            self.assertLess(min(off, default=1.0), 1e-6, contact)
        return contacts


class Told(Search, daemon.LockstepCase):
    """Under scripted poses."""

    def play(self, text, tracks):
        """States and events of the poses of all tools, by id, with the scene's Stage."""
        session = self.session
        session.load_scene(text)
        session.subscribe(divisor=1, sections=SECTIONS, max_contacts=256)
        list(session.events(timeout=0))
        count = max(len(rows) for rows in tracks.values())
        states = []
        for first in range(0, count, 500):
            for tool_id, rows in tracks.items():
                some = [rows[min(k, len(rows) - 1)] for k in range(first, min(first + 500, count))]
                session.poses(some, first_tick=first, tool_id=tool_id)
            states += session.run(min(500, count - first)).states
        stage = Stage(session.scene.scene)
        return states, list(session.events(timeout=0)), stage

    def test_a_finger_in_and_out_of_touch_has_the_gap_that_a_search_finds(self):
        rows = step((0.1, 0.02, 0), (0.1, 0.001, 0.0), 120) + step((0.1, 0.001, 0), (0.16, 0.002, 0.004), 80) + \
            step((0.16, 0.002, 0.004), (0.16, 0.012, 0.02), 30) + step((0.16, 0.012, 0.02), (0.0, 0.0045, -0.02), 100)
        states, events, stage = self.play('name: "x"\n' + tip() + string() + "vibration {} tones {} torque {}", {0: rows})
        self.check(states, stage)
        self.assertGreaterEqual(len(self.check_places(states, events, stage)), 2)
        self.assertTrue(any(state.strings for state in states))

    def test_tick_0_has_no_overlap_where_there_is_room_and_one_where_there_is_none(self):
        for height, overlaps in ((0.012, False), (0.0054, False), (0.004, True)):
            states, _, stage = self.play('name: "x"\n' + tip(at=(0, height, 0)) + string(), {0: [(0, height, 0)] * 5})
            self.check(states, stage)
            causes = {CAUSE.Cause.Name(state.cause) for state in states}
            self.assertEqual("CAUSE_OVERLAP" in causes, overlaps, height)
            self.assertEqual(states[-1].loop_state == hapticd.v1.state_pb2.LOOP_STATE_ENGAGED, not overlaps)

    def test_the_residual_is_that_of_an_optimum_where_the_solver_has_found_one(self):
        rows = step((0.1, 0.02, 0), (0.1, 0.001, 0.0), 120) + step((0.1, 0.001, 0), (0.16, 0.002, 0.004), 80)
        states, _, _ = self.play('name: "x"\n' + tip() + string() + "torque {}", {0: rows})
        self.assertLess(max(state.tools[0].residual_n for state in states), 1e-6)
        self.assertLess(max(state.tools[0].residual_m for state in states), 1e-9)

    def test_settling_lasts_as_long_as_numbers_move(self):
        session = self.session
        session.load_scene("single_string")
        session.subscribe(divisor=1, sections=["TOOLS"])
        session.run(10)
        self.assertFalse(any(state.settling for state in session.run(10).states))
        session.set("strings[0].tension_n", 40)
        settling = [state.settling for state in session.run(2000).states]
        self.assertTrue(settling[0])
        self.assertEqual(settling, sorted(settling, reverse=True))
        self.assertFalse(settling[-1])


if __name__ == "__main__":
    sys.exit(unittest.main(verbosity=2))
