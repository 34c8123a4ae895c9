"""A State says what is: gaps, drawn strings, contacts and their places are those that an exhaustive search over the very State finds
(state_search.py), in shipped scenes under gestures and in scenes of one kind each under poses from a seed."""
import random
import secrets
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
# Of what begins to bear force: two skins, and what rounds.
REACH_M = 4.1e-5
# Contacts in a State have whole nanometres, micrometres and ten thousandths.
GAP_M, PLACE_M, NORMAL = 1e-9, 1e-6, 1e-4
# Sections of all that is searched.
SECTIONS = ["TOOLS", "STRINGS", "CONTACTS"]
PLAYS = [("guqin", "press", 700), ("guqin_coarse", "gou", 900), ("guqin_coarse", "slide_on_body", 900), ("five_fingers", "roll", 1600),
         ("bunny_coarse", "bunny_two_regions", 900), ("cabin", "reach_through_cabin", 1500), ("strings_100", "gou", 900),
         ("wall", "contact_switch", 900)]
TIP = 'tools {{ tool_id: {0} name: "t{0}" parts {{ name: "p" shape {{ spheres {{ centre_m: [0, 0, 0] radius_m: {1} }} }} }} pose_wg {{ p_m: [{2}, {3}, {4}] }} {5} }}\n'


def tip(tool_id=0, radius=0.005, at=(0, 0.02, 0), more=""):
    return TIP.format(tool_id, radius, *at, more)


def string(z=0.0, more="", radius=0.00034):
    return f'strings {{ name: "s{z}" p_wa_m: [-0.55, 0, {z}] p_wb_m: [0.55, 0, {z}] radius_m: {radius} {more} }}\n'


def seeds(fixed, fresh):
    """Fixed seeds, and so many that are new in every run."""
    new = [secrets.randbits(32) for _ in range(fresh)]
    print(f"seeds of this run: {new}", file=sys.stderr)
    return [*fixed, *new]


def step(a, b, ticks):
    return [tuple(p + (q - p) * k / ticks for p, q in zip(a, b)) for k in range(1, ticks + 1)]


def wander(draw, home, legs):
    """A hand that goes about `home`: nowhere, to where a tip just touches the straight string, or anywhere."""
    rows, at = [], home
    for _ in range(legs):
        x, choice = home[0] + draw.uniform(-0.05, 0.05), draw.randrange(4)
        to = at if choice == 0 else (x, 0.00534, 0.0) if choice == 1 else (x, draw.uniform(-0.004, 0.012), draw.uniform(-0.004, 0.004))
        rows += step(at, to, draw.randint(1, 60))
        at = to
    return rows


class Search:
    """What is asserted of States by searching in them."""

    def check_all(self, states, events, stage, chosen=None):
        """Everything there is to say of them; gaps and contacts of the `chosen` States, else of all."""
        chosen = states if chosen is None else chosen
        self.check(chosen, stage)
        self.check_contacts(chosen, stage)
        return self.check_places(states, events, stage)

    def check(self, states, stage):
        for state in states:
            for tool_id, (drawn, nearest) in stage.gaps(state).items():
                told = next(tool for tool in state.tools if tool.tool_id == tool_id)
                where = f"tick {state.tick}, tool {tool_id}, flags {list(told.flags)}"
                if hapticd.v1.state_pb2.TOOL_FLAG_RECOVERING not in told.flags:
                    self.assertGreaterEqual(drawn, -DRAWN_M, where)
                self.assertAlmostEqual(told.minimum_gap_m, min(nearest, stage.margin), delta=ROUNDING_M, msg=where)

    def check_contacts(self, states, stage):
        """Every listed contact has its place on a sphere of the tool, and no patch misses the nearest pair of its object."""
        for state in states:
            for patch in state.contacts:
                if not patch.gap_nanometres:
                    continue
                where = f"tick {state.tick}, {patch}"
                nearest = stage.gap_to_object(patch, state)
                told = patch.gap_nanometres[0] * 1e-9
                self.assertGreaterEqual(told, nearest - GAP_M - ROUNDING_M, where)
                if nearest < 2 * stage.skin - ROUNDING_M:
                    self.assertAlmostEqual(told, nearest, delta=GAP_M + ROUNDING_M, msg=where)
                spheres = stage.tool(next(tool for tool in state.tools if tool.tool_id == patch.tool_id))
                for k in range(len(patch.gap_nanometres)):
                    p = 1e-6 * numpy.array(patch.p_wc_um[3 * k:3 * k + 3])
                    n = 1e-4 * numpy.array(patch.nhat_og_w_e4[3 * k:3 * k + 3])
                    off = numpy.linalg.norm(p + spheres[:, 3:] * n - spheres[:, :3], axis=1) - NORMAL * spheres[:, 3]
                    self.assertLess(off.min(), PLACE_M, where)

    def check_places(self, states, events, stage):
        """Every Contact has a place on a sphere of its tool, and a normal that points to its centre, as the tool stands after the tick that the
        instant is in; one on the border of two ticks is in either."""
        by_tick = {state.tick: state for state in states}
        contacts = [event.body for event in events if event.kind == "contact"]
        for contact in contacts:
            self.assertEqual((len(contact.p_wc_m), len(contact.nhat_og_w)), (3, 3), contact)
            p, n = numpy.array(contact.p_wc_m), numpy.array(contact.nhat_og_w)
            self.assertAlmostEqual(numpy.linalg.norm(n), 1, delta=1e-6)
            after = -(-contact.t_ns // 1_000_000)
            ticks = [after, after + 1] if contact.t_ns % 1_000_000 == 0 else [after]
            if contact.phase == PHASE.Value("CONTACT_PHASE_END"):
                # Where the tool stood as it let go, however much later that is told.
                ticks = range(after - 1, after + 2)
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
        stage = Stage(session.scene.scene, session.scene.solver_in_force)
        return states, list(session.events(timeout=0)), stage

    def test_a_finger_in_and_out_of_touch_has_the_gap_that_a_search_finds(self):
        rows = step((0.1, 0.02, 0), (0.1, 0.001, 0.0), 120) + step((0.1, 0.001, 0), (0.16, 0.002, 0.004), 80) + \
            step((0.16, 0.002, 0.004), (0.16, 0.012, 0.02), 30) + step((0.16, 0.012, 0.02), (0.0, 0.0045, -0.02), 100)
        states, events, stage = self.play('name: "x"\n' + tip() + string() + "vibration {} tones {} torque {}", {0: rows})
        self.assertGreaterEqual(len(self.check_all(states, events, stage)), 2)
        self.assertTrue(any(state.strings for state in states))

    def test_several_tools_bend_one_string_and_none_is_in_what_is_drawn(self):
        shared = 0
        for seed in seeds([1, 2, 2952455503, 3682406839, 4048015580, 4284702718, 480576460], 3):
            for apart in (0.15, 0.03):
                with self.subTest(seed=seed, apart=apart):
                    draw = random.Random(seed)
                    homes = [(apart * k - 0.2, 0.02, 0.0) for k in range(4)]
                    tools = "".join(tip(k, at=home) for k, home in enumerate(homes))
                    tracks = {k: wander(draw, home, 8) for k, home in enumerate(homes)}
                    states, events, stage = self.play('name: "x"\n' + tools + string() + "vibration {} tones {}", tracks)
                    self.check_all(states, events, stage)
                    shared += sum(bool(each.further_lambda) for state in states for each in state.strings)
        self.assertGreater(shared, 0)

    def test_thin_strings_swept_with_one_sub_step_are_told_as_they_are(self):
        for seed in seeds([5, 7, 8, 9, 37, 54], 4):
            with self.subTest(seed=seed):
                draw = random.Random(seed)
                at, rows = (0.0, 0.009, 0.0), []
                for _ in range(25):
                    to = (draw.uniform(-0.2, 0.2), draw.uniform(-0.004, 0.009), draw.uniform(-0.006, 0.006))
                    rows += step(at, to, draw.choice((1, 1, 2, 8)))
                    at = to
                text = 'name: "x"\n' + tip(radius=0.0007, at=(0, 0.009, 0)) + "".join(
                    string(z, "model: STRING_MODEL_DEFLECTING", 1.6e-5) for z in (-0.0015, -0.0005, 0.0005, 0.0015)) + \
                    "quality { level: 1 } solver { max_substeps: 1 }"
                states, events, stage = self.play(text, {0: rows})
                self.check_all(states, events, stage)
                self.check_reach(states, stage)

    def check_reach(self, states, stage):
        """What begins to bear force in a State is within reach of the tool in it, or of the hand."""
        before = set()
        for state in states:
            told = {each.string_index: each for each in state.strings}
            tool = state.tools[0]
            now = {patch.string_index for patch in state.contacts if any(patch.force_mn)}
            for number in now - before:
                at_tool = stage.tool(tool)
                at_hand = at_tool + numpy.append(numpy.subtract(tool.p_wh_m, tool.p_wg_m), 0)
                gap = min(stage.gap_to_string(number, told.get(number), at_tool[:, :3], at_tool[:, 3]),
                          stage.gap_to_string(number, None, at_hand[:, :3], at_hand[:, 3]))
                self.assertLess(gap, REACH_M, f"tick {state.tick}, string {number}")
            before = now

    def test_tick_0_has_no_overlap_where_there_is_room_and_one_where_there_is_none(self):
        for height, overlaps in ((0.012, False), (0.0054, False), (0.004, True)):
            states, _, stage = self.play('name: "x"\n' + tip(at=(0, height, 0)) + string(), {0: [(0, height, 0)] * 5})
            self.check(states, stage)
            causes = {CAUSE.Cause.Name(state.cause) for state in states}
            self.assertEqual("CAUSE_OVERLAP" in causes, overlaps, height)
            self.assertEqual(states[-1].loop_state == hapticd.v1.state_pb2.LOOP_STATE_ENGAGED, not overlaps)

    def test_a_tone_is_told_where_the_string_was_plucked_though_another_tool_stops_it_lightly(self):
        for node in (0.25, 1 / 3, 0.5):
            x = -0.55 + 1.1 * node
            pluck = [(0.44, 0.02, -0.012)] * 100 + step((0.44, 0.02, -0.012), (0.44, 0.003, -0.012), 60) + \
                step((0.44, 0.003, -0.012), (0.44, 0.003, 0.014), 52)
            touch = step((x, 0.0153, 0), (x, 0.00529, 0), 60) + [(x, 0.00529, 0)] * (len(pluck) - 45) + step((x, 0.00529, 0), (x, 0.02, 0), 60)
            text = 'name: "x"\n' + tip(0, at=(x, 0.0153, 0)) + tip(1, at=(0.44, 0.02, -0.012)) + string(more="frequency_hz: 110") + "vibration {} tones {}"
            states, events, stage = self.play(text, {0: touch, 1: pluck})
            tones = [event.body for event in events if event.kind == "tone" and event.body.tool_id == 1]
            self.assertEqual(len(tones), 1)
            self.assertAlmostEqual(getattr(tones[0], "lambda"), 0.9, delta=0.002)
            self.check_all(states, events, stage)

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


class Shipped(Search, unittest.TestCase):
    """Under the gestures that are shipped, of hands that are simulated."""

    def test_gestures_in_shipped_scenes(self):
        (seed,) = seeds([], 1)
        draw = random.Random(seed)
        for scene, gesture, ticks in PLAYS:
            with self.subTest(scene=scene, gesture=gesture, seed=seed):
                with daemon.Daemon("--clock", "virtual", "--scene", scene, "--gesture", gesture) as played, hapticd.Session(played.address) as session:
                    session.acquire("test")
                    session.subscribe(divisor=1, sections=SECTIONS, max_contacts=256)
                    states = session.run(ticks).states
                    events = list(session.events(timeout=0))
                    stage = Stage(session.scene.scene, session.scene.solver_in_force)
                    touching = [state for state in states if state.contacts]
                    chosen = [states[0]] + draw.sample(states, 40) + draw.sample(touching, min(40, len(touching)))
                    self.check_all(states, events, stage, chosen)
                    self.assertTrue(touching)


if __name__ == "__main__":
    sys.exit(unittest.main(verbosity=2))
