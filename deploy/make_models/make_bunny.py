#!/usr/bin/python3
"""Writes the bunny of the npm package `bunny` as binary PLY: upright (y up), the middle of its bounding box at the origin, and of
the size of a thing held in the hand. Single precision; the same input gives the same bytes.

usage: make_bunny.py INDEX_JS OUTPUT
"""
import json
import re
import struct
import sys

DIAGONAL = 0.1  # of the bounding box, m


def array(text, name):
    """The nested array that is assigned to exports.NAME. Nothing of the file is run."""
    found = re.search(rf"exports\.{name}\s*=\s*(\[[-\d.eE+,\s\[\]]*\])", text)
    if not found:
        sys.exit(f"make_bunny.py: no exports.{name} in the file: is it bunny 1.0.1?")
    return json.loads(found.group(1))


def main():
    source, output = sys.argv[1:]
    with open(source, encoding="utf-8") as file:
        text = file.read()
    positions, cells = array(text, "positions"), array(text, "cells")
    low = [min(p[k] for p in positions) for k in range(3)]
    high = [max(p[k] for p in positions) for k in range(3)]
    scale = DIAGONAL / sum((b - a) ** 2 for a, b in zip(low, high)) ** 0.5
    header = (f"ply\nformat binary_little_endian 1.0\ncomment metres\nelement vertex {len(positions)}\n"
              "property float x\nproperty float y\nproperty float z\n"
              f"element face {len(cells)}\nproperty list uchar int vertex_indices\nend_header\n")
    with open(output, "wb") as file:
        file.write(header.encode())
        for p in positions:
            file.write(struct.pack("<3f", *((p[k] - (low[k] + high[k]) / 2) * scale for k in range(3))))
        for t in cells:
            file.write(struct.pack("<B3i", 3, *t))


main()
