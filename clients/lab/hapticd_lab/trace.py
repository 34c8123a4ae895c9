"""A session as columns of numbers, a row for each tick: what figures are plotted from and claims are measured on."""
from __future__ import annotations

import csv
import pathlib
from dataclasses import dataclass, field
from typing import Any, Dict, List

import numpy

AXES = ("x", "y", "z")


@dataclass
class Trace:
    """n ticks of one tool. Wrenches are F_H_W, rendered; torque about the origin of H."""

    tick: numpy.ndarray  # n
    t_s: numpy.ndarray  # n, from 0
    force_n: numpy.ndarray  # n x 3
    torque_n_m: numpy.ndarray  # n x 3
    unlimited_force_n: numpy.ndarray  # n x 3, before the safety stage
    cpu_us: numpy.ndarray  # n, thread CPU time of the tick
    p_wh_m: numpy.ndarray  # n x 3
    q_wh: numpy.ndarray  # n x 4, w x y z
    p_wg_m: numpy.ndarray  # n x 3
    q_wg: numpy.ndarray  # n x 4
    gap_m: numpy.ndarray  # n, smallest gap to anything, up to the margin
    substeps: numpy.ndarray  # n, linearisations
    sphere_tests: numpy.ndarray  # n
    port_j: numpy.ndarray  # n, net energy given to the hand so far
    stiffness_scale: numpy.ndarray  # n, factor of the stiffness clamp
    flags: List[frozenset]  # n, names of ToolFlags
    object_force_n: Dict[str, numpy.ndarray] = field(default_factory=dict)  # n x 3 by object that was ever in contact
    regions: Dict[str, numpy.ndarray] = field(default_factory=dict)  # n, separate regions that bear force
    region_force_n: Dict[str, numpy.ndarray] = field(default_factory=dict)  # n, normal forces of the strongest region together
    contact_m: Dict[str, numpy.ndarray] = field(default_factory=dict)  # n x 3, middle of the contacts that bear force
    deflection_m: Dict[str, numpy.ndarray] = field(default_factory=dict)  # n x 3 by string that was ever awake
    radius_m: Dict[str, numpy.ndarray] = field(default_factory=dict)  # n, as drawn
    string_phase: Dict[str, numpy.ndarray] = field(default_factory=dict)  # n, StringPhase; 0 asleep
    events: List[Any] = field(default_factory=list)  # hapticd.Event that carry an instant, in order
    began_s: float = 0.0  # instant of the first row by the daemon's clock
    kt_n_per_m: float = 1000.0  # coupling of the tool, before the stiffness clamp
    length_m: float = 0.032  # that makes kr = kt l^2
    contact_stiffness_n_per_m: float = 1000.0  # kc, the largest any string has in contact
    strings: List[Any] = field(default_factory=list)  # scene.String, in order

    def __len__(self) -> int:
        return len(self.tick)

    def touched(self, name: str) -> numpy.ndarray:
        """n, True where the object bears force."""
        force = self.object_force_n.get(name)
        return numpy.zeros(len(self), bool) if force is None else numpy.linalg.norm(force, axis=1) > 0.0

    def write_csv(self, path: pathlib.Path) -> None:
        """One row a tick, the header names quantity, axis and unit: R's read.csv and pandas read it directly."""
        columns = {"tick": self.tick, "t_s": self.t_s}
        for name, table in (("force", self.force_n), ("torque", self.torque_n_m), ("p_wh", self.p_wh_m), ("p_wg", self.p_wg_m)):
            unit = {"force": "n", "torque": "n_m"}.get(name, "m")
            columns.update({f"{name}_{axis}_{unit}": table[:, i] for i, axis in enumerate(AXES)})
        for name, table in (("q_wh", self.q_wh), ("q_wg", self.q_wg)):
            columns.update({f"{name}_{part}": table[:, i] for i, part in enumerate("wxyz")})
        columns.update({"gap_m": self.gap_m, "cpu_us": self.cpu_us, "substeps": self.substeps, "sphere_tests": self.sphere_tests,
                        "port_j": self.port_j, "stiffness_scale": self.stiffness_scale})
        for name, force in sorted(self.object_force_n.items()):
            columns.update({f"force_of_{name}_{axis}_n": force[:, i] for i, axis in enumerate(AXES)})
            columns[f"regions_of_{name}"] = self.regions[name]
        with open(path, "w", newline="") as file:
            rows = csv.writer(file)
            rows.writerow(columns)
            rows.writerows(zip(*([f"{value:.9g}" for value in column] for column in columns.values())))
