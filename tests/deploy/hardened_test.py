"""Programs that are shipped are hardened, and the script that looks whether they are sees it.
usage: hardened_test.py COMPILER FLAGS LINK_FLAGS      the flags of hardened builds, separated by spaces"""
import pathlib
import subprocess
import sys
import tempfile
import unittest

ROOT = pathlib.Path(__file__).resolve().parents[2]
COMPILER, FLAGS, LINK_FLAGS = sys.argv[1], sys.argv[2].split(), sys.argv[3].split()
# What a compiler does by itself is undone, so that only the flags can have brought it.
PLAIN = ["-O2", "-fno-stack-protector", "-fcf-protection=none" if "-fcf-protection" in FLAGS else "-mbranch-protection=none", "-U_FORTIFY_SOURCE"]
PLAIN_LINK = ["-Wl,-z,norelro", "-Wl,-z,lazy"]
LACKS = {
    "-fstack-protector-strong": "stack protectors",
    "-D_FORTIFY_SOURCE=3": "checked library calls",
    "-fcf-protection": "landing pads",
    "-mbranch-protection=standard": "landing pads",
    "-Wl,-z,relro": "read-only relocations",
    "-Wl,-z,now": "addresses bound at the start",
}
SOURCE = """
#include <cstdio>
#include <cstring>
FUNCTIONS
int (*volatile const all[])(int) = {NAMES};
int main(int count, char** words) {
  char text[32];
  std::strcpy(text, words[count - 1]);
  std::puts(text);
  return all[count](count);
}
""".replace("FUNCTIONS", "\n".join(f"int f{k}(int x) {{ return x % {k + 3} * x / {k + 7}; }}" for k in range(500))) \
    .replace("NAMES", ", ".join(f"f{k}" for k in range(500)))


class Hardened(unittest.TestCase):
    def setUp(self):
        folder = tempfile.TemporaryDirectory()
        self.addCleanup(folder.cleanup)
        self.folder = pathlib.Path(folder.name)

    def judge(self, flags, link_flags):
        """What the script says of a program that was built so."""
        built = self.folder / "built"
        built.mkdir(exist_ok=True)
        (self.folder / "program.cpp").write_text(SOURCE)
        subprocess.run([COMPILER, *PLAIN, *flags, self.folder / "program.cpp", "-o", built / "program", *PLAIN_LINK, *link_flags], check=True)
        return subprocess.run([sys.executable, "-B", ROOT / "tests/system/hardened.py", built], capture_output=True, text=True, check=False)

    def test_a_program_with_all_flags_lacks_nothing(self):
        said = self.judge(FLAGS, LINK_FLAGS)
        self.assertEqual(said.returncode, 0, said.stdout)

    def test_what_a_flag_less_takes_away_is_named(self):
        for flag in FLAGS + LINK_FLAGS:
            if flag not in LACKS:
                continue
            with self.subTest(flag=flag):
                said = self.judge([each for each in FLAGS if each != flag], [each for each in LINK_FLAGS if each != flag])
                self.assertEqual(said.returncode, 1, said.stdout)
                self.assertIn(LACKS[flag], said.stdout)

    def test_a_folder_without_programs_is_not_taken_for_hardened(self):
        said = subprocess.run([sys.executable, "-B", ROOT / "tests/system/hardened.py", self.folder], capture_output=True, text=True, check=False)
        self.assertEqual(said.returncode, 1, said.stdout)

    def test_releases_are_built_so(self):
        said = subprocess.run(["cmake", "--preset", "release", "-N"], cwd=ROOT, capture_output=True, text=True, check=True).stdout
        self.assertIn('HAPTICD_HARDENED="ON"', said)
        self.assertIn("--preset release", (ROOT / "deploy/package").read_text())


if __name__ == "__main__":
    unittest.main(argv=sys.argv[:1])
