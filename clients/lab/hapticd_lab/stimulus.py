"""Strings to be pressed, one after the other, by a real hapticd in lockstep. Every change of string goes the same way, a scene of its own: R is
no live parameter, and T and E must not be told from it by how they change."""
from __future__ import annotations

import pathlib
from typing import Any, Callable, Optional

import numpy
from google.protobuf import text_format

import hapticd
from hapticd.v1 import scene_pb2
from hapticd_lab import player
from hapticd_lab.states import build_trace
from hapticd_lab.string_law import PARAMETERS, StringValues, forget_own_law
from hapticd_lab.trace import Trace

SCENE = "single_string"
TIP_RADIUS_M = 0.005
FREE_M = 0.002
"""Above the string at the beginning and at the end of a press."""
PRESS_M_PER_S = 0.05
HOLD_S = 0.2


def press_path(string: StringValues, depth_m: float, place: float, speed_m_per_s: float = PRESS_M_PER_S, hold_s: float = HOLD_S) -> numpy.ndarray:
    """Poses of the finger: down on the string from above at a place lambda, held at the depth, and up the same way; a row each ms."""
    touch = TIP_RADIUS_M + string.radius_m
    down = numpy.append(numpy.arange(touch + FREE_M, touch - depth_m, -speed_m_per_s * 1e-3), touch - depth_m)
    y = numpy.concatenate((down, numpy.full(round(hold_s * 1e3), touch - depth_m), down[::-1]))
    poses = numpy.zeros((len(y), 7))
    poses[:, 0], poses[:, 1], poses[:, 3] = (place - 0.5) * string.length_m, y, 1.0
    return poses


def string_scene(plain: scene_pb2.Scene, string: StringValues, sounding: bool = False,
                 change: Optional[Callable[[scene_pb2.Scene], None]] = None) -> str:
    """The plain scene with that string, as text. The tuning stays; `sounding` False: nothing is heard, which would give the answer."""
    scene = scene_pb2.Scene()
    scene.CopyFrom(plain)
    one = scene.strings[0]
    forget_own_law(one)
    for field in PARAMETERS.values():
        setattr(one, field, getattr(string, field))
    one.p_wa_m[:], one.p_wb_m[:] = [-0.5 * string.length_m, 0.0, 0.0], [0.5 * string.length_m, 0.0, 0.0]
    if not sounding:
        scene.ClearField("tones")
    if change is not None:
        change(scene)
    return text_format.MessageToString(scene)


class Bench:
    """A hapticd with a scripted finger, until the end of the block."""

    def __init__(self) -> None:
        self._daemon = player.Daemon("--clock", "virtual", "--device", "scripted", "--scene", "wall")
        self.session: Any = None
        self._plain = scene_pb2.Scene()

    def __enter__(self) -> "Bench":
        self._daemon.__enter__()
        try:
            self.session = hapticd.Session(self._daemon.address)
            self.session.acquire("hapticd-lab")
            self._plain.CopyFrom(self.session.load_scene(SCENE, preset="PAPER").scene)
        except BaseException:
            self.__exit__()
            raise
        return self

    def __exit__(self, *_: object) -> None:
        if self.session is not None:
            self.session.close()
        self._daemon.__exit__()

    def present(self, string: StringValues, poses: numpy.ndarray, sounding: bool = False,
                change: Optional[Callable[[scene_pb2.Scene], None]] = None) -> Trace:
        """A string, by a change of scene, and the finger along the poses; the trace begins with the first of them."""
        self.bring(string, sounding, change)
        return self.follow(poses)

    def bring(self, string: StringValues, sounding: bool = False, change: Optional[Callable[[scene_pb2.Scene], None]] = None) -> None:
        """A string at rest, by a change of scene."""
        self.session.load_scene(string_scene(self._plain, string, sounding, change))

    def follow(self, poses: numpy.ndarray) -> Trace:
        """The finger along the poses in the scene that is loaded."""
        self.session.subscribe(1, player.SECTIONS, player.CONTACTS)
        list(self.session.events(timeout=0))
        self.session.run(poses=[poses[0]] * int(player.ENGAGE_S * 1e3))
        states = self.session.run(poses=poses).states
        self.session.run(steps=1)
        return build_trace(self.session.scene, states, list(self.session.events(timeout=0)))


def peak_n(trace: Trace) -> float:
    """Largest force on the finger."""
    return float(numpy.linalg.norm(trace.force_n, axis=1).max())


def write(trace: Trace, path: pathlib.Path) -> None:
    """The raw ticks; the file is whole or not there."""
    part = path.with_suffix(".part")
    trace.write_csv(part)
    part.replace(path)
