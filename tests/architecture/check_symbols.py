#!/usr/bin/python3
"""Checks that static libraries of the realtime path leave only the symbols of realtime_symbols.txt undefined.

usage: check_symbols.py LIBRARY...

Prints each violation; exit code 1 if any.
"""
import re
import subprocess
import sys

import source_tree


def allowed():
    lines = source_tree.read("tests/architecture/realtime_symbols.txt").splitlines()
    return re.compile("|".join(f"(?:{line})" for line in lines if line and not line.startswith("#")))


def undefined(library):
    """Demangled names the library needs from elsewhere."""
    listing = subprocess.run(["nm", "--demangle", "--undefined-only", "--format=posix", library],
                             capture_output=True, text=True, check=True).stdout
    return sorted(set(re.findall(r"^(.+) [Uvw]\s*$", listing, re.MULTILINE)))


def violations(library):
    names = allowed()
    return [f"{library}: needs {name}" for name in undefined(library) if not names.fullmatch(name)]


def main():
    if len(sys.argv) < 2:
        sys.exit(__doc__)
    found = [line for library in sys.argv[1:] for line in violations(library)]
    print("\n".join(found))
    return 1 if found else 0


if __name__ == "__main__":
    sys.exit(main())
