"""Scenes of one or more strings, hands led tick by tick in the daemon's own time, and what it tells of them. SI; a place along a string is its
share of the length from the end A, at -x. y is up, z across the strings."""
import math
import pathlib
import subprocess
import sys
import tempfile
from dataclasses import dataclass, field
from typing import Any

import numpy as np

ROOT = pathlib.Path(__file__).resolve().parents[2]
sys.path.insert(0, str(ROOT / "tests/system"))
import daemon  # noqa: E402
import hapticd  # noqa: E402

LENGTH_M, STRING_M, TENSION_N = 1.1, 3.4e-4, 30.0
TICK_NS = 1_000_000
PIECE = 500  # poses sent at a time


@dataclass
class String:
    """Without stretch and loss unless it is told otherwise."""
    hz: float = 65.4
    decay_s: float = 1000.0
    loss_n2: float = 0.0
    stretch_n: float = 0.0
    z: float = 0.0
    silent: bool = False  # keeps to its static law
    rung: str = ""  # of the ladder: "RIGID", "STATIC", "FUNDAMENTAL", "WAVE"; as high as it goes without one
    touch: tuple = ()  # names of what it lies on where it is pressed down

    def text(self, number):
        rung = "STATIC" if self.silent else self.rung
        half, level = LENGTH_M / 2, f" max_level: STRING_LEVEL_{rung}" if rung else ""
        level += "".join(f' touch: "{name}"' for name in self.touch)
        return (f'strings {{ name: "s{number}" p_wa_m: [{-half}, 0, {self.z!r}] p_wb_m: [{half}, 0, {self.z!r}] radius_m: {STRING_M} '
                f"tension_n: {TENSION_N} axial_stiffness_n: {self.stretch_n!r} frequency_hz: {self.hz!r} decay_s: {self.decay_s!r} "
                f"loss_n2_per_s: {self.loss_n2!r}{level} }}\n")


@dataclass
class Hand:
    """A round finger, or several side by side. The coupling is so stiff against turning that each touch is as soft as it is straight on."""
    rows: list  # of (x, y, z), one a tick
    radius: float = 0.005
    kt: float = 1000.0
    skin: tuple = ()  # stiffness N/m and damping N s/m of a fingertip that yields
    across: tuple = (0.0,)  # z of its spheres

    def text(self, tool_id):
        tip = f" fingertip {{ stiffness_n_per_m: {self.skin[0]!r} damping_n_s_per_m: {self.skin[1]!r} }}" if self.skin else ""
        parts = "".join(f' parts {{ name: "p{k}" shape {{ spheres {{ centre_m: [0, 0, {z!r}] radius_m: {self.radius!r} }} }}{tip} }}\n'
                        for k, z in enumerate(self.across))
        place = ", ".join(repr(float(each)) for each in self.rows[0])
        return (f'tools {{ tool_id: {tool_id} name: "t{tool_id}"\n{parts} pose_wg {{ p_m: [{place}] }} '
                f"coupling {{ kt_n_per_m: {self.kt!r} length_m: 1 }} }}\n")


def scene(hands, strings, extras=""):
    """The text of a scene; its strings are waves because nothing else is said."""
    return "".join(['name: "one_string"\n', *(hand.text(k) for k, hand in enumerate(hands)), *(s.text(k) for k, s in enumerate(strings)),
                    "" if "vibration" in extras else "vibration {}\n", "tones {}\n", extras])


def x_of(share):
    return (share - 0.5) * LENGTH_M


def line(start, end, speed):
    """Rows from `start`, which they leave out, to `end` at `speed` (m/s)."""
    start, end = np.asarray(start, float), np.asarray(end, float)
    count = max(1, math.ceil(np.linalg.norm(end - start) / (1e-3 * speed)))
    return [tuple(start + (end - start) * (k + 1) / count) for k in range(count)]


def together(*ways):
    """Rows of several hands made equally long: who is done waits."""
    longest = max(map(len, ways))
    return [list(way) + [way[-1]] * (longest - len(way)) for way in ways]


@dataclass
class Take:
    """What was told."""
    states: list
    events: list
    recording: Any = None  # path
    begin_ns: int = 0  # instant at which a rendered recording begins
    told: list = field(default_factory=list)  # StringSounding
    tones: list = field(default_factory=list)

    def __post_init__(self):
        self.tones = [event.body for event in self.events if event.kind == "tone"]
        self.told = [event.body for event in self.events if event.kind == "string_sounding"]
        heard = [event.body.t_ns for event in self.events if event.kind in ("tone", "string_sounding", "string_radius")]
        self.begin_ns = min(heard, default=0)

    def forces(self, tool_id=0):
        """Of all that a hand touches on it, before the device's limits, N, one row a tick."""
        return np.array([force_of(state, tool_id) for state in self.states])


def force_of(state, tool_id):
    tool = next(tool for tool in state.tools if tool.tool_id == tool_id)
    return list(tool.wrench_unlimited_h_w or tool.wrench_h_w)[:3]


class Stage:
    """A folder, and daemons that play in it in virtual time."""

    def __init__(self, audio):
        self.audio = audio
        self.holder = tempfile.TemporaryDirectory(prefix="one_string_")
        self.folder = pathlib.Path(self.holder.name)
        self.made = 0

    def __enter__(self):
        return self

    def __exit__(self, *_):
        self.holder.cleanup()

    def play(self, hands, strings, extras="", sections=("TOOLS", "STRINGS"), record=False):
        """Leads the hands from the first row of each to the last: a Take."""
        self.made += 1
        file = self.folder / f"{self.made}.textproto"
        file.write_text(scene(hands, strings, extras), encoding="utf-8")
        recording = self.folder / f"{self.made}.mcap"
        options = ("--record", str(recording)) if record else ()
        states = []
        with daemon.Daemon("--clock", "virtual", "--device", "scripted", "--scene", str(file), *options) as played:
            with hapticd.Session(played.address) as session:
                session.acquire("one_string")
                session.subscribe(divisor=1, sections=list(sections))
                count = len(hands[0].rows)
                for first in range(0, count, PIECE):
                    for tool_id, hand in enumerate(hands):
                        rows = [tuple(map(float, row)) for row in hand.rows[first:first + PIECE]]
                        session.poses(rows, first_tick=first, tool_id=tool_id)
                    states += session.run(min(PIECE, count - first)).states
                events = list(session.events(timeout=0))
            if played.end() != 0:
                raise RuntimeError(played.log)
        return Take(states, events, recording if record else None)

    def render(self, take, rate=48000):
        """The sound of a recorded take by haptic-audio: samples; the first is at take.begin_ns."""
        file = take.recording.with_suffix(".wav")
        subprocess.run([self.audio, "--render", file, "--recording", take.recording, "--synth", "--rate", str(rate)], check=True, capture_output=True)
        wave = file.read_bytes()
        at = wave.index(b"data")
        return np.frombuffer(wave[at + 8:at + 8 + int.from_bytes(wave[at + 4:at + 8], "little")], np.float32).astype(float)


def reckoned_hz(told, t_ns):
    """What a client goes on with from the newest message: its glide for at most 100 ms."""
    last = max((each for each in told if each.t_ns <= t_ns), key=lambda each: each.number)
    return last.frequency_hz * 2 ** (last.cents_per_s * min(1e-9 * (t_ns - last.t_ns), 0.1) / 1200)


def place_of(tone):
    """Tone.lambda, which is a word of Python."""
    return getattr(tone, "lambda")
