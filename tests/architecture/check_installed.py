#!/usr/bin/python3
"""All that `cmake --install` copies out of a build tree is made by the target `installed`, which deploy/play builds. Files in a folder
`configured`, and those of install(EXPORT), are there before: CMake writes them.

usage: check_installed.py BUILD-FOLDER NINJA
"""
import pathlib
import re
import subprocess
import sys

WRITTEN_BY_CMAKE = {"configured", "Export"}
COPIES = re.compile(r'file\(INSTALL .*?\bFILES((?:\s+"[^"]*")+)', re.DOTALL)


def copied(build):
    """Paths below the build tree that the install scripts copy."""
    found = set()
    for script in build.rglob("cmake_install.cmake"):
        for paths in COPIES.findall(script.read_text(encoding="utf-8")):
            found.update(pathlib.Path(path) for path in re.findall(r'"([^"]*)"', paths) if path.startswith(f"{build}/"))
    return found


def made(build, ninja):
    """Files that the target `installed` builds; ninja calls a target without a rule of its own phony, and knows what is behind it."""
    files, asked, rest = set(), set(), ["installed"]
    while rest:
        asked.update(rest)
        query = subprocess.run([ninja, "-C", build, "-t", "query", *rest], capture_output=True, text=True, check=False)
        if query.returncode != 0:
            raise LookupError(query.stdout + query.stderr)
        rest = set()
        for name, rule, inputs in re.findall(r"^(\S.*):\n  input: (\S+)\n((?:    .*\n)*)", query.stdout, re.MULTILINE):
            if rule in ("phony", "CMAKE_SYMLINK_LIBRARY"):
                rest.update(re.sub(r"^\|+ ", "", line.strip()) for line in inputs.splitlines())
            else:
                files.add(build / name)
        rest = sorted(rest - asked)
    return files


def is_there(path, built):
    """The path, the file it is a link to, or what is in the folder that it is."""
    if WRITTEN_BY_CMAKE & set(path.parts):
        return path.exists()
    return path in built or path.resolve() in built or any(path in one.parents for one in built)


def problems_of(build, ninja):
    try:
        built = made(build, ninja)
    except LookupError as error:
        return [f"ninja knows no target installed: {error}"]
    paths = copied(build)
    if not paths:
        return ["nothing is installed"]
    return [f"{path.relative_to(build)} is installed, but the target installed does not build it: use hapticd_program or hapticd_installed"
            for path in sorted(paths) if not is_there(path, built)]


def main():
    problems = problems_of(pathlib.Path(sys.argv[1]).resolve(), sys.argv[2])
    print("\n".join(problems) or "all that is installed is built by the target installed")
    return 1 if problems else 0


if __name__ == "__main__":
    sys.exit(main())
