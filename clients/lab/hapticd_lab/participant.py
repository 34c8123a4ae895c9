"""Who takes part in the experiment: a simulated observer, through the protocol in lockstep; or a person at a device, asked in
the terminal or in a page."""
from __future__ import annotations

import datetime
import math
import time
from dataclasses import dataclass, field
from functools import partial
from typing import Any, Callable, Dict, List, Optional, Sequence, Tuple

import numpy
from google.protobuf import text_format

import hapticd
from hapticd.errors import shown_text
from hapticd.v1 import scene_pb2, state_pb2
from hapticd_lab import player
from hapticd_lab.observer import FELT_DEPTH_M, FELT_PLACE, FIRST, WeberObserver
from hapticd_lab.states import build_trace
from hapticd_lab.stimulus import Bench, peak_n, press_path
from hapticd_lab.string_law import PARAMETERS, StringValues, change, forget_own_law
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

    def instruct(self, trials: int, kept: int) -> None:
        """Knows what to do."""

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


def trial_scene(plain: scene_pb2.Scene, string: StringValues) -> str:
    """The scene with T, E and R of all strings set, silent: the sound must not give the answer. The tuning stays."""
    scene = scene_pb2.Scene()
    scene.CopyFrom(plain)
    for each in scene.strings:
        forget_own_law(each)
        for name in PARAMETERS.values():
            setattr(each, name, getattr(string, name))
    scene.ClearField("tones")
    return text_format.MessageToString(scene)


class LostControl(Exception):
    """Somebody else has control of the daemon, or it was restarted: what is felt is not the plan's any more."""


class Person:
    """At the device of a running hapticd, told and asked by the screen: TerminalScreen or PageScreen."""

    asks_people = True

    def __init__(self, address: str, scene: str, screen: Any, key: Any = None) -> None:
        self._address, self._scene, self._screen, self._key = address, scene, screen, key
        self._plain = scene_pb2.Scene()

    def __enter__(self) -> "Person":
        self._session = hapticd.Session(self._address, keep_states=KEPT_STATES, key=self._key)
        try:
            self._session.acquire("hapticd-lab experiment")
            self._epoch = self._session.epoch
            self._plain.CopyFrom(self._session.load_scene(self._scene, preset="PAPER").scene)
            if not self._plain.strings:
                raise Unplayable(f"the scene {self._scene} has no string: name one that has, such as single_string or guqin")
            self._screen.watch(self._check_control)
        except BaseException:
            self._session.close()
            raise
        return self

    def __exit__(self, *_: object) -> None:
        try:
            self._session.load_scene(self._scene)  # the last string of a trial is nobody's scene
        except (hapticd.RequestError, ConnectionError):
            pass  # who has control now chooses the scene
        self._session.close()

    def _check_control(self) -> None:
        self._session.ping()  # raises where the daemon has ended or is silent
        if self._session.epoch != self._epoch:
            raise LostControl("the connection to hapticd was lost")
        lease = self._session.lease
        if not lease.yours:
            raise LostControl(f"{shown_text(lease.holder) or 'another program'} took control" if lease.fence and lease.holder else "control was lost")

    def _engage(self) -> None:
        try:
            self._session.engage()
        except hapticd.RequestError as error:
            self._screen.no_force(str(error))

    def _clear_and_engage(self) -> None:
        try:
            self._session.clear()
        except hapticd.RequestError:
            pass  # there was no fault, or its cause is not gone: engaging says so
        self._engage()

    def _cut_off(self) -> bool:
        """A fault took the force away: what was felt is no string to compare."""
        latest = self._session.latest
        return latest is not None and latest.loop_state == state_pb2.LOOP_STATE_FAULT

    def _touch(self, touched: Callable[[], bool]) -> Trace:
        """What the tool felt while the person took the time to answer."""
        self._engage()
        self._session.subscribe(1, player.SECTIONS, player.CONTACTS)
        list(self._session.events(timeout=0))
        while not (goes_on := touched()) or self._cut_off():
            if goes_on:
                self._screen.no_force("a fault is latched")  # force comes again by the person's own order alone
            else:
                self._clear_and_engage()
        self._check_control()
        states = list(self._session.states(timeout=0))
        self._session.subscribe(0)
        return build_trace(self._session.scene, states, list(self._session.events(timeout=0)))

    def instruct(self, trials: int, kept: int) -> None:
        """Before the first trial of this run."""
        self._screen.instruct(trials, kept)

    def familiarise(self, scene: str) -> Trace:
        """As long as the person likes."""
        self._session.load_scene(scene)
        return self._touch(lambda: self._screen.familiarise(scene))

    def compare(self, trial: Trial) -> Answered:
        """A, then B, as often as asked for; the ticks are those of the last time."""
        while True:
            ticks = {}
            for label, string in zip(LABELS, trial.strings):
                self._session.load_scene(trial_scene(self._plain, string))
                ticks[label] = self._touch(partial(self._screen.touch, trial.trial, label))
            begin = time.monotonic()
            answer = self._screen.choose(trial.trial)
            self._check_control()
            if answer:
                log_ratio = math.log1p(change(REFERENCE, trial.parameter, trial.increment, FELT_DEPTH_M, FELT_PLACE))
                now = datetime.datetime.now(datetime.timezone.utc).isoformat(timespec="seconds")
                return Answered(answer, ticks, log_ratio, (now, f"{time.monotonic() - begin:.1f}"))

    def score(self, metric: str, explanation: str) -> int:
        """A slider of the questionnaire, 0 to 100."""
        return self._screen.rate(metric, explanation)


Participant = SimulatedParticipant | Person


def familiarisation_left(done: Sequence[str]) -> List[str]:
    """Scenes that were not yet touched."""
    return [scene for scene in FAMILIARISATION if scene not in done]
