"""Plays a real hapticd for the lab: starts it, gives it a scene and a motion through the protocol, and returns what it said as a Trace. With
the virtual clock in lockstep, so that the same motion gives the same bits on every machine; what a tick costs is measured on the real one."""
from __future__ import annotations

import os
import pathlib
import shutil
import signal
import socket
import subprocess
import tempfile
from dataclasses import dataclass
from typing import Any, Callable, List, Optional, Sequence, Tuple

import numpy
from google.protobuf import text_format

import hapticd
from hapticd.v1 import config_pb2, gesture_pb2, scene_pb2
from hapticd_lab import oracle
from hapticd_lab.states import build_trace
from hapticd_lab.tick_costs import TickCosts
from hapticd_lab.trace import Trace

SECTIONS = ("TOOLS", "DEVICES", "CONTACTS", "STRINGS", "TIMING", "ENERGY", "QUALITY", "STIFFNESS", "GESTURES")
CONTACTS = 64
"""Contacts listed of a tick, at most."""
START_TIMEOUT_S = 60.0
ENGAGE_S = 0.3
"""The first pose is held so long before a motion begins: force comes on within 200 ms."""
LONGEST_GESTURE_S = 600.0
EXACT = ("--quality", "4", "--budget-us", "0")
"""Of every session: the most exact, and no tick cut short, so that what figures show is the model, not how far it was computed."""


class DaemonError(RuntimeError):
    """hapticd does not start; the text is what it said."""


@dataclass(frozen=True)
class Setup:
    """What is played. `preset`: "PAPER" or "DEFLECTING"; `change`: alters the scene, with every default filled in, before it is loaded."""

    scene: str
    preset: str = "PAPER"
    change: Optional[Callable[[scene_pb2.Scene], None]] = None
    tool_id: int = 0


@dataclass(frozen=True)
class Hand:
    """The simulated device behind a gesture. `profile`: a device profile by name or file."""

    arm: str = "LIGHT"
    profile: str = "premium_3_0_6dof"
    seed: int = 1


class Daemon:
    """A hapticd of its own on a free port of loopback, until the end of the block."""

    def __init__(self, *options: str, program: Optional[str] = None) -> None:
        with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as probe:
            probe.bind(("127.0.0.1", 0))
            self.address = f"127.0.0.1:{probe.getsockname()[1]}"
        self._state = tempfile.TemporaryDirectory(prefix="hapticd-lab-")
        self._recordings: List[Tuple[str, pathlib.Path]] = []  # where each is, and where it goes
        self._process = subprocess.Popen([program or oracle.find_program("hapticd"), "--listen", self.address, *EXACT, *options],
                                         stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True,
                                         env=dict(os.environ, XDG_STATE_HOME=self._state.name))

    def __enter__(self) -> "Daemon":
        said = []
        for line in self._process.stdout:
            said.append(line)
            if "listening on" in line:
                return self
        self.__exit__()
        raise DaemonError("hapticd does not start:\n" + "".join(said))

    def record(self, session: hapticd.Session, recording: pathlib.Path) -> None:
        """Records from now on; the file is there after the block."""
        self._recordings.append((session.record("START"), recording))

    def __exit__(self, *_: object) -> None:
        if self._process.poll() is None:
            self._process.send_signal(signal.SIGTERM)
            try:
                self._process.communicate(timeout=START_TIMEOUT_S)
            except subprocess.TimeoutExpired:
                self._process.kill()
        self._process.stdout.close()
        self._process.wait()
        for written, wanted in self._recordings:
            shutil.move(written, wanted)
        self._state.cleanup()


def load(session: hapticd.Session, setup: Setup) -> None:
    """Loads the scene of the setup."""
    session.load_scene(setup.scene, preset=setup.preset)
    if setup.change is not None:
        scene = scene_pb2.Scene()
        scene.CopyFrom(session.scene.scene)
        setup.change(scene)
        session.load_scene(text_format.MessageToString(scene))


def play_path(setup: Setup, poses: numpy.ndarray, recording: Optional[pathlib.Path] = None) -> Trace:
    """The scripted device follows poses X_DH exactly, a row of 7 each ms, in lockstep; the first is held until force is on. The trace begins
    with the first row. `recording`: where the session is recorded to, for the oracle."""
    with Daemon("--clock", "virtual", "--device", "scripted", "--scene", "wall") as daemon:
        with hapticd.Session(daemon.address) as session:
            session.acquire("hapticd-lab")
            load(session, setup)
            session.subscribe(1, SECTIONS, CONTACTS)
            if recording is not None:
                daemon.record(session, recording)
            held = int(ENGAGE_S * 1e3)
            session.run(poses=[poses[0]] * held, tool_id=setup.tool_id)
            states = session.run(poses=poses, tool_id=setup.tool_id).states
            session.run(steps=1)
            return build_trace(session.scene, states, list(session.events(timeout=0)), setup.tool_id)


def play_hand(setup: Setup, gesture: gesture_pb2.Gesture, hand: Hand, recording: Optional[pathlib.Path] = None) -> Trace:
    """A simulated hand on a simulated device follows the gesture, in lockstep, until the gesture has ended; the trace begins with the
    gesture's own first way-point, whose approach it leaves out. `recording` as in play_path."""
    with tempfile.TemporaryDirectory(prefix="hapticd-lab-") as folder:
        config = config_pb2.Config(clock=config_pb2.CLOCK_MODE_VIRTUAL, seed=hand.seed, scene="wall")
        config.device.add(tool_id=setup.tool_id, source="simulated", profile=hand.profile)
        path = pathlib.Path(folder) / "config.textproto"
        path.write_text(text_format.MessageToString(config))
        with Daemon("--config", str(path)) as daemon, hapticd.Session(daemon.address) as session:
            session.acquire("hapticd-lab")
            load(session, setup)
            session.play_gesture(None)  # a loaded scene begins with the one that the daemon was started with
            session.subscribe(1, SECTIONS, CONTACTS)
            if recording is not None:
                daemon.record(session, recording)
            session.run(steps=int(ENGAGE_S * 1e3))
            session.play_gesture(gesture, arm=hand.arm, seed=hand.seed, repeat=1)
            states = []
            while not states or (states[-1].gestures and len(states) < LONGEST_GESTURE_S * 1e3):
                states += session.run(steps=500).states
            playing = [state for state in states if state.gestures and state.gestures[0].progress > 0.0]
            return build_trace(session.scene, playing, list(session.events(timeout=0)), setup.tool_id)


def tick_costs_us(setup: Setup, poses: numpy.ndarray) -> numpy.ndarray:
    """Thread CPU time of the tick that was given each of the poses, on the real clock, us; NaN where the machine skipped the tick."""
    with Daemon("--device", "scripted", "--scene", "wall") as daemon:
        with hapticd.Session(daemon.address, keep_states=len(poses) + 10000) as session:
            session.acquire("hapticd-lab")
            load(session, setup)
            session.subscribe(1, ("TIMING", "DEVICES"))
            held = int(ENGAGE_S * 1e3)
            rows = [poses[0]] * held + list(poses)
            costs = TickCosts(numpy.asarray(rows))
            for first in range(0, len(rows), 1000):
                session.poses(rows[first:first + 1000], tool_id=setup.tool_id)
                if first:
                    costs.take(session.states(1000, timeout=1.0))
            costs.take(session.states(len(rows), timeout=1.0))
            return costs.us[held:]
