#!/usr/bin/python3
"""Says which sources of each target can be compiled as one: no name that is one file's own stands in another of the group or in a header
that another includes.

usage: unity_groups.py OUTPUT < LINES      each line: TARGET;FOLDER;SOURCE;SOURCE...
Writes a CMake file that gives every such source its group. A file's own names are those of its anonymous namespaces and its macros; an
alias that means the same in two files may be in both.
"""
import functools
import os
import re
import sys

sys.path.insert(0, os.path.join(os.path.dirname(os.path.abspath(__file__)), "../../tests/architecture"))
import cpp_outline  # noqa: E402

MOST_FILES = 8
"""Of a group. More: less to compile in all; fewer: less to compile anew when one file changes."""
MACRO = re.compile(r"^[ \t]*#[ \t]*define[ \t]+(\w+)", re.MULTILINE)
INCLUDE = re.compile(r'^#include "([^"]+)"', re.MULTILINE)
DECLARED = re.compile(r"^(?:using|class|struct|enum class|(?:inline )?(?:constexpr|const) [\w:<>, ]*?)[ ]?(\w+)(?: =| \{|\{|\[|;)", re.MULTILINE)
"""A type, an alias or a constant of a namespace, as a header that is laid out as all here are begins it."""
WORD = re.compile(r"(?<![\w.>])(?<!\bcore/)[A-Za-z_]\w*")


@functools.cache
def read(path):
    with open(path, encoding="utf-8") as file:
        return file.read()


@functools.cache
def header_names(path):
    """Names that a header of the project declares, with those that it includes."""
    if not os.path.exists(path):
        return frozenset()
    text = read(path)
    return frozenset(DECLARED.findall(text)).union(*(header_names(other) for other in INCLUDE.findall(text)))


class Source:
    def __init__(self, path, text):
        outline = cpp_outline.read(text)
        self.path = path
        self.aliases = outline.aliases
        self.own = outline.own | set(MACRO.findall(text))
        self.words = set(WORD.findall(cpp_outline.without_text(text))).union(*(header_names(name) for name in INCLUDE.findall(text)))

    def clashes(self, other):
        """Whether the two cannot be compiled as one."""
        same = {name for name, meaning in self.aliases.items() if other.aliases.get(name) == meaning}
        return bool((self.own - same) & other.words or (other.own - same) & self.words)


def group(sources):
    """Lists of sources that can be compiled as one; each source is in one list."""
    groups = []
    for source in sources:
        fitting = (each for each in groups if len(each) < MOST_FILES and not any(source.clashes(other) for other in each))
        found = next(fitting, None)
        if found is None:
            groups.append([source])
        else:
            found.append(source)
    return groups


def main():
    lines = []
    for line in sys.stdin.read().splitlines():
        target, folder, *names = line.split(";")
        sources = []
        for name in names:
            path = os.path.normpath(os.path.join(folder, name))
            if name.endswith(".cpp") and os.path.exists(path):
                sources.append(Source(path, read(path)))
        for number, members in enumerate(group(sources)):
            for source in members if len(members) > 1 else ():
                lines.append(f'set_source_files_properties("{source.path}" TARGET_DIRECTORY {target} PROPERTIES UNITY_GROUP {number})')
    with open(sys.argv[1], "w", encoding="utf-8") as file:
        file.write("\n".join(lines) + "\n")


if __name__ == "__main__":
    main()
