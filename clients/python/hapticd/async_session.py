"""A session with hapticd in asyncio: the methods of Session, each to be awaited, and streams for `async for`. It has no thread: the event loop
keeps the session alive, so a coroutine that computes for 2 s without awaiting anything loses the lease."""
from __future__ import annotations

import asyncio
from typing import Any, AsyncIterator, Dict, Iterable, Optional, Sequence, TypeVar, Union

from hapticd import requests
from hapticd.async_connection import AsyncConnection
from hapticd.conversation import TOLD, Event, Peer
from hapticd.errors import SessionEnded, SessionLost
from hapticd.key import KeyLike
from hapticd.requests import Ask, Course, Look, Path, Send, Step, Work
from hapticd.run import RunResult, run
from hapticd.v1 import answer_pb2, control_pb2, gesture_pb2, state_pb2, stream_pb2
from hapticd.view import View

T = TypeVar("T")


class AsyncSession(View):
    """async with AsyncSession("127.0.0.1:47800") as session: ...

    The arguments are those of Session. It belongs to the loop in which it was opened and to its thread; any number of tasks may use it, and
    a loop may have any number of sessions. A task that is cancelled while it runs steps stops time; a request that was sent is
    carried out whether somebody waits for its answer or not."""

    def __init__(self, address: str = "127.0.0.1:47800", reconnect: bool = True, keep_states: int = 16384, key: Optional[KeyLike] = None,
                 role: Optional[str] = None) -> None:
        self._peer = Peer(address, reconnect, keep_states, key, role)
        self._opened: Optional[AsyncConnection] = None
        self._runs = asyncio.Lock()

    async def open(self) -> "AsyncSession":
        """Joins the server. ServerSilent if nobody answers within 3 s, ServerFull if it has no session left. RuntimeError if repeated."""
        if self._opened is not None:
            raise RuntimeError("this session was opened before: make another")
        self._opened = AsyncConnection(self._peer)
        try:
            await self._opened.open()
            await self._opened.wait(lambda: len(self._connection.info) == len(TOLD), survives=self._peer.reconnect)
        except BaseException:
            await self.close()
            raise
        return self

    async def __aenter__(self) -> "AsyncSession":
        return await self.open()

    async def __aexit__(self, *_: object) -> None:
        await self.close()

    async def close(self) -> None:
        """Says Bye; the lease, if held, ends with it. Harmless when repeated."""
        if self._opened is not None:
            await self._opened.close()

    @property
    def _connection(self) -> AsyncConnection:  # type: ignore[override]
        if self._opened is None:
            raise RuntimeError("the session is not open: use `async with AsyncSession(...) as session`, or await session.open()")
        return self._opened

    async def _do(self, work: Work[T]) -> T:
        """Carries out the steps of a request."""
        course = Course(work)
        while course.forward():
            try:
                course.answer = await self._carry_out(course.step)
            except BaseException as raised:  # the request may have something to undo
                course.error = raised
        return course.value

    async def _carry_out(self, step: Step) -> Any:
        connection = self._connection
        if isinstance(step, Send):
            return await connection.submit(step.item, at_once=step.at_once)
        if isinstance(step, Ask):
            result = await connection.result(await connection.submit(step.item, awaited=True))
            return connection.settle(step.item, result)
        if isinstance(step, Look):
            return step.action(connection)
        until = step
        return await connection.wait(lambda: until.holds(connection), until.timeout_s, until.survives)

    # What the server has sent.

    def _told(self, kind: str) -> Any:
        if kind not in self._connection.info:
            self._connection.check()
            raise SessionLost("the server is being joined anew and has not told yet: ask again after `await session.ping()`")
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

    # Streams.

    async def subscribe(self, divisor: int = 1, sections: Iterable[Union[str, int]] = (), max_contacts: Optional[int] = None) -> None:
        """As Session.subscribe."""
        await self._do(requests.subscribe(divisor, sections, max_contacts))

    def states(self, count: Optional[int] = None, timeout: Optional[float] = None) -> AsyncIterator[state_pb2.State]:
        """As Session.states, for `async for`."""
        return self._stream(self._connection.states, count, timeout)

    def events(self, count: Optional[int] = None, timeout: Optional[float] = None) -> AsyncIterator[Event]:
        """As Session.events, for `async for`."""
        return self._stream(self._connection.events, count, timeout)

    async def _stream(self, queue: Any, count: Optional[int], timeout: Optional[float]) -> AsyncIterator[Any]:
        while count is None or count > 0:
            try:
                if not await self._connection.wait(lambda: len(queue) > 0, timeout, survives=True):
                    return
            except SessionEnded as ended:
                if ended.reason in ("DONE", "SHUTDOWN"):
                    return
                raise
            yield queue.popleft()
            count = None if count is None else count - 1

    # Requests.

    async def request(self, item: stream_pb2.Item) -> answer_pb2.Result:
        """As Session.request."""
        return await self._do(requests.any_item(item))

    async def ping(self) -> None:
        """As Session.ping."""
        await self._do(requests.simple("ping"))

    async def acquire(self, holder: str = "python", take_over: str = "") -> answer_pb2.LeaseInfo:
        """As Session.acquire."""
        return await self._do(requests.acquire(holder, take_over))

    async def release(self) -> None:
        """As Session.release."""
        await self._do(requests.simple("release"))

    async def engage(self) -> None:
        """As Session.engage."""
        await self._do(requests.simple("engage"))

    async def disengage(self) -> None:
        """As Session.disengage."""
        await self._do(requests.simple("disengage"))

    async def stop(self) -> None:
        """As Session.stop."""
        await self._do(requests.simple("stop"))

    async def clear(self) -> None:
        """As Session.clear."""
        await self._do(requests.simple("clear"))

    async def load_scene(self, scene: Path, preset: Optional[str] = None, check_only: bool = False) -> answer_pb2.SceneInfo:
        """As Session.load_scene."""
        return await self._do(requests.load_scene(scene, preset, check_only))

    async def set(self, path: Union[str, Dict[str, Any]], value: Any = None, at_tick: Optional[int] = None) -> None:
        """As Session.set."""
        await self._do(requests.set_parameters(path, value, at_tick))

    async def get(self, paths: Union[str, Sequence[str]] = ()) -> Any:
        """As Session.get."""
        return await self._do(requests.get_parameters(paths))

    async def scenes(self) -> Dict[str, str]:
        """As Session.scenes."""
        return await self._do(requests.listing("list_scenes"))

    async def gestures(self) -> Dict[str, str]:
        """As Session.gestures."""
        return await self._do(requests.listing("list_gestures"))

    async def recordings(self) -> Dict[str, str]:
        """As Session.recordings."""
        return await self._do(requests.listing("list_recordings"))

    async def devices(self) -> Sequence[answer_pb2.DeviceInfo]:
        """As Session.devices."""
        return await self._do(requests.devices())

    async def play_gesture(self, gesture: Union[Path, gesture_pb2.Gesture, None], arm: Optional[str] = None, seed: Optional[int] = None,
                           repeat: Optional[int] = None) -> None:
        """As Session.play_gesture."""
        await self._do(requests.play_gesture(gesture, arm, seed, repeat))

    async def record(self, mode: str = "START", file: str = "") -> str:
        """As Session.record."""
        return await self._do(requests.record(mode, file))

    # Poses and time.

    async def poses(self, poses: Iterable[Sequence[float]], first_tick: Optional[int] = None, tool_id: int = 0) -> int:
        """As Session.poses."""
        return await self._do(requests.poses(poses, first_tick, tool_id))

    async def run(self, steps: Optional[int] = None, poses: Optional[Sequence[Sequence[float]]] = None, tool_id: int = 0,
                  collect: bool = True) -> RunResult:
        """As Session.run."""
        async with self._runs:
            try:
                return await self._do(run(steps, poses, tool_id, collect))
            finally:
                self._connection.collected = None

    async def run_live(self) -> None:
        """As Session.run_live."""
        await self._do(requests.any_item(requests.run_item(control_pb2.RUN_MODE_LIVE)))

    async def halt(self) -> None:
        """As Session.halt; ends a Run of steps of another task too."""
        await self._do(requests.any_item(requests.run_item(control_pb2.RUN_MODE_STOP)))
