"""What is said to do nothing in a scene does nothing: a session in lockstep with the field changed has the same States and events. And what
is not said to, in scenes that use it, changes them."""
import os
import pathlib
import random
import re
import subprocess
import tempfile
import unittest

import daemon
import hapticd

BIN = pathlib.Path(os.environ["HAPTICCTL"]).parent
SCENES = pathlib.Path(__file__).resolve().parents[2] / "deploy/scenes"
TICKS = 1500
SAMPLES = 6

TIP = "spheres { centre_m: [0, 0, 0] radius_m: 0.005 }"
HEAD = 'name: "tried"\ntools {\n name: "finger"\n parts {\n  name: "tip" shape { %s }\n%s }\n pose_wg { p_m: [0, 0.0153, 0] }\n}\n'
FINGER = HEAD % (TIP, "")
SOFT = HEAD % (TIP, "  fingertip { stiffness_n_per_m: 900 }\n")
WALL = 'bodies { name: "wall" shape { spheres { centre_m: [0, -1.004, 0] radius_m: 1 } } }\n'
BUNNY = 'bodies { name: "bunny" shape { tree: "bunny_64.tree" } pose_wb { p_m: [0, -0.15, 0] } }\n'


def string(words="", name="A", z=0.0):
    return f'strings {{\n name: "{name}" p_wa_m: [-0.55, 0, {z}] p_wb_m: [0.55, 0, {z}]\n{words} }}\n'


TUNED = " frequency_hz: 65.4\n"
PLAIN = FINGER + string(TUNED)
# (rest of the scene, what is tried in it, what it is changed to, path of the warning). \0 stands for the place of what is tried.
IDLE = [
    *((FINGER + WALL + "\0", feature + "\n", "", feature.split()[0]) for feature in
      ("friction { coefficient: 0.5 }", "vibration {}", "lateral_force {}", "tones {}", "release { arm_deflection_m: 1e-4 }")),
    (FINGER + WALL + "\0", "preset: PRESET_PAPER\n", "", "preset"),
    (FINGER + WALL + "vibration {}\n\0", "wave { modes: 4 }\n", "", "wave"),
    (FINGER + string() + "\0", "vibration {}\n", "", "vibration"),
    (FINGER + string() + "vibration {}\n\0", "tones {}\n", "", "tones"),
    (PLAIN + "\0", "tones {}\n", "", "tones"),
    (FINGER + string(TUNED + " max_level: STRING_LEVEL_FUNDAMENTAL\n") + "vibration {}\n\0", "wave { modes: 4 }\n", "", "wave"),
    (FINGER + string(TUNED + " max_level: STRING_LEVEL_RIGID\n") + "\0", "lateral_force {}\n", "", "lateral_force"),
    (PLAIN + "\0", "lateral_force {}\n", "", "lateral_force"),
    (FINGER + string(" model: STRING_MODEL_RIGID\n") + "\0", "lateral_force {}\n", "", "lateral_force"),
    (FINGER + string(TUNED + " max_level: STRING_LEVEL_RIGID\n") + "\0", "release {\n arm_deflection_m: 1e-5\n}\n", "", "release.arm_deflection_m"),
    (FINGER + string(TUNED + " max_level: STRING_LEVEL_RIGID\n") + "\0", "friction { coefficient: 0.5 }\n", "", "friction"),
    (FINGER + string(" max_level: STRING_LEVEL_RIGID\n\0") + "friction { coefficient: 0.5 }\n", " friction_coefficient: 0.9\n", "",
     "strings[0].friction_coefficient"),
    (PLAIN + "vibration {}\n\0", "tones {\n reference_force_n: 1\n}\n", "tones {}\n", "tones.reference_force_n"),
    (PLAIN + "vibration {}\n\0", "tones { level: TONE_LEVEL_FORCE\n reference_amplitude_m: 1e-4\n}\n", "tones { level: TONE_LEVEL_FORCE }\n",
     "tones.reference_amplitude_m"),
    (FINGER + string(TUNED + "\0") + "vibration {}\n", " linear_density_kg_per_m: 1.4e-3\n", "", "strings[0].linear_density_kg_per_m"),
    (FINGER + string(TUNED + "\0") + "vibration {}\n", " k_s: 7\n", "", "strings[0].k_s"),
    (FINGER + string(TUNED + "\0") + "vibration {}\n", " k_s_from_device {}\n", "", "strings[0].k_s_from_device"),
    (FINGER + string(TUNED + "\0") + "vibration {}\npreset: PRESET_PAPER\n", " inharmonicity: 1e-3\n", "", "strings[0].inharmonicity"),
    *((FINGER + string(" max_level: STRING_LEVEL_RIGID\n\0"), f" {field}\n", "", f"strings[0].{field.split(':')[0]}") for field in
      ("tension_n: 90", "youngs_modulus_pa: 1e9", "axial_stiffness_n: 900", "k_s: 4")),
    (FINGER + string(" max_level: STRING_LEVEL_RIGID model: STRING_MODEL_RIGID\n\0"), " k_s: 4\n", "", "strings[0].k_s"),
    *((FINGER + string(tuning + "\0"), f" {field}\n", "", f"strings[0].{field.split(':')[0]}") for tuning, field in
      (("", "frequency_hz: 200"), ("", "linear_density_kg_per_m: 0.01"), (TUNED, "decay_s: 3"), (TUNED, "touch_decay_s: 3"),
       (TUNED, "inharmonicity: 0.01"), (TUNED, "loss_n2_per_s: 9"), (TUNED, "tuning: TUNING_TENSION"),
       (" axial_stiffness_n: 900\n", "youngs_modulus_pa: 1e9"))),
    (FINGER + string(" linear_density_kg_per_m: 1.4e-3 tuning: TUNING_TENSION\n\0") + "vibration {}\n", " frequency_hz: 70\n", "", "strings[0].frequency_hz"),
    (FINGER + WALL + "vibration {}\n\0", "modes { count: 4 }\n", "", "modes"),
    (PLAIN + "\0", "solver {\n tool_level: 1\n}\n", "", "solver.tool_level"),
    (PLAIN + "\0", "solver {\n body_level: 1\n}\n", "", "solver.body_level"),
    (SOFT + BUNNY + "\0", "solver {\n body_level: 1\n}\n", "", "solver.body_level"),
    *((FINGER + "\0", f"solver {{\n {knob}: {value}\n}}\n", "", f"solver.{knob}") for knob, value in
      (("max_substeps", 2), ("stop_step_m", 1e-4), ("skin_m", 1e-4), ("max_rotation_rad", 0.01), ("max_rows", 4),
       ("recovery_speed_m_per_s", 9))),
    (HEAD % (TIP, "\0"), "  fingertip { stiffness_n_per_m: 900 }\n", "", "tools[0].parts[0].fingertip"),
]
RICH_STRING = (" tension_n: 30 youngs_modulus_pa: 1.9e11 frequency_hz: 65.4 decay_s: 0.5 touch_decay_s: 0.03 inharmonicity: 1e-3\n"
               " friction_coefficient: 0.2\n")
RICH = (FINGER + string(RICH_STRING) + string(TUNED, "B", 0.012) + "vibration {}\nwave { modes: 8 }\nfriction { coefficient: 0.3 }\n"
        "tones { level: TONE_LEVEL_AMPLITUDE reference_amplitude_m: 0.03 }\nrelease { arm_deflection_m: 4e-4 }\n")
RIGID = FINGER + string(" max_level: STRING_LEVEL_RIGID\n") + "release { release_gap_m: 1e-4 }\n"
UNTUNED = FINGER + string(" max_level: STRING_LEVEL_%s\n")
# (scene, field that is idle there and that it cannot do without, what in it is changed to obey the warning, and to what).
NEEDED = [
    (UNTUNED % "FUNDAMENTAL" + "vibration {}\n", "vibration", " max_level", TUNED + " max_level"),
    (UNTUNED % "WAVE" + "preset: PRESET_PAPER\nvibration {}\nwave { modes: 4 }\n", "wave", " max_level", TUNED + " max_level"),
    (FINGER + string(TUNED + " max_level: STRING_LEVEL_FUNDAMENTAL\n") + string(" max_level: STRING_LEVEL_WAVE\n", "B", 0.012)
     + "preset: PRESET_PAPER\nvibration {}\nwave { modes: 4 }\n", "wave", " max_level: STRING_LEVEL_WAVE", TUNED + " max_level: STRING_LEVEL_WAVE"),
    (FINGER + WALL + "vibration {}\nwave { modes: 4 }\n", "vibration", "vibration {}\nwave { modes: 4 }\n", ""),
]
STRAIGHT = FINGER + string(" model: STRING_MODEL_RIGID k_s: 1\n") + "preset: PRESET_PAPER\n"
# (scene, what is in it, what takes its place): what is played differs.
EFFECTIVE = [
    *((RICH, old, new) for old, new in (
        ("tension_n: 30", "tension_n: 31"), ("youngs_modulus_pa: 1.9e11", "youngs_modulus_pa: 1e11"), ("frequency_hz: 65.4 decay", "frequency_hz: 70 decay"),
        ("decay_s: 0.5 ", "decay_s: 0.3 "), ("touch_decay_s: 0.03", "touch_decay_s: 0.01"), ("inharmonicity: 1e-3", "inharmonicity: 2e-3"),
        ("friction_coefficient: 0.2", "friction_coefficient: 0.4"), ("vibration {}\nwave { modes: 8 }", ""), ("wave { modes: 8 }", ""),
        ("coefficient: 0.3", "coefficient: 0.6"), ("reference_amplitude_m: 0.03", "reference_amplitude_m: 0.02"),
        ("tones { level: TONE_LEVEL_AMPLITUDE reference_amplitude_m: 0.03 }", ""), ("arm_deflection_m: 4e-4", "arm_deflection_m: 2e-3"))),
    (RIGID, "release_gap_m: 1e-4", "release_gap_m: 0.05"),
    (STRAIGHT, "k_s: 1", "k_s: 2"),
    (STRAIGHT + "lateral_force {}\n", "lateral_force {}\n", ""),
    (FINGER + string(" linear_density_kg_per_m: 1.4e-3\n") + "vibration {}\n", "1.4e-3", "1.5e-3"),
    (FINGER + string(" axial_stiffness_n: 2e4\n"), "2e4", "1e4"),
    (FINGER + BUNNY + "solver {\n body_level: 1\n}\n", "body_level: 1", "body_level: 2"),
    (SOFT + WALL, "stiffness_n_per_m: 900", "stiffness_n_per_m: 800"),
    (FINGER + WALL + "solver { skin_m: 2e-5 }\n", "skin_m: 2e-5", "skin_m: 3e-5"),
]


def path(seed):
    """A finger that wanders beside and below the strings' plane, at less than 0.4 m/s: it presses, plucks, slides along and touches again."""
    turn, at, rows = random.Random(seed), [0.0, 0.0153, 0.0], []
    while len(rows) < TICKS:
        goal = [turn.uniform(-0.15, 0.15), turn.choice([0.0153, 0.003, -0.002, -0.012]), turn.uniform(-0.02, 0.03)]
        steps = turn.randint(60, 160)
        for k in range(steps):
            share = (k + 1) / steps
            rows.append(tuple(a + share * (b - a) for a, b in zip(at, goal)))
        at = goal
    return rows[:TICKS]


def checked(text, name):
    """Exit code and complaints of hapticd-model check, and the path of the scene."""
    with tempfile.TemporaryDirectory() as folder:
        file = pathlib.Path(folder, f"{name}.textproto")
        file.write_text(text, encoding="utf-8")
        done = subprocess.run([BIN / "hapticd-model", "check", file], capture_output=True, text=True, check=False)
        return done.returncode, done.stderr, str(file)


def warned(text, name):
    """{path: line} of what hapticd-model says does nothing in a scene."""
    code, complaints, file = checked(text, name)
    if code:
        raise AssertionError(complaints)
    found = re.findall(rf"^{re.escape(file)}:(\d+):\d+: warning: (\S+): this does nothing: ", complaints, re.MULTILINE)
    return {field: int(line) for line, field in found}


def told(event):
    """What an event says. A string that is still has no decay."""
    body = type(event.body)()
    body.CopyFrom(event.body)
    if event.kind == "string_radius" and body.r_max_m == 0.0:
        body.ClearField("decay_s")
    return event.kind, body.SerializeToString(deterministic=True)


class IdleFields(daemon.LockstepCase):
    def all_of(self, text, poses):
        """All that a session was told."""
        self.session.load_scene(text)
        list(self.session.events(timeout=0))
        result = self.session.run(poses=poses)
        return result.state_hash, [told(event) for event in self.session.events(timeout=0)]

    def setUp(self):
        self.seed = random.randrange(2**32)
        self.poses = path(self.seed)

    def test_what_is_said_to_do_nothing_does_nothing(self):
        for rest, tried, other, field in IDLE:
            text = rest.replace("\0", tried)
            with self.subTest(field, seed=self.seed, text=text):
                lines = warned(text, "tried")
                self.assertIn(field, lines)
                self.assertIn(field.split(".")[-1], text.splitlines()[lines[field] - 1])
                self.assertEqual(self.all_of(text, self.poses), self.all_of(rest.replace("\0", other), self.poses))

    def test_what_is_not_said_to_do_nothing_does_something(self):
        # More than one path: no single one slides, plucks and touches again in every way.
        paths = [self.poses, path(self.seed + 1), path(self.seed + 2)]
        for text, old, new in EFFECTIVE:
            with self.subTest(old, seed=self.seed):
                self.assertIn(old, text)
                self.assertEqual({}, warned(text, "tried"))
                changed = text.replace(old, new)
                self.assertTrue(any(self.all_of(text, poses) != self.all_of(changed, poses) for poses in paths))


class Remedies(unittest.TestCase):
    def test_nobody_is_told_to_leave_out_alone_what_the_scene_needs(self):
        for text, field, old, new in NEEDED:
            with self.subTest(field, text=text):
                self.assertIn(field, warned(text, "tried"))
                self.assertNotEqual(0, checked(re.sub(rf"{field} .*\n", "", text), "tried")[0])
                (said,) = (line for line in checked(text, "tried")[1].splitlines() if f"warning: {field}: " in line)
                self.assertNotIn("Leave it out,", said)
                self.assertIn("frequency_hz" if new else "together with wave", said)
                self.assertEqual({}, warned(text.replace(old, new), "tried"))

    def test_the_coefficient_that_a_scene_with_friction_must_have_is_no_doubt(self):
        text = FINGER + string(" friction_coefficient: 0.3\n") + "friction { coefficient: 0.1 }\n"
        self.assertEqual({}, warned(text, "tried"))


class ShippedScenes(unittest.TestCase):
    """A hand strums the Guqin: every string is plucked."""

    def test_fields_of_a_shipped_scene_do_something(self):
        seed = random.randrange(2**32)
        turn = random.Random(seed)
        text = (SCENES / "guqin_coarse.textproto").read_text(encoding="utf-8")
        self.assertEqual({}, warned(text, "guqin_coarse"))
        numbers = list(re.finditer(r"(?m)^strings .*?\b(radius_m|linear_density_kg_per_m|axial_stiffness_n): ([\d.]+)", text))
        with daemon.Daemon("--clock", "virtual", "--scene", "guqin_coarse") as played, hapticd.Session(played.address) as session:
            session.acquire("test")
            usual = self.strummed(session, text)
            self.assertTrue([kind for kind, _ in usual[1] if kind == "tone"])
            for field in turn.sample(numbers, SAMPLES):
                value = f"{float(field.group(2)) * turn.uniform(1.05, 1.2):.9g}"
                with self.subTest(field.group(), value=value, seed=seed):
                    changed = text[:field.start(2)] + value + text[field.end(2):]
                    self.assertNotEqual(usual, self.strummed(session, changed))
            for feature in ("vibration {}\n", "tones {}\n", "torque {}\n"):
                with self.subTest(feature):
                    self.assertNotEqual(usual, self.strummed(session, text.replace(feature, "")))

    @staticmethod
    def strummed(session, text):
        session.load_scene(text)
        list(session.events(timeout=0))
        session.play_gesture("strum", seed=1, repeat=1)
        result = session.run(steps=6000)
        return result.state_hash, [told(event) for event in session.events(timeout=0)]


if __name__ == "__main__":
    unittest.main()
