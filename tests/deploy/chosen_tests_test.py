"""deploy/test runs the tests of the fast labels and says what it leaves out; --all and a label choose others. Shown on a copy of it with
stand-ins for what builds and tests."""
import os
import pathlib
import shutil
import subprocess
import tempfile
import unittest

ROOT = pathlib.Path(__file__).resolve().parents[2]
COPIED = ("deploy/test", "deploy/cmake/read_report.py", "clients/play/nearest_name", "CMakePresets.json")
REPORT = '<testsuite><testcase name="one" status="run"/></testsuite>'
STAND_INS = {
    "deploy/install_packages": "#!/bin/bash\n",
    "programs/cmake": "#!/bin/bash\nmkdir -p build/dev\n",
    "programs/ninja": "#!/bin/bash\n",
    "programs/ctest": f"#!/bin/bash\nprintf '%s\\n' \"$@\" >>asked\necho '{REPORT}' >build/dev/tests.xml\n",
}


class Chosen(unittest.TestCase):
    def run_it(self, *options):
        """(labels that ctest was asked for, or None; what deploy/test printed)"""
        with tempfile.TemporaryDirectory() as folder:
            root = pathlib.Path(folder)
            for name in COPIED:
                (root / name).parent.mkdir(parents=True, exist_ok=True)
                shutil.copy(ROOT / name, root / name)
            for name, text in STAND_INS.items():
                (root / name).parent.mkdir(parents=True, exist_ok=True)
                (root / name).write_text(text, encoding="utf-8")
                (root / name).chmod(0o755)
            environment = dict(os.environ, PATH=f"{root / 'programs'}:{os.environ['PATH']}")
            done = subprocess.run([root / "deploy/test", *options], env=environment, capture_output=True, text=True, check=True, timeout=60)
            self.assertTrue(done.stdout.endswith("\n1 passed, 0 failed\n"), done.stdout)
            asked = (root / "asked").read_text(encoding="utf-8").split("\n")
            labels = asked[asked.index("--label-regex") + 1] if "--label-regex" in asked else None
            return labels, done.stdout

    def test_by_default_the_fast_ones(self):
        labels, said = self.run_it()
        self.assertEqual(labels, "^(unit|protocol|fuzz|architecture)$")
        self.assertIn("left out: the tests of the other labels: deploy/test --all\n", said)

    def test_all(self):
        labels, said = self.run_it("--all")
        self.assertIsNone(labels)
        self.assertNotIn("left out", said)

    def test_of_one_label(self):
        labels, said = self.run_it("system")
        self.assertEqual(labels, "^(system)$")
        self.assertNotIn("left out", said)


if __name__ == "__main__":
    unittest.main()
