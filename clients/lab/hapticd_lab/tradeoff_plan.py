"""What a study of speed against accuracy plays: units of work, each one seeded gesture in one scene at one speed, with every setting in it."""
from __future__ import annotations

import hashlib
import json
from dataclasses import dataclass
from typing import Dict, List, Sequence

SCENES = ("bunny_fine", "guqin", "cabin", "single_string", "strings_100")
"""Each with the finest trees that every build makes: many spheres on lines and bodies; a hand on strings and a body; a hand among pipes; one sphere on one string; on a hundred."""
FINEST_SCENE = "guqin_fine"
"""Played too where its trees have been made: levels, rungs and leaves alone, since it takes ten times as long as others."""
SPEEDS = (0.05, 0.5)
"""m/s: a probing and a fast hand."""
GESTURES = 20
QUICK_SCENES, QUICK_SPEEDS, QUICK_GESTURES = ("bunny", "cabin", "single_string"), (0.5,), 2
HELD_OUT = 100_000
"""Added to the seeds of gestures that no table is made from."""

BASELINES = ("paper", "penalty")
WITH_STRINGS = frozenset({"guqin", "guqin_coarse", "guqin_fine", "single_string", "strings_100", "five_fingers"})
COARSER = {"bunny": ("bunny_coarse",), "bunny_fine": ("bunny_coarse", "bunny"), "guqin": ("guqin_coarse",), "guqin_fine": ("guqin_coarse", "guqin")}
"""Scenes that differ from another by coarser leaves alone."""

LEVELS = {f"level {n}": f"level={n}" for n in range(5)}
KNOBS: Dict[str, Dict[str, str]] = {
    "sub-steps": {f"sub-steps {n}": f"sub_steps={n}" for n in (1, 2, 4, 8, 16, 24, 64)},
    "stop tolerance": {f"tolerance {um:g} um": f"stop_tolerance={um * 1e-6:g}" for um in (1000, 300, 100, 30, 10, 0.1, 0.01)},
    "margin": {f"margin {mm:g} mm": f"margin={mm * 1e-3:g}" for mm in (0.5, 1, 2, 5)},
    "rows": {f"rows {n}": f"max_rows={n}" for n in (8, 32, 256)},
    "rotation step": {f"rotation {mrad:g} mrad": f"rotation_step={mrad * 1e-3:g}" for mrad in (10, 50, 200)},
    "tree level of the tool": {f"tool level {n}": f"tool_level={n}" for n in (2, 3)},
    "tree level of bodies": {f"body level {n}": f"body_level={n}" for n in (2, 3)},
    "loop rate": {f"rate {hz} Hz": f"rate={hz}" for hz in (250, 500, 1000, 2000)},
}
STRING_KNOBS: Dict[str, Dict[str, str]] = {
    "string model": {"rigid string": "string=rigid", "static string": "string_level=static", "fundamental": "string_level=fundamental"},
    "modes": {f"modes {n}": f"string_level=modes,modes={n}" for n in (4, 8, 16, 32, 64)},
    "sub-steps of modes": {f"{n} modes {s} times a ms": f"string_level=modes,modes={n},wave_substeps={s}"
                           for n, s in ((8, 16), (16, 16), (16, 32), (64, 64))},
}
LADDER = {f"ladder {steps}/{um:g}": f"sub_steps={steps},stop_tolerance={um * 1e-6:g},judged=no"
          for um, counts in ((1000, (1, 2, 4, 8, 32)), (300, (2, 4, 8, 16, 32)), (100, (2, 4, 8, 16, 32)), (30, (2, 4, 8, 16, 32)),
                             (10, (2, 4, 8, 16, 24, 32)), (1, (2, 4, 8, 16, 24, 32)), (0.1, (16, 32, 64)), (0.01, (32, 64))) for steps in counts}
"""What levels of quality are chosen from: "ladder SUB-STEPS/TOLERANCE in um". Their ways are judged as those of levels."""


@dataclass(frozen=True)
class Unit:
    """One call of hapticd-oracle measure."""

    scene: str
    seed: int
    speed: float

    @property
    def name(self) -> str:
        """Of its file."""
        return f"{self.scene}-{self.seed}-{self.speed:g}"


@dataclass(frozen=True)
class Plan:
    """All of a study. Two plans with the same key give the same numbers."""

    scenes: Sequence[str]
    gestures: int
    speeds: Sequence[float]
    quick: bool = False
    first_seed: int = 1
    ladder_only: bool = False

    def units(self) -> List[Unit]:
        """In the order in which they are told."""
        seeds = range(self.first_seed, self.first_seed + self.gestures)
        return [Unit(scene, seed, speed) for scene in self.scenes for seed in seeds for speed in self.speeds]

    def knobs(self, scene: str) -> Dict[str, Dict[str, str]]:
        """Settings of each knob in a scene, by knob and name."""
        found = {"level": dict(LEVELS)}
        if not self.ladder_only and scene != FINEST_SCENE:
            found.update({knob: _few(values) if self.quick else dict(values) for knob, values in KNOBS.items()})
            if scene in WITH_STRINGS:
                found.update({knob: _few(values) if self.quick else dict(values) for knob, values in STRING_KNOBS.items()})
        if scene in COARSER:
            found["leaves"] = {f"{other}, level {n}": f"scene={other},level={n}" for other in COARSER[scene] for n in (0, 3, 4)}
        if not self.quick:
            found["ladder"] = dict(LADDER)
        return found

    def settings(self, scene: str) -> Dict[str, str]:
        """All settings of a scene by name."""
        return {"usual": ""} | {name: text for values in self.knobs(scene).values() for name, text in values.items()}

    def key(self) -> str:
        """Tells plans apart."""
        whole = [[unit.name for unit in self.units()], {scene: self.settings(scene) for scene in self.scenes}, BASELINES]
        return hashlib.sha256(json.dumps(whole).encode()).hexdigest()[:16]

    def text(self) -> str:
        """As plan.json holds it."""
        return json.dumps({"key": self.key(), "scenes": list(self.scenes), "gestures": self.gestures, "speeds": list(self.speeds),
                           "quick": self.quick, "first_seed": self.first_seed, "ladder_only": self.ladder_only}, indent=1) + "\n"


def _few(values: Dict[str, str]) -> Dict[str, str]:
    """The first and the last."""
    names = list(values)
    return {name: values[name] for name in dict.fromkeys((names[0], names[-1]))}


def read_plan(text: str) -> Plan:
    """Of plan.json. ValueError where it is none, or of another version."""
    try:
        values = json.loads(text)
        key = values.pop("key")
        plan = Plan(**values)
        if plan.key() == key:
            return plan
    except (AttributeError, KeyError, TypeError, ValueError):
        pass
    raise ValueError("its plan is of another version of hapticd-lab")
