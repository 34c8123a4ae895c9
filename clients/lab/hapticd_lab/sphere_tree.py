"""Reads sphere-trees and meshes as scenes name them, by the description of their files alone (server/scene_io/sphere_tree_file.h), and
looks into them without the code that made them. Metres."""
from __future__ import annotations

import hashlib
import pathlib
import struct
from dataclasses import dataclass
from typing import List, Tuple

import numpy

from hapticd_lab.oracle import find_program

MAGIC = b"HDTREE\r\n"
HASH_BYTES = 32


def model_path(name: str) -> pathlib.Path:
    """A model file by the name that scenes use, where the programs look for it."""
    return pathlib.Path(find_program("hapticd")).resolve().parent.parent / "share" / "hapticd" / "models" / name


@dataclass
class Tree:
    """`leaves`: n x 4, x y z r. `nodes`: of each node its slots; a slot is (bound or None, node or leaf that it leads to)."""

    source_name: str
    outer_m: float
    leaves: numpy.ndarray
    nodes: List[List[Tuple[numpy.ndarray | None, int]]]
    levels: List[Tuple[int, float, float]]
    """Of each level: spheres, bound of how far they are outside, mean of it."""

    def level(self, depth: int) -> numpy.ndarray:
        """Spheres (n x 4) that stand for the shape where a search stops `depth` levels below the root, from 1."""
        spheres, front = [], [0]
        for at in range(depth):
            deeper = []
            for node in front:
                for bound, target in self.nodes[node]:
                    if bound is None:
                        spheres.append(self.leaves[target])
                    elif at == depth - 1:
                        spheres.append(bound)
                    else:
                        deeper.append(target)
            front = deeper
        return numpy.array(spheres)

    def leaves_below(self) -> List[List[int]]:
        """Of every node the leaves below it. Children have larger numbers."""
        below: List[List[int]] = [[] for _ in self.nodes]
        for node in range(len(self.nodes) - 1, -1, -1):
            for bound, target in self.nodes[node]:
                below[node] += [target] if bound is None else below[target]
        return below

    def worst_excess_m(self) -> float:
        """How far a leaf sticks out of a bound above it, at worst; negative: inside."""
        below, worst = self.leaves_below(), -numpy.inf
        for slots in self.nodes:
            for bound, target in slots:
                if bound is not None:
                    leaves = self.leaves[below[target]]
                    reach = numpy.linalg.norm(leaves[:, :3] - bound[:3], axis=1) + leaves[:, 3] - bound[3]
                    worst = max(worst, float(reach.max()))
        return worst


def read_tree(path: pathlib.Path) -> Tree:
    """A tree file. ValueError when it is none, or not what was written."""
    data = path.read_bytes()
    if data[:len(MAGIC)] != MAGIC or hashlib.blake2b(data[:-HASH_BYTES], digest_size=HASH_BYTES).digest() != data[-HASH_BYTES:]:
        raise ValueError(f"{path}: not a tree file, or damaged")
    at = len(MAGIC)

    def take(layout: str) -> Tuple:
        nonlocal at
        values = struct.unpack_from("<" + layout, data, at)
        at += struct.calcsize("<" + layout)
        return values

    _, leaf_count, node_count, level_count, name_bytes = take("5I")
    at += HASH_BYTES
    outer, *_ = take("6d")
    levels = [take("Idd") for _ in range(level_count)]
    name = data[at:at + name_bytes].decode()
    at += name_bytes
    leaves = numpy.frombuffer(data, "<f8", 4 * leaf_count, at).reshape(-1, 4)
    at += 32 * leaf_count
    nodes, inner_slots = [], 0
    for _ in range(node_count):
        used, inner = take("BB")
        slots = []
        for bit in range(8):
            if inner >> bit & 1:
                inner_slots += 1
                slots.append((numpy.array(take("4d")), inner_slots))
            elif used >> bit & 1:
                slots.append((None, take("I")[0]))
        nodes.append(slots)
    return Tree(name, outer, leaves, nodes, levels)


def read_mesh(path: pathlib.Path) -> Tuple[numpy.ndarray, numpy.ndarray]:
    """Corners (n x 3) and triangles (m x 3) of a PLY file as hapticd-model writes it: binary, triangles alone."""
    data = path.read_bytes()
    head, _, body = data.partition(b"end_header\n")
    counts = {words[1]: int(words[2]) for words in (line.split() for line in head.decode().splitlines()) if words[:1] == ["element"]}
    if b"format binary_little_endian" not in head or b"property float x" not in head:
        raise ValueError(f"{path}: not a PLY file as hapticd-model writes it")
    corners = numpy.frombuffer(body, "<f4", 3 * counts["vertex"]).reshape(-1, 3)
    faces = numpy.frombuffer(body, numpy.dtype([("count", "u1"), ("corner", "<i4", 3)]), counts["face"], corners.nbytes)
    return corners.astype(float), faces["corner"]


def open_edges(triangles: numpy.ndarray) -> int:
    """Edges that do not lie between exactly two triangles which run along it in opposite ways; 0 for a closed mesh."""
    edges = numpy.concatenate([triangles[:, [0, 1]], triangles[:, [1, 2]], triangles[:, [2, 0]]]).astype(numpy.int64)
    size = int(triangles.max()) + 1
    forth, count = numpy.unique(edges[:, 0] * size + edges[:, 1], return_counts=True)
    back = numpy.unique(edges[:, 1] * size + edges[:, 0])
    return int((count != 1).sum() + len(numpy.setxor1d(forth, back)))
