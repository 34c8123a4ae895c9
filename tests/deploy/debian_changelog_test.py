#!/usr/bin/python3
"""What Debian reads of CHANGELOG.md has every point under the heading it has there. Truth: a changelog written by hand, and what
dpkg-parsechangelog makes of it."""
import os
import pathlib
import shutil
import subprocess
import sys
import tempfile
import unittest

ROOT = pathlib.Path(__file__).resolve().parents[2]
MADE = ROOT / "deploy/cmake/debian_changelog.py"
WRITTEN = """# Changelog

## [1.2.0] - 2026-01-02

### Added

- A point of
  two lines.
- Another one.

### Fixed

- A mended one.

## [1.1.0] - 2026-01-01

- One without a heading.
"""
EXPECTED = """hapticd (1.2.0) unstable; urgency=medium

  [ Added ]
  * A point of two lines.
  * Another one.

  [ Fixed ]
  * A mended one.

 -- A <a@example.org>  Fri, 02 Jan 2026 12:00:00 -0000

hapticd (1.1.0) unstable; urgency=medium

  * One without a heading.

 -- A <a@example.org>  Thu, 01 Jan 2026 12:00:00 -0000

"""


def made(path):
    return subprocess.run([sys.executable, "-B", MADE, path, "1.2.0", "A <a@example.org>"], capture_output=True, text=True, check=True,
                          env={**os.environ, "LC_ALL": "C.UTF-8"}).stdout


class DebianChangelog(unittest.TestCase):
    def test_points_stand_under_their_headings(self):
        with tempfile.TemporaryDirectory() as folder:
            path = pathlib.Path(folder, "CHANGELOG.md")
            path.write_text(WRITTEN, encoding="utf-8")
            self.assertEqual(EXPECTED, made(path))

    @unittest.skipUnless(shutil.which("dpkg-parsechangelog"), "dpkg-dev is not installed")
    def test_debian_reads_ours_without_a_complaint(self):
        with tempfile.TemporaryDirectory() as folder:
            path = pathlib.Path(folder, "changelog")
            path.write_text(made(ROOT / "CHANGELOG.md"), encoding="utf-8")
            done = subprocess.run(["dpkg-parsechangelog", "-l", path, "--all"], capture_output=True, text=True, check=False)
            self.assertEqual((0, ""), (done.returncode, done.stderr))
            self.assertIn("[ Fixed ]", done.stdout)


if __name__ == "__main__":
    unittest.main()
