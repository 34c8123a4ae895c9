#!/usr/bin/python3
"""Writes the file ctest includes: one add_test per TEST_CASE of a doctest executable.

usage: list_test_cases.py EXECUTABLE FOLDER LABELS OUTPUT [BEFORE]...

The name of an entry is "FOLDER: name of the case". Names may hold any character: they are bracket-quoted for CMake and
escaped for doctest, whose filter takes a comma as a separator. BEFORE are the words that go before the command of each. A case
that cannot run on this machine ends with 77 (tests/support/skip.h); ctest then counts it as skipped.
"""
import subprocess
import sys
import xml.etree.ElementTree as xml


def bracket(text):
    """CMake bracket argument: nothing inside is an escape or a variable."""
    equals = "=="
    while f"]{equals}]" in text:
        equals += "="
    return f"[{equals}[{text}]{equals}]"


def main():
    executable, folder, labels, output, *before = sys.argv[1:]
    listing = subprocess.run([executable, "--list-test-cases", "--reporters=xml", "--no-skip=true"],
                             check=True, capture_output=True, text=True).stdout
    names = [case.get("name") for case in xml.fromstring(listing).iter("TestCase")]
    if not names:
        sys.exit(f"{executable} holds no test case")
    twice = sorted({name for name in names if names.count(name) > 1})
    if twice:
        sys.exit(f"{executable}: two test cases are called {twice}")

    lines = []
    for name in names:
        entry = bracket(f"{folder}: {name}")
        pattern = name.replace("\\", "\\\\").replace(",", "\\,")
        command = " ".join(bracket(word) for word in [*before, executable, f"--test-case={pattern}"])
        lines.append(f"add_test({entry} {command})")
        lines.append(f"set_tests_properties({entry} PROPERTIES LABELS {bracket(labels)} SKIP_RETURN_CODE 77)")
    with open(output, "w", encoding="utf-8") as file:
        file.write("\n".join(lines) + "\n")


main()
