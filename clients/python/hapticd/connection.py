"""The thread that keeps one session alive: it sends what is due, receives, and sorts what came into results, events and States. A
daemon thread, so that lease and keep-alive hold while the user's code computes; everything it shares is guarded by `changed`.
A server that was restarted or forgot us is joined anew by itself (PROTOCOL.md section 3); what was unanswered then fails."""
from __future__ import annotations

import secrets
import select
import socket
import threading
import time
from collections import deque
from typing import Callable, Deque, Dict, List, NamedTuple, Optional, Tuple

from google.protobuf.message import Message

from hapticd import link as link_module
from hapticd.errors import ServerFull, ServerSilent, SessionEnded, SessionLost
from hapticd.link import Link
from hapticd.road import KeyedRoad
from hapticd.v1 import answer_pb2, control_pb2, state_pb2, stream_pb2

DEFAULT_PORT = 47800
SILENCE_NS = 3_000_000_000
"""A server that is silent this long, though it must speak every 100 ms, is not there."""
ANEW_NS = 10_000_000_000
"""After this long a silence the session is over on the server's side too, and starts again."""
RECEIVE_BUFFER_BYTES = 1 << 20
MOST_EVENTS = 1 << 16
MOST_WAITING = 256
"""With more unacknowledged Items than this the user's thread waits, so that a long path of poses never fills the backlog."""
_BURST = 256  # datagrams read before something may be sent


class Event(NamedTuple):
    """`kind` is the name of the Item: tone, contact, string_radius, fault, lease_info, record_info, scene_info."""

    kind: str
    body: Message


def open_socket(address: str) -> socket.socket:
    """A UDP socket connected to "HOST:PORT", "HOST" or "[IPv6]:PORT"."""
    host, separator, port = address.rpartition(":")
    if not separator or address.endswith("]") or (host.count(":") and not host.endswith("]")):
        host, port = address, str(DEFAULT_PORT)
    family, kind, protocol, _, target = socket.getaddrinfo(host.strip("[]") or "127.0.0.1", port, type=socket.SOCK_DGRAM)[0]
    found = socket.socket(family, kind, protocol)
    found.setsockopt(socket.SOL_SOCKET, socket.SO_RCVBUF, RECEIVE_BUFFER_BYTES)
    found.setblocking(False)
    found.connect(target)
    return found


class Connection:
    """One session after another with one server."""

    def __init__(self, address: str, reconnect: bool, keep_states: int, key: Optional[bytes], role: str) -> None:
        self.changed = threading.Condition()
        self.events: Deque[Event] = deque(maxlen=MOST_EVENTS)
        self.events_dropped = 0
        self.keep_states = keep_states
        self.states: Deque[state_pb2.State] = deque()
        self.states_dropped = 0
        self.collected: Optional[List[state_pb2.State]] = None  # of the Run of steps under way
        self.latest: Optional[state_pb2.State] = None
        self.info: Dict[str, Message] = {}  # newest scene_info, lease_info, record_info of this session
        self.failures: List[answer_pb2.Result] = []  # of requests that are answered only when they fail
        self.epoch = 0  # counts the sessions
        self.over: Optional[Exception] = None
        self.subscription: Optional[stream_pb2.Item] = None
        self.reconnect = reconnect
        self._key, self._role = key, role
        self._results: Dict[int, answer_pb2.Result] = {}
        self._awaited: set[int] = set()
        self._socket = open_socket(address)
        self._wake_in, self._wake_out = socket.socketpair()
        self._wake_in.setblocking(False)
        self._stopping = False
        self._link = self._new_link()
        self._thread = threading.Thread(target=self._run, name="hapticd", daemon=True)
        self._thread.start()

    # For the user's thread.

    @property
    def link(self) -> Link:
        return self._link

    def submit(self, item: stream_pb2.Item, awaited: bool = False) -> int:
        """Sends an Item; returns its id. `awaited`: its Result will be fetched."""
        with self.changed:
            self.check()
            self.wait(lambda: self._link.backlog < MOST_WAITING)
            item_id = self._link.submit(item)
            if awaited:
                self._awaited.add(item_id)
        self._wake()
        return item_id

    def wait(self, until: Callable[[], bool], timeout_s: Optional[float] = None, survives: bool = False) -> bool:
        """Waits, with `changed` held, until the condition holds; False on timeout. ServerSilent, SessionLost or SessionEnded where it
        can no longer come true. `survives`: what is waited for may come from the session after this one."""
        epoch = self.epoch
        deadline = None if timeout_s is None else time.monotonic() + timeout_s
        while not until():
            self.check()
            if self.epoch != epoch and not survives:
                raise SessionLost("the session was lost; the request may or may not have been carried out")
            if time.monotonic_ns() - self._link.heard_ns > SILENCE_NS:
                raise ServerSilent(f"nothing heard for {SILENCE_NS // 10**9} s; is hapticd running there?")
            left = 0.1 if deadline is None else min(0.1, deadline - time.monotonic())
            if left <= 0:
                return False
            self.changed.wait(left)
        return True

    def result(self, item_id: int) -> answer_pb2.Result:
        """Waits for the Result of an awaited request."""
        with self.changed:
            try:
                self.wait(lambda: item_id in self._results)
                return self._results.pop(item_id)
            finally:
                self._awaited.discard(item_id)

    def check(self) -> None:
        """Raises if the session is over."""
        if self.over is not None:
            raise self.over

    def close(self) -> None:
        """Bye, repeated until acknowledged, 1 s at most; then the thread ends."""
        with self.changed:
            if self.over is None:
                self.over = SessionEnded(control_pb2.BYE_REASON_DONE, "closed")
                self._link.say_bye(control_pb2.BYE_REASON_DONE)
            self._stopping = True
        self._wake()
        self._thread.join(link_module.BYE_PATIENCE_NS * 2e-9)

    def _wake(self) -> None:
        try:
            self._wake_out.send(b"!")
        except OSError:
            pass  # the thread has ended

    # The thread.

    def _new_link(self) -> Link:
        self.epoch += 1
        self.info = {}
        self._results.clear()
        self._awaited.clear()
        now_ns = time.monotonic_ns()
        road = secrets.randbelow(2**32 - 1) + 1 if self._key is None else KeyedRoad(self._key, self._role, now_ns)
        link = Link(road, now_ns)
        if self.subscription is not None:
            link.submit(self.subscription)
        return link

    def _run(self) -> None:
        end_ns: Optional[int] = None
        try:
            while end_ns is None or time.monotonic_ns() < end_ns:
                timeout_s = self._send_due()
                readable, _, _ = select.select([self._socket, self._wake_in], [], [], timeout_s)
                with self.changed:
                    if self._wake_in in readable:
                        self._drain_wake()
                    if self._socket in readable:
                        self._receive()
                    self._watch_silence()
                    if end_ns is None and (self._stopping or self.over is not None):
                        end_ns = time.monotonic_ns() + link_module.BYE_PATIENCE_NS
                    self.changed.notify_all()
                    if self._stopping and self._link.finished:
                        break
        except Exception as error:  # whoever waits must hear of it
            with self.changed:
                self.over = self.over or error
                self.changed.notify_all()
        for each in (self._socket, self._wake_in, self._wake_out):
            each.close()

    def _send_due(self) -> float:
        """Sends what is due and returns how long nothing else will be, in s."""
        with self.changed:
            now_ns = time.monotonic_ns()
            if self._link.due_ns() <= now_ns:
                try:
                    self._socket.send(self._link.datagram(now_ns))
                except OSError:
                    pass  # nobody listens, or the buffer is full: a lost datagram like any other
            return max(0.0, (self._link.due_ns() - time.monotonic_ns()) * 1e-9)

    def _drain_wake(self) -> None:
        try:
            while self._wake_in.recv(4096):
                pass
        except BlockingIOError:
            pass

    def _receive(self) -> None:
        for _ in range(_BURST):
            try:
                data = self._socket.recv(2048)
            except OSError:
                return  # all read, or nobody listens
            try:
                arrived = self._link.receive(data, time.monotonic_ns())
            except (SessionLost, ServerFull) as error:
                self._lost(error)
                return
            for _, item in arrived.items:
                if item is not None:
                    self._sort(item)
            if arrived.state is not None:
                self._keep(arrived.state)
            if self._link.ended is not None and self.over is None:
                self.over = SessionEnded(self._link.ended.reason, self._link.ended.message)

    def _watch_silence(self) -> None:
        """A keyed server says nothing to a session it does not know: after 3 s of silence it is HELLO again. PLAIN waits for 10 s."""
        patience_ns = SILENCE_NS if self._link.keyed else ANEW_NS
        if self._link.boot_id != 0 and time.monotonic_ns() - self._link.heard_ns > patience_ns:
            self._lost(SessionLost(f"nothing heard for {patience_ns // 10**9} s"))

    def _lost(self, error: Exception) -> None:
        """The server does not know us: start again, unless that is pointless or not wanted."""
        if not self.reconnect or isinstance(error, ServerFull) or self._stopping:
            self.over = self.over or error
            self._stopping = True
            return
        self._link = self._new_link()

    def _keep(self, state: state_pb2.State) -> None:
        if self.collected is not None:
            self.collected.append(state)
        elif len(self.states) >= self.keep_states:
            self.states.popleft()
            self.states_dropped += 1
        self.states.append(state)
        self.latest = state

    def _sort(self, item: stream_pb2.Item) -> None:
        kind = item.WhichOneof("body")
        if kind == "result":
            if item.result.item_id in self._awaited:
                self._results[item.result.item_id] = item.result
            elif item.result.code != answer_pb2.RESULT_CODE_OK:
                self.failures.append(item.result)
        elif kind not in (None, "bye"):
            body = getattr(item, kind)
            if kind in ("scene_info", "lease_info", "record_info"):
                self.info[kind] = body
            self.events_dropped += len(self.events) == self.events.maxlen
            self.events.append(Event(kind, body))
