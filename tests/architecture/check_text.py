#!/usr/bin/python3
"""Checks what every file of the project must be: short, opened by a comment, free of leftovers and of one machine's paths, and
part of the build. Prints each violation; exit code 1 if any."""
import os
import re
import sys

import source_tree

MOST_LINES = 600
TOP_LEVEL = {"CHANGELOG.md", "CITATION.cff", "CMakeLists.txt", "CMakePresets.json", "CONTRIBUTING.md", "LICENSE", "NOTICE", "README.md",
             "clients", "core", "deploy", "device", "proto", "server", "tests"}
# Written with brackets so that this file does not match itself.
LEFTOVERS = {
    "a note to do something later": re.compile(r"\b(TO[D]O|FIX[M]E|X[X]X|HA[C]K)\b"),
    "a path of one machine": re.compile(r"(?<![\w.])/(wor[k]|hom[e]|roo[t]|User[s])/\w"),
    "a tab": re.compile(r"\t"),
    "a space at the end of a line": re.compile(r" $", re.MULTILINE),
}
CORPORA = "tests/fuzz/corpus/"
"""Bytes for fuzzers, some of which happen to be text."""
CODE = (".h", ".cpp", ".proto", ".py", ".js", ".cmake", ".sh")
OPENING_COMMENT = {".h": "//", ".cpp": "//", ".proto": "//", ".py": ('"""', "#"), ".js": ("//", "/*"), ".cmake": "#", ".sh": "#"}


def opening(text):
    """The text without the line that names an interpreter."""
    return text.split("\n", 1)[1] if text.startswith("#!") else text


def violations(path, text):
    """All violations in one file, as lines to print."""
    found = []
    top = path.split("/")[0]
    if top not in TOP_LEVEL and not top.startswith("."):
        found.append(f"{path}: the top level is fixed and has no {top}")
    extension = os.path.splitext(path)[1]
    lines = text.count("\n")
    if extension in CODE and lines >= MOST_LINES:
        found.append(f"{path}: {lines} lines; one concept stays below {MOST_LINES}")
    if extension in OPENING_COMMENT and not opening(text).startswith(OPENING_COMMENT[extension]):
        found.append(f"{path}: does not start with a comment that says what it is")
    if extension == ".h" and "\n#pragma once\n" not in text:
        found.append(f"{path}: no #pragma once")
    for name, pattern in LEFTOVERS.items():
        for match in pattern.finditer(text):
            found.append(f"{path}:{text.count(chr(10), 0, match.start()) + 1}: {name}")
    return found


def unlisted(paths, top):
    """Folders with a CMakeLists.txt that the list in the top one, given as text, forgets: nothing in them would be built."""
    listed = tuple(f"{folder}/" for folder in top.replace(")", " ").split())
    folders = [os.path.dirname(path) for path in paths if path.endswith("/CMakeLists.txt")]
    return [f"{folder}: not in the list of CMakeLists.txt" for folder in folders if not f"{folder}/".startswith(listed)]


def main():
    found = unlisted(source_tree.files(), source_tree.read("CMakeLists.txt"))
    for path in source_tree.files():
        if path.startswith(CORPORA):
            continue
        try:
            found += violations(path, source_tree.read(path))
        except UnicodeDecodeError:
            continue  # meshes, images
    print("\n".join(found))
    return 1 if found else 0


if __name__ == "__main__":
    sys.exit(main())
