"""hapticd-lab as a program, where it was built: finds its packages by itself, lists, refuses. usage: program_test.py HAPTICD_LAB"""
import os
import pathlib
import shutil
import subprocess
import sys
import tempfile
import unittest

PROGRAM = sys.argv.pop(1) if len(sys.argv) > 1 else "hapticd-lab"


def run(*arguments):
    """Exit code, stdout, stderr, without help from the environment."""
    environment = {name: value for name, value in os.environ.items() if name != "PYTHONPATH"}
    done = subprocess.run([PROGRAM, *arguments], capture_output=True, text=True, timeout=120, env=environment, check=False)
    return done.returncode, done.stdout, done.stderr


class Program(unittest.TestCase):
    def test_lists_its_figures_without_being_told_where_to_write(self):
        code, out, _ = run("repro", "--list")
        self.assertEqual(code, 0)
        ids = [line.split()[0] for line in out.splitlines()]
        self.assertLessEqual({"F2", "F3", "F4", "F5", "S2.2"}, set(ids))

    def test_a_reader_that_has_seen_enough_is_no_error(self):
        with subprocess.Popen([PROGRAM, "repro", "--list"], stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True) as listing:
            listing.stdout.close()
            said = listing.stderr.read()
        self.assertEqual((listing.returncode, said), (0, ""))

    def test_its_version_is_that_of_hapticd_and_without_it_this_is_said(self):
        with tempfile.TemporaryDirectory() as folder:
            place = pathlib.Path(folder)
            (place / "clients").symlink_to(pathlib.Path(PROGRAM).resolve().parent.parent / "clients")
            (place / "bin").mkdir()
            program, hapticd = place / "bin" / "hapticd-lab", place / "bin" / "hapticd"
            shutil.copy(PROGRAM, program)

            def version(**environment):
                done = subprocess.run([program, "--version"], capture_output=True, text=True, timeout=120, check=False,
                                      env={"PATH": "/nonexistent", **environment})
                return done.returncode, done.stdout, done.stderr
            self.assertEqual(version(), (1, "", "hapticd-lab --version: hapticd is not installed: put it on the PATH, or name it in HAPTICD\n"))
            self.assertEqual(version(HAPTICD=f"{place}/none"), (1, "", f"hapticd-lab --version: {place}/none: No such file or directory\n"))
            hapticd.write_text("#!/bin/sh\necho hapticd 12.3 $*\n", encoding="utf-8")
            hapticd.chmod(0o755)
            self.assertEqual(version(), (0, "hapticd-lab 12.3 --version\n", ""))

    def test_hapticctl_knows_the_experiment(self):
        hapticctl = pathlib.Path(PROGRAM).parent / "hapticctl"
        told = subprocess.run([hapticctl, "experiment", "--help"], capture_output=True, text=True, timeout=60, check=False)
        self.assertEqual((told.returncode, told.stdout), run("experiment", "--help")[:2])

    def test_help_says_what_exit_codes_mean(self):
        code, out, _ = run("repro", "--help")
        self.assertEqual(code, 0)
        for text in ("--all", "--output", "--jobs", "--video", "--list", "3 some claim deviates"):
            self.assertIn(text, out)

    def refused(self, *arguments):
        with tempfile.TemporaryDirectory() as folder:
            output = pathlib.Path(folder) / "out"
            code, _, said = run("repro", *arguments, "--output", str(output))
            self.assertFalse(output.exists(), arguments)
        self.assertNotIn("Traceback", said)
        return code, said

    def test_refuses_an_unknown_figure_with_the_list_and_writes_nothing(self):
        for arguments in (["F3", "F99"], ["--all", "F99"], ["F3", "--video", "F99"]):
            code, said = self.refused(*arguments)
            self.assertEqual(code, 1)
            self.assertRegex(said, "there is no figure F99; there are .*F2, F3, ")

    def test_the_scene_that_was_meant_is_named_before_a_study_is_made(self):
        with tempfile.TemporaryDirectory() as folder:
            code, out, said = run("tradeoff", "--quick", "--scene", "guqn", "--output", f"{folder}/study")
            self.assertEqual((code, out, os.listdir(folder)), (1, "", []))
        self.assertRegex(said, r"\Ahapticd-lab tradeoff: --scene: guqn: .*Did you mean guqin\?")

    def test_a_file_that_is_not_there_is_named_in_plain_words(self):
        with tempfile.TemporaryDirectory() as folder:
            code, _, said = run("fit", f"{folder}/none.csv", "--scene", "guqin", "--output", f"{folder}/out")
        self.assertEqual((code, said), (1, f"hapticd-lab fit: {folder}/none.csv: No such file or directory\n"))

    def test_refuses_what_makes_no_sense(self):
        for arguments, why in (([], "--all"), (["F3", "--jobs", "0"], "--jobs")):
            code, said = self.refused(*arguments)
            self.assertEqual(code, 1)
            self.assertIn(why, said)
        self.assertEqual(run("repro", "F3")[0], 1)
        self.assertEqual(run()[0], 2)
        self.assertEqual(run("nonsense")[0], 2)


if __name__ == "__main__":
    unittest.main()
