#!/usr/bin/python3
"""A test that requires a group of packages runs where it is installed, and else is skipped with the command that installs it; deploy/test tells
of it, and with --full counts it as failed."""
import os
import pathlib
import re
import subprocess
import sys
import tempfile
import unittest

from source_tree import ROOT

sys.path.insert(0, f"{ROOT}/deploy/cmake")
import read_report  # noqa: E402

WITH_GROUPS = f"{ROOT}/deploy/cmake/with_groups"


class WithGroupsTest(unittest.TestCase):
    def run_with(self, groups, installed):
        """With a dpkg-query that says of all packages that they are installed, or not."""
        with tempfile.TemporaryDirectory() as folder:
            query = pathlib.Path(folder, "dpkg-query")
            query.write_text(f"#!/bin/sh\nprintf '{'install ok installed' if installed else 'unknown ok not-installed'}'\n", encoding="utf-8")
            query.chmod(0o755)
            return subprocess.run([WITH_GROUPS, groups, "sh", "-c", "echo ran; exit 3"], capture_output=True, text=True, check=False,
                                  env={**os.environ, "PATH": f"{folder}:{os.environ['PATH']}"})

    def test_where_all_groups_are_installed_the_test_runs_and_ends_as_it_ends(self):
        done = self.run_with("page,lab", True)
        self.assertEqual((3, "ran\n"), (done.returncode, done.stdout), done.stderr)

    def test_where_a_group_is_missing_the_test_is_skipped_and_says_how_to_get_it(self):
        done = self.run_with("lab", False)
        self.assertEqual((77, "SKIPPED: needs the group lab: deploy/install_packages lab\n"), (done.returncode, done.stdout), done.stderr)

    def test_a_group_that_nobody_knows_is_a_failure(self):
        done = self.run_with("pages", True)
        self.assertNotIn(done.returncode, (0, 77))
        self.assertNotIn("ran", done.stdout)


class GroupsTest(unittest.TestCase):
    def test_full_installs_each_group_that_a_test_requires(self):
        required = {group for path in pathlib.Path(ROOT, "tests").rglob("CMakeLists.txt")
                    for groups in re.findall(r"^[^#\n]*(?:REQUIRES|\brequires_\w+) ([a-z]+(?: [a-z]+)*)", path.read_text(encoding="utf-8"), re.MULTILINE)
                    for group in groups.split()}
        self.assertLessEqual({"page", "lab", "audio", "vm"}, required)
        installed = re.search(r"^OPTIONAL_GROUPS=\((.*)\)$", pathlib.Path(ROOT, "deploy/test").read_text(encoding="utf-8"), re.MULTILINE)
        self.assertLessEqual(required, set(installed[1].split()))


class ReportTest(unittest.TestCase):
    CASES = [("a", "run", "text"), ("b", "skipped", "SKIPPED: needs the group page: get it\n"), ("c", "skipped", "SKIPPED: needs the group page: get it\n"),
             ("d", "skipped", "SKIPPED: this processor has no AVX2\n"), ("e", "run", "SKIPPED: case: only root can\n")]

    def test_what_lacks_a_group_shares_a_line_and_the_rest_has_its_own(self):
        self.assertEqual((2, 0, ["skipped: d: this processor has no AVX2", "skipped in part: e: case: only root can",
                                 "skipped: 2 tests that need the group page: get it"]), read_report.read(self.CASES, False))

    def test_where_all_groups_were_to_be_installed_what_lacks_one_has_failed(self):
        passed, failed, notes = read_report.read(self.CASES, True)
        self.assertEqual((2, 2), (passed, failed))
        self.assertIn("failed: b", notes)
        self.assertIn("skipped: d: this processor has no AVX2", notes)

    def test_what_fails_or_is_skipped_without_a_reason_has_failed(self):
        for case in (("a", "fail", "SKIPPED: needs the group page: get it\n"), ("a", "skipped", ""), ("a", "notrun", "")):
            self.assertEqual(1, read_report.read([case], False)[1], case)


if __name__ == "__main__":
    unittest.main()
