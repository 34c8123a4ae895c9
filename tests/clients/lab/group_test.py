"""hapticd-lab group: seven participants put together, held against means, deviations and F worked out here; what is not finished is refused."""
import contextlib
import csv
import io
import json
import math
import pathlib
import statistics
import tempfile
import unittest

from hapticd_lab import main
from hapticd_lab.published import TABLE_2
from hapticd_lab.trials import TrialLog, plan

CORRECT = {"T": (1, 2, 3), "E": (1, 1, 1), "R": (0, 1, 2)}
"""Correct answers of three by increment of every even participant; an odd one has one less."""


class Group(unittest.TestCase):
    def setUp(self):
        scratch = tempfile.TemporaryDirectory()
        self.addCleanup(scratch.cleanup)
        self.folder = pathlib.Path(scratch.name)
        self.names = [self.member(number) for number in range(7)]

    def member(self, number, trials=27, scores=True):
        folder = self.folder / f"p{number}"
        folder.mkdir()
        (folder / "experiment.json").write_text(json.dumps({"seed": number, "repetitions": 3}))
        log = TrialLog(folder / "trials.csv", plan(number, 3))
        for trial in plan(number, 3)[:trials]:
            right = max(CORRECT[trial.parameter][round(trial.increment * 10) - 3] - number % 2, 0)
            answer = trial.stiffer if trial.repetition <= right else ("equal", "first", "second")[trial.trial % 2]
            if trial.repetition > right and answer == trial.stiffer:
                answer = "equal"
            log.add(trial, answer, (1.0, 1.0), trial.increment * {"T": 0.8, "E": 0.2, "R": 0.4}[trial.parameter])
        if scores:
            (folder / "questionnaire.csv").write_text("metric,score\n" + "".join(f"{metric},{10 * number + i}\n" for i, metric in enumerate(TABLE_2)))
        return str(folder)

    def run_group(self, *names):
        out, error = io.StringIO(), io.StringIO()
        with contextlib.redirect_stdout(out), contextlib.redirect_stderr(error):
            code = main.main(["group", *names, "--output", str(self.folder / "all")])
        return code, out.getvalue(), error.getvalue()

    def test_rates_scores_and_analyses_are_those_of_the_participants(self):
        code, out, said = self.run_group(*self.names)
        self.assertEqual((code, said), (0, ""))
        self.assertIn("# 7 participants, 189 trials", out)
        rates = [100.0 / 3.0 * (1 - number % 2) for number in range(7)]
        shown = f"{statistics.mean(rates):.1f} \N{PLUS-MINUS SIGN} {statistics.stdev(rates):.1f}"
        self.assertIn(f"| T | {shown} | ", out)
        # T at 30 and 50 %: both scatter alike, 66.67 points apart: F = 7 (66.67^2 / 2) / variance
        f = 7.0 * (200.0 / 3.0) ** 2 / 2.0 / statistics.variance(rates)
        self.assertIn(f"| T | 30 %, 50 % | F(1, 12) = {f:.3f}", out)
        self.assertIn("F(1, 12) = 1.739", out)  # recomputed from the printed table
        scores = [10.0 * number for number in range(7)]
        self.assertIn(f"| Thin string sensation | {statistics.mean(scores):.1f} \N{PLUS-MINUS SIGN} {statistics.stdev(scores):.1f} | 90.0", out)

    def test_tables_have_every_participant_and_the_codebook_their_columns(self):
        self.run_group(*self.names)
        book = (self.folder / "all/codebook.md").read_text()
        for name, count in (("rates.csv", 7 * 9), ("scores.csv", 7 * 5)):
            with open(self.folder / "all" / name, newline="", encoding="utf-8") as file:
                rows = list(csv.DictReader(file))
            self.assertEqual(len(rows), count)
            for column in rows[0]:
                self.assertIn(column, book)
        with open(self.folder / "all/rates.csv", newline="", encoding="utf-8") as file:
            one = next(row for row in csv.DictReader(file) if (row["parameter"], row["increment"]) == ("T", "0.5"))
        self.assertTrue(math.isclose(float(one["rate"]), 100.0) and one["trials"] == "3")

    def test_participants_without_a_questionnaire_do_not_count_in_it(self):
        names = [self.member(8, scores=False), self.names[0]]
        self.assertIn("Questionnaire of 1 of them", self.run_group(*names)[1])

    def refused(self, text, *names):
        code, _, said = self.run_group(*names)
        self.assertEqual(code, 1)
        self.assertIn(text, said)
        self.assertFalse((self.folder / "all").exists())

    def test_what_is_not_finished_or_no_experiment_is_refused_with_what_helps(self):
        self.refused("9 has 5 of 27 trials: go on with", self.names[0], self.member(9, trials=5))
        self.refused("no experiment.json", self.names[0], str(self.folder))
        self.refused("each named once", self.names[0])
        self.refused("each named once", self.names[0], self.names[0])
        (self.folder / "p1/questionnaire.csv").write_text("metric,score\nThin string sensation,many\n")
        self.refused("questionnaire.csv:2", *self.names)


if __name__ == "__main__":
    unittest.main()
