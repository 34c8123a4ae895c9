"""Eq. 10-12 in closed form: the force of a string pressed sideways, and how it changes with tension T, Young's modulus E and radius R.
Written from the equations, independently of the daemon: what it renders is held against this. SI; arrays allowed."""
from __future__ import annotations

from dataclasses import dataclass, replace
from typing import Any, Optional

import numpy

from hapticd.v1 import scene_pb2

PARAMETERS = {"T": "tension_n", "E": "youngs_modulus_pa", "R": "radius_m"}
"""Symbol to field, of StringValues and of the scene's strings alike."""


@dataclass(frozen=True)
class StringValues:
    """A string; the paper's reference as defaults, with the length of the installed Guqin."""

    tension_n: float = 30.0
    youngs_modulus_pa: float = 1.9e11
    radius_m: float = 3.4e-4
    length_m: float = 1.1
    own_axial_stiffness_n: Optional[float] = None
    """E A of a string that is not solid, such as a wound one; E has no effect then."""

    @property
    def axial_stiffness_n(self) -> float:
        """E A, the only way E enters, and R but for where contact begins."""
        if self.own_axial_stiffness_n is not None:
            return self.own_axial_stiffness_n
        return self.youngs_modulus_pa * numpy.pi * self.radius_m ** 2

    def raised(self, parameter: str, increment: float) -> "StringValues":
        """With T, E or R raised by a share."""
        field = PARAMETERS[parameter]
        return replace(self, **{field: getattr(self, field) * (1.0 + increment)})


def values_of(string: scene_pb2.String) -> StringValues:
    """What a scene, its defaults filled in, says of a string."""
    own = string.axial_stiffness_n if string.HasField("axial_stiffness_n") else None
    length_m = float(numpy.linalg.norm(numpy.subtract(string.p_wb_m, string.p_wa_m)))
    return StringValues(string.tension_n, string.youngs_modulus_pa, string.radius_m, length_m, own)


def forget_own_law(string: scene_pb2.String) -> None:
    """Lets T, E and R alone decide what it takes to press the string, and keeps its pitch whatever they are."""
    for field in ("axial_stiffness_n", "linear_density_kg_per_m", "tuning"):
        string.ClearField(field)


def shape(deflection_m: Any, place: Any, length_m: float) -> tuple:
    """(sum of the sines, strain): force = (T + E A strain) sines. `place`: lambda, 0 to 1. No differences of nearly equal numbers."""
    delta = numpy.asarray(deflection_m, float)
    near, far = numpy.asarray(place, float) * length_m, (1.0 - numpy.asarray(place, float)) * length_m
    first, second = numpy.hypot(near, delta), numpy.hypot(far, delta)
    extension = delta ** 2 / (first + near) + delta ** 2 / (second + far)
    return delta / first + delta / second, extension / length_m


def force_n(string: StringValues, deflection_m: Any, place: Any = 0.5) -> Any:
    """|F_r| at a deflection and place lambda."""
    sines, strain = shape(deflection_m, place, string.length_m)
    return (string.tension_n + string.axial_stiffness_n * strain) * sines


def change(string: StringValues, parameter: str, increment: float, deflection_m: float, place: float) -> float:
    """Force of the raised string over that of the reference at the same deflection, less 1."""
    return float(force_n(string.raised(parameter, increment), deflection_m, place) / force_n(string, deflection_m, place) - 1.0)
