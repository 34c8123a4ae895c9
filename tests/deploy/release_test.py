#!/usr/bin/python3
"""deploy/release refuses what must not be released, and tags only what it has tested, packed and summed. It runs in repositories made for the
test, with stand-ins for deploy/test and deploy/package."""
import hashlib
import os
import pathlib
import shutil
import subprocess
import tarfile
import tempfile
import unittest

RELEASE = pathlib.Path(__file__).resolve().parents[2] / "deploy/release"
WHO = {"GIT_AUTHOR_NAME": "a", "GIT_AUTHOR_EMAIL": "a@example.org", "GIT_COMMITTER_NAME": "a", "GIT_COMMITTER_EMAIL": "a@example.org",
       "GIT_CONFIG_GLOBAL": "/dev/null", "GIT_CONFIG_SYSTEM": "/dev/null"}
FILES = {
    "CMakeLists.txt": "project(hapticd VERSION 1.2.3 LANGUAGES CXX)\n",
    "CHANGELOG.md": "# Changelog\n\n## [1.2.3] - 2026-01-02\n\n- A point.\n\n## [1.2.2] - 2026-01-01\n\n- An older one.\n",
    "CITATION.cff": 'version: "1.2.3"\n',
    ".gitignore": "/build/\n",
    "deploy/test": "#!/bin/bash\nmkdir -p build && echo tested >>build/done\n",
    "deploy/package": '#!/bin/bash\necho packed >>build/done\necho content >"$2/hapticd_1.2.3_amd64.deb"\n',
}


class Release(unittest.TestCase):
    def setUp(self):
        scratch = tempfile.TemporaryDirectory()
        self.addCleanup(scratch.cleanup)
        self.root = pathlib.Path(scratch.name) / "clone"
        (self.root / "deploy").mkdir(parents=True)
        for path, text in FILES.items():
            self.write(path, text)
        shutil.copy(RELEASE, self.root / "deploy")
        self.git("init", "--quiet")
        self.commit()

    def git(self, *words):
        return subprocess.run(["git", *words], cwd=self.root, env={**os.environ, **WHO}, capture_output=True, text=True, check=True).stdout

    def write(self, path, text):
        file = self.root / path
        file.write_text(text, encoding="utf-8")
        if text.startswith("#!"):
            file.chmod(0o755)

    def commit(self):
        self.git("add", "--all")
        self.git("commit", "--quiet", "--message", "a")

    def release(self, *options):
        return subprocess.run([self.root / "deploy/release", *options], cwd="/", env={**os.environ, **WHO}, capture_output=True, text=True,
                              check=False)

    def done(self):
        path = self.root / "build/done"
        return path.read_text(encoding="utf-8").split() if path.exists() else []

    def refused(self, why, after=(), options=()):
        """It ends with a word of `why`, without a tag, and has come as far as `after`."""
        run = self.release(*options)
        self.assertEqual(2, run.returncode, run.stdout + run.stderr)
        self.assertIn(why, run.stderr)
        self.assertEqual(list(after), self.done())
        self.assertNotIn("v1.2.3", self.git("tag"))

    def test_it_tags_what_it_has_tested_packed_and_summed(self):
        run = self.release()
        self.assertEqual(0, run.returncode, run.stderr)
        self.assertEqual(["tested", "packed"], self.done())
        output = self.root / "build/release-1.2.3"
        sums = dict(reversed(line.split("  ")) for line in (output / "SHA256SUMS").read_text(encoding="utf-8").splitlines())
        self.assertEqual({path.name for path in output.iterdir()} - {"SHA256SUMS"}, set(sums))
        for name, digest in sums.items():
            self.assertEqual(hashlib.sha256((output / name).read_bytes()).hexdigest(), digest)
        with tarfile.open(output / "hapticd-1.2.3.tar.gz") as archive:
            inside = {name.removeprefix("hapticd-1.2.3/") for name in archive.getnames()}
        self.assertLessEqual(set(self.git("ls-files").split()), inside)
        self.assertEqual("tag\n", self.git("cat-file", "-t", "v1.2.3"))
        self.assertEqual(self.git("rev-parse", "HEAD"), self.git("rev-parse", "v1.2.3^{commit}"))

    def test_a_dry_run_does_all_but_the_tag_and_gives_the_same_bytes(self):
        archives = []
        for folder in ("one", "two"):
            run = self.release("--dry-run", "--output", str(self.root / "build" / folder))
            self.assertEqual(0, run.returncode, run.stderr)
            archives.append((self.root / "build" / folder / "hapticd-1.2.3.tar.gz").read_bytes())
        self.assertEqual(archives[0], archives[1])
        self.assertEqual("", self.git("tag"))

    def test_changes_that_are_not_committed_are_refused(self):
        self.write("new", "text\n")
        self.refused("not committed")

    def test_a_version_that_has_a_tag_is_refused(self):
        self.git("tag", "v1.2.3")
        run = self.release()
        self.assertEqual((2, []), (run.returncode, self.done()))
        self.assertIn("the tag v1.2.3 exists", run.stderr)

    def test_a_changelog_without_a_dated_section_is_refused(self):
        for heading, why in (("## [1.2.3]", "no dated section"), ("## [1.2.4] - 2026-01-02", "no dated section"),
                             ("## [1.2.3] - 2026-01-02\n\n## [1.2.2]", "says nothing"),
                             ("## [Unreleased]\n\n- New.\n\n## [1.2.3] - 2026-01-02", "under Unreleased")):
            with self.subTest(heading):
                self.write("CHANGELOG.md", f"# Changelog\n\n{heading}\n\n- A point.\n")
                self.commit()
                self.refused(why)

    def test_a_long_section_is_read_to_its_end(self):
        # More than a pipe holds: who stops reading early ends the writer by a signal.
        points = "- A point.\n" * 20000
        self.write("CHANGELOG.md", f"# Changelog\n\n## [Unreleased]\n\n## [1.2.3] - 2026-01-02\n\n{points}")
        self.commit()
        run = self.release("--dry-run")
        self.assertEqual(0, run.returncode, run.stderr)
        shutil.rmtree(self.root / "build")
        self.write("CHANGELOG.md", f"# Changelog\n\n## [Unreleased]\n\n{points}\n## [1.2.3] - 2026-01-02\n\n- A point.\n")
        self.commit()
        self.refused("under Unreleased")

    def test_a_folder_that_would_be_a_change_of_the_tree_is_refused_at_once(self):
        for folder in (self.root / "out", self.root / "deploy/new/out"):
            self.refused("is in the clone and not ignored", options=("--output", str(folder)))

    def test_a_citation_of_another_version_is_refused(self):
        self.write("CITATION.cff", 'version: "1.2.2"\n')
        self.commit()
        self.refused("CITATION.cff")

    def test_a_folder_that_holds_something_is_refused(self):
        self.refused("not empty", options=("--output", str(self.root / "deploy")))

    def test_a_file_is_no_folder(self):
        self.refused("CITATION.cff is a file; name a folder with --output", options=("--output", str(self.root / "CITATION.cff")))

    def test_what_fails_its_tests_is_not_packed(self):
        self.write("deploy/test", "#!/bin/bash\nexit 1\n")
        self.commit()
        self.refused("tests failed")

    def test_what_cannot_be_packed_or_is_of_another_version_is_not_tagged(self):
        self.write("deploy/package", "#!/bin/bash\nexit 1\n")
        self.commit()
        self.refused("packages were not built", after=("tested",))
        shutil.rmtree(self.root / "build")
        self.write("deploy/package", '#!/bin/bash\necho content >"$2/hapticd_1.2.2_amd64.deb"\n')
        self.commit()
        self.refused("not of version 1.2.3", after=("tested",))

    def test_a_tree_that_changed_in_between_is_not_tagged(self):
        self.write("deploy/test", FILES["deploy/test"] + "echo more >>CITATION.cff\n")
        self.commit()
        self.refused("changed the tree", after=("tested", "packed"))


if __name__ == "__main__":
    unittest.main()
