#!/usr/bin/python3
"""Builds the determinism probes with several compilers and flags and compares their output: equal bits are promised.

usage: compare_builds.py BUILD_FOLDER [--builds NAME...] [--jobs N] [--sessions PROBE...]
Prints one line per build, each of which runs twice; exit code 1 when a build fails or any run differs from the first. --builds: these of
ALL_BUILDS, which are gcc and clang at -O0, -O2 and -O3, plain and under every sanitizer, beside what is built in CI; all probes run in
each, those too that CI has no time for. The recorded_session_probe of builds that exist: the first records a session, and all replay it to
the bit.
"""
import argparse
import concurrent.futures
import pathlib
import shutil
import subprocess
import sys

from source_tree import ROOT

COMPILERS = {"gcc": "g++", "clang": "clang++-14"}
LEVELS = ("-O0", "-O2", "-O3")
SANITIZERS = {"asan": "-fsanitize=address,undefined -fno-sanitize-recover=all", "tsan": "-fsanitize=thread"}
MATRIX = {f"{name}{level}": (compiler, level) for name, compiler in COMPILERS.items() for level in LEVELS}
BUILDS = MATRIX | {"gcc-O3-x86-64-v3": ("g++", "-O3 -march=x86-64-v3"), "clang-O2-asan": ("clang++-14", f"-O2 {SANITIZERS['asan']}")}
"""In CI: eight."""
ALL_BUILDS = BUILDS | {f"{name}-{sanitizer}": (compiler, f"{level} {flags}")
                       for name, (compiler, level) in MATRIX.items() for sanitizer, flags in SANITIZERS.items()}
RUNS = 2
FOLDERS = ("core/math core/rt core/tick core/geometry core/solver core/safety core/instrument core/collision core/tree"
           " core/contact core/simulation core/scene server/model/packing server/model/shapes tests/support tests/core/math"
           " tests/server/model/shapes tests/realtime")
PROBES = {"determinism_probe_core_math": "tests/core/math", "determinism_probe_core_modeling": "tests/server/model/shapes",
          "determinism_probe_contact_tick": "tests/realtime"}
ONE_BY_ONE = "gcc-O2"
"""The build whose sources are compiled one by one, as users do; those of the others together, which must not change a bit either."""
SLOW_PROBE = "determinism_probe_core_modeling"
"""Makes models; takes minutes where nothing is optimised, so it runs there with --builds alone."""


def build(folder: pathlib.Path, compiler: str, flags: str, probes: list, jobs: int) -> None:
    subprocess.run(["cmake", "-S", str(ROOT), "-B", str(folder), "-G", "Ninja", "-DCMAKE_BUILD_TYPE=None",
                    f"-DCMAKE_CXX_COMPILER={compiler}", f"-DCMAKE_CXX_FLAGS={flags}", "-DHAPTICD_CHECK_HEADERS=OFF",
                    f"-DHAPTICD_UNITY={'OFF' if folder.name == ONE_BY_ONE else 'ON'}",
                    f"-DHAPTICD_FOLDERS={FOLDERS.replace(' ', ';')}"], check=True, capture_output=True, text=True)
    subprocess.run(["cmake", "--build", str(folder), "--parallel", str(jobs), "--target", *probes],
                   check=True, capture_output=True, text=True)


def output_of(probe: pathlib.Path) -> str:
    return subprocess.run([str(probe)], check=True, capture_output=True, text=True).stdout


def outputs_of(folder: pathlib.Path, probes: list, jobs: int) -> dict:
    """What each probe prints, by run: one text where bits are equal. Addresses are laid out anew in each."""
    with concurrent.futures.ThreadPoolExecutor(jobs) as pool:
        runs = {probe: [pool.submit(output_of, folder / PROBES[probe] / probe) for _ in range(RUNS)] for probe in probes}
        return {probe: {run.result() for run in of_probe} for probe, of_probe in runs.items()}


def compare_sessions(probes: list, recordings: pathlib.Path) -> bool:
    shutil.rmtree(recordings, ignore_errors=True)
    recordings.mkdir(parents=True)
    subprocess.run([probes[0], "record", str(recordings)], check=True)
    same = True
    for probe in probes:
        verified = subprocess.run([probe, "verify", str(recordings)], capture_output=True, text=True, check=False)
        same = same and verified.returncode == 0
        print(f"{probe}: {'; '.join((verified.stdout + verified.stderr).splitlines())}")
    return same


def main() -> int:
    parser = argparse.ArgumentParser()
    parser.add_argument("build_folder", type=pathlib.Path)
    parser.add_argument("--builds", nargs="+", choices=ALL_BUILDS, default=[])
    parser.add_argument("--jobs", type=int, default=2)
    parser.add_argument("--sessions", nargs="*", default=[])
    options = parser.parse_args()
    expected: dict = {}
    same = True
    for name in options.builds or BUILDS:
        compiler, flags = ALL_BUILDS[name]
        folder = options.build_folder / name
        probes = [probe for probe in PROBES if options.builds or probe != SLOW_PROBE or ("-O0" not in flags and "sanitize" not in flags)]
        try:
            build(folder, compiler, flags, probes, options.jobs)
            outputs = outputs_of(folder, probes, options.jobs)
        except subprocess.CalledProcessError as error:
            same = False
            print(f"{name}: FAILED: {error}", flush=True)
            print((error.stdout + error.stderr)[-4000:], file=sys.stderr)
            continue
        equal = all(len(texts) == 1 and texts == expected.setdefault(probe, texts) for probe, texts in outputs.items())
        same = same and equal
        said = " | ".join(" ".join(text.split()) for texts in outputs.values() for text in sorted(texts))
        print(f"{name}: {'same bits' if equal else 'DIFFERS'}: {said}", flush=True)
    if options.sessions:
        same = compare_sessions(options.sessions, options.build_folder / "recordings") and same
    return 0 if same else 1


if __name__ == "__main__":
    sys.exit(main())
