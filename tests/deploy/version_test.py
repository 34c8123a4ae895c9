#!/usr/bin/python3
"""The version stands in the top CMakeLists.txt alone: programs say it, and what cannot take it from there, CHANGELOG.md and CITATION.cff, equals
it.

usage: version_test.py PROGRAM...
"""
import pathlib
import re
import subprocess
import sys
import unittest

ROOT = pathlib.Path(__file__).resolve().parents[2]
PROGRAMS = []


def read(path):
    return (ROOT / path).read_text(encoding="utf-8")


VERSION = re.search(r"^project\(hapticd VERSION (\d+\.\d+\.\d+) ", read("CMakeLists.txt"), re.MULTILINE).group(1)


class Version(unittest.TestCase):
    def test_every_program_says_it(self):
        for program in PROGRAMS:
            with self.subTest(program):
                done = subprocess.run([program, "--version"], capture_output=True, text=True, check=False, timeout=60)
                self.assertEqual(0, done.returncode, done.stderr)
                self.assertRegex(done.stdout, rf"^haptic[a-z-]* {re.escape(VERSION)}\n$")

    def test_the_changelog_begins_with_it(self):
        names = re.findall(r"^## \[([^]]+)\]", read("CHANGELOG.md"), re.MULTILINE)
        self.assertEqual(VERSION, [name for name in names if name != "Unreleased"][0])

    def test_the_citation_has_it_and_the_paper_as_the_method(self):
        citation = read("CITATION.cff")
        self.assertEqual([VERSION], re.findall(r'^version: "(.*)"$', citation, re.MULTILINE))
        references = citation.split("\nreferences:\n")[1]
        self.assertIn("doi: 10.1109/TOH.2016.2628369\n", references)

    def test_no_other_version_is_written_beside_it(self):
        """In the build files, where a version would be a second place."""
        for path in [*ROOT.glob("*/**/CMakeLists.txt"), *ROOT.glob("deploy/cmake/*.cmake")]:
            if "build" not in path.relative_to(ROOT).parts and "node_modules" not in path.parts:
                self.assertNotIn(f'"{VERSION}"', path.read_text(encoding="utf-8"), path)


if __name__ == "__main__":
    PROGRAMS = sys.argv[1:]
    unittest.main(argv=sys.argv[:1])
