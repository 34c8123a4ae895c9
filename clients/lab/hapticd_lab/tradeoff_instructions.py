"""Instructions that a tick takes at each level of quality, counted by callgrind: a cost that is the same on a busy machine and an idle one."""
from __future__ import annotations

import csv
import json
import pathlib
import re
import shutil
import subprocess
import tempfile
from typing import Dict, List, Tuple

from hapticd_lab import oracle
from hapticd_lab.tradeoff_plan import LEVELS, Plan
from hapticd_lab.tradeoff_units import BadStudy

Counts = Dict[Tuple[str, float], List[float]]
"""Mean instructions per tick of all levels, by scene and speed."""


def _part_number(path: pathlib.Path) -> int:
    return int(path.suffix[1:]) if path.suffix[1:].isdigit() else 0


def _totals(folder: pathlib.Path) -> List[int]:
    """Of callgrind's dumps, in order; what is left when the program ends is none of a setting's."""
    parts = [path for path in folder.iterdir() if path.name.count(".") == 2]
    found = [re.search(r"^totals: (\d+)", path.read_text(encoding="utf-8"), re.MULTILINE) for path in sorted(parts, key=_part_number)]
    return [int(each.group(1)) for each in found if each]


def _counted(scene: str, seed: int, speed: float) -> List[float]:
    with tempfile.TemporaryDirectory() as folder:
        command = ["valgrind", "--tool=callgrind", f"--callgrind-out-file={folder}/callgrind.out", "--toggle-collect=hapticd::Simulation::step*",
                   "--dump-after=hapticd::play_study*", oracle.find_program("hapticd-oracle"), "ticks", "--scene", scene, "--seed", str(seed),
                   "--speed", f"{speed:g}"]
        for name, text in LEVELS.items():
            command += ["--setting", f"{name}:{text}"]
        done = subprocess.run(command, capture_output=True, text=True, check=False)
        if done.returncode != 0:
            raise BadStudy(f"{' '.join(command[:2])} of {scene} ended with {done.returncode}: {done.stderr.strip()[-400:]}")
        ticks = [json.loads(line)["ticks"] for line in done.stdout.splitlines()]
        totals = _totals(pathlib.Path(folder))
        if len(totals) < len(ticks):
            raise BadStudy(f"callgrind found no {len(ticks)} plays in hapticd-oracle ticks: was it built without symbols?")
        return [total / count for total, count in zip(totals, ticks)]


def count(plan: Plan) -> Counts:
    """Of the plan's first gesture in each scene. BadStudy where valgrind is not there."""
    if shutil.which("valgrind") is None:
        raise BadStudy("--instructions wants valgrind: install it")
    return {(scene, speed): _counted(scene, plan.first_seed, speed) for scene in plan.scenes for speed in plan.speeds}


def write(counts: Counts, output: pathlib.Path) -> None:
    """instructions.csv: the same for the same programs on every machine."""
    with open(output / "instructions.csv", "w", newline="", encoding="utf-8") as file:
        writer = csv.writer(file, lineterminator="\n")
        writer.writerow(("scene", "speed_m_per_s", *LEVELS))
        writer.writerows([scene, f"{speed:g}", *(f"{each:.0f}" for each in own)] for (scene, speed), own in counts.items())
