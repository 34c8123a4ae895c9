"""A short session in lockstep whose States are looked at one by one; whole figures are played by player.py."""
from __future__ import annotations

from typing import List, Sequence

import numpy

import hapticd
from hapticd.v1 import state_pb2
from hapticd_lab.player import ENGAGE_S, Daemon

CONTACTS = 256
"""Listed at most, which is all that a State may list."""


def states_of(scene: str, poses: numpy.ndarray, sections: Sequence[str], preset: str = "PAPER") -> List[state_pb2.State]:
    """The States of a scripted device that follows poses X_DH (n x 3 or n x 7), a row each ms; the first is held before until force is
    on, and one State comes of each row. `scene`: by name, or as text."""
    held = round(ENGAGE_S * 1e3)
    with Daemon("--clock", "virtual", "--device", "scripted", "--scene", "wall") as daemon, hapticd.Session(daemon.address) as session:
        session.acquire("hapticd-lab")
        session.load_scene(scene, preset=preset)
        session.run(poses=numpy.repeat(poses[:1], held, axis=0))
        session.subscribe(1, sections, CONTACTS)
        return session.run(poses=numpy.vstack([poses, poses[-1:]])).states[:-1]
