#!/usr/bin/python3
"""Checks the size of what a reader has to hold at once, against the list of exceptions in exceptions.txt:
  files       the members of a class are defined in one .cpp
  public      a class has at most 20 public members
  parameters  a function has at most 5 parameters
Prints each violation, and each exception that is not needed any more or is larger than needed; exit code 1 if any.

A class here is what is declared with the word class, and a struct or union of which a function is defined outside of it: the rest are
plain records, whose fields are no interface. Of public members functions and data count, each overload once; constructors,
destructors, assignments, types and friends do not. Functions count where they are defined, templates as well, lambdas do not."""
import collections
import os
import sys

import cpp_outline
import source_tree

FOLDERS = ("core/", "proto/", "device/", "server/", "clients/", "tests/")
MOST = {"files": 1, "public": 20, "parameters": 5}
SAYS = {"files": "its members are defined in {found} files, and belong into one",
        "public": "{found} public members; at most {most}",
        "parameters": "{found} parameters; at most {most}"}
LIST = "tests/architecture/exceptions.txt"


class Places:
    """Where each class is declared, and which class a name means at a place."""

    def __init__(self, outlines):
        self.of_headers = collections.defaultdict(list)  # name: paths
        self.of_sources = set()  # (path, name)
        self.aliases = {path: outline.aliases for path, outline in outlines.items()}
        for path, outline in outlines.items():
            for found in outline.classes:
                if path.endswith(".h"):
                    self.of_headers[found.name].append(path)
                else:
                    self.of_sources.add((path, found.name))

    def class_of(self, path, function):
        """(path, name) of the class that a function defined outside of it in a .cpp belongs to, or None."""
        written = function.name[len(function.scope):-1]
        if written[0] in self.aliases[path]:
            written = cpp_outline.Reader.qualified(self.aliases[path][written[0]]) + written[1:]
        for depth in range(len(function.scope), -1, -1):
            name = function.scope[:depth] + written
            if (path, name) in self.of_sources:
                return path, name
            if name in self.of_headers:
                # Tests may have classes of one name in several folders: the one that is nearest is meant.
                return max(self.of_headers[name], key=lambda header: len(os.path.commonprefix([header, path]))), name
        return None


def measure(outlines):
    """{(rule, name): (found, path)} of everything that a rule limits; outlines: {path: Outline}. Of equal names the worst."""
    places = Places(outlines)
    files = collections.defaultdict(set)
    found = {}

    def note(rule, name, number, path):
        key = rule, "::".join(part for part in name if part)
        found[key] = max(found.get(key, (0, "")), (number, path))

    for path, outline in outlines.items():
        for function in outline.functions:
            note("parameters", function.name, function.parameters, path)
            if path.endswith(".cpp") and not function.is_member and len(function.name) > len(function.scope) + 1:
                owner = places.class_of(path, function)
                if owner:
                    files[owner].add(path)
    for (path, name), where in files.items():
        note("files", name, len(where), path)
    for path, outline in outlines.items():
        for each in outline.classes:
            if each.keyword == "class" or (path, each.name) in files:
                members = [member for member in each.members if member.access == "public" and not member.is_special]
                note("public", each.name, len(members), path)
    return found


def read_exceptions(text):
    """{(rule, name): number} of the lines `RULE NUMBER NAME REASON`, and what is wrong with the others."""
    exceptions, wrong = {}, []
    for line in text.splitlines():
        words = line.split("#")[0].split()
        if not words:
            continue
        if len(words) < 4 or words[0] not in MOST or not words[1].isdigit():
            wrong.append(f"{LIST}: '{line}' is not RULE NUMBER NAME REASON")
        elif (words[0], words[2]) in exceptions:
            wrong.append(f"{LIST}: {words[0]} {words[2]} stands there twice")
        else:
            exceptions[words[0], words[2]] = int(words[1])
    return exceptions, wrong


def violations(sources, exceptions_text):
    """All violations, as lines to print; sources: {path: text}."""
    exceptions, wrong = read_exceptions(exceptions_text)
    found = measure({path: cpp_outline.read(text) for path, text in sources.items()})
    for (rule, name), (number, path) in sorted(found.items()):
        allowed = exceptions.get((rule, name), MOST[rule])
        if number > allowed:
            wrong.append(f"{path}: {name}: {SAYS[rule].format(found=number, most=allowed)}")
    for (rule, name), allowed in sorted(exceptions.items()):
        number = found.get((rule, name), (0, ""))[0]
        if number <= MOST[rule]:
            wrong.append(f"{LIST}: {rule} {name} needs no exception any more: take it out")
        elif number < allowed:
            wrong.append(f"{LIST}: {rule} {name} is {number} now: write it instead of {allowed}")
    return wrong


def main():
    sources = {path: source_tree.read(path) for path in source_tree.files() if path.startswith(FOLDERS) and path.endswith((".h", ".cpp"))}
    found = violations(sources, source_tree.read(LIST))
    print("\n".join(found))
    return 1 if found else 0


if __name__ == "__main__":
    sys.exit(main())
