#!/usr/bin/python3
"""CHANGELOG.md as a Debian changelog, on standard output: an entry for each version, its points under the headings that they have, in
Debian's form: [ Added ]. What is unreleased belongs to VERSION. The date of an entry is that of its heading, or SOURCE_DATE_EPOCH, or when CHANGELOG.md was last changed.

usage: debian_changelog.py CHANGELOG.md VERSION MAINTAINER
"""
import datetime
import email.utils
import os
import pathlib
import re
import sys
import textwrap


def groups(body):
    """(heading or "", points) of each part of a version that has points."""
    first, *parts = re.split(r"^### ", body, flags=re.MULTILINE)
    for heading, _, part in [("", "", first), *(part.partition("\n") for part in parts)]:
        points = [" ".join(point.split()) for point in re.findall(r"^- (.*(?:\n  .*)*)", part, re.MULTILINE)]
        if points:
            yield heading.strip(), points


def entries(text):
    """(version, date or None, groups) of each heading, the newest first."""
    for part in re.split(r"^## ", text, flags=re.MULTILINE)[1:]:
        heading, _, body = part.partition("\n")
        version, date = re.match(r"\[([^]]+)\](?: - (\d{4}-\d\d-\d\d))?", heading.strip()).groups()
        found = list(groups(body))
        if found:
            yield version, date, found


def print_group(heading, points):
    if heading:
        print(f"  [ {heading} ]")
    for point in points:
        print(textwrap.fill(point, 78, initial_indent="  * ", subsequent_indent="    ", break_on_hyphens=False))


def main():
    path, newest, maintainer = pathlib.Path(sys.argv[1]), *sys.argv[2:]
    now = float(os.environ.get("SOURCE_DATE_EPOCH", path.stat().st_mtime))
    for version, date, found in entries(path.read_text(encoding="utf-8")):
        seconds = now if date is None else datetime.datetime.fromisoformat(f"{date}T12:00:00+00:00").timestamp()
        print(f"hapticd ({newest if version == 'Unreleased' else version}) unstable; urgency=medium\n")
        for index, group in enumerate(found):
            if index:
                print()
            print_group(*group)
        print(f"\n -- {maintainer}  {email.utils.formatdate(seconds)}\n")


if __name__ == "__main__":
    main()
