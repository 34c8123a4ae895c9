"""The units of systemd, as they are installed: systemd finds nothing to complain of, judges them safe, and hapticd accepts its configuration.

usage: units_test.py CMAKE INSTALL-SCRIPT, the script that installs deploy/systemd
"""
import os
import pathlib
import re
import subprocess
import sys
import tempfile
import unittest

import daemon

SERVICES = ("hapticd.service", "haptic-web.service")
# Of systemd-analyze, in tenths: 100 is a service that nothing confines.
MOST_EXPOSED = 20


class Units(unittest.TestCase):
    def setUp(self):
        folder = tempfile.TemporaryDirectory()
        self.addCleanup(folder.cleanup)
        self.folder = pathlib.Path(folder.name)

    def install(self, prefix, destination=""):
        subprocess.run([CMAKE, f"-DCMAKE_INSTALL_PREFIX={prefix}", "-P", SCRIPT], env=dict(os.environ, DESTDIR=str(destination)), check=True,
                       stdout=subprocess.DEVNULL)

    def analyze(self, *arguments):
        done = subprocess.run(["systemd-analyze", *arguments], capture_output=True, text=True, check=False,
                              env=dict(os.environ, SYSTEMD_UNIT_PATH=f"{self.folder}/lib/systemd/system:"))
        return done.returncode, done.stdout + done.stderr

    def test_units_are_exposed_to_no_more_than_2(self):
        self.install("/usr", self.folder)
        for service in SERVICES:
            unit = self.folder / "usr/lib/systemd/system" / service
            code, text = self.analyze("security", "--offline=true", "--no-pager", f"--threshold={MOST_EXPOSED}", str(unit))
            self.assertEqual(code, 0, text)
            exposure = float(re.search(r"Overall exposure level for \S+: ([0-9.]+)", text)[1])
            self.assertLessEqual(exposure, MOST_EXPOSED / 10)
            # An unconfined unit is seen to be one: the judge judges.
            bare = self.folder / "bare.service"
            bare.write_text("[Service]\nExecStart=/bin/true\n")
            self.assertNotEqual(self.analyze("security", "--offline=true", "--no-pager", f"--threshold={MOST_EXPOSED}", str(bare))[0], 0)

    def test_systemd_finds_no_fault_in_any_unit(self):
        self.install(self.folder)
        (self.folder / "bin").mkdir()
        for program in ("hapticd", "haptic-web"):
            (self.folder / "bin" / program).symlink_to("/bin/true")
        for unit in (*SERVICES, "hapticd.socket"):
            code, text = self.analyze("verify", "--man=no", str(self.folder / "lib/systemd/system" / unit))
            self.assertEqual((code, text), (0, ""))

    def test_systemd_accepts_each_change_of_a_unit_that_the_page_shows(self):
        self.install(self.folder)
        (self.folder / "bin").mkdir()
        for program in ("hapticd", "haptic-web"):
            (self.folder / "bin" / program).symlink_to("/bin/true")
        page = (pathlib.Path(__file__).resolve().parents[2] / "deploy/docs/service.md").read_text(encoding="utf-8")
        shown = re.findall(r"`sudo systemctl edit (\S+)`\s+with\n\n```\n(.*?)```\n", page, flags=re.DOTALL)
        self.assertEqual(page.count("systemctl edit"), len(shown))
        for name, text in shown:
            with self.subTest(name, text=text):
                unit = self.folder / "lib/systemd/system" / (name if "." in name else f"{name}.service")
                changes = unit.with_name(f"{unit.name}.d")
                changes.mkdir()
                (changes / "override.conf").write_text(text, encoding="utf-8")
                self.assertEqual((0, ""), self.analyze("verify", "--man=no", str(unit)))
                (changes / "override.conf").unlink()
                changes.rmdir()

    def test_a_package_has_its_programs_in_usr_and_its_configuration_in_etc(self):
        self.install("/usr", self.folder)
        text = (self.folder / "usr/lib/systemd/system/hapticd.service").read_text(encoding="utf-8")
        self.assertIn("\nExecStart=/usr/bin/hapticd --config /etc/hapticd/hapticd.textproto ", text)
        self.assertTrue((self.folder / "etc/hapticd/hapticd.textproto").is_file())

    def test_systemd_is_told_by_both_services_when_they_serve(self):
        self.install(self.folder)
        for service in SERVICES:
            self.assertIn("\nType=notify\n", (self.folder / "lib/systemd/system" / service).read_text(encoding="utf-8"))

    def test_the_installed_configuration_is_accepted_also_with_every_example_in_it(self):
        self.install(self.folder)
        config = self.folder / "etc/hapticd/hapticd.textproto"
        code, text = daemon.run("--config", str(config), "--check")
        self.assertEqual(code, 0, text)
        keys = self.folder / "keys"
        subprocess.run([os.environ["HAPTICCTL"], "keygen", str(keys)], check=True, stdout=subprocess.DEVNULL)
        examples = re.sub("^# (?=[a-z_]+[: ]+[{\"A-Z])", "", config.read_text(encoding="utf-8"), flags=re.MULTILINE)
        self.assertNotEqual(examples, config.read_text(encoding="utf-8"))
        config.write_text(examples.replace("/etc/hapticd/keys", str(keys)), encoding="utf-8")
        code, text = daemon.run("--config", str(config), "--check")
        self.assertEqual(code, 0, text)


if __name__ == "__main__":
    CMAKE, SCRIPT = sys.argv[1:]
    unittest.main(argv=sys.argv[:1])
