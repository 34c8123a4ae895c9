#!/usr/bin/python3
"""Checks every #include of the project against the floors of floors.txt. Prints each violation; exit code 1 if any."""
import os
import re
import sys

import source_tree

INCLUDE = re.compile(r'^\s*#\s*include\s*([<"])([^>"]+)[>"]', re.MULTILINE)
OURS = ("core", "proto", "device", "server", "clients", "tests")


class Floors:
    def __init__(self, text):
        self.floor, self.realtime, self.apart, self.only, self.realtime_headers = {}, set(), [], {}, set()
        for line in text.splitlines():
            words = line.split("#")[0].split()
            if not words:
                continue
            if words[0] == "floor":
                self.floor[words[2]] = int(words[1])
                if words[3:] == ["realtime"]:
                    self.realtime.add(words[2])
            elif words[0] == "apart":
                self.apart += [(words[1], words[2]), (words[2], words[1])]
            elif words[0] == "only":
                self.only[words[1]] = words[2:]
            elif words[0] == "realtime_header":
                self.realtime_headers.update(words[1:])
            else:
                sys.exit(f"floors.txt: what is '{line}'?")

    def folder_of(self, path):
        """The folder of the table a file belongs to, or None."""
        folder = os.path.dirname(path)
        if folder == "proto" or folder.startswith("proto/"):
            return "proto"
        return folder if folder in self.floor or os.path.dirname(folder) + "/*" in self.floor else None

    def number(self, folder):
        return self.floor.get(folder, self.floor.get(os.path.dirname(folder) + "/*"))


def below(folder, tree):
    return folder == tree or folder.startswith(tree + "/")


def beyond_only(floors, mine, other):
    """The rule of `only` that a file of folder `mine` breaks by including one of folder `other`; None if none."""
    for tree, allowed in floors.only.items():
        if below(mine, tree) and not any(below(other, permitted) for permitted in (mine, *allowed)):
            return f"{tree} sees only {' '.join(allowed)}"
    return None


def project_include(floors, mine, target):
    """What is wrong with a file of folder `mine` including the project's file `target`; None if nothing."""
    if below(mine, "tests"):
        return beyond_only(floors, mine, os.path.dirname(target))
    other = floors.folder_of(target)
    if below(target, "tests"):
        return "only tests may include tests"
    if other is None:
        return "unknown folder"
    if other == mine:
        return None
    if floors.number(other) >= floors.number(mine):
        return f"floor {floors.number(mine)} may not include floor {floors.number(other)}"
    if any(below(mine, left) and below(other, right) for left, right in floors.apart):
        return "these two do not know each other"
    if reason := beyond_only(floors, mine, other):
        return reason
    if mine in floors.realtime and other not in floors.realtime:
        return "a realtime folder includes only realtime folders"
    return None


def violations(floors, path, text):
    """All violations in one file, as lines to print. Below tests/, `only` binds what is not itself a test."""
    if below(path, "tests") and path.endswith("_test.cpp"):
        return []
    mine = os.path.dirname(path) if below(path, "tests") else floors.folder_of(path)
    if mine is None:
        return [f"{path}: its folder has no floor in floors.txt"]
    found = []
    for bracket, target in INCLUDE.findall(text):
        if target.startswith("hapticd/v1/"):
            target = "proto/" + target
        if target.split("/")[0] in OURS and "/" in target:
            reason = project_include(floors, mine, target)
        elif bracket == '"' and not below(mine, "tests"):
            reason = "write the path from the root of the repository"
        elif mine in floors.realtime and target not in floors.realtime_headers:
            reason = "not among the headers of realtime folders"
        else:
            reason = None
        if reason:
            found.append(f"{path}: includes {target}: {reason}")
    return found


def unmarked_libraries(floors, path, text):
    """A realtime folder whose CMakeLists.txt forgets REALTIME would escape the symbol check."""
    folder = os.path.dirname(path)
    if folder not in floors.realtime or re.search(r"\bREALTIME\b", text):
        return []
    return [f"{path}: floors.txt calls {folder} realtime, hapticd_library does not say REALTIME"]


def main():
    floors = Floors(source_tree.read("tests/architecture/floors.txt"))
    found = []
    for path in source_tree.files():
        if path.split("/")[0] in OURS:
            if path.endswith((".h", ".cpp")):
                found += violations(floors, path, source_tree.read(path))
            elif path.endswith("CMakeLists.txt"):
                found += unmarked_libraries(floors, path, source_tree.read(path))
    print("\n".join(found))
    return 1 if found else 0


if __name__ == "__main__":
    sys.exit(main())
