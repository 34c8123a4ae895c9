#!/usr/bin/python3
"""Holds tests/EXTREMES.md against the sources: every test that it names, as `file: name`, is a test case of that file. Exit code 1 otherwise."""
import pathlib
import re
import sys

from source_tree import ROOT

CASE = re.compile(r'TEST_CASE(?:_FIXTURE\(\s*\w+\s*,|\()\s*((?:"(?:[^"\\]|\\.)*"\s*)+)')
NAMED = re.compile(r"`([\w/]+\.cpp): ([^`]+)`")


def cases(text: str) -> set:
    """Names of the test cases of a source, whose literals may be in pieces."""
    return {"".join(re.findall(r'"((?:[^"\\]|\\.)*)"', pieces)) for pieces in CASE.findall(text)}


def problems(page: str, read) -> list:
    """What the page says that is not so. `read`: text of a file below tests, or None."""
    found = []
    rows = [line for line in page.splitlines() if line.startswith("|")][2:]
    if not rows:
        found.append("the page has no rows")
    for row in rows:
        named = NAMED.findall(row)
        if not named:
            found.append(f"no test: {row[:60]}")
        for file, name in named:
            text = read(file)
            if text is None:
                found.append(f"there is no tests/{file}")
            elif name not in cases(text):
                found.append(f'tests/{file} has no case "{name}"')
    return found


def read_test(file: str):
    path = pathlib.Path(ROOT) / "tests" / file
    return path.read_text(encoding="utf-8") if path.is_file() else None


if __name__ == "__main__":
    said = problems((pathlib.Path(ROOT) / "tests/EXTREMES.md").read_text(encoding="utf-8"), read_test)
    print("\n".join(said))
    sys.exit(1 if said else 0)
