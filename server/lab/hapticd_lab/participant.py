"""Who takes part in the experiment: a simulated observer, through the protocol in lockstep; or a person at a device, asked in the terminal."""
from __future__ import annotations

import datetime
import math
import time
from dataclasses import dataclass, field
from typing import Callable, Dict, List, Sequence, Tuple

import numpy
from google.protobuf import text_format

import hapticd
from hapticd.v1 import scene_pb2
from hapticd_lab import player
from hapticd_lab.observer import EQUAL, FELT_DEPTH_M, FELT_PLACE, FIRST, SECOND, WeberObserver
from hapticd_lab.states import build_trace
from hapticd_lab.stimulus import Bench, peak_n, press_path
from hapticd_lab.string_law import PARAMETERS, StringValues, change
from hapticd_lab.trace import Trace
from hapticd_lab.trials import REFERENCE, Trial

FAMILIARISATION = ("wall", "sphere")
APPROACH = {"wall": numpy.array([0.0, 0.0, -1.0]), "sphere": numpy.array([0.0, -1.0, 0.0])}
"""Which way the simulated finger goes from where the scene puts it."""
APPROACH_M, APPROACH_M_PER_S = 0.03, 0.1
KEPT_STATES = 600_000
"""Ten minutes with one string."""
LABELS = ("A", "B")


@dataclass
class Answered:
    """What a trial gave. `ticks` by label; `answered`: when and how long it took, empty for a simulated observer."""

    answer: str
    ticks: Dict[str, Trace]
    log_ratio: float
    answered: Tuple[str, str] = ("", "")
    peaks_n: List[float] = field(default_factory=list)

    def __post_init__(self) -> None:
        self.peaks_n = [peak_n(self.ticks[label]) if len(self.ticks[label]) else 0.0 for label in LABELS]


class SimulatedParticipant:
    """Presses both strings alike and answers by Weber's rule. The noise of a trial follows from seed and trial alone, so that an experiment that was
    interrupted goes on as if it had not been."""

    asks_people = False

    def __init__(self, observer: WeberObserver, seed: int) -> None:
        self._observer, self._seed, self._bench = observer, seed, Bench()

    def __enter__(self) -> "SimulatedParticipant":
        self._bench.__enter__()
        return self

    def __exit__(self, *_: object) -> None:
        self._bench.__exit__()

    def familiarise(self, scene: str) -> Trace:
        """Touches the wall or the sphere once."""
        loaded = self._bench.session.load_scene(scene).scene
        start = numpy.array(loaded.tools[0].pose_wg.p_m)
        way = numpy.arange(0.0, APPROACH_M, APPROACH_M_PER_S * 1e-3)
        poses = numpy.zeros((2 * len(way), 7))
        poses[:, :3] = start + numpy.concatenate((way, way[::-1]))[:, None] * APPROACH[scene]
        poses[:, 3] = 1.0
        return self._bench.follow(poses)

    def compare(self, trial: Trial) -> Answered:
        """Feels A, then B."""
        ticks = {label: self._bench.present(string, press_path(string, FELT_DEPTH_M, FELT_PLACE)) for label, string in zip(LABELS, trial.strings)}
        peaks = [peak_n(ticks[label]) for label in LABELS]
        noise = float(numpy.random.Generator(numpy.random.PCG64([self._seed, trial.trial])).standard_normal())
        raised, reference = (peaks[0], peaks[1]) if trial.stiffer == FIRST else (peaks[1], peaks[0])
        return Answered(self._observer.answer(peaks[0], peaks[1], noise), ticks, math.log(raised / reference))


class Unplayable(ValueError):
    """The experiment cannot be played on that scene."""


class Interrupted(Exception):
    """The person ended the session; what was answered is kept."""


def trial_scene(plain: scene_pb2.Scene, string: StringValues) -> str:
    """The scene with T, E and R of all strings set, silent: the sound must not give the answer. The tuning stays."""
    scene = scene_pb2.Scene()
    scene.CopyFrom(plain)
    for each in scene.strings:
        each.ClearField("linear_density_kg_per_m")  # it would contradict the tuning once T has changed
        for name in PARAMETERS.values():
            setattr(each, name, getattr(string, name))
    scene.ClearField("tones")
    return text_format.MessageToString(scene)


class Person:
    """At the device of a running hapticd. `ask` and `say`: the terminal's, as input and print are."""

    asks_people = True

    def __init__(self, address: str, scene: str, ask: Callable[[str], str] = input, say: Callable[[str], None] = print) -> None:
        self._address, self._scene, self._ask_line, self._say = address, scene, ask, say
        self._plain = scene_pb2.Scene()

    def __enter__(self) -> "Person":
        self._session = hapticd.Session(self._address, keep_states=KEPT_STATES)
        try:
            self._session.acquire("hapticd-lab experiment")
            self._plain.CopyFrom(self._session.load_scene(self._scene, preset="PAPER").scene)
            if not self._plain.strings:
                raise Unplayable(f"the scene {self._scene} has no string: name one that has, such as single_string or guqin")
        except BaseException:
            self._session.close()
            raise
        return self

    def __exit__(self, *_: object) -> None:
        self._session.close()

    def _ask(self, question: str) -> str:
        try:
            return self._ask_line(question).strip()
        except (EOFError, KeyboardInterrupt):
            raise Interrupted from None

    def _engage(self) -> None:
        try:
            self._session.engage()
        except hapticd.RequestError as error:
            self._say(f"The device does not engage ({error}): move it clear of everything, or clear its fault.")

    def _touch(self, question: str) -> Trace:
        """What the tool felt while the person took the time to answer."""
        self._engage()
        self._session.subscribe(1, player.SECTIONS, player.CONTACTS)
        list(self._session.events(timeout=0))
        self._ask(question)
        states = list(self._session.states(timeout=0))
        self._session.subscribe(0)
        return build_trace(self._session.scene, states, list(self._session.events(timeout=0)))

    def familiarise(self, scene: str) -> Trace:
        """As long as the person likes."""
        self._session.load_scene(scene)
        return self._touch(f"Get used to the device: here is a {scene}. Touch it, press it, slide on it; then press Enter. ")

    def compare(self, trial: Trial) -> Answered:
        """A, then B, as often as asked for; the ticks are those of the last time."""
        while True:
            ticks = {}
            for label, string in zip(LABELS, trial.strings):
                self._session.load_scene(trial_scene(self._plain, string))
                ticks[label] = self._touch(f"Trial {trial.trial}, string {label}: press it; then press Enter. ")
            begin = time.monotonic()
            answer = self._choose()
            if answer:
                log_ratio = math.log1p(change(REFERENCE, trial.parameter, trial.increment, FELT_DEPTH_M, FELT_PLACE))
                now = datetime.datetime.now(datetime.timezone.utc).isoformat(timespec="seconds")
                return Answered(answer, ticks, log_ratio, (now, f"{time.monotonic() - begin:.1f}"))

    def _choose(self) -> str:
        choices = {"a": FIRST, "1": FIRST, FIRST: FIRST, "b": SECOND, "2": SECOND, SECOND: SECOND, "e": EQUAL, "=": EQUAL, EQUAL: EQUAL, "again": "", "r": ""}
        while True:
            given = self._ask("Which one was stiffer? first, second or equal (or: again) ").lower()
            if given in choices:
                return choices[given]
            self._say("Say first, second or equal; or again, to feel both once more.")

    def score(self, metric: str, explanation: str) -> int:
        """A slider of the questionnaire, 0 to 100."""
        while True:
            given = self._ask(f"{metric} ({explanation}): 0 to 100, 100 is like a real string: ")
            if given.isdecimal() and int(given) <= 100:
                return int(given)
            self._say("Give a whole number from 0 to 100.")


Participant = SimulatedParticipant | Person


def familiarisation_left(done: Sequence[str]) -> List[str]:
    """Scenes that were not yet touched."""
    return [scene for scene in FAMILIARISATION if scene not in done]
