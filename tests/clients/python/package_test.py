"""The package as pip has it, without a network: from the project, from a source archive that lies anywhere, and refused with a remedy where
something is missing. The version is the project's, which the top CMakeLists.txt says. A small script is typed, by mypy --strict."""
import os
import pathlib
import re
import shutil
import subprocess
import sys
import tarfile
import tempfile
import unittest

import support

ROOT = pathlib.Path(support.ROOT).resolve()
PACKAGE = ROOT / "clients" / "python"
VERSION = re.search(r"^project\(hapticd VERSION (\S+)", (ROOT / "CMakeLists.txt").read_text(encoding="utf-8"), re.MULTILINE)[1]
PIP = [sys.executable, "-m", "pip", "--disable-pip-version-check"]
OFFLINE = ["--no-build-isolation", "--no-index"]
SCRIPT = """
from importlib import metadata
import hapticd
from hapticd.v1 import scene_pb2
print(hapticd.__version__, metadata.version("hapticd"), scene_pb2.Scene(name="wall").name)
print(hapticd.__file__)
"""
TYPED = '''
import asyncio
import hapticd


def force_n(address: str) -> list[float]:
    with hapticd.Session(address) as session:
        session.acquire("typed")
        session.subscribe(divisor=1, sections=["TOOLS"])
        result: hapticd.RunResult = session.run(poses=[(0.0, 0.01, 0.0)] * 10)
        for event in result.events:
            print(event.kind, hapticd.__version__)
        table = result.table()
        table.to_csv("table.csv")
        print(table.units["t_s"], session.scene.rate_hz)
        return [row[1] for row in table["wrench_h_w"]]


async def ticks(address: str) -> list[int]:
    async with hapticd.AsyncSession(address) as session:
        await session.set({"strings[0].tension_n": 41.5})
        return [state.tick async for state in session.states(10, timeout=1.0)]

asyncio.run(ticks("127.0.0.1"))
'''
MISTAKES = {
    'hapticd.Session("127.0.0.1").set_parameter("a", 1)': "set_parameter",
    'hapticd.Session(47800)': "incompatible type",
    'hapticd.Session("127.0.0.1").run(steps="many")': "incompatible type",
    'print(hapticd.Session("127.0.0.1").run(1).state)': '"state"',
    'print(hapticd.columns)': "columns",
}


def run(*command, path="", **options):
    """(exit code, what it wrote)"""
    environment = {name: value for name, value in os.environ.items() if not name.startswith(("PIP_", "PYTHON"))}
    environment.update({"PYTHONPATH": path} if path else {}, PIP_CONFIG_FILE=os.devnull, HTTPS_PROXY="http://127.0.0.1:9", **options.pop("environment", {}))
    done = subprocess.run([str(word) for word in command], stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True, check=False, timeout=300,
                          env=environment, **options)
    return done.returncode, done.stdout


def tree(folder):
    """All files with their lengths, but what Python compiled."""
    return {path: path.stat().st_size for path in folder.rglob("*") if path.is_file() and "__pycache__" not in path.parts}


class InFolder(unittest.TestCase):
    def setUp(self):
        self.folder = pathlib.Path(self.enterContext(tempfile.TemporaryDirectory()))

    def install(self, source, **options):
        place = self.folder / "installed"
        code, said = run(*PIP, "install", *OFFLINE, "--no-deps", "--target", place, source, **options)
        return code, said, place

    def check_installed(self, place):
        code, said = run(sys.executable, "-c", SCRIPT, path=place, cwd=self.folder)
        self.assertEqual(said.splitlines()[0], f"{VERSION} {VERSION} wall")
        self.assertTrue(said.splitlines()[1].startswith(str(place)), said)
        self.assertEqual(code, 0)
        for name in ("py.typed", "v1/stream_pb2.pyi"):
            self.assertTrue((place / "hapticd" / name).exists(), name)


class Pip(InFolder):
    def test_a_source_archive_is_installed_without_the_project_and_without_protoc(self):
        make = "from setuptools import build_meta as made; import sys; print(made.build_sdist(sys.argv[1]))"
        code, said = run(sys.executable, "-c", make, self.folder, cwd=PACKAGE)
        self.assertEqual(code, 0, said)
        archive = self.folder / f"hapticd-{VERSION}.tar.gz"
        with tarfile.open(archive) as file:
            names = {pathlib.PurePath(name).name for name in file.getnames()}
        self.assertLessEqual({"state_pb2.py", "state_pb2.pyi", "py.typed", "README.md", "setup.py"}, names)
        code, said, place = self.install(archive, environment={"PATH": "/nonexistent"})
        self.assertEqual(code, 0, said)
        self.check_installed(place)

    def test_what_is_missing_is_named_with_its_remedy(self):
        code, said, _ = self.install(PACKAGE, environment={"PATH": "/nonexistent"})
        self.assertNotEqual(code, 0)
        self.assertIn("On Debian: apt install protobuf-compiler", said)
        alone = self.folder / "alone" / "clients" / "python"
        shutil.copytree(PACKAGE, alone)
        code, said, _ = self.install(alone)
        self.assertNotEqual(code, 0)
        self.assertIn("Install from the folder clients/python of hapticd's sources, or from a source archive", said)
        below_root = "import pathlib, sys; exec(pathlib.Path(sys.argv[1]).read_text(), {'__file__': '/alone/setup.py'})"
        code, said = run(sys.executable, "-c", below_root, PACKAGE / "setup.py", cwd=self.folder)
        self.assertEqual((code, said.count("\n")), (1, 1), said)
        self.assertIn("Install from the folder clients/python of hapticd's sources, or from a source archive", said)
        code, said = run(*PIP, "install", *OFFLINE, "--no-deps", "--target", self.folder / "editable", "-e", PACKAGE)
        self.assertNotEqual(code, 0)
        self.assertIn("an editable install would have no wire types", said)


class BuildTree(InFolder):
    def test_it_has_the_version_of_the_project_and_so_has_what_cmake_installs(self):
        built = os.environ["HAPTICD_PYTHON_PACKAGE"]
        self.check_installed(pathlib.Path(built))
        code, said = run(os.environ["HAPTICD_CMAKE"], "--install", built, "--prefix", self.folder)
        self.assertEqual(code, 0, said)
        self.check_installed(self.folder / "lib" / "python3" / "dist-packages")


class Environment(unittest.TestCase):
    """An environment with the package, made as the README says."""

    @classmethod
    def setUpClass(cls):
        cls.folder = pathlib.Path(cls.enterClassContext(tempfile.TemporaryDirectory()))
        words = re.findall(r"^    (python3 -m venv .*|\S*pip install .*)$", (PACKAGE / "README.md").read_text(encoding="utf-8"), re.MULTILINE)
        assert len(words) == 2, words
        before = tree(PACKAGE)
        for line in words:
            code, said = run("bash", "-ec", line.replace("python3 -m", f"{sys.executable} -m"), cwd=ROOT, environment={"HOME": str(cls.folder)})
            assert code == 0, said
        cls.written = set(tree(PACKAGE).items()) ^ set(before.items())
        cls.python = cls.folder / "haptics" / "bin" / "python"

    def test_it_has_the_package_and_nothing_was_written_beside_the_sources(self):
        self.assertEqual(self.written, set())
        code, said = run(self.python, "-c", SCRIPT, cwd=self.folder)
        self.assertEqual((code, said.splitlines()[0]), (0, f"{VERSION} {VERSION} wall"))
        _, said = run(self.python, "-m", "pip", "check")
        self.assertNotIn("hapticd", said)

    def test_a_script_is_typed_and_its_mistakes_are_found(self):
        (self.folder / "script.py").write_text(TYPED + "".join(f"\n{mistake}" for mistake in MISTAKES) + "\n", encoding="utf-8")
        code, said = run("mypy", "--strict", "--config-file", PACKAGE / "pyproject.toml", "--python-executable", self.python, "script.py",
                         cwd=self.folder)
        found = [line for line in said.splitlines() if ": error: " in line]
        self.assertEqual((code, len(found)), (1, len(MISTAKES)), said)
        for line, (mistake, words) in enumerate(MISTAKES.items(), TYPED.count("\n") + 2):
            self.assertTrue(any(each.startswith(f"script.py:{line}: ") and words in each for each in found), f"{mistake}: {said}")

    def test_the_package_itself_is_typed(self):
        code, said = run("mypy", "--config-file", PACKAGE / "pyproject.toml", pathlib.Path(os.environ["HAPTICD_PYTHON_PACKAGE"]) / "hapticd",
                         cwd=self.folder)
        self.assertEqual(code, 0, said)


if __name__ == "__main__":
    unittest.main()
