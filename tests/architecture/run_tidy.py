#!/usr/bin/python3
"""Runs clang-tidy 22 over the translation units of a build folder, in parallel. Exit code 1 if any has a finding.

usage: run_tidy.py BUILD_FOLDER [--all] [--jobs N]

A unit found clean is remembered under ${XDG_CACHE_HOME:-~/.cache}/hapticd/tidy by the hash of all that the result depends on:
its flags, its project files, .clang-tidy and the version of clang-tidy. It is not checked again until one of them changes, or
--all is given. Headers are checked with the units that include them; one that none includes, by itself.
"""
import argparse
import concurrent.futures
import hashlib
import json
import os
import pathlib
import shlex
import subprocess
import sys

import source_tree

TIDY = "clang-tidy-22"
CACHE = pathlib.Path(os.environ.get("XDG_CACHE_HOME") or pathlib.Path.home() / ".cache") / "hapticd" / "tidy"


class Unit:
    """A translation unit: its source, its flags without the paths of this clone, and the project files it reads."""

    def __init__(self, entry):
        self.source = entry["file"]
        words = shlex.split(entry["command"])
        output = words.index("-o")
        words = words[:output] + words[output + 2:]
        listing = subprocess.run([*words, "-M", "-MT", "unit"], cwd=entry["directory"], capture_output=True, text=True, check=False)
        if listing.returncode:
            sys.exit(f"{self.source}: {listing.stderr}")
        paths = listing.stdout.replace("\\\n", " ").split()[1:]
        paths = {os.path.normpath(os.path.join(entry["directory"], path)) for path in paths}
        self.files = sorted(path for path in paths if path.startswith((source_tree.ROOT + "/", entry["directory"] + "/")))
        self.flags = " ".join(words).replace(entry["directory"], "BUILD").replace(source_tree.ROOT, "ROOT")

    def key(self, common):
        digest = hashlib.sha256(common + self.flags.encode())
        for path in self.files:
            digest.update(hashlib.sha256(pathlib.Path(path).read_bytes()).digest())
        return digest.hexdigest()


def choose(units):
    """The units written by hand, and the generated unit of each header that none of them includes."""
    marker = "/header_alone/"
    by_hand = [unit for unit in units if marker not in unit.source]
    seen = {path for unit in by_hand for path in unit.files}
    alone = [unit for unit in units if marker in unit.source]
    return by_hand + [unit for unit in alone
                      if os.path.join(source_tree.ROOT, unit.source.split(marker)[1][:-len(".cpp")]) not in seen]


def main():
    parser = argparse.ArgumentParser()
    parser.add_argument("build")
    parser.add_argument("--all", action="store_true")
    parser.add_argument("--jobs", type=int, default=os.cpu_count())
    arguments = parser.parse_args()

    build = os.path.abspath(arguments.build)
    entries = json.loads(pathlib.Path(build, "compile_commands.json").read_text(encoding="utf-8"))
    entries = [entry for entry in entries if not entry["file"].endswith(".pb.cc")]
    version = subprocess.run([TIDY, "--version"], capture_output=True, check=True).stdout
    common = version + "".join(source_tree.read(path) for path in source_tree.files() if path.endswith(".clang-tidy")).encode()
    CACHE.mkdir(parents=True, exist_ok=True)

    def check(unit):
        """None if known to be clean, else whether it is, and what clang-tidy said."""
        clean = CACHE / unit.key(common)
        if clean.exists() and not arguments.all:
            return None
        run = subprocess.run([TIDY, "--quiet", "-p", build, unit.source], capture_output=True, text=True, check=False)
        if run.returncode == 0:
            clean.touch()
        return run.returncode == 0, run.stdout + (run.stderr if run.returncode else "")

    with concurrent.futures.ThreadPoolExecutor(arguments.jobs) as pool:
        units = choose(list(pool.map(Unit, entries)))
        checked = []
        for result in pool.map(check, units):
            if result:
                checked.append(result)
                if not result[0]:
                    print(result[1], flush=True)
    failed = sum(not clean for clean, _ in checked)
    print(f"clang-tidy: {len(units)} units, {len(checked)} checked, {failed} with findings")
    return 1 if failed else 0


if __name__ == "__main__":
    sys.exit(main())
