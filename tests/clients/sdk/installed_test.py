"""What a user of the installed library does: finds it with CMake or pkg-config, builds the examples and what the README shows, and plays a daemon in virtual time
with them. What they say is held against closed forms and against the Python client, which shares no code with them."""
import csv
import os
import pathlib
import re
import subprocess
import sys
import tempfile
import unittest

import daemon
import hapticd
from installed_library import EXAMPLES, SCRIPTED, SOURCE, check_press, checked, install

CMAKE, CXX = os.environ["CMAKE"], os.environ["CXX"]
WARNINGS = ["-Wall", "-Wextra", "-Wpedantic", "-Wshadow", "-Wconversion", "-Wsign-conversion", "-Werror"]


class Installed(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        cls.scratch = tempfile.TemporaryDirectory()
        cls.folder = pathlib.Path(cls.scratch.name)
        cls.prefix = cls.folder / "usr"
        cls.library_folder = install(cls.prefix)
        cls.programs = cls.folder / "programs"
        flags = " ".join(WARNINGS)
        checked(CMAKE, "-S", EXAMPLES, "-B", cls.programs, "-G", "Ninja", f"-DCMAKE_PREFIX_PATH={cls.prefix}", f"-DCMAKE_CXX_COMPILER={CXX}",
                f"-DCMAKE_CXX_FLAGS=-std=c++17 -fvisibility=hidden {flags}", f"-DCMAKE_C_FLAGS={flags}")
        checked(CMAKE, "--build", cls.programs)

    @classmethod
    def tearDownClass(cls):
        cls.scratch.cleanup()

    def played(self, example, *arguments, options=SCRIPTED):
        """What an example prints about a daemon of its own."""
        with daemon.Daemon(*options, state=str(self.folder / "state")) as played:
            return checked(self.programs / example, played.address, *arguments, cwd=self.folder)

    def pkg_config(self, *options):
        environment = dict(os.environ, PKG_CONFIG_PATH=str(self.library_folder / "pkgconfig"))
        return checked("pkg-config", *options, env=environment).split()

    def test_the_force_is_stiffness_times_displacement(self):
        lines = re.findall(r"(\d+) N/m: ([\d.]+) N, the finger ([\d.]+) mm", self.played("stiffness"))
        self.assertEqual([int(kt) for kt, _, _ in lines], [1000, 500, 250])
        for kt, force, offset in lines:
            self.assertAlmostEqual(float(force), float(kt) * float(offset) * 1e-3, delta=2e-4)
        forces = [float(force) for _, force, _ in lines]
        self.assertEqual(forces, sorted(forces, reverse=True))

    def test_a_scene_of_ones_own_becomes_a_table(self):
        printed = self.played("own_scene", "own.csv")
        with open(self.folder / "own.csv", encoding="utf-8", newline="") as file:
            rows = [{name: float(value) for name, value in row.items()} for row in csv.DictReader(file)]
        self.assertEqual([row["tick"] for row in rows], list(range(500)))
        for row in rows:
            self.assertGreaterEqual(row["tool0_wg_y_m"], 0.01)  # the radii of ball and rod together
        for row in rows[300:]:  # the force is on since 200 ms
            self.assertAlmostEqual(row["tool0_fy_n"], 800.0 * (row["tool0_wg_y_m"] - row["tool0_wh_y_m"]), delta=0.02)
        self.assertAlmostEqual(rows[-1]["tool0_wh_y_m"], 0.004, places=12)
        self.assertAlmostEqual(rows[-1]["tool0_fy_n"], 800.0 * 0.006, delta=0.05)
        # The path is 10 mm above the axis, where the surfaces meet, at 250 ms.
        self.assertAlmostEqual(float(re.search(r"after ([\d.]+) ms", printed)[1]), 250.0, delta=2.0)

    def test_c_plays_the_same_bits_as_python(self):
        check_press(self, self.programs / "press")

    def test_pkg_config_builds_c_and_a_program_that_needs_no_library_of_ours(self):
        shared = self.folder / "shared_press"
        checked("cc", "-std=c11", *WARNINGS, EXAMPLES / "press.c", "-o", shared, *self.pkg_config("--cflags", "--libs", "hapticd-client"), "-lm",
                f"-Wl,-rpath,{self.library_folder}")
        check_press(self, shared)
        alone = self.folder / "own_scene_alone"
        flags = self.pkg_config("--static", "--cflags", "--libs", "hapticd-client")
        self.assertEqual(flags.count("-lhapticd-client"), 1)
        flags[flags.index("-lhapticd-client")] = "-l:libhapticd-client.a"
        checked(CXX, "-std=c++17", *WARNINGS, EXAMPLES / "own_scene.cpp", "-o", alone, *flags)
        self.assertNotIn("hapticd", checked("ldd", alone))
        with daemon.Daemon(*SCRIPTED) as played:
            self.assertIn("500 rows", checked(alone, played.address, self.folder / "alone.csv"))

    def test_a_gesture_is_recorded_and_exported(self):
        recording = self.folder / "state" / "hapticd" / "recordings" / "strum.mcap"
        printed = self.played("record_gesture", "strum", options=("--clock", "virtual"))
        self.assertTrue(printed.startswith(f"{recording}: "), printed)
        ticks, events = map(int, re.search(r"(\d+) ticks, (\d+) events", printed).groups())
        with open(self.folder / "strum.csv", encoding="utf-8", newline="") as file:
            numbers = [int(row["tick"]) for row in csv.DictReader(file)]
        self.assertEqual(numbers, list(range(numbers[0], numbers[0] + ticks)))
        with open(self.folder / "strum_events.csv", encoding="utf-8", newline="") as file:
            rows = list(csv.DictReader(file))
        self.assertEqual(len(rows), events)
        strings = [int(row["string_index"]) for row in rows if int(row["kind"]) == 1]
        self.assertEqual(strings, [0, 1, 2, 3, 4, 5, 6])  # each once, in the order of the stroke

    def test_tones_become_a_tempo(self):
        with daemon.Daemon("--clock", "virtual") as played, hapticd.Session(played.address) as session:
            session.acquire("test")
            follower = subprocess.Popen([self.programs / "metronome", played.address, "5"], stdout=subprocess.PIPE, text=True)
            self.assertEqual(follower.stdout.readline(), "listening\n")
            session.play_gesture("strum")
            session.run(4000)
            printed = follower.communicate(timeout=60)[0].splitlines()
            tones = [event.body for event in session.events(timeout=0) if event.kind == "tone"][:5]
        self.assertEqual(len(tones), 5)
        expected = [f"{60e9 / (tone.t_ns - before.t_ns):6.1f} bpm {'#' * int(tone.level * 40)}" for before, tone in zip(tones, tones[1:])]
        self.assertEqual(printed, expected)

    def test_what_the_readme_shows_is_built_as_it_says_and_runs(self):
        text = (SOURCE / "clients" / "sdk" / "README.md").read_text(encoding="utf-8")
        cpp, cmake, c = (re.findall(rf"```{language}\n(.*?)```", text, re.DOTALL) for language in ("cpp", "cmake", "c"))
        self.assertEqual((len(cpp), len(cmake), len(c)), (1, 1, 1))
        folder = self.folder / "readme"
        folder.mkdir()
        for name, content in (("feel.cpp", cpp[0]), ("watch.c", c[0]), ("CMakeLists.txt", cmake[0])):
            (folder / name).write_text(content, encoding="utf-8")
        checked(CMAKE, "-S", folder, "-B", folder / "build", f"-DCMAKE_PREFIX_PATH={self.prefix}", f"-DCMAKE_CXX_COMPILER={CXX}")
        checked(CMAKE, "--build", folder / "build")
        environment = dict(os.environ, PKG_CONFIG_PATH=str(self.library_folder / "pkgconfig"), LD_LIBRARY_PATH=str(self.library_folder))
        for command in re.findall(r"```sh\n(.*?)```", text, re.DOTALL):
            checked("sh", "-ec", command, cwd=folder, env=environment)
        for program in (folder / "build" / "feel", folder / "feel"):
            with daemon.Daemon(*SCRIPTED) as played:
                printed = checked(program, played.address, env=environment).splitlines()
            # Surfaces meet 10 mm above the axis; the hand ends at 20 mm - 499 * 0.03 mm.
            self.assertAlmostEqual(float(printed[0].split()[2]), 10e-3 / 3e-5, delta=2.0)
            self.assertAlmostEqual(float(printed[1].split()[0]), 500 * (0.01 - (0.02 - 499 * 3e-5)), delta=0.05)
        with daemon.Daemon("--clock", "virtual") as played, hapticd.Session(played.address) as session:
            session.acquire("test")
            watcher = subprocess.Popen([folder / "watch", played.address], stdout=subprocess.PIPE, text=True, env=environment)
            session.run_live()
            printed = watcher.communicate(timeout=60)[0].splitlines()
        self.assertEqual(watcher.returncode, 0)
        self.assertGreater(len(printed), 50)

    def test_the_version_is_the_projects(self):
        (version,) = re.findall(r"^project\(hapticd VERSION (\S+)", (SOURCE / "CMakeLists.txt").read_text(encoding="utf-8"), re.MULTILINE)
        self.assertEqual(self.pkg_config("--modversion", "hapticd-client"), [version])
        project = self.folder / "asks"
        project.mkdir()
        text = "cmake_minimum_required(VERSION 3.21)\nproject(asks CXX)\nfind_package(hapticd {} CONFIG REQUIRED)\n"
        major, minor = (int(part) for part in version.split(".")[:2])
        # A program written for an earlier version finds a later one of the same major.
        earlier = [(f"{major}.{minor - 1}", True)] if minor else []
        for asked, found in ((version, True), *earlier, (f"{major}.{minor + 1}", False), (f"{major + 1}.0", False)):
            (project / "CMakeLists.txt").write_text(text.format(asked), encoding="utf-8")
            done = subprocess.run([CMAKE, "-S", project, "-B", project / asked, f"-DCMAKE_PREFIX_PATH={self.prefix}"], stdout=subprocess.DEVNULL,
                                  stderr=subprocess.DEVNULL, check=False)
            self.assertEqual(done.returncode == 0, found)

    def test_the_wire_format_is_installed_whole(self):
        protos = self.prefix / "share" / "hapticd" / "proto"
        files = sorted(str(path.relative_to(protos)) for path in protos.rglob("*.proto"))
        self.assertEqual(files, sorted(f"hapticd/v1/{path.name}" for path in (SOURCE / "proto" / "hapticd" / "v1").glob("*.proto")))
        checked("protoc", f"--proto_path={protos}", f"--descriptor_set_out={self.folder / 'all.pb'}", *files)
        self.assertTrue((protos / "PROTOCOL.md").is_file())


if __name__ == "__main__":
    sys.exit(unittest.main(verbosity=2))
