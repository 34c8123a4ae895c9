#!/usr/bin/env python3
"""Makes the table of field_table.h from the comments of .proto files, so that what is checked is what is promised.

usage: make_field_table.py OUT.inc FILE.proto...

A comment ends in [unit; shape; range; when absent], of which a field has the parts that make sense for it; PROTOCOL.md has
the grammar. One line per field: FieldRow{"Message.field", "unit", "shape", "range", live, may_be_absent},
"""
import re
import sys

FIELD = re.compile(r"\s*(?:repeated |optional )?[\w.]+ (\w+) = \d+;")
RANGE = re.compile(r"[\[(].*, .*[\])]|\d+\.\.\d+.*|>= .*|finite|any")


def entry(message, field, comment):
    found = re.fullmatch(r"(.*[.?]) \[(.*)\]", comment)
    if not found:
        sys.exit(f"make_field_table.py: {message}.{field} has no brackets at the end of its comment")
    parts = found.group(2).split("; ")
    middle = parts[:-1]
    span = middle.pop() if middle and RANGE.fullmatch(middle[-1]) else ""
    unit = middle[0] if middle else ""
    shape = middle[1] if len(middle) > 1 else ""
    live = "true" if re.search(r"\bLive\b", found.group(1)) else "false"
    absent = "true" if parts[-1].startswith("absent") else "false"
    return f'FieldRow{{"{message}.{field}", "{unit}", "{shape}", "{span}", {live}, {absent}}},'


def entries(lines):
    message, comment = "", []
    for line in lines:
        start = re.match(r"message (\w+) {(})?", line)
        if start:
            message, comment = start.group(1), []
        elif line.strip().startswith("//"):
            comment.append(line.strip()[2:].strip())
            continue
        elif message and FIELD.match(line):
            yield entry(message, FIELD.match(line).group(1), " ".join(comment))
        if line.startswith("}") or (start and start.group(2)):
            message = ""
        comment = []


def main():
    out = []
    for name in sys.argv[2:]:
        with open(name, encoding="utf-8") as file:
            out += entries(file.read().splitlines())
    with open(sys.argv[1], "w", encoding="utf-8") as file:
        file.write("\n".join(out) + "\n")


main()
