#!/usr/bin/python3
"""Builds the determinism probes with several compilers and flags and compares their output, and replays in each build the session that the
first has recorded: equal bits are promised.

usage: compare_builds.py BUILD_FOLDER [--jobs N]
Prints one line per build; exit code 1 when a build fails or differs from the first.
"""
import argparse
import pathlib
import shutil
import subprocess
import sys

from source_tree import ROOT

BUILDS = {
    "gcc-O1": ("g++", "-O1"),
    "gcc-O3-x86-64-v3": ("g++", "-O3 -march=x86-64-v3"),
    "clang-O2": ("clang++-14", "-O2"),
}
FOLDERS = ("core/math core/rt proto proto/noise proto/wire core/geometry core/solver core/safety device/api device/simulated core/instrument"
           " core/collision core/modeling core/rendering core/simulation core/scene server/scene_io server/haptic_loop server/encoding"
           " server/network server/system server/telemetry server/daemon"
           " tests/support tests/core/math tests/core/modeling tests/realtime tests/server/daemon")
PROBES = {"determinism_probe_core_math": "tests/core/math", "determinism_probe_core_modeling": "tests/core/modeling",
          "determinism_probe_contact_tick": "tests/realtime"}
SESSION_PROBE = "recorded_session_probe"


def build(folder: pathlib.Path, compiler: str, flags: str, jobs: int) -> None:
    subprocess.run(["cmake", "-S", str(ROOT), "-B", str(folder), "-G", "Ninja", "-DCMAKE_BUILD_TYPE=None",
                    f"-DCMAKE_CXX_COMPILER={compiler}", f"-DCMAKE_CXX_FLAGS={flags}", "-DHAPTICD_CHECK_HEADERS=OFF",
                    f"-DHAPTICD_FOLDERS={FOLDERS.replace(' ', ';')}"], check=True, stdout=subprocess.DEVNULL)
    subprocess.run(["cmake", "--build", str(folder), "--parallel", str(jobs), "--target", *PROBES, SESSION_PROBE],
                   check=True, stdout=subprocess.DEVNULL)


def output_of(folder: pathlib.Path) -> str:
    return "".join(subprocess.run([str(folder / where / probe)], check=True, capture_output=True, text=True).stdout
                   for probe, where in PROBES.items())


def session(folder: pathlib.Path, what: str, recordings: pathlib.Path) -> subprocess.CompletedProcess:
    return subprocess.run([str(folder / "tests/server/daemon" / SESSION_PROBE), what, str(recordings)], capture_output=True, text=True)


def main() -> int:
    parser = argparse.ArgumentParser()
    parser.add_argument("build_folder", type=pathlib.Path)
    parser.add_argument("--jobs", type=int, default=2)
    options = parser.parse_args()
    recordings = options.build_folder / "recordings"
    shutil.rmtree(recordings, ignore_errors=True)
    recordings.mkdir(parents=True)
    expected = None
    same = True
    for name, (compiler, flags) in BUILDS.items():
        folder = options.build_folder / name
        build(folder, compiler, flags, options.jobs)
        output = output_of(folder)
        expected = expected or output
        verdict = "same bits" if output == expected else "DIFFERS"
        same = same and output == expected
        print(f"{name}: {verdict}: {' '.join(output.split())}")
        if not any(recordings.iterdir()):
            session(folder, "record", recordings).check_returncode()
        verified = session(folder, "verify", recordings)
        same = same and verified.returncode == 0
        print(f"{name}: recorded session: {'; '.join((verified.stdout + verified.stderr).splitlines())}")
    return 0 if same else 1


if __name__ == "__main__":
    sys.exit(main())
