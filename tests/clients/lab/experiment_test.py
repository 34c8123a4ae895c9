"""hapticd-lab experiment, end to end with the program as it stands in the build tree: a simulated observer whose threshold comes back from its
answers, a run that is killed in the middle and goes on, and a person at the terminal. usage: experiment_test.py HAPTICD_LAB"""
import csv
import json
import os
import pathlib
import signal
import subprocess
import sys
import tempfile
import unittest

import numpy
from hapticd_lab import player, threshold_fit
from hapticd_lab.observer import WeberObserver
from hapticd_lab.trials import COLUMNS, BadTrials, TrialLog, plan, rates

PROGRAM = sys.argv.pop(1) if len(sys.argv) > 1 else "hapticd-lab"
PATIENCE_S = 120.0


def rows_of(path):
    with open(path, newline="", encoding="utf-8") as file:
        return list(csv.DictReader(file))


class Plan(unittest.TestCase):
    def test_every_comparison_comes_as_often_as_asked_in_an_order_that_follows_from_the_seed(self):
        trials = plan(1, 3)
        self.assertEqual([each.trial for each in trials], list(range(1, 28)))
        self.assertEqual(len({(each.parameter, each.increment, each.repetition) for each in trials}), 27)
        self.assertEqual(plan(1, 3), trials)
        self.assertNotEqual([each.parameter for each in plan(2, 3)], [each.parameter for each in trials])

    def test_the_raised_string_is_first_as_often_as_second_by_chance(self):
        share = numpy.mean([each.stiffer == "first" for seed in range(100) for each in plan(seed, 3)])
        self.assertLess(abs(share - 0.5), 4.0 * 0.5 / numpy.sqrt(2700))

    def test_one_string_of_a_trial_is_the_reference_and_the_other_has_one_parameter_raised(self):
        for each in plan(3, 1):
            raised = each.strings[0 if each.stiffer == "first" else 1]
            values = (raised.tension_n / 30.0, raised.youngs_modulus_pa / 1.9e11, raised.radius_m / 3.4e-4)
            expected = [1.0, 1.0, 1.0]
            expected["TER".index(each.parameter)] = 1.0 + each.increment
            numpy.testing.assert_allclose(values, expected, rtol=1e-12)


class Log(unittest.TestCase):
    def setUp(self):
        scratch = tempfile.TemporaryDirectory()
        self.addCleanup(scratch.cleanup)
        self.path = pathlib.Path(scratch.name) / "trials.csv"
        self.trials = plan(1, 1)

    def answer(self, log, count):
        for trial in self.trials[len(log.rows):len(log.rows) + count]:
            log.add(trial, ("first", "second", "equal")[trial.trial % 3], (1.0 / 3.0, 2.0), 0.1)

    def test_a_line_that_was_cut_off_is_asked_again_and_no_other_is_lost(self):
        self.answer(TrialLog(self.path, self.trials), 9)
        whole = self.path.read_bytes()
        for kept in range(len(whole)):
            self.path.write_bytes(whole[:kept])
            log = TrialLog(self.path, self.trials)
            self.assertEqual(len(log.rows), max(whole[:kept].count(b"\n") - 1, 0))
            self.assertEqual(self.path.read_bytes(), whole[:kept])  # reading changes nothing
            self.answer(log, 9)
            self.assertEqual(self.path.read_bytes(), whole, kept)

    def test_trials_of_another_experiment_are_refused_with_the_line(self):
        self.answer(TrialLog(self.path, self.trials), 4)
        with self.assertRaisesRegex(BadTrials, r"trials.csv:2: trial 1.* where the plan has 1"):
            TrialLog(self.path, plan(2, 1))
        with self.assertRaisesRegex(BadTrials, "trials.csv:4"):
            TrialLog(self.path, self.trials[:2])
        self.path.write_text("a,b\n")
        with self.assertRaisesRegex(BadTrials, "heading"):
            TrialLog(self.path, self.trials)

    def test_rates_are_of_correct_answers_and_equal_is_none(self):
        log = TrialLog(self.path, self.trials)
        for trial in self.trials:
            log.add(trial, {"T": trial.stiffer, "E": "equal", "R": "first" if trial.stiffer == "second" else "second"}[trial.parameter], (1.0, 1.0), 0.0)
        self.assertEqual(rates(log.rows), {"T": [100.0] * 3, "E": [0.0] * 3, "R": [0.0] * 3})


class Threshold(unittest.TestCase):
    def test_intervals_of_95_percent_hold_the_observer_s_values(self):
        observer, inside, groups = WeberObserver(sigma=0.3, criterion=0.2), [0, 0], 60
        ratios = numpy.tile(numpy.linspace(0.05, 0.6, 12), 20)
        for seed in range(groups):
            felt = ratios + observer.sigma * numpy.random.default_rng(seed).normal(size=len(ratios))
            found = threshold_fit.fit(ratios, numpy.where(felt > 0.2, 1, numpy.where(felt < -0.2, -1, 0)))
            inside[0] += found.criterion.low <= 0.2 <= found.criterion.high
            inside[1] += found.sigma.low <= 0.3 <= found.sigma.high
        for count in inside:
            self.assertGreaterEqual(count, groups * 0.95 - 4.0 * numpy.sqrt(groups * 0.95 * 0.05))
        self.assertLess(sum(inside), 2 * groups)  # intervals that never miss are too wide

    def test_answers_that_bound_nothing_leave_the_interval_open(self):
        found = threshold_fit.fit([0.1, 0.3], [0, 0])
        self.assertEqual(found.criterion.high, float("inf"))


class Running(unittest.TestCase):
    def setUp(self):
        scratch = tempfile.TemporaryDirectory()
        self.addCleanup(scratch.cleanup)
        self.folder = pathlib.Path(scratch.name)

    def run_program(self, *arguments, **more):
        return subprocess.run([PROGRAM, "experiment", *arguments], capture_output=True, text=True, timeout=PATIENCE_S, check=False, **more)


class Program(Running):
    def test_the_threshold_of_a_simulated_observer_is_recovered_within_its_interval(self):
        done = self.run_program("--output", str(self.folder / "a"), "--observer", "weber:5", "--sigma", "0.15", "--criterion", "0.12", "--repetitions", "4")
        self.assertEqual((done.returncode, done.stderr), (0, ""))
        rows = rows_of(self.folder / "a/trials.csv")
        self.assertEqual(tuple(rows[0]), COLUMNS)
        self.assertEqual(len(rows), 36)
        judged = [0 if row["answer"] == "equal" else 1 if row["correct"] == "1" else -1 for row in rows]
        found = threshold_fit.fit([float(row["log_ratio"]) for row in rows], judged)
        for one, truth in ((found.criterion, 0.12), (found.sigma, 0.15)):
            self.assertTrue(one.low <= truth <= one.high, (one, truth))
            self.assertLess(one.high / one.low, 10.0)
        self.assertIn("criterion 0.12, noise 0.15", (self.folder / "a/summary.md").read_text())
        self.check_ticks(self.folder / "a", rows)
        book = (self.folder / "a/codebook.md").read_text()
        for name in COLUMNS:
            self.assertIn(name, book)

    def check_ticks(self, folder, rows):
        names = {path.name for path in (folder / "ticks").iterdir()}
        self.assertEqual(names, {"wall.csv", "sphere.csv"} | {f"{int(row['trial']):03}_{label}.csv" for row in rows for label in "AB"})
        for name in ("wall.csv", "sphere.csv"):
            table = rows_of(folder / "ticks" / name)
            self.assertGreater(max(abs(float(row["force_y_n"])) + abs(float(row["force_z_n"])) for row in table), 1.0)
        for label in "ab":
            table = rows_of(folder / f"ticks/001_{label.upper()}.csv")
            peak = max(sum(float(row[f"force_{axis}_n"]) ** 2 for axis in "xyz") ** 0.5 for row in table)
            self.assertAlmostEqual(peak, float(rows[0][f"peak_{label}_n"]), 6)

    def test_killed_in_the_middle_and_resumed_it_gives_the_same_trials_as_without(self):
        options = ["--observer", "weber:2", "--repetitions", "1", "--seed", "4"]
        self.assertEqual(self.run_program("--output", str(self.folder / "whole"), *options).returncode, 0)
        torn = self.folder / "torn"
        with subprocess.Popen([PROGRAM, "experiment", "--output", str(torn), *options], stdout=subprocess.PIPE, text=True, start_new_session=True) as program:
            for line in program.stdout:
                if line.startswith("trial 4 "):
                    break
            os.killpg(program.pid, signal.SIGKILL)  # the program and its hapticd, at whatever they do
        left = (torn / "trials.csv").read_bytes()
        self.assertGreaterEqual(left.count(b"\n"), 5)
        self.assertLess(left.count(b"\n"), 10)
        refused = self.run_program("--output", str(torn), *options)
        self.assertEqual(refused.returncode, 1)
        self.assertIn("--resume", refused.stderr)
        self.assertEqual(self.run_program("--output", str(torn), "--resume").returncode, 0)
        whole = self.folder / "whole"
        for name in ("trials.csv", "summary.md", "codebook.md", "experiment.json"):
            self.assertEqual((torn / name).read_bytes(), (whole / name).read_bytes(), name)
        self.assertTrue((torn / "trials.csv").read_bytes().startswith(left[:left.rfind(b"\n") + 1]))

    def test_what_makes_no_sense_is_refused_and_nothing_is_written(self):
        for options, text in ((["--observer", "fechner:1"], "weber:SEED"), (["--repetitions", "0"], "--repetitions"), (["--sigma", "0"], "--sigma"),
                              (["--scene", "wall"], "--scene is for"), (["--live", "--sigma", "1"], "--sigma is for"),
                              (["--resume"], "no experiment to resume"), (["--seed", "-1"], "--seed")):
            done = self.run_program("--output", str(self.folder / "none"), *options)
            self.assertEqual(done.returncode, 1)
            self.assertIn(text, done.stderr)
            self.assertFalse((self.folder / "none").exists())

    def test_a_page_is_told_what_is_refused_and_what_is_there_stays(self):
        (self.folder / "key").write_bytes(b"short")
        (self.folder / "key").chmod(0o600)
        kept = {"none": None, "key": None, "simulated": '{"seed": 1, "repetitions": 3, "participant": "", "observer": "weber:1", "sigma": 1, "criterion": 1, "scene": "x"}',
                "torn": '{"seed": 1, "rep'}
        for name, options, text in (("none", ["--address", "127.0.0.1:9"], "is hapticd running there"), ("key", ["--key", str(self.folder / "key")], "have 72 bytes"),
                                    ("simulated", [], "of a simulated observer: choose another name"), ("torn", [], "restore the file")):
            place = self.folder / "all" / name
            if kept[name] is not None:
                place.mkdir(parents=True)
                (place / "experiment.json").write_text(kept[name])
            done = self.run_program("--page", "--participant", name, "--output", str(place), *options, input="")
            screen = json.loads(done.stdout)
            self.assertEqual((done.returncode, screen["stage"], screen["participant"]), (1, "EXPERIMENT_STAGE_STOPPED", name))
            self.assertIn(text, screen["text"])
            self.assertNotIn("Traceback", done.stderr)
            self.assertEqual([path.read_text() for path in place.glob("*")], [kept[name]] if kept[name] else [])


class Terminal(Running):
    """A person, whose answers are typed ahead, at a simulated device."""

    def setUp(self):
        super().setUp()
        beside = pathlib.Path(PROGRAM).resolve().parent / "hapticd"
        daemon = player.Daemon("--device", "simulated", "--scene", "wall", program=str(beside) if beside.exists() else None)
        self.addCleanup(daemon.__exit__)
        self.address = daemon.__enter__().address

    def test_a_person_is_asked_and_after_an_interruption_asked_on(self):
        options = ["--address", self.address]
        first = self.run_program("--live", "--repetitions", "1", "--participant", "P1", *options, "--output", str(self.folder / "p1"),
                                 input="\n\n" + "\n\nfirst\n" + "\n\nwhat\nagain\n\n\nequal\n")
        self.assertEqual(first.returncode, 130, first.stderr)
        self.assertIn("2 of 9 trials are kept", first.stderr)
        for text in ("here is a wall", "here is a sphere", "string A", "string B", "Which one was stiffer?", "again, to feel both once more"):
            self.assertIn(text, first.stdout)
        for word in (" T ", "tension", "radius", "30 %", "raised"):
            self.assertNotIn(word, first.stdout)  # nothing tells which is which
        second = self.run_program("--resume", *options, "--output", str(self.folder / "p1"), input="\n\nsecond\n" * 7 + "90\n101\n85\n70\n0\n100\n")
        self.assertEqual(second.returncode, 0, second.stderr)
        rows = rows_of(self.folder / "p1/trials.csv")
        self.assertEqual([row["answer"] for row in rows], ["first", "equal"] + ["second"] * 7)
        self.assertTrue(all(row["answered_utc"] and float(row["answer_s"]) >= 0.0 for row in rows))
        self.assertEqual([row["score"] for row in rows_of(self.folder / "p1/questionnaire.csv")], ["90", "85", "70", "0", "100"])
        self.assertTrue((self.folder / "p1/ticks/009_B.csv").exists())

    def test_a_scene_that_cannot_be_played_on_is_refused_and_nothing_is_written(self):
        for scene, text in (("wall", "has no string"), ("nonsense", "no scene of this name")):
            done = self.run_program("--live", "--address", self.address, "--scene", scene, "--output", str(self.folder / "p2"), input="")
            self.assertEqual(done.returncode, 1)
            self.assertIn(text, done.stderr)
            self.assertNotIn("Traceback", done.stderr)
            self.assertFalse((self.folder / "p2").exists())


if __name__ == "__main__":
    unittest.main()
