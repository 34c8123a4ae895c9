"""A scene as SceneInfo tells it can be sent back with another quality: the level's own knobs are in force then, and the author's where he gave some.
Truth: the table of levels, core/scene/quality_levels.inc, read here."""
import pathlib
import re
import sys
import tempfile
import unittest

import daemon
import hapticd
from google.protobuf import text_format

ROOT = pathlib.Path(__file__).resolve().parents[2]
LEVELS = [(int(row[0]), float(row[1])) for row in re.findall(r"^\{(\d+), ([^,]+),", (ROOT / "core/scene/quality_levels.inc").read_text(), re.MULTILINE)]
"""Sub-steps and stop tolerance of each level."""
VIRTUAL = ("--clock", "virtual", "--device", "scripted")
SCENES = ("guqin", "five_fingers", "bunny", "cabin", "single_string", "strings_100", "wall", "sphere", "guqin_coarse", "bunny_coarse")


def copy_of(session):
    scene = hapticd.v1.scene_pb2.Scene()
    scene.CopyFrom(session.scene.scene)
    return scene


def send(session, scene):
    return session.load_scene(text_format.MessageToString(scene))


class Told(daemon.LockstepCase):
    def in_force(self, session, level, knobs=None):
        """What is said to be in force, and what the ticks do: no more sub-steps than that."""
        info = session.scene
        self.assertEqual(info.quality_in_force.level, level)
        wanted = knobs or LEVELS[level]
        self.assertEqual((info.solver_in_force.max_substeps, info.solver_in_force.stop_step_m), wanted)
        session.subscribe(divisor=1, sections=["QUALITY"])
        result = session.run(3)
        self.assertEqual({state.quality.level for state in session.states(result.steps)}, {level})

    def test_a_told_scene_sent_back_with_another_level_has_that_levels_knobs(self):
        for name in SCENES:
            with self.subTest(name):
                self.session.load_scene(name)
                for level in (0, 4, 1, 3, 2):
                    scene = copy_of(self.session)
                    scene.quality.level = level
                    send(self.session, scene)
                    self.in_force(self.session, level)

    def test_a_told_scene_sent_back_as_it_is_is_told_so_again(self):
        for name in SCENES:
            with self.subTest(name):
                self.session.load_scene(name)
                for _ in range(2):
                    before = copy_of(self.session)
                    force = (self.session.scene.quality_in_force, self.session.scene.solver_in_force)
                    info = send(self.session, before)
                    self.assertEqual(info.scene, before)
                    self.assertEqual((info.quality_in_force, info.solver_in_force), force)

    def test_knobs_that_the_author_gave_stand_at_every_level_equal_to_a_levels_own_too(self):
        self.session.load_scene("wall")
        plain = copy_of(self.session)
        for substeps, stop in ((LEVELS[3][0], None), (77, None), (None, LEVELS[1][1]), (5, 3e-5)):
            given = hapticd.v1.scene_pb2.Scene()
            given.CopyFrom(plain)
            if substeps is not None:
                given.solver.max_substeps = substeps
            if stop is not None:
                given.solver.stop_step_m = stop
            send(self.session, given)
            for level in range(5):
                scene = copy_of(self.session)
                self.assertEqual(scene.solver.HasField("max_substeps"), substeps is not None)
                self.assertEqual(scene.solver.HasField("stop_step_m"), stop is not None)
                scene.quality.level = level
                send(self.session, scene)
                knobs = (substeps or LEVELS[level][0], stop or LEVELS[level][1])
                self.in_force(self.session, level, knobs)
                # As a live parameter: the knobs in force follow, those given stand.
                other = (level + 2) % 5
                self.session.set("quality", other)
                with hapticd.Session(self.played.address) as late:
                    late_knobs = (late.scene.solver_in_force.max_substeps, late.scene.solver_in_force.stop_step_m)
                    self.assertEqual(late_knobs, (substeps or LEVELS[other][0], stop or LEVELS[other][1]))

    def test_a_bound_of_the_error_and_automatic_quality_come_back_as_they_were_written(self):
        for text in ("quality { max_force_error: 0.1 }", "quality { automatic {} }", "quality { automatic { budget_us: 70 } }"):
            self.session.load_scene("wall")
            scene = copy_of(self.session)
            text_format.Merge(text, scene)
            written = text_format.MessageToString(scene.quality)
            info = send(self.session, scene)
            self.assertEqual(text_format.MessageToString(info.scene.quality), written)
            self.assertFalse(info.scene.solver.HasField("max_substeps"))
            if scene.quality.HasField("automatic"):
                self.assertEqual(info.quality_in_force.automatic.budget_us, scene.quality.automatic.budget_us or 500)
            scene = copy_of(self.session)
            scene.quality.level = 0
            send(self.session, scene)
            self.in_force(self.session, 0)

    def test_parameters_set_since_are_told_to_who_comes_later_and_go_back_with_the_scene(self):
        self.session.load_scene("single_string")
        self.session.set({"strings[0].tension_n": 44, "quality": 1, "tools[0].coupling.kt_n_per_m": 700, "solver.margin_m": 0.004})
        with hapticd.Session(self.played.address) as late:
            scene = copy_of(late)
            self.assertEqual((scene.strings[0].tension_n, scene.tools[0].coupling.kt_n_per_m, scene.solver.margin_m), (44, 700, 0.004))
            self.assertEqual(scene.quality.level, 1)
            self.assertEqual(late.scene.quality_in_force.level, 1)
        send(self.session, scene)
        self.in_force(self.session, 1)
        self.assertEqual(self.session.get("strings[0].tension_n"), 44)
        self.session.set("quality", "auto")
        self.session.set("quality.automatic.budget_us", 90)
        with hapticd.Session(self.played.address) as late:
            self.assertEqual(late.scene.scene.quality.automatic.budget_us, 90)

    def test_what_hapticd_was_started_with_is_in_force_and_not_the_scenes(self):
        with tempfile.TemporaryDirectory() as folder:
            path = pathlib.Path(folder) / "mine.textproto"
            text = (ROOT / "deploy/scenes/wall.textproto").read_text()
            path.write_text(text + "quality { level: 4 }\n")
            for option, level in (("1", 1), ("auto", 3)):
                with daemon.Daemon(*VIRTUAL, "--scene", str(path), "--quality", option) as played, hapticd.Session(played.address) as session:
                    self.assertEqual(session.scene.scene.quality.level, 4)
                    self.assertEqual(session.scene.quality_in_force.HasField("automatic"), option == "auto")
                    force = session.scene.solver_in_force
                    self.assertEqual((force.max_substeps, force.stop_step_m), LEVELS[level])
                    # Sent to another one, which was started with nothing, it has the author's quality.
                    scene = copy_of(session)
                send(self.session, scene)
                self.in_force(self.session, 4)


if __name__ == "__main__":
    sys.exit(unittest.main(verbosity=2))
