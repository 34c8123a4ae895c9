"""One session after another with one server, without socket, thread and event loop: what came is sorted into results, events and States,
and a server that was restarted or forgot us is joined anew (PROTOCOL.md section 3); what was unanswered then fails. `Connection` drives
it from a thread, `AsyncConnection` from an event loop. Times in ns of time.monotonic_ns()."""
from __future__ import annotations

import secrets
import time
from collections import deque
from dataclasses import dataclass
from typing import Any, Deque, Dict, Iterator, List, NamedTuple, Optional, Set, Union

from google.protobuf.message import Message

from hapticd.ahead import MOST_AHEAD
from hapticd.errors import RequestError, ServerFull, ServerSilent, SessionEnded, SessionLost
from hapticd.key import KeyLike, taken
from hapticd.link import Link
from hapticd.road import KeyedRoad
from hapticd.soundings import Soundings
from hapticd.v1 import answer_pb2, config_pb2, control_pb2, event_pb2, state_pb2, stream_pb2

DEFAULT_PORT = 47800
SILENCE_NS = 3_000_000_000
"""A server that is silent this long, though it must speak every 100 ms, is not there."""
ANEW_NS = 10_000_000_000
"""After this long a silence the session is over on the server's side too, and starts again."""
RECEIVE_BUFFER_BYTES = 1 << 20
MOST_DATAGRAM_BYTES = 2048
"""Read at most of a datagram: more than any that is valid."""
MOST_EVENTS = 1 << 16
MOST_WAITING = 256
"""With more unacknowledged Items than this the caller waits, so that a long path of poses never fills the backlog."""
TOLD = ("scene_info", "lease_info", "record_info")
"""What a server tells a new session first."""


class Event(NamedTuple):
    """`kind` is the name of the Item: tone, contact, string_radius, string_sounding, fault, lease_info, record_info, scene_info. `body` is that message."""

    kind: str
    body: Any


class Collected(NamedTuple):
    """What came during the Run of steps under way."""

    states: List[state_pb2.State]
    events: List[Event]


@dataclass(frozen=True)
class Peer:
    """Whom to talk to and how. `key`: a key file or its bytes; `role`, "control" or "view", instead of its own; without a key the session is
    PLAIN. `keep_states`: unread States that are kept, the newest ones. ValueError below 1, and for an
    address that `host_and_port` does not read."""

    address: str
    reconnect: bool = True
    keep_states: int = 16384
    key: Optional[KeyLike] = None
    role: Optional[str] = None

    def __post_init__(self) -> None:
        if self.keep_states < 1:
            raise ValueError(f"keep_states is {self.keep_states}: at least one State is kept. Without a subscription none comes")
        host_and_port(self.address)


def host_and_port(address: str) -> tuple[str, int]:
    """Of "HOST:PORT", "HOST" or "[IPv6]:PORT". ValueError where the port is no number from 1 to 65535."""
    host, separator, port = address.rpartition(":")
    if not separator or address.endswith("]") or (host.count(":") and not host.endswith("]")):
        host, port = address, str(DEFAULT_PORT)
    if not (port.isascii() and port.isdigit() and 1 <= int(port) <= 65535):
        raise ValueError(f"{address!r} is not HOST:PORT, HOST or [IPv6]:PORT: a port is a number from 1 to 65535, and not {port!r}.")
    return host.strip("[]") or "127.0.0.1", int(port)


FORCE_HOLDS_NS = 20_000_000
"""A forwarder lets go when no State has come for this long."""
LONGEST_PERIOD_NS = 4_000_000
"""Of a tick."""
STATE_HOLDS_NS = 500_000_000
"""Under the real clock a State is over when no newer one has come for this long, or for three times as long as one is apart from the next."""


def without_force(state: state_pb2.State) -> state_pb2.State:
    """A State that is over: what stood where, and no force."""
    over = state_pb2.State()
    over.CopyFrom(state)
    over.loop_state, over.cause = state_pb2.LOOP_STATE_DETACHED, event_pb2.CAUSE_INPUT_STALE
    for tool in over.tools:
        tool.wrench_h_w[:] = [0.0] * len(tool.wrench_h_w)
        del tool.wrench_unlimited_h_w[:]
    return over


class Conversation:
    """The state of it. Whoever drives it sends what `due_datagrams` gives when the link's `due_ns` says so, hands in what arrives, and calls
    `watch_silence` now and then."""

    def __init__(self, peer: Peer) -> None:
        self._key = None if peer.key is None else taken(peer.key, peer.role)
        self.events: Deque[Event] = deque(maxlen=MOST_EVENTS)
        self.events_dropped = 0
        self.states: Deque[state_pb2.State] = deque()
        self.states_dropped = 0
        self.collected: Optional[Collected] = None  # of the Run of steps under way
        self.latest: Optional[state_pb2.State] = None
        self.latest_ns = 0  # when it came
        self.soundings = Soundings()
        self.info: Dict[str, Message] = {}  # newest scene_info, lease_info, record_info of this session
        self.failures: List[answer_pb2.Result] = []  # of requests that are answered only when they fail
        self.epoch = 0  # counts the sessions
        self.over: Optional[Exception] = None
        self.subscription: Optional[stream_pb2.Item] = None
        self.results: Dict[int, answer_pb2.Result] = {}
        self._peer = peer
        self._awaited: Set[int] = set()
        self._stopping = False
        self._link = self._new_link()

    @property
    def link(self) -> Link:
        """The session of now."""
        return self._link

    @property
    def divisor(self) -> int:
        """Of the subscription; 0: there is none."""
        return self.subscription.subscribe.divisor if self.subscription is not None else 0

    def present(self, now_ns: int) -> Optional[state_pb2.State]:
        """The newest State; without its force when it is over."""
        state, scene = self.latest, self.info.get("scene_info")
        if state is None or scene is None or scene.clock != config_pb2.CLOCK_MODE_REALTIME:
            return state
        holds_ns = max(STATE_HOLDS_NS, 3 * self.divisor * LONGEST_PERIOD_NS)
        return state if now_ns - self.latest_ns <= holds_ns else without_force(state)

    def force_holds(self, now_ns: int) -> bool:
        """Whether the newest State came so lately that its force may be passed on."""
        return self.latest is not None and now_ns - self.latest_ns <= FORCE_HOLDS_NS

    # For whoever asks.

    def put(self, item: stream_pb2.Item, awaited: bool = False) -> int:
        """Queues an Item; returns its id. `awaited`: its Result is kept in `results`. Raises if the session is over."""
        self.check()
        item_id = self._link.submit(item)
        if awaited:
            self._awaited.add(item_id)
        return item_id

    def forget_request(self, item_id: int) -> None:
        """Its Result is not awaited any more."""
        self._awaited.discard(item_id)
        self.results.pop(item_id, None)

    def settle(self, item: stream_pb2.Item, result: answer_pb2.Result) -> answer_pb2.Result:
        """What the Result of a request means. RequestError unless it is OK, and for refusals of what was sent before and is answered
        only when it fails."""
        if item.HasField("subscribe") and result.code == answer_pb2.RESULT_CODE_OK:
            self.subscription = item if item.subscribe.divisor else None
        failures, self.failures = self.failures, []
        for each in (*failures, result):
            if each.code != answer_pb2.RESULT_CODE_OK:
                raise RequestError(each)
        return result

    def check(self) -> None:
        """Raises if the session is over."""
        if self.over is not None:
            raise self.over

    def check_waiting(self, epoch: int, survives: bool) -> None:
        """For who has waited since `epoch`: ServerSilent, SessionLost or SessionEnded where it can no longer come true. `survives`: what is
        waited for may come from the session after that one."""
        self.check()
        if self.epoch != epoch and not survives:
            raise SessionLost("the session was lost; the request may or may not have been carried out")
        if time.monotonic_ns() - self._link.heard_ns > SILENCE_NS:
            raise ServerSilent(f"nothing heard for {SILENCE_NS // 10**9} s; is hapticd running there?")

    def begin_collecting(self, states: bool) -> List[state_pb2.State]:
        """What comes from now on is a run's; gives the unread States that make way, if `states` are to come."""
        unread = list(self.states) if states else []
        if states:
            self.states.clear()
        self.collected = Collected([], [])
        return unread

    # For whoever drives it.

    def due_datagrams(self) -> Iterator[bytes]:
        """What has to leave now."""
        now_ns = time.monotonic_ns()
        for _ in range(MOST_AHEAD):
            if self._link.due_ns() > now_ns:
                break
            yield self._link.datagram(now_ns)

    def say_bye(self) -> None:
        """The session is over on this side; the link repeats the Bye until `link.finished`."""
        if self.over is None:
            self.over = SessionEnded(control_pb2.BYE_REASON_DONE, "closed")
            self._link.say_bye(control_pb2.BYE_REASON_DONE)
        self._stopping = True

    def take(self, data: bytes, now_ns: int) -> bool:
        """Takes a datagram. False: the session it belonged to is lost, and what else waits to be read belongs to no other."""
        try:
            arrived = self._link.receive(data, now_ns)
        except (SessionLost, ServerFull) as error:
            self._lost(error)
            return False
        for _, item in arrived.items:
            if item is not None:
                self._sort(item)
        if arrived.state is not None:
            self._keep(arrived.state)
        if self._link.ended is not None and self.over is None:
            self.over = SessionEnded(self._link.ended.reason, self._link.ended.message)
        return True

    def watch_silence(self) -> None:
        """A keyed server says nothing to a session it does not know: after 3 s of silence it is HELLO again. PLAIN waits for 10 s."""
        patience_ns = SILENCE_NS if self._link.keyed else ANEW_NS
        if self._link.boot_id != 0 and time.monotonic_ns() - self._link.heard_ns > patience_ns:
            self._lost(SessionLost(f"nothing heard for {patience_ns // 10**9} s"))

    @property
    def ending(self) -> bool:
        """Nothing will be asked any more: what is left to say is Bye, for BYE_PATIENCE_NS at most."""
        return self._stopping or self.over is not None

    def _new_link(self) -> Link:
        self.epoch += 1
        self.info = {}
        self.results.clear()
        self._awaited.clear()
        now_ns = time.monotonic_ns()
        road: Union[int, KeyedRoad] = secrets.randbelow(2**32 - 1) + 1 if self._key is None else KeyedRoad(self._key, now_ns)
        link = Link(road, now_ns)
        if self.subscription is not None:
            link.submit(self.subscription)
        return link

    def _lost(self, error: Exception) -> None:
        """The server does not know us: start again, unless that is pointless or not wanted."""
        if not self._peer.reconnect or isinstance(error, ServerFull) or self._stopping:
            self.over = self.over or error
            self._stopping = True
            return
        self._link = self._new_link()

    def _keep(self, state: state_pb2.State) -> None:
        if self.collected is not None:
            self.collected.states.append(state)
        elif len(self.states) >= self._peer.keep_states:
            self.states.popleft()
            self.states_dropped += 1
        self.states.append(state)
        self.latest, self.latest_ns = state, time.monotonic_ns()
        self.soundings.take_state(state)

    def _sort(self, item: stream_pb2.Item) -> None:
        kind = item.WhichOneof("body")
        if kind == "result":
            if item.result.item_id in self._awaited:
                self.results[item.result.item_id] = item.result
            elif item.result.code != answer_pb2.RESULT_CODE_OK:
                self.failures.append(item.result)
        elif kind is not None and kind != "bye":
            event = Event(kind, getattr(item, kind))
            if kind in TOLD:
                self.info[kind] = event.body
            if kind == "scene_info":
                self.soundings.begin(event.body)
            elif kind == "string_sounding":
                self.soundings.take(event.body)
            self.events_dropped += len(self.events) == self.events.maxlen
            self.events.append(event)
            if self.collected is not None:
                self.collected.events.append(event)
