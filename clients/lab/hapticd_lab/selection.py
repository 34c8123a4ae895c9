"""Which figures are meant: all that modules in figures/ offer, and those chosen by id or group on the command line."""
from __future__ import annotations

import importlib
import pkgutil
import re
from typing import Dict, List, Sequence, Tuple

from hapticd_lab import figures
from hapticd_lab.figure import Spec


class UnknownFigure(ValueError):
    """An id that no figure and no group has."""


def order(figure_id: str) -> List[Tuple[int, str]]:
    """Sorts figures (F2 before F10, F15a before F15b), then sections (S), then tables (T)."""
    return [(int(number or 0), text) for number, text in re.findall(r"(\d+)|(\D+)", figure_id)]


def offered() -> List[Spec]:
    """Every figure, in the paper's order. ValueError where two modules offer the same id."""
    specs: List[Spec] = []
    for module in pkgutil.iter_modules(figures.__path__):
        specs += importlib.import_module(f"{figures.__name__}.{module.name}").SPECS
    ids = [spec.id for spec in specs]
    twice = sorted({each for each in ids if ids.count(each) > 1})
    if twice:
        raise ValueError(f"offered twice: {', '.join(twice)}")
    return sorted(specs, key=lambda spec: order(spec.id))


def groups(specs: Sequence[Spec]) -> Dict[str, List[str]]:
    """Groups by name: F15 of F15a, F15b..., wherever an id ends with a letter after a number."""
    found: Dict[str, List[str]] = {}
    for spec in specs:
        match = re.fullmatch(r"(.*\d)[a-z]", spec.id)
        if match:
            found.setdefault(match[1], []).append(spec.id)
    return found


def chosen(specs: Sequence[Spec], names: Sequence[str]) -> List[Spec]:
    """The specs of those ids and groups, in the paper's order, each once; capital letters do not matter. UnknownFigure names those
    that there are."""
    wanted = set()
    by_name = {spec.id.lower(): [spec.id] for spec in specs}
    for group, members in groups(specs).items():
        by_name.setdefault(group.lower(), members)
    for name in names:
        if name.lower() not in by_name:
            there_are = ", ".join([spec.id for spec in specs] + sorted(groups(specs), key=order))
            raise UnknownFigure(f"there is no figure {name}; there are {there_are}")
        wanted.update(by_name[name.lower()])
    return [spec for spec in specs if spec.id in wanted]
