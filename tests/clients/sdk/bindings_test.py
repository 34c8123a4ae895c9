"""The examples in C# and Rust, compiled by Debian's compilers against the installed library: they give the same bits as the Python client,
and say what is wrong when there is no daemon."""
import os
import pathlib
import subprocess
import sys
import tempfile
import unittest

from installed_library import EXAMPLES, check_press, checked, install


class Bindings(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        cls.scratch = tempfile.TemporaryDirectory()
        cls.folder = pathlib.Path(cls.scratch.name)
        cls.libraries = install(cls.folder / "usr")
        cls.environment = dict(os.environ, LD_LIBRARY_PATH=str(cls.libraries))

    @classmethod
    def tearDownClass(cls):
        cls.scratch.cleanup()

    def check(self, *program):
        with subprocess.Popen([*program, "127.0.0.1:1"], env=self.environment, stderr=subprocess.PIPE, text=True) as alone:
            check_press(self, *program, env=self.environment)
            said = alone.communicate(timeout=60)[1]
        self.assertEqual(alone.returncode, 1)
        self.assertIn("no daemon answers at 127.0.0.1:1", said)

    def test_c_sharp(self):
        program = self.folder / "Press.exe"
        checked("mcs", "-warnaserror", f"-out:{program}", *sorted((EXAMPLES / "csharp").glob("*.cs")))
        self.check("mono", program)

    def test_rust(self):
        program = self.folder / "press"
        checked("rustc", "--edition", "2021", "-D", "warnings", "-L", f"native={self.libraries}", "-o", program, EXAMPLES / "rust" / "press.rs")
        self.check(program)


if __name__ == "__main__":
    sys.exit(unittest.main(verbosity=2))
