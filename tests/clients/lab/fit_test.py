"""hapticd-lab fit: noisy data made from the equations, written anew here, give the truth back within the intervals, which hold as often as
they say; files that cannot be used are refused with line and remedy."""
import argparse
import contextlib
import csv
import io
import math
import os
import pathlib
import tempfile
import unittest

import numpy
from hapticd_lab import main, measured, string_fit
from hapticd_lab.length import length

T, E, R, LENGTH, TIP = 30.0, 1.9e11, 3.4e-4, 1.1, 5e-3
F_HZ, T_D, K_V = 65.4, 0.5, 100.0
PLACE = 0.3
SEEDS = int(os.environ.get("HAPTICD_LAB_FIT_SEEDS", "60"))
X = numpy.array([2.0, 1.0, 2.0]) / 3.0  # along the string, askew on purpose
Y = numpy.array([-2.0, 2.0, 1.0]) / 3.0  # from the string to the finger
A = numpy.array([0.1, -0.2, 0.3])
B = A + LENGTH * X
HEADING = ["t_s", "p_x_m", "p_y_m", "p_z_m", "force_x_n", "force_y_n", "force_z_n"]


def law(delta, place):
    """Eq. 10-12 as they are printed, with the exact sine, in long double."""
    delta = numpy.longdouble(delta)
    first = numpy.sqrt((numpy.longdouble(place) * LENGTH) ** 2 + delta ** 2)
    second = numpy.sqrt(((1 - numpy.longdouble(place)) * LENGTH) ** 2 + delta ** 2)
    inner = numpy.longdouble(E) * numpy.pi * numpy.longdouble(R) ** 2 * (first + second - LENGTH) / LENGTH
    return ((T + inner) * (delta / first + delta / second)).astype(float)


def session(seed, depth_m=0.008, ring_s=1.5, force_noise_n=0.02, place_noise_m=2e-6, still_s=0.3):
    """(t, p, F, phase): a press, a release, and a touch of the string while it vibrates; 1 kHz."""
    random = numpy.random.default_rng(seed)
    press = depth_m * numpy.sin(numpy.linspace(0.0, 0.5 * math.pi, 1500)) ** 2
    depth = numpy.concatenate((numpy.full(int(still_s * 1e3), -0.002), press, numpy.full(100, depth_m), numpy.full(60, -0.002),
                               numpy.full(int(ring_s * 1e3), 0.003)))
    t = numpy.arange(len(depth)) * 1e-3
    released = t[int(still_s * 1e3) + 1599]
    force = law(numpy.maximum(depth, 0.0), PLACE)
    phase = numpy.where(depth <= 0.0, "free", numpy.where(t > released, "ring", "press"))
    ringing = phase == "ring"
    since = t[ringing] - released
    force[ringing] += K_V * depth_m * numpy.exp(-since / T_D) * numpy.sin(2.0 * math.pi * F_HZ * since)
    force = numpy.maximum(force, 0.0)
    places = A + PLACE * LENGTH * X + (TIP + R - depth)[:, None] * Y + random.normal(0.0, place_noise_m, (len(t), 3))
    forces = force[:, None] * Y + random.normal(0.0, force_noise_n, (len(t), 3))
    return t, places, forces, phase


def fitted(seed, radius=R, tip=None, **more):
    """The fit of that session, without files."""
    t, places, forces, phase = session(seed, **more)
    data = measured.Measured(t, places, forces, None, None, list(phase))
    return string_fit.fit(data, places, string_fit.Geometry(A, B, radius, tip))


TRUTH = {"T": T, "EA": E * math.pi * R ** 2, "E": E, "contact_distance": TIP + R, "k_v_r_max": K_V * 0.008, "k_v": K_V, "T_d": T_D,
         "omega": 2.0 * math.pi * F_HZ}


class Truth(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        cls.fits = [fitted(seed) for seed in range(SEEDS)]

    def test_intervals_of_95_percent_hold_the_truth_in_about_95_of_100_sessions(self):
        inside = {name: sum(each.estimate(name).low <= truth <= each.estimate(name).high for each in self.fits) for name, truth in TRUTH.items()}
        for name, count in inside.items():
            # 99.99 % of binomials (60, .95) lie at 50 or above; all of them together may be too good by chance alone
            self.assertGreaterEqual(count, SEEDS * 0.95 - 4.0 * math.sqrt(SEEDS * 0.95 * 0.05), (name, inside))
        independent = ("T", "k_v_r_max", "T_d", "omega")
        self.assertLess(sum(inside[name] for name in independent), 4 * SEEDS, f"intervals that never miss are too wide: {inside}")

    def test_estimates_are_not_off_on_the_average_and_scatter_as_their_intervals_say(self):
        for name, truth in TRUTH.items():
            values = numpy.array([each.estimate(name).value for each in self.fits])
            half = numpy.mean([each.estimate(name).high - each.estimate(name).low for each in self.fits]) / 2.0
            self.assertLess(abs(values.mean() - truth), 4.0 * values.std() / math.sqrt(SEEDS) + 0.15 * half, name)
            self.assertGreater(values.std() * 1.96 / half, 0.7, name)
            self.assertLess(values.std() * 1.96 / half, 1.4, name)

    def test_the_intervals_are_of_use(self):
        for name, share in (("T", 0.02), ("E", 0.10), ("k_v", 0.05), ("T_d", 0.05), ("omega", 0.001)):
            each = self.fits[0].estimate(name)
            self.assertLess((each.high - each.low) / 2.0 / each.value, share, name)

    def test_the_noise_is_told(self):
        self.assertLess(abs(self.fits[0].sigma_n / 0.02 - 1.0), 0.1)


class WhatCannotBeToldApart(unittest.TestCase):
    def test_without_radius_and_fingertip_e_and_r_are_not_known_and_it_says_why(self):
        found = fitted(1, radius=None)
        for name in ("E", "R"):
            self.assertFalse(found.estimate(name).known)
            self.assertIn("only E A", found.estimate(name).how)
        self.assertTrue(found.estimate("EA").low < E * math.pi * R ** 2 < found.estimate("EA").high)

    def test_r_follows_from_where_contact_begins_once_the_fingertip_is_known(self):
        found = fitted(2, radius=None, tip=TIP)
        for name, truth in (("R", R), ("E", E)):
            self.assertTrue(found.estimate(name).low < truth < found.estimate(name).high, name)

    def test_a_short_touch_of_the_ringing_string_leaves_the_vibration_unknown_with_what_is_missing(self):
        found = fitted(3, ring_s=0.05)
        self.assertIn("periods", found.estimate("omega").how)
        self.assertTrue(found.estimate("T").low < T < found.estimate("T").high)

    def test_without_a_ringing_touch_the_rest_is_fitted_all_the_same(self):
        found = fitted(4, ring_s=0.0)
        self.assertIn("press, leave, touch again", found.estimate("k_v").how)
        self.assertTrue(found.estimate("EA").known)

    def test_phases_that_the_file_does_not_say_are_found_by_the_force(self):
        t, places, forces, phase = session(5)
        found = string_fit.fit(measured.Measured(t, places, forces, None, None, []), places, string_fit.Geometry(A, B, R))
        self.assertEqual([touch.phase for touch in found.touches], ["press", "ring"])
        for name in ("T", "omega", "T_d"):
            self.assertLess(abs(found.estimate(name).value / TRUTH[name] - 1.0), 0.05, name)


class TooLittle(unittest.TestCase):
    def missing(self, text, **more):
        with self.assertRaises(string_fit.TooLittle) as caught:
            fitted(0, **more)
        self.assertIn(text, str(caught.exception))

    def test_a_shallow_press_says_how_deep_it_must_be(self):
        self.missing("2 mm are needed", depth_m=0.001)

    def test_forces_of_the_wrong_sign_say_so(self):
        t, places, forces, phase = session(0)
        # the string pulls: more force, the farther away
        data = measured.Measured(t, places, -forces, None, None, list(phase))
        with self.assertRaisesRegex(string_fit.TooLittle, "on the finger"):
            string_fit.fit(data, places, string_fit.Geometry(A, B, R))

    def test_a_string_in_another_frame_is_noticed(self):
        t, places, forces, phase = session(0)
        data = measured.Measured(t, places, forces, None, None, list(phase))
        with self.assertRaisesRegex(string_fit.TooLittle, "beyond the string's ends"):
            string_fit.fit(data, places, string_fit.Geometry(A - 2.0 * X, B - 2.0 * X, R))


class Command(unittest.TestCase):
    def setUp(self):
        scratch = tempfile.TemporaryDirectory()
        self.addCleanup(scratch.cleanup)
        self.folder = pathlib.Path(scratch.name)
        self.file = self.folder / "measured.csv"

    def run_fit(self, *options):
        """Exit code, stdout, stderr."""
        out, error = io.StringIO(), io.StringIO()
        with contextlib.redirect_stdout(out), contextlib.redirect_stderr(error):
            code = main.main(["fit", str(self.file), "--output", str(self.folder / "out"), "--a", *map(repr, A.tolist()),
                              "--b", *map(repr, B.tolist()), *options])
        return code, out.getvalue(), error.getvalue()

    def write(self, heading=HEADING, rows=()):
        with open(self.file, "w", newline="", encoding="utf-8") as file:
            out = csv.writer(file)
            out.writerow(heading)
            out.writerows(rows)

    def refused(self, line, *texts):
        code, _, said = self.run_fit()
        self.assertEqual(code, 1)
        self.assertIn(f"{self.file}:{line}: ", said)
        for text in texts:
            self.assertIn(text, said)
        self.assertFalse((self.folder / "out").exists())

    def test_a_good_file_gives_parameters_residuals_plot_report_and_codebook(self):
        t, places, forces, _ = session(6)
        self.write(rows=numpy.column_stack((t, places, forces)))
        code, out, said = self.run_fit("--radius", str(R))
        self.assertEqual((code, said), (0, ""))
        self.assertEqual({path.name for path in (self.folder / "out").iterdir()},
                         {"parameters.csv", "residuals.csv", "codebook.md", "report.md", "fit.svg", "fit.png"})
        with open(self.folder / "out/parameters.csv", newline="", encoding="utf-8") as file:
            rows = {row["parameter"]: row for row in csv.DictReader(file)}
        self.assertTrue(float(rows["T"]["low_95"]) < T < float(rows["T"]["high_95"]))
        with open(self.folder / "out/residuals.csv", newline="", encoding="utf-8") as file:
            residuals = list(csv.DictReader(file))
        self.assertEqual({row["phase"] for row in residuals}, {"press", "ring"})
        self.assertIn("| T |", (self.folder / "out/report.md").read_text())
        book = (self.folder / "out/codebook.md").read_text()
        for name in (*residuals[0], *rows["T"], *rows):
            self.assertIn(name, book)

    def test_the_fingertip_of_a_tilted_tool_is_where_its_quaternion_puts_it(self):
        t, places, forces, _ = session(7)
        arm, turn = numpy.array([0.0, 0.0, 0.1]), math.sqrt(0.5)  # a quarter turn about x takes z to -y
        self.write(HEADING + ["q_w", "q_x", "q_y", "q_z"], numpy.column_stack((t, places - [0.0, -0.1, 0.0], forces, numpy.tile([turn, turn, 0, 0], (len(t), 1)))))
        code, out, _ = self.run_fit("--radius", str(R), "--tip", *map(str, arm))
        self.assertEqual(code, 0)
        self.assertLess(abs(float(out.split()[1]) / T - 1.0), 0.05)

    def test_a_wrong_heading_is_refused_with_the_columns_that_are_missing(self):
        self.write(["time", *HEADING[1:]])
        self.refused(1, "no t_s", "t_s,p_x_m")
        self.write(HEADING + ["q_w"])
        self.refused(1, "q_w alone", "all of")
        self.write(HEADING + ["t_s"])
        self.refused(1, "more than once")
        self.file.write_text("")
        self.refused(1, "no heading")
        self.file.write_bytes(b"\xff\xfe\x00PK")
        self.refused(1, "UTF-8")

    def test_a_bad_line_is_named(self):
        good = [[0.001 * i, 0, 0, 0, 0, 0, 0] for i in range(3)]
        for bad, text in ((["nan", 0, 0, 0, 0, 0, 0], "finite"), ([0.01, 0, 0, 0, 0, 0], "6 fields"), ([0.002, 0, 0, 0, 0, 0, 0], "sort"),
                          ([0.01, "1,5", 0, 0, 0, 0, 0], "finite")):
            self.write(rows=[*good, bad])
            self.refused(5, text)
        self.write(HEADING + ["phase"], [[*row, "press"] for row in good] + [[0.01, 0, 0, 0, 0, 0, 0, "pluck"]])
        self.refused(5, "free, press, ring")
        self.write(HEADING + ["q_w", "q_x", "q_y", "q_z"], [[*good[0], 1, 0, 0, 0], [*good[1], 1, 1, 0, 0]])
        self.refused(3, "unit quaternions")

    def test_too_little_data_says_what_is_missing(self):
        self.write(rows=[[0.001 * i, 0, 0, 0, 0, 0, 0] for i in range(10)])
        code, _, said = self.run_fit()
        self.assertEqual(code, 1)
        self.assertIn("10 samples, 30 are needed", said)

    def test_options_that_make_no_sense_are_refused(self):
        self.write()
        for options, text in ((["--radius", "0"], "above 0"), (["--radius", "-1"], "above 0"), (["--scene", "wall"], "leave --a")):
            code, _, said = self.run_fit(*options)
            self.assertEqual(code, 1)
            self.assertIn(text, said)

    def test_lengths_have_units_and_a_decimal_comma_is_refused_with_the_right_form(self):
        for text, metres in (("340um", 340e-6), ("0.34 mm", 340e-6), ("5cm", 0.05), ("-2m", -2.0), ("1e-3", 1e-3), (".5mm", 5e-4)):
            self.assertAlmostEqual(length(text), metres, delta=1e-12 * abs(metres), msg=text)
        for text, remedy in (("0,34mm", "write 0.34mm"), ("3in", "write 0.34mm, or"), ("mm", "no length"), ("1.2.3", "no length")):
            with self.assertRaisesRegex(argparse.ArgumentTypeError, remedy):
                length(text)


if __name__ == "__main__":
    unittest.main()
