"""A session with hapticd, blocking and Pythonic: every request is a method that returns when the server has answered and raises
`RequestError` when it refused. A thread behind it keeps the session alive (connection.py). Several threads may use one Session."""
from __future__ import annotations

import threading
from typing import Any, Dict, Iterable, Iterator, Optional, Sequence, TypeVar, Union

from hapticd import requests
from hapticd.connection import Connection
from hapticd.conversation import TOLD, Event, Peer
from hapticd.errors import SessionEnded
from hapticd.key import KeyLike
from hapticd.requests import Ask, Course, Look, Path, Send, Step, Work
from hapticd.run import RunResult, run
from hapticd.view import View
from hapticd.v1 import answer_pb2, control_pb2, gesture_pb2, state_pb2, stream_pb2

T = TypeVar("T")


class Session(View):
    """with Session("127.0.0.1:47800") as session: ...

    `reconnect`: join anew when the server was restarted; the subscription is renewed, the lease and unanswered requests are lost.
    `key`: a key file, or its bytes, for a server with keys; `role`, "control" or "view", instead of the key's own. Without it the session is
    PLAIN.
    `keep_states`: how many unread States are kept for `states()`, at least 1; the oldest make room, and `states_dropped` counts them. The
    States of a run are all kept, however many.
    Raises ServerSilent if nobody answers within 3 s, ServerFull if the server has no session left, ValueError if `keep_states` is
    below 1 or `key` is none, of hapticd 0.1, or a file that others may access."""

    def __init__(self, address: str = "127.0.0.1:47800", reconnect: bool = True, keep_states: int = 16384, key: Optional[KeyLike] = None,
                 role: Optional[str] = None) -> None:
        self._runs = threading.Lock()
        self._connection: Connection = Connection(Peer(address, reconnect, keep_states, key, role))
        try:
            with self._connection.changed:
                self._connection.wait(lambda: len(self._connection.info) == len(TOLD), survives=reconnect)
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

    def _do(self, work: Work[T]) -> T:
        """Carries out the steps of a request."""
        course = Course(work)
        while course.forward():
            try:
                course.answer = self._carry_out(course.step)
            except BaseException as raised:  # the request may have something to undo
                course.error = raised
        return course.value

    def _carry_out(self, step: Step) -> Any:
        connection = self._connection
        if isinstance(step, Send):
            return connection.submit(step.item, at_once=step.at_once)
        if isinstance(step, Ask):
            result = connection.result(connection.submit(step.item, awaited=True))
            with connection.changed:
                return connection.settle(step.item, result)
        with connection.changed:
            if isinstance(step, Look):
                return step.action(connection)
            until = step
            return connection.wait(lambda: until.holds(connection), until.timeout_s, until.survives)

    # What the server has sent.

    @property
    def scene(self) -> answer_pb2.SceneInfo:
        """The scene with every default filled in, its live parameters, the rate and the clock."""
        return self._do(requests.told("scene_info"))

    @property
    def lease(self) -> answer_pb2.LeaseInfo:
        """Who controls; `lease.yours` is true while this session does."""
        return self._do(requests.told("lease_info"))

    @property
    def recorder(self) -> answer_pb2.RecordInfo:
        """What the recorder does."""
        return self._do(requests.told("record_info"))

    # Streams.

    def subscribe(self, divisor: int = 1, sections: Iterable[Union[str, int]] = (), max_contacts: Optional[int] = None) -> None:
        """Asks for the State of every divisor-th tick; 0 ends it. Sections by name ("TOOLS", "STRINGS", ...) or number; none given:
        tools, strings and contacts. Unread States of an earlier subscription are forgotten."""
        self._do(requests.subscribe(divisor, sections, max_contacts))

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
        return self._do(requests.any_item(item))

    def ping(self) -> None:
        """Returns when the server has answered."""
        self._do(requests.simple("ping"))

    def acquire(self, holder: str = "python", take_over: str = "") -> answer_pb2.LeaseInfo:
        """Takes the lease. RequestError BUSY if another session holds it, unless `take_over` says why it is taken from it: everyone is told
        that, in 400 bytes at most. A run of that session ends with NOT_OWNER, and force fades to zero."""
        return self._do(requests.acquire(holder, take_over))

    def release(self) -> None:
        """Gives the lease back."""
        self._do(requests.simple("release"))

    def engage(self) -> None:
        """Force on, from zero in 200 ms."""
        self._do(requests.simple("engage"))

    def disengage(self) -> None:
        """Force to zero in 50 ms."""
        self._do(requests.simple("disengage"))

    def stop(self) -> None:
        """Zero wrench at the next tick, latched until `clear()`. Needs no lease."""
        self._do(requests.simple("stop"))

    def clear(self) -> None:
        """Leaves FAULT once its cause is gone."""
        self._do(requests.simple("clear"))

    def load_scene(self, scene: Path, preset: Optional[str] = None, check_only: bool = False) -> answer_pb2.SceneInfo:
        """Loads an installed scene by name; what is in a file of this machine, if the argument is a path, has a '/' or ends in
        ".textproto"; or, if it has a line break or brace, a scene in protobuf text format. Of a file the trees and meshes beside it that
        the server does not have are sent too: ValueError where one cannot be. `preset`: "PAPER" or "DEFLECTING". Returns the new scene."""
        return self._do(requests.load_scene(scene, preset, check_only))

    def set(self, path: Union[str, Dict[str, Any]], value: Any = None, at_tick: Optional[int] = None) -> None:
        """Sets one live parameter, or a dict of them: all or none. Numbers ramp over 50 ms. `path` of the error names the bad one."""
        self._do(requests.set_parameters(path, value, at_tick))

    def get(self, paths: Union[str, Sequence[str]] = ()) -> Any:
        """Values of live parameters by path; all of them if none is named, `[*]` for every index. One exact path: its value alone."""
        return self._do(requests.get_parameters(paths))

    def scenes(self) -> Dict[str, str]:
        """Installed scenes: name to description."""
        return self._do(requests.listing("list_scenes"))

    def gestures(self) -> Dict[str, str]:
        """Installed gestures: name to description."""
        return self._do(requests.listing("list_gestures"))

    def recordings(self) -> Dict[str, str]:
        """Recordings: name to description."""
        return self._do(requests.listing("list_recordings"))

    def devices(self) -> Sequence[answer_pb2.DeviceInfo]:
        """The devices, their profiles included."""
        return self._do(requests.devices())

    def play_gesture(self, gesture: Union[Path, gesture_pb2.Gesture, None], arm: Optional[str] = None,
                     seed: Optional[int] = None, repeat: Optional[int] = None) -> None:
        """The simulated hand follows a gesture, by name, from a file of this machine (a path, as for `load_scene`) or as written; None
        ends it. `arm`: "OFF", "LIGHT", "FIRM", "ADVERSARIAL"; `repeat` 0 = until told otherwise."""
        self._do(requests.play_gesture(gesture, arm, seed, repeat))

    def record(self, mode: str = "START", file: str = "") -> str:
        """Starts or stops a recording, or dumps the last 60 s: "START", "STOP", "DUMP". Returns once that is done, with the file's path on the
        daemon's machine. `file`: its name in the daemon's folder of recordings, without it one made from the time."""
        return self._do(requests.record(mode, file))

    # Poses and time.

    def poses(self, poses: Iterable[Sequence[float]], first_tick: Optional[int] = None, tool_id: int = 0) -> int:
        """Queues poses X_DH for a scripted device, rows of 3 or 7 numbers, one per tick from `first_tick` (None: after those queued).
        Returns how many. Does not wait: a refusal is raised by the next request. The server queues 4096. ValueError, and nothing is sent,
        where a number is not finite or a quaternion has a norm outside [0.5, 2]."""
        return self._do(requests.poses(poses, first_tick, tool_id))

    def run(self, steps: Optional[int] = None, poses: Optional[Sequence[Sequence[float]]] = None, tool_id: int = 0,
            collect: bool = True) -> RunResult:
        """Lockstep: advances time by `steps` ticks and returns when they are done. With `poses` the tool follows them, one per tick
        from the next tick on (steps None: as many as poses); what it does beyond them is to hold the last one. A fault that latches ends
        the run with its tick, and what is left of the poses is dropped; a run that begins in FAULT goes on.
        The result has the States of these ticks that were subscribed to, all of them: StatesLost if one did not arrive. `collect` False:
        they go to `states()` alone, as under the real clock.
        Before anything runs: ValueError for steps outside [1, 1e9], for more than a million States to collect, and as `poses`; RequestError
        if the server refuses a pose. A path of more than 2048 poses runs in pieces of as many, and each is judged before it runs.
        ServerSilent in the middle of it: the server is told to stop time, and does when it hears again."""
        with self._runs:
            try:
                return self._do(run(steps, poses, tool_id, collect))
            finally:
                self._connection.collected = None

    def run_live(self) -> None:
        """Lets virtual time follow real time, until `halt()`."""
        self._do(requests.any_item(requests.run_item(control_pb2.RUN_MODE_LIVE)))

    def halt(self) -> None:
        """Stops time; ends a Run of steps of another thread too."""
        self._do(requests.any_item(requests.run_item(control_pb2.RUN_MODE_STOP)))
