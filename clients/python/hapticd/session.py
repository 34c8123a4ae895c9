"""A session with hapticd, blocking and Pythonic: every request is a method that returns when the server has answered and raises
`RequestError` when it refused. A thread behind it keeps the session alive (connection.py). Several threads may use one Session."""
from __future__ import annotations

import os
import threading
import time
from dataclasses import dataclass, field
from typing import Any, Dict, Iterable, Iterator, List, Optional, Sequence, Union

from google.protobuf import text_format

from hapticd import values
from hapticd.clock import ClockEstimate
from hapticd.connection import Connection, Event
from hapticd.errors import RequestError, SessionEnded, StatesLost, enum_name
from hapticd.v1 import answer_pb2, control_pb2, gesture_pb2, scene_pb2, state_pb2, stream_pb2

QUEUE_SAMPLES = 4096
"""What the server queues per scripted tool; a longer path is run in pieces."""
RUN_PIECE = QUEUE_SAMPLES // 2
MOST_RUN_STATES = 1_000_000
"""States that one run collects: a kilobyte or more each."""
STRAGGLERS_S = 0.5
"""How long States may come after the answer to their run. Longer ones are lost: the server sends them once."""


@dataclass(frozen=True)
class RunResult:
    """What a lockstep run did: ticks advanced, the tick that would run next, the hash over the States of all ticks since the scene was
    loaded, the ticks without a sample of some scripted tool, and the States of its own ticks, in order: all that were subscribed to."""

    steps: int
    next_tick: int
    state_hash: bytes
    held_inputs: int
    states: List[state_pb2.State] = field(default_factory=list, repr=False, compare=False)


class Session:
    """with Session("127.0.0.1:47800") as session: ...

    `reconnect`: join anew when the server was restarted; the subscription is renewed, the lease and unanswered requests are lost.
    `key`: 32 bytes, for a server with keys; `role` says whose key it is, "control" or "view". Without it the session is PLAIN.
    `keep_states`: how many unread States are kept for `states()`; the oldest make room, and `states_dropped` counts them. The States
    of a run are all kept, however many.
    Raises ServerSilent if nobody answers within 3 s, ServerFull if the server has no session left."""

    def __init__(self, address: str = "127.0.0.1:47800", reconnect: bool = True, keep_states: int = 16384, key: Optional[bytes] = None,
                 role: str = "control") -> None:
        self._runs = threading.Lock()
        self._connection = Connection(address, reconnect, keep_states, key, role)
        try:
            with self._connection.changed:
                self._connection.wait(lambda: len(self._connection.info) == 3, survives=reconnect)
        except BaseException:
            self.close()
            raise

    def __enter__(self) -> "Session":
        return self

    def __exit__(self, *_: object) -> None:
        self.close()

    def close(self) -> None:
        """Says Bye; the lease, if held, ends with it. Harmless when repeated."""
        self._connection.close()

    # What the server has sent.

    def _told(self, kind: str) -> Any:
        with self._connection.changed:
            if kind not in self._connection.info:
                self._connection.wait(lambda: kind in self._connection.info, survives=True)
            return self._connection.info[kind]

    @property
    def scene(self) -> answer_pb2.SceneInfo:
        """The scene with every default filled in, its live parameters, the rate and the clock."""
        return self._told("scene_info")

    @property
    def lease(self) -> answer_pb2.LeaseInfo:
        """Who controls; `lease.yours` is true while this session does."""
        return self._told("lease_info")

    @property
    def recorder(self) -> answer_pb2.RecordInfo:
        """What the recorder does."""
        return self._told("record_info")

    @property
    def latest(self) -> Optional[state_pb2.State]:
        """The newest State, or None before the first."""
        return self._connection.latest

    @property
    def boot_id(self) -> int:
        """Random number of this run of the server."""
        return self._connection.link.boot_id

    @property
    def epoch(self) -> int:
        """Counts the sessions with the server: it grows when the server was restarted and joined again."""
        return self._connection.epoch

    @property
    def states_dropped(self) -> int:
        """States that made room for newer ones before `states()` had read them."""
        return self._connection.states_dropped

    def clock(self) -> Optional[ClockEstimate]:
        """The server's clock relative to time.monotonic_ns(), here and now; None before the first exchange."""
        return self._connection.link.clock.estimate(time.monotonic_ns())

    # Streams.

    def subscribe(self, divisor: int = 1, sections: Iterable[Union[str, int]] = (), max_contacts: Optional[int] = None) -> None:
        """Asks for the State of every divisor-th tick; 0 ends it. Sections by name ("TOOLS", "STRINGS", ...) or number; none given:
        tools, strings and contacts. Unread States of an earlier subscription are forgotten."""
        item = stream_pb2.Item()
        item.subscribe.divisor = divisor
        item.subscribe.sections.extend(_enum(control_pb2.Section, "SECTION_", section) for section in sections)
        if max_contacts is not None:
            item.subscribe.max_contacts = max_contacts
        with self._connection.changed:
            self._connection.states.clear()
        self.request(item)

    def states(self, count: Optional[int] = None, timeout: Optional[float] = None) -> Iterator[state_pb2.State]:
        """The States in order of time, each once; waits for the next. Ends after `count`, after `timeout` s without one, and when the
        session is closed or the server ends. `run()` forgets those that are unread when it begins: after it they are those of that run."""
        return self._stream(self._connection.states, count, timeout)

    def events(self, count: Optional[int] = None, timeout: Optional[float] = None) -> Iterator[Event]:
        """Tones, contacts, faults, leases and the rest in order, none missing. `timeout=0` yields what is there."""
        return self._stream(self._connection.events, count, timeout)

    def _stream(self, queue: Any, count: Optional[int], timeout: Optional[float]) -> Iterator[Any]:
        while count is None or count > 0:
            with self._connection.changed:
                try:
                    if not self._connection.wait(lambda: len(queue) > 0, timeout, survives=True):
                        return
                except SessionEnded as ended:
                    if ended.reason in ("DONE", "SHUTDOWN"):
                        return
                    raise
                element = queue.popleft()
            yield element
            count = None if count is None else count - 1

    # Requests.

    def request(self, item: stream_pb2.Item) -> answer_pb2.Result:
        """Sends any request and waits for its Result; RequestError unless it is OK. Refused poses sent before count as well: they are
        answered only when they fail."""
        item_id = self._connection.submit(item, awaited=True)
        result = self._connection.result(item_id)
        with self._connection.changed:
            if item.HasField("subscribe") and result.code == answer_pb2.RESULT_CODE_OK:
                self._connection.subscription = item if item.subscribe.divisor else None
            failures, self._connection.failures = self._connection.failures, []
        for each in (*failures, result):
            if each.code != answer_pb2.RESULT_CODE_OK:
                raise RequestError(each)
        return result

    def _simple(self, kind: str) -> answer_pb2.Result:
        item = stream_pb2.Item()
        getattr(item, kind).SetInParent()
        return self.request(item)

    def ping(self) -> None:
        """Returns when the server has answered."""
        self._simple("ping")

    def acquire(self, holder: str = "python") -> answer_pb2.LeaseInfo:
        """Takes the lease. RequestError BUSY if another session holds it."""
        item = stream_pb2.Item()
        item.acquire.holder = holder
        item.acquire.SetInParent()
        return self.request(item).lease

    def release(self) -> None:
        """Gives the lease back."""
        self._simple("release")

    def engage(self) -> None:
        """Force on, from zero in 200 ms."""
        self._simple("engage")

    def disengage(self) -> None:
        """Force to zero in 50 ms."""
        self._simple("disengage")

    def stop(self) -> None:
        """Zero wrench at the next tick, latched until `clear()`. Needs no lease."""
        self._simple("stop")

    def clear(self) -> None:
        """Leaves FAULT once its cause is gone."""
        self._simple("clear")

    def load_scene(self, scene: Union[str, "os.PathLike[str]"], preset: Optional[str] = None,
                   check_only: bool = False) -> answer_pb2.SceneInfo:
        """Loads an installed scene by name; what is in a file of this machine, if the argument is a path, has a '/' or ends in
        ".textproto"; or, if it has a line break or brace, a scene in protobuf text format. `preset`: "PAPER" or "DEFLECTING". Returns
        the new scene."""
        item = stream_pb2.Item()
        if isinstance(scene, str) and ("\n" in scene or "{" in scene):
            item.load_scene.text = scene
        elif _names_file(scene):
            item.load_scene.text = _text_of(scene)
        else:
            item.load_scene.name = scene
        if preset is not None:
            item.load_scene.preset = _enum(scene_pb2.Preset, "PRESET_", preset)
        item.load_scene.check_only = check_only
        before = self.scene.scene_id
        self.request(item)
        if not check_only:
            with self._connection.changed:
                self._connection.wait(lambda: self.scene.scene_id != before)
        return self.scene

    def set(self, path: Union[str, Dict[str, Any]], value: Any = None, at_tick: Optional[int] = None) -> None:
        """Sets one live parameter, or a dict of them: all or none. Numbers ramp over 50 ms. `path` of the error names the bad one."""
        item = stream_pb2.Item()
        for name, each in (path if isinstance(path, dict) else {path: value}).items():
            assignment = item.set_parameter.assignments.add(path=name)
            values.fill_value(assignment, each)
        if at_tick is not None:
            item.set_parameter.at_tick = at_tick
        self.request(item)

    def get(self, paths: Union[str, Sequence[str]] = ()) -> Any:
        """Values of live parameters by path; all of them if none is named, `[*]` for every index. One exact path: its value alone."""
        one = isinstance(paths, str)
        item = stream_pb2.Item()
        item.get_parameters.paths.extend([paths] if one else paths)
        item.get_parameters.SetInParent()
        found = {each.path: values.read_value(each) for each in self.request(item).parameters.values}
        return found[paths] if one and paths in found else found

    def scenes(self) -> Dict[str, str]:
        """Installed scenes: name to description."""
        return _listing(self._simple("list_scenes"))

    def gestures(self) -> Dict[str, str]:
        """Installed gestures: name to description."""
        return _listing(self._simple("list_gestures"))

    def recordings(self) -> Dict[str, str]:
        """Recordings: name to description."""
        return _listing(self._simple("list_recordings"))

    def devices(self) -> Sequence[answer_pb2.DeviceInfo]:
        """The devices, their profiles included."""
        return self._simple("get_device_info").devices.devices

    def play_gesture(self, gesture: Union[str, "os.PathLike[str]", gesture_pb2.Gesture, None], arm: Optional[str] = None,
                     seed: Optional[int] = None, repeat: Optional[int] = None) -> None:
        """The simulated hand follows a gesture, by name, from a file of this machine (a path, as for `load_scene`) or as written; None
        ends it. `arm`: "OFF", "LIGHT", "FIRM", "ADVERSARIAL"; `repeat` 0 = until told otherwise."""
        item = stream_pb2.Item()
        item.play_gesture.SetInParent()
        if isinstance(gesture, (str, os.PathLike)) and _names_file(gesture):
            text_format.Parse(_text_of(gesture), item.play_gesture.gesture)
        elif isinstance(gesture, str):
            item.play_gesture.name = gesture
        elif gesture is not None:
            item.play_gesture.gesture.CopyFrom(gesture)
        if arm is not None:
            item.play_gesture.arm = _enum(gesture_pb2.Arm, "ARM_", arm)
        if seed is not None:
            item.play_gesture.seed = seed
        if repeat is not None:
            item.play_gesture.repeat = repeat
        self.request(item)

    def record(self, mode: str = "START", file: str = "") -> None:
        """Starts or stops a recording, or dumps the last 60 s: "START", "STOP", "DUMP"."""
        item = stream_pb2.Item()
        item.record.mode = _enum(control_pb2.RecordMode, "RECORD_MODE_", mode)
        item.record.file = file
        self.request(item)

    # Poses and time.

    def poses(self, poses: Iterable[Sequence[float]], first_tick: Optional[int] = None, tool_id: int = 0) -> int:
        """Queues poses X_DH for a scripted device, rows of 3 or 7 numbers, one per tick from `first_tick` (None: after those queued).
        Returns how many. Does not wait: a refusal is raised by the next request. The server queues 4096."""
        count = 0
        for batch in values.pose_batches(poses, tool_id, first_tick):
            item = stream_pb2.Item()
            item.pose_batch.CopyFrom(batch)
            self._connection.submit(item)
            count += len(batch.poses)
        return count

    def run(self, steps: Optional[int] = None, poses: Optional[Sequence[Sequence[float]]] = None, tool_id: int = 0,
            collect: bool = True) -> RunResult:
        """Lockstep: advances time by `steps` ticks and returns when they are done. With `poses` the tool follows them, one per tick
        from the next tick on (steps None: as many as poses); what it does beyond them is to hold the last one.
        The result has the States of these ticks that were subscribed to, all of them: StatesLost if one did not arrive, ValueError
        before anything runs if there would be more than a million. `collect` False: they go to `states()` alone, as under the real clock."""
        rows = [] if poses is None else list(poses)
        left = len(rows) if steps is None else steps
        with self._runs:
            divisor = self._divisor() if collect else 0
            if divisor and left // divisor > MOST_RUN_STATES:
                raise ValueError(f"{left} steps give {left // divisor} States, and a run collects {MOST_RUN_STATES} at most: run in pieces, "
                                 "subscribe with a larger divisor, or give collect=False")
            unread = self._begin_collecting() if divisor else []
            try:
                result = self._advance(rows, left, tool_id)
                missing = self._await_states(result, divisor) if divisor else []
            except RequestError:
                with self._connection.changed:
                    self._connection.states.extendleft(reversed(unread))
                raise
            finally:
                self._connection.collected = None
        if missing:
            raise StatesLost(result, missing)
        return result

    def _divisor(self) -> int:
        """Of the subscription; 0: there is none."""
        with self._connection.changed:
            subscription = self._connection.subscription
            return subscription.subscribe.divisor if subscription is not None else 0

    def _begin_collecting(self) -> List[state_pb2.State]:
        """What comes from now on is the run's; gives the unread States that make way."""
        with self._connection.changed:
            unread = list(self._connection.states)
            self._connection.states.clear()
            self._connection.collected = []
            return unread

    def _await_states(self, result: RunResult, divisor: int) -> List[int]:
        """Puts the States of the run into its result; the ticks of those that do not come."""
        begin = max(0, result.next_tick - result.steps)
        wanted = range(-(-begin // divisor) * divisor, result.next_tick, divisor)
        scene_id = self.scene.scene_id
        with self._connection.changed:
            collected = self._connection.collected

            def last_is_there() -> bool:
                return not wanted or any(state.scene_id == scene_id and state.tick >= wanted[-1] for state in collected[-1:])
            self._connection.wait(last_is_there, STRAGGLERS_S)
            found = {state.tick: state for state in collected if state.scene_id == scene_id and state.tick in wanted}
        result.states.extend(found[tick] for tick in sorted(found))
        return [tick for tick in wanted if tick not in found]

    def _advance(self, rows: List[Sequence[float]], left: int, tool_id: int) -> RunResult:
        """Runs `left` steps along the rows, in pieces that the server's queue holds."""
        done, held, at = 0, 0, 0
        while True:
            self.poses(rows[at:at + min(left, RUN_PIECE)], tool_id=tool_id)
            piece = min(left, RUN_PIECE) if at < len(rows) else left
            item = stream_pb2.Item()
            item.run.mode = control_pb2.RUN_MODE_STEP
            item.run.steps = piece
            answer = self.request(item).run
            done, held, at, left = done + answer.steps, held + answer.held_inputs, at + piece, left - piece
            if left <= 0 or answer.steps < piece:
                return RunResult(done, answer.next_tick, answer.state_hash, held)

    def run_live(self) -> None:
        """Lets virtual time follow real time, until `halt()`."""
        self._run_mode(control_pb2.RUN_MODE_LIVE)

    def halt(self) -> None:
        """Stops time; ends a Run of steps of another thread too."""
        self._run_mode(control_pb2.RUN_MODE_STOP)

    def _run_mode(self, mode: int) -> None:
        item = stream_pb2.Item()
        item.run.mode = mode
        self.request(item)


def _enum(enum: Any, prefix: str, value: Union[str, int]) -> int:
    """A value by its name, with or without the prefix, in any case. ValueError lists the names."""
    if isinstance(value, int):
        return value
    name = value.upper()
    name = name if name.startswith(prefix) else prefix + name
    if name not in enum.keys():
        raise ValueError(f"{value!r} is none of {', '.join(enum_name(enum, number, prefix) for number in enum.values() if number)}")
    return enum.Value(name)


def _names_file(source: Union[str, "os.PathLike[str]"]) -> bool:
    """A path, and no name of something installed: the server opens no file by its path."""
    return not isinstance(source, str) or "/" in source or source.endswith(".textproto")


def _text_of(path: Union[str, "os.PathLike[str]"]) -> str:
    with open(path, encoding="utf-8") as file:
        return file.read()


def _listing(result: answer_pb2.Result) -> Dict[str, str]:
    names, descriptions = result.listing.names, result.listing.descriptions
    return dict(zip(names, descriptions)) if len(descriptions) == len(names) else dict.fromkeys(names, "")
