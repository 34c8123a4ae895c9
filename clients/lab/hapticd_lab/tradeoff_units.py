"""Plays the units of a study, as many at once as asked for. Each leaves one file when it is done and nothing before, so that a run that was
killed goes on where it was, shards of a run can be put together, and nothing depends on who played what."""
from __future__ import annotations

import concurrent.futures
import json
import os
import pathlib
import shutil
import threading
import time
from typing import Any, Dict, List, Sequence

from hapticd_lab import oracle
from hapticd_lab.progress import Progress
from hapticd_lab.tradeoff_plan import BASELINES, Plan, Unit, read_plan

USUAL_COST_S = 6.0
"""What a unit of a whole study takes, about; only the time left that is told before the first is done comes from it."""


class BadStudy(ValueError):
    """A folder that is no part of this study, or lacks some."""


def shard_of(units: Sequence[Unit], shard: str) -> List[Unit]:
    """The units of shard K/N, K from 1: every N-th. BadStudy where that makes no sense."""
    try:
        number, count = (int(part) for part in shard.split("/"))
    except ValueError as error:
        raise BadStudy(f"--shard needs K/N, such as 1/4, not {shard}") from error
    if not 1 <= number <= count:
        raise BadStudy(f"--shard {shard}: K is from 1 to N")
    return list(units)[number - 1::count]


def claim(folder: pathlib.Path, plan: Plan) -> None:
    """Makes `folder` the plan's, or finds that it is. BadStudy where it is another's."""
    (folder / "units").mkdir(parents=True, exist_ok=True)
    path = folder / "plan.json"
    if not path.exists():
        _write(path, plan.text())
    if json.loads(path.read_text(encoding="utf-8"))["key"] != plan.key():
        raise BadStudy(f"{folder} holds another study: name another --output, or remove it")


def give_back(folder: pathlib.Path) -> None:
    """Undoes claim() where nothing was done since."""
    if not any((folder / "units").iterdir()):
        (folder / "units").rmdir()
        (folder / "plan.json").unlink()


def _write(path: pathlib.Path, text: str) -> None:
    """All of it or nothing, whatever happens meanwhile."""
    part = path.with_name(f".{path.name}.{os.getpid()}.{threading.get_ident()}")
    part.write_text(text, encoding="utf-8")
    part.replace(path)


def unit_path(folder: pathlib.Path, unit: Unit) -> pathlib.Path:
    """Where a unit's lines are when it is done."""
    return folder / "units" / f"{unit.name}.jsonl"


def play(unit: Unit, plan: Plan, folder: pathlib.Path) -> float:
    """Plays a unit; seconds it took."""
    begin = time.monotonic()
    arguments = ["measure", "--scene", unit.scene, "--seed", str(unit.seed), "--speed", f"{unit.speed:g}"]
    for name, text in plan.settings(unit.scene).items():
        arguments += ["--setting", f"{name}:{text}"]
    for name in BASELINES:
        arguments += ["--baseline", name]
    _write(unit_path(folder, unit), oracle.call(*arguments))
    return time.monotonic() - begin


def play_all(units: Sequence[Unit], plan: Plan, folder: pathlib.Path, jobs: int) -> None:
    """Plays those that are not done yet, scenes in turn: they differ in cost, and the time left is told from what was done."""
    left = sorted((unit for unit in units if not unit_path(folder, unit).exists()), key=lambda unit: (unit.seed, unit.speed))
    progress = Progress({unit.name: USUAL_COST_S for unit in left}, jobs)
    if not left:
        return
    progress.began("units")
    with concurrent.futures.ThreadPoolExecutor(jobs) as pool:
        running = {pool.submit(play, unit, plan, folder): unit for unit in left}
        try:
            for done in concurrent.futures.as_completed(running):
                progress.finished(running[done].name, "done", done.result(), {})
        except BaseException:
            pool.shutdown(wait=False, cancel_futures=True)
            raise
        finally:
            progress.close()


def plan_of_shards(shards: Sequence[pathlib.Path]) -> Plan:
    """What all of them are parts of. BadStudy where one is no output of a study, or of another one."""
    plans = []
    for shard in shards:
        try:
            plans.append(read_plan((shard / "plan.json").read_text(encoding="utf-8")))
        except OSError as error:
            raise BadStudy(f"{shard} is not an output of hapticd-lab tradeoff") from error
        except ValueError as error:
            raise BadStudy(f"{shard}: {error}") from error
        if plans[-1].key() != plans[0].key():
            raise BadStudy(f"{shard} holds another study than {shards[0]}")
    return plans[0]


def gather(shards: Sequence[pathlib.Path], folder: pathlib.Path) -> None:
    """Copies the units of shards into `folder`, which is their plan's."""
    for shard in shards:
        for path in sorted((shard / "units").glob("*.jsonl")):
            if not (folder / "units" / path.name).exists():
                shutil.copyfile(path, folder / "units" / path.name)


def missing(plan: Plan, folder: pathlib.Path) -> List[Unit]:
    """Units that are not done."""
    return [unit for unit in plan.units() if not unit_path(folder, unit).exists()]


def read_unit(folder: pathlib.Path, unit: Unit) -> Dict[str, Dict[str, Any]]:
    """Its measurements by setting. BadStudy where the file is damaged."""
    path = unit_path(folder, unit)
    try:
        lines = [json.loads(line) for line in path.read_text(encoding="utf-8").splitlines()]
        return {line["name"]: line for line in lines}
    except (ValueError, KeyError) as error:
        raise BadStudy(f"{path} is damaged: remove it, and run the study again") from error
