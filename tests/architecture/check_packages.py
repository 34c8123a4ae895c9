#!/usr/bin/python3
"""Every file that `cmake --install` puts somewhere is put there by one component alone, and every component is a Debian package. Links are
installed instead of copies, which takes no time; the build must be complete.

usage: check_packages.py BUILD-FOLDER CMAKE
"""
import collections
import os
import pathlib
import re
import subprocess
import sys
import tempfile


def packages_of(build):
    """The components that CPack makes packages of."""
    config = (build / "CPackConfig.cmake").read_text(encoding="utf-8")
    (names,) = re.findall(r'^set\(CPACK_COMPONENTS_ALL "([^"]*)"\)', config, re.MULTILINE)
    return names.split(";")


def installed(build, cmake, component=None):
    """Paths, relative to the prefix, of all files of a component, or of the whole."""
    with tempfile.TemporaryDirectory() as folder:
        part = ["--component", component] if component else []
        subprocess.run([cmake, "--install", build, "--prefix", folder, *part], env=dict(os.environ, CMAKE_INSTALL_MODE="ABS_SYMLINK"),
                       stdout=subprocess.DEVNULL, check=True)
        return {str(path.relative_to(folder)) for path in pathlib.Path(folder).rglob("*") if path.is_symlink() or path.is_file()}


def problems_of(whole, parts):
    """whole: all files; parts: the files of each component."""
    owners = collections.defaultdict(list)
    for name, files in parts.items():
        for path in files:
            owners[path].append(name)
    found = [f"{path} is installed, but in no package" for path in sorted(whole - set(owners))]
    found += [f"{path} is in {' and in '.join(names)}" for path, names in sorted(owners.items()) if len(names) > 1]
    found += [f"{path} is in {owners[path][0]} alone, and not installed with all" for path in sorted(set(owners) - whole)]
    return found + [f"the package {name} is empty" for name, files in parts.items() if not files]


def main():
    build, cmake = pathlib.Path(sys.argv[1]).resolve(), sys.argv[2]
    parts = {name: installed(build, cmake, name) for name in packages_of(build)}
    problems = problems_of(installed(build, cmake), parts)
    print("\n".join(problems) or ", ".join(f"{name}: {len(files)} files" for name, files in parts.items()))
    return 1 if problems else 0


if __name__ == "__main__":
    sys.exit(main())
