"""Figures in processes of their own: what fails, dies or is interrupted costs no other, and what ran is ended."""
import contextlib
import io
import os
import pathlib
import signal
import tempfile
import time
import unittest

from hapticd_lab import repro, worker
from hapticd_lab.figure import DEVIATES, REPRODUCED, Spec, at_most
from hapticd_lab.outcome import FAILED
from hapticd_lab.progress import Progress
from lab_support import make_outcome


def good(_, figure):
    figure.claims.append(at_most("small", 1.0, 2.0, "N"))


def bad(_, figure):
    figure.claims.append(at_most("small", 3.0, 2.0, "N"))


def fails(_, figure):
    raise ValueError("no session")


def dies(_, figure):
    os.kill(os.getpid(), signal.SIGKILL)


@contextlib.contextmanager
def lab_with_a_trace(spec, folder):
    """Leaves a file that says that it was ended in order."""
    try:
        yield folder
    finally:
        (folder / "ended").write_text("")


def interrupts(folder, figure):
    """Lets the parent be told to stop, as by SIGTERM, and goes on for long."""
    time.sleep(0.5)
    os.kill(os.getppid(), signal.SIGTERM)
    time.sleep(60.0)


def make_all(jobs=2, **makers):
    specs = [Spec(name, name, "", maker, 1.0) for name, maker in makers.items()]
    with tempfile.TemporaryDirectory() as folder:
        output = pathlib.Path(folder)
        made = worker.make_all(specs, output, jobs, lab_with_a_trace, Progress({spec.id: 1.0 for spec in specs}, jobs, io.StringIO()))
        return made, {str(path.relative_to(output)) for path in output.rglob("*") if path.is_file()}


class Making(unittest.TestCase):
    def test_outcomes_come_in_the_order_asked_for(self):
        made, files = make_all(F2=good, F1=bad, F3=good)
        self.assertEqual([(each.id, each.verdict) for each in made.outcomes], [("F2", REPRODUCED), ("F1", DEVIATES), ("F3", REPRODUCED)])
        self.assertFalse(made.interrupted)
        self.assertLessEqual({"F1/claims.csv", "F2/claims.csv", "F3/claims.csv"}, files)

    def test_one_that_fails_is_told_with_the_reason_and_the_others_are_made(self):
        made, files = make_all(F1=fails, F2=good)
        self.assertEqual([each.verdict for each in made.outcomes], [FAILED, REPRODUCED])
        self.assertEqual(made.outcomes[0].error, "ValueError: no session")
        self.assertIn("F1/error.txt", files)

    def test_what_an_earlier_run_said_is_gone_when_it_fails_now_or_did_then(self):
        with tempfile.TemporaryDirectory() as folder:
            for maker, there, gone in ((good, "claims.csv", "error.txt"), (fails, "error.txt", "claims.csv"), (good, "claims.csv", "error.txt")):
                worker.make(Spec("F1", "", "", maker), pathlib.Path(folder), lab_with_a_trace)
                self.assertTrue((pathlib.Path(folder) / there).is_file())
                self.assertFalse((pathlib.Path(folder) / gone).exists())

    def test_one_whose_process_dies_is_told_and_the_others_are_made(self):
        made, _ = make_all(F1=dies, F2=good)
        self.assertEqual([each.verdict for each in made.outcomes], [FAILED, REPRODUCED])
        self.assertIn("-9", made.outcomes[0].error)

    def test_interrupted_it_keeps_what_is_finished_and_ends_what_runs_in_order(self):
        begin = time.monotonic()
        made, files = make_all(jobs=1, F1=interrupts, F2=good)
        self.assertTrue(made.interrupted)
        self.assertLess(time.monotonic() - begin, 50.0)
        self.assertEqual([each.id for each in made.outcomes], ["F2"])
        self.assertIn("F1/ended", files)
        self.assertNotIn("F1/claims.csv", files)


class ExitCode(unittest.TestCase):
    def test_says_what_happened(self):
        fine, off, failed = make_outcome("F1", verdict=REPRODUCED), make_outcome("F2", verdict=DEVIATES), make_outcome("F3")
        for outcomes, interrupted, code in (
            ([fine], False, 0),
            ([fine, off], False, 3),
            ([off, failed], False, 1),
            ([fine], True, 130),
            ([], False, 0),
        ):
            self.assertEqual(repro.exit_code(outcomes, interrupted), code)


if __name__ == "__main__":
    unittest.main()
