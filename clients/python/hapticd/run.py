"""A run in lockstep: the poses and steps it sends, in pieces that the server's queue holds, and the States and events that are its own."""
from __future__ import annotations

import contextlib
import operator
import os
import pathlib
from dataclasses import dataclass, field
from typing import List, Optional, Sequence

from hapticd.conversation import Collected, Conversation, Event
from hapticd.errors import ProtocolError, RequestError, ServerSilent, StatesLost
from hapticd.requests import Ask, Look, Send, Until, Work, poses, run_item, scene_id, simple
from hapticd.tables import EVENT_KINDS, Table, event_table, table
from hapticd.v1 import answer_pb2, control_pb2, state_pb2
from hapticd.values import pose_rows

QUEUE_SAMPLES = 4096
"""What the server queues per scripted tool; a longer path is run in pieces."""
RUN_PIECE = QUEUE_SAMPLES // 2
MOST_RUN_STEPS = 1_000_000_000
"""As for Run.steps in control.proto."""
MOST_RUN_STATES = 1_000_000
"""States that one run collects: a kilobyte or more each."""
STRAGGLERS_S = 0.5
"""How long States may come after the answer to their run. Longer ones are lost: the server sends them once."""


@dataclass(frozen=True)
class RunResult:
    """What a lockstep run did: ticks advanced, the tick that would run next, the hash over the States of all ticks since the scene was
    loaded, the ticks without a sample of some scripted tool, and of its own ticks, in order, the States that were subscribed to and all
    events."""

    steps: int
    next_tick: int
    state_hash: bytes
    held_inputs: int
    states: List[state_pb2.State] = field(default_factory=list, repr=False, compare=False)
    events: List[Event] = field(default_factory=list, repr=False, compare=False)

    def table(self, tool_id: int = 0) -> Table:
        """The States of a tool as columns: see hapticd.table."""
        return table(self.states, tool_id)

    def event_table(self, kind: str = "tone") -> Table:
        """The events of one kind as columns: see hapticd.event_table."""
        return event_table(self.events, kind)

    def export(self, folder: "str | os.PathLike[str]") -> List[pathlib.Path]:
        """Writes the run into a folder, which is made: tool_0.csv and so on, a row for each State, and for each kind of event a file such
        as tone.csv. Returns the paths. What has these names there is replaced."""
        place = pathlib.Path(folder)
        place.mkdir(parents=True, exist_ok=True)
        tables = {f"tool_{tool_id}": self.table(tool_id) for tool_id in sorted({tool.tool_id for state in self.states for tool in state.tools})}
        tables.update((kind, self.event_table(kind)) for kind in EVENT_KINDS)
        paths = []
        for name, each in tables.items():
            paths.append(place / f"{name}.csv")
            each.to_csv(paths[-1])
        return paths


def run(steps: Optional[int], path: Optional[Sequence[Sequence[float]]], tool_id: int, collect: bool) -> Work[RunResult]:
    """A run of `steps` ticks along a path. No other run of the session may be under way; whoever drives it ends the collecting."""
    rows = [] if path is None else pose_rows(path)  # all of them are judged before the first is sent
    left = len(rows) if steps is None else operator.index(steps)
    if not 1 <= left <= MOST_RUN_STEPS:
        raise ValueError(f"a run has 1 to {MOST_RUN_STEPS} steps, not {left}")
    subscribed = yield Look(lambda conversation: conversation.divisor)
    divisor = subscribed if collect else 0
    if divisor and left // divisor > MOST_RUN_STATES:
        raise ValueError(f"{left} steps give {left // divisor} States, and a run collects {MOST_RUN_STATES} at most: run in pieces, "
                         "subscribe with a larger divisor, or give collect=False")
    if not collect:
        return (yield from _advance(rows, left, tool_id))
    unread = yield Look(lambda conversation: conversation.begin_collecting(bool(divisor)))
    try:
        result = yield from _advance(rows, left, tool_id)
        missing = (yield from _await_states(result, divisor)) if divisor else []
        yield from _take_events(result)
    except RequestError:
        yield Look(lambda conversation: conversation.states.extendleft(reversed(unread)))
        raise
    if missing:
        raise StatesLost(result, missing)
    return result


def _advance(rows: List[List[float]], left: int, tool_id: int) -> Work[RunResult]:
    """Runs `left` steps along the rows, in pieces that the server's queue holds. Whoever interrupts it stops time as well, and so does a
    server that falls silent, as soon as it hears of it."""
    done, held, at = 0, 0, 0
    while True:
        yield from poses(rows[at:at + min(left, RUN_PIECE)], None, tool_id)
        piece = min(left, RUN_PIECE) if at < len(rows) else left
        yield from simple("ping")  # raises what was refused of the poses before any tick runs without them
        try:
            answer = (yield Ask(run_item(control_pb2.RUN_MODE_STEP, piece))).run
        except BaseException as error:
            interrupted = not isinstance(error, (Exception, GeneratorExit))  # by a key, or as a cancelled task
            if interrupted or isinstance(error, ServerSilent):
                with contextlib.suppress(Exception):
                    yield Send(run_item(control_pb2.RUN_MODE_STOP), at_once=True)
            raise
        _check_answer(answer, piece)
        done, held, at, left = done + answer.steps, held + answer.held_inputs, at + piece, left - piece
        if left <= 0 or answer.steps < piece:
            return RunResult(done, answer.next_tick, answer.state_hash, held)


def _check_answer(answer: answer_pb2.RunResult, piece: int) -> None:
    """ProtocolError for what no run of so many steps comes to: it says how much is waited for."""
    if answer.steps > piece or answer.next_tick < answer.steps:
        raise ProtocolError(f"the server says that of {piece} steps {answer.steps} were run, up to tick {answer.next_tick}")


def _await_states(result: RunResult, divisor: int) -> Work[List[int]]:
    """Puts the States of the run into its result; the ticks of those that do not come."""
    begin = max(0, result.next_tick - result.steps)
    wanted = range(-(-begin // divisor) * divisor, result.next_tick, divisor)

    def last_is_there(conversation: Conversation) -> bool:
        scene = scene_id(conversation)
        return not wanted or any(state.scene_id == scene and state.tick >= wanted[-1] for state in _collected(conversation).states[-1:])

    def of_the_run(conversation: Conversation) -> List[state_pb2.State]:
        scene = scene_id(conversation)
        return [state for state in _collected(conversation).states if state.scene_id == scene and state.tick in wanted]

    yield Until(last_is_there, STRAGGLERS_S)
    found = {state.tick: state for state in (yield Look(of_the_run))}
    result.states.extend(found[tick] for tick in sorted(found))
    return [tick for tick in wanted if tick not in found]


def _take_events(result: RunResult) -> Work[None]:
    """Puts the events of the run's ticks into its result. They came before its Result: Items are in order. Those of tick k have instants
    after that of tick k - 1, up to its own."""

    def of_the_run(conversation: Conversation) -> List[Event]:
        info = conversation.info.get("scene_info")
        period_ns = round(1e9 / getattr(info, "rate_hz", 1e3))
        begin_ns = (result.next_tick - result.steps - 1) * period_ns
        return [event for event in _collected(conversation).events if event.kind in EVENT_KINDS and event.body.t_ns > begin_ns]
    result.events.extend((yield Look(of_the_run)))


def _collected(conversation: Conversation) -> Collected:
    return conversation.collected or Collected([], [])
