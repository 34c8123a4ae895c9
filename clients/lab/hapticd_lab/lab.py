"""The lab in which one figure is made: its folder, and what plays in it."""
from __future__ import annotations

import pathlib
import tempfile
from typing import Any, Callable, List, Optional, Sequence, TypeVar

import numpy
from google.protobuf import text_format

import hapticd
from hapticd.v1 import device_profile_pb2, gesture_pb2, scene_pb2
from hapticd_lab import oracle, player
from hapticd_lab.judgement import Judgement, judge
from hapticd_lab.player import Hand, Setup
from hapticd_lab.trace import Trace

T = TypeVar("T")
FRICTION = 0.3
"""Coefficient of the finger on every string in the second column of all figures: dry skin on metal, stated once."""
MODES = 32
"""Modes of every string there."""
REFERENCE_SUBSTEPS = 400
REFERENCE_ROTATION_RAD = 0.004
REFERENCE_STOP_M = 1e-10


def as_reference(scene: scene_pb2.Scene) -> None:
    """The scene as exactly as it can be computed: what errors are measured against."""
    scene.solver.max_substeps = REFERENCE_SUBSTEPS
    scene.solver.max_rotation_rad = REFERENCE_ROTATION_RAD
    scene.solver.stop_step_m = REFERENCE_STOP_M


def with_friction_and_modes(scene: scene_pb2.Scene) -> None:
    """Beyond the paper: yielding strings that hold the finger, and ring with all their modes."""
    scene.friction.coefficient = FRICTION
    for string in scene.strings:
        string.friction_coefficient = FRICTION
    if scene.HasField("vibration"):
        scene.wave.modes = MODES


def beyond(scene: str) -> Setup:
    """The second column of every figure with strings."""
    return Setup(scene, "DEFLECTING", with_friction_and_modes)


class Lab:
    """What a figure is made with. `folder` is the figure's own; recordings that nobody asked for are kept in it only while it is made.
    `variations`: how many of each kind it goes through; None: all."""

    def __init__(self, folder: pathlib.Path, variations: Optional[int] = None) -> None:
        self.folder = folder
        self.variations = variations
        self._scratch = tempfile.TemporaryDirectory(prefix="hapticd-lab-")

    def __enter__(self) -> "Lab":
        return self

    def __exit__(self, *_: object) -> None:
        self._scratch.cleanup()

    def some(self, kind: Sequence[T]) -> List[T]:
        """Of the motions, speeds or hands that a figure goes through, as many as asked for: the first, the last, and others between."""
        count = len(kind) if self.variations is None else min(self.variations, len(kind))
        return [kind[place * (len(kind) - 1) // max(count - 1, 1)] for place in range(count)]

    def recording(self, name: str) -> pathlib.Path:
        """Where a recording lies until the figure is made."""
        return pathlib.Path(self._scratch.name) / f"{name}.mcap"

    def gesture(self, name: str) -> gesture_pb2.Gesture:
        """An installed gesture, as data."""
        return text_format.Parse(oracle.call("gesture", name), gesture_pb2.Gesture())

    def poses(self, gesture: str | gesture_pb2.Gesture, scene: str) -> numpy.ndarray:
        """X_DH along a gesture, installed or as data, a row each ms."""
        if isinstance(gesture, str):
            return oracle.poses(gesture, scene)
        path = pathlib.Path(self._scratch.name) / f"{gesture.name}.textproto"
        path.write_text(text_format.MessageToString(gesture))
        return oracle.poses(path, scene)

    def profile(self, name: str, change: Callable[[device_profile_pb2.DeviceProfile], None]) -> str:
        """The simulated device of every session, changed, as a file."""
        path = pathlib.Path(self._scratch.name) / f"{name}.textproto"
        if not path.exists():
            with player.Daemon("--clock", "virtual", "--scene", "wall") as daemon, hapticd.Session(daemon.address) as session:
                profile = session.devices()[0].profile
            profile.name = name
            change(profile)
            path.write_text(text_format.MessageToString(profile))
        return str(path)

    def play(self, setup: Setup, poses: numpy.ndarray, name: Optional[str] = None, timed: bool = False) -> Trace:
        """The scripted device along the poses. `name`: recorded under it, for judge(). `timed`: what ticks cost is measured anew on the
        real clock, which takes as long as the motion."""
        trace = player.play_path(setup, poses, self.recording(name) if name else None)
        trace.cpu_us = player.tick_costs_us(setup, poses) if timed else numpy.full(len(trace), numpy.nan)
        return trace

    def judge(self, name: str, trace: Trace) -> Judgement:
        """What the oracle, which knows no collision query, says of the recording of that name."""
        return judge(self.recording(name), trace)

    def play_hand(self, setup: Setup, gesture: gesture_pb2.Gesture, hand: Hand) -> Trace:
        """A simulated hand along the gesture."""
        return player.play_hand(setup, gesture, hand)

    def keep(self, name: str) -> pathlib.Path:
        """Moves the recording of that name into the figure's folder."""
        kept: Any = self.folder / f"{name}.mcap"
        return self.recording(name).replace(kept)
