#!/usr/bin/python3
"""Writes models.md from the reports that measure_models collects, one JSON object a line.

usage: models_page.py REPORTS
"""
import json
import os
import re
import sys

INTRO = """# Sphere-trees of the models

What is touched is not a mesh but spheres that cover it. `hapticd-model build` packs them: no point of a sphere is further outside
the mesh than the bound asked for, and none of the surface stays uncovered. A finer bound takes more spheres, and a tick more time;
`hapticd-model explain SCENE` tells how much.

Written by `deploy/docs/measure_models` on {machine} at a load of {load:.1f}: with other work at the same
time, builds take longer. Distances are those of points on the surface of all spheres to the mesh, about 200 000 points each, exact;
*uncovered* is the share of as many points of the mesh outside all spheres; *scallop* is the difference of the 99th and the 1st
percentile. *Over exhaustive* is the time of the build over that in which one thread measures the same points against every
triangle.
"""

ANCHOR = """
## Against a published packing

The bunny, in % of the diagonal of its bounding box. *Published* is the program of G. Bradshaw and C. O'Sullivan, "Adaptive medial-axis
approximation for sphere-tree construction", ACM Transactions on Graphics 2004, run on the same mesh and judged in the same way.

| spheres | outside max | mean | uncovered | build | published: spheres | max | mean | uncovered | build |
|---:|---:|---:|---:|---:|---:|---:|---:|---:|---:|
"""

PUBLISHED = {"8": ("8", "10.56", "5.03", "0 %", "35 s"), "64": ("64", "3.65", "1.38", "0.14 %", "266 s"),
             "500": ("490", "2.0", "0.34", "1.58 %", "266 s")}

HEAD = """| bound asked | spheres | levels | bound reached | outside max | mean | p99 | uncovered | scallop | build | over exhaustive | memory |
|---:|---:|---:|---:|---:|---:|---:|---:|---:|---:|---:|---:|
"""

BUNNY = "deploy/models/bunny.ply"
PICTURE = """
Mesh and spheres as a picture: `hapticd-model build {mesh} {option} -o {name}.tree --picture {name}.png`.
"""


def machine():
    with open("/proc/cpuinfo", encoding="utf-8") as file:
        name = re.search(r"model name\s*: (.*)", file.read())
    return f"{os.cpu_count()} cores of {name.group(1) if name else 'an unknown processor'}"


def micrometres(metres):
    return f"{1e6 * metres:.0f} um"


def row(r):
    outside = r["outside"]
    return (f"| {r['asked']} | {r['spheres']} | {len(r['levels'])} | {micrometres(r['outer'])} | {micrometres(outside['max'])} "
            f"| {micrometres(outside['mean'])} | {micrometres(outside['p99'])} | {100 * r['uncovered']:g} % "
            f"| {micrometres(r['scallop'])} | {r['seconds']:.1f} s | {r['seconds'] / r['exhaustive_seconds']:.2f} "
            f"| {r['memory_bytes'] / 1000:.0f} kB |\n")


def levels(r):
    text = f"\nLevels of {r['model']} at {r['asked']}: spheres, bound and mean distance outside when a query stops there.\n\n"
    text += "| level | spheres | bound | mean |\n|---:|---:|---:|---:|\n"
    for k, level in enumerate(r["levels"], 1):
        text += f"| {k} | {level['spheres']} | {micrometres(level['outer'])} | {micrometres(level['mean'])} |\n"
    return text


def main():
    with open(sys.argv[1], encoding="utf-8") as file:
        reports = [json.loads(line) for line in file]
    out = INTRO.format(machine=machine(), load=os.getloadavg()[2])
    for name, mesh, title in (("bunny", BUNNY, "Bunny, 100 mm"), ("guqin_body", "model:guqin_body", "Body of the Guqin, 1220 mm"),
                              ("hand", "model:hand", "Hand, 180 mm")):
        of_model = [r for r in reports if r["model"] == name and r["asked"].endswith("um")]
        out += f"\n## {title}\n\n{HEAD}" + "".join(row(r) for r in of_model) + levels(of_model[-1])
        out += PICTURE.format(mesh=mesh, option="--error 1000um", name=name)
    out += ANCHOR
    for r in reports:
        if r["asked"] not in PUBLISHED:
            continue
        share = 100 / r["diagonal"]
        out += (f"| {r['spheres']} | {share * r['outside']['max']:.2f} | {share * r['outside']['mean']:.2f} | {100 * r['uncovered']:g} % "
                f"| {r['seconds']:.0f} s | " + " | ".join(PUBLISHED[r["asked"]]) + " |\n")
    out += PICTURE.format(mesh=BUNNY, option="--leaves 64", name="bunny")
    sys.stdout.write(out)


main()
