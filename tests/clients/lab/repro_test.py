"""hapticd-lab makes every figure, and its verdicts are those expected: what deviates stands in expected_deviations.txt with a reason.
usage: repro_test.py HAPTICD_LAB [ID...]     default --all; writes into $HAPTICD_REPRO_OUTPUT, else a folder that is removed
Each figure goes through three of its motions, speeds and hands; with HAPTICD_TEST_SCALE=1 through all."""
import os
import pathlib
import subprocess
import sys
import tempfile
import unittest

import expectations

PROGRAM, IDS = sys.argv[1], sys.argv[2:]
del sys.argv[1:]
EXPECTED = expectations.read(pathlib.Path(__file__).resolve().parent / "expected_deviations.txt")
KEPT = os.environ.get("HAPTICD_REPRO_OUTPUT")


class Repro(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        cls.scratch = tempfile.TemporaryDirectory()
        cls.output = pathlib.Path(KEPT or cls.scratch.name)
        variations = [] if float(os.environ.get("HAPTICD_TEST_SCALE", "0.1")) >= 1.0 else ["--variations", "3"]
        command = [PROGRAM, "repro", *(IDS or ["--all"]), *variations, "--output", str(cls.output)]
        cls.done = subprocess.run(command, stdout=subprocess.PIPE, text=True, check=False)
        cls.claims = expectations.read_claims(cls.output / "claims.csv")

    @classmethod
    def tearDownClass(cls):
        cls.scratch.cleanup()

    def test_every_figure_is_made(self):
        listed = subprocess.run([PROGRAM, "repro", "--list"], stdout=subprocess.PIPE, text=True, check=True).stdout
        wanted = {line.split()[0] for line in listed.splitlines()}
        made = {row["figure"] for row in self.claims}
        self.assertLessEqual(made, wanted)
        if not IDS:
            self.assertEqual(made, wanted, self.done.stdout)
        self.assertNotIn(" failed ", self.done.stdout)

    def test_deviations_are_those_expected(self):
        found = expectations.differences(self.claims, EXPECTED, {row["figure"] for row in self.claims})
        self.assertEqual(found, [], "\n" + "\n".join(found))

    def test_the_exit_code_says_whether_something_deviates(self):
        deviates = any(row["verdict"] == "deviates" for row in self.claims)
        self.assertEqual(self.done.returncode, 3 if deviates else 0, self.done.stdout)

    def test_figures_have_their_files_and_the_reports_are_whole(self):
        for name in ("report.html", "report.md", "machine.txt"):
            self.assertGreater((self.output / name).stat().st_size, 100, name)
        page = (self.output / "report.html").read_text(encoding="utf-8")
        self.assertTrue(page.rstrip().endswith("</html>"))
        for figure in {row["figure"] for row in self.claims}:
            folder = self.output / figure
            self.assertTrue((folder / "claims.csv").is_file(), figure)
            self.assertIn(f'id="{figure}"', page)
            traces = [path for path in folder.glob("*.csv") if path.name != "claims.csv"]
            self.assertEqual(bool(traces), (folder / "plot.svg").is_file() and (folder / "plot.png").is_file(), figure)


if __name__ == "__main__":
    unittest.main()
