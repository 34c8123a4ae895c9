"""deploy/install_packages asks for no more rights than it needs, and deploy/progress says how far something is."""
import os
import pathlib
import shutil
import subprocess
import tempfile
import unittest

DEPLOY = pathlib.Path(__file__).resolve().parents[2] / "deploy"
NOBODY = 65534


class InstallPackages(unittest.TestCase):
    def setUp(self):
        scratch = tempfile.TemporaryDirectory()
        self.addCleanup(scratch.cleanup)
        self.folder = pathlib.Path(scratch.name)
        self.folder.chmod(0o777)
        for name in ("install_packages", "packages", "progress"):  # nobody may not be able to read the tree
            shutil.copy(DEPLOY / name, self.folder)

    def fake(self, name, script):
        """A command of that name in front of the machine's own; what it is called with is noted."""
        path = self.folder / name
        path.write_text(f'#!/bin/bash\necho "{name} $*" >> "{self.folder}/called"\n{script}\n', encoding="utf-8")
        path.chmod(0o755)

    def as_nobody(self):
        """How a process is started that has no rights, and finds the fake commands first."""
        user = {"user": NOBODY, "group": NOBODY, "extra_groups": []} if os.geteuid() == 0 else {}
        return {"text": True, "cwd": "/", "env": {"PATH": f"{self.folder}:/usr/bin:/bin"}, **user}

    def run_as_nobody(self, *groups):
        return subprocess.run([self.folder / "install_packages", *groups], capture_output=True, check=False, **self.as_nobody())

    def called(self):
        path = self.folder / "called"
        return path.read_text(encoding="utf-8") if path.exists() else ""

    def test_who_may_not_install_is_told_what_an_administrator_has_to(self):
        self.fake("dpkg-query", "exit 1")
        self.fake("apt-get", "exit 99")
        self.fake("sudo", "exit 1")
        done = self.run_as_nobody("peers")
        self.assertEqual(9, done.returncode, done.stderr)
        self.assertIn("\n  apt-get update && apt-get install --no-install-recommends libbullet-dev libfcl-dev libmujoco-dev\n", done.stderr)
        self.assertNotIn("apt-get", self.called())

    def test_where_nothing_is_missing_nobody_is_asked(self):
        self.fake("dpkg-query", "echo 'install ok installed'")
        self.fake("sudo", "exit 1")
        done = self.run_as_nobody("build", "test")
        self.assertEqual((0, "", ""), (done.returncode, done.stdout, done.stderr))
        self.assertNotIn("sudo", self.called())

    def test_what_is_missing_is_installed_as_root(self):
        self.fake("dpkg-query", "exit 1")
        self.fake("apt-get", "[[ $* == *Status-Fd=1* ]] || exit 0\necho 'dlstatus:1:50:Retrieving'\necho 'pmstatus:gcovr:100:Installed'")
        self.fake("sudo", '[[ $1 != -* ]] || shift; exec "$@"')
        done = self.run_as_nobody("coverage")
        self.assertEqual(0, done.returncode, done.stderr)
        self.assertIn("gcovr", done.stdout.splitlines()[0])
        self.assertEqual("packages: 100 %", done.stdout.splitlines()[-1])
        self.assertRegex(self.called(), r"sudo env DEBIAN_FRONTEND=noninteractive apt-get install .*gcovr")

    def test_how_far_it_is_is_said_while_it_runs(self):
        self.fake("dpkg-query", "exit 1")
        self.fake("apt-get", '[[ $* == *Status-Fd=1* ]] || exit 0\necho dlstatus:1:50:x\nfor ((i = 0; i < 200; ++i)); do\n'
                             f'  [[ ! -e "{self.folder}/seen" ]] || exit 0\n  sleep 0.05\ndone\nexit 1')
        self.fake("sudo", '[[ $1 != -* ]] || shift; exec "$@"')
        with subprocess.Popen([self.folder / "install_packages", "coverage"], stdout=subprocess.PIPE, **self.as_nobody()) as running:
            for line in running.stdout:
                if line.startswith("packages: 25 %"):
                    (self.folder / "seen").touch()
            self.assertEqual(0, running.wait())

    def test_building_all_takes_what_playing_needs(self):
        self.fake("dpkg-query", "exit 1")
        missing = self.run_as_nobody("--missing", "build").stdout.split()
        self.assertIn("libassimp-dev", missing)
        self.assertIn("libeigen3-dev", missing)


class Progress(unittest.TestCase):
    def test_a_line_is_said_every_ten_percent_and_other_lines_are_passed_on(self):
        lines = [f"@{done} 200 x" for done in range(201)]
        lines.insert(100, "error: a b")
        done = subprocess.run([DEPLOY / "progress", "building"], input="\n".join(lines) + "\n", capture_output=True, text=True, check=True)
        said = done.stdout.splitlines()
        self.assertEqual([f"building: {10 * k} %" for k in range(11)], [line.split(",")[0] for line in said if line != "error: a b"])
        self.assertEqual(1, said.count("error: a b"))

    def test_an_error_of_ninja_is_passed_on_and_that_there_is_nothing_to_do_is_not(self):
        lines = "@0 2 Re-checking globbed directories...\nninja: no work to do.\nninja: error: loading 'build.ninja'\nninja: build stopped: subcommand failed.\n"
        done = subprocess.run([DEPLOY / "progress", "building"], input=lines, capture_output=True, text=True, check=True)
        self.assertEqual(lines.splitlines()[2:], done.stdout.splitlines())


if __name__ == "__main__":
    unittest.main()
