"""What can go wrong, as exceptions. A refused request is a `RequestError` with the server's code, path and message; everything about
the connection is a `ConnectionError`."""
from __future__ import annotations

import re
from typing import TYPE_CHECKING, Any, List

from hapticd.v1 import answer_pb2, control_pb2

if TYPE_CHECKING:
    from hapticd.run import RunResult


def enum_name(enum: Any, number: int, prefix: str) -> str:
    """Name of an enum's value without its prefix; a value of a later version stays a number."""
    try:
        return enum.Name(number).removeprefix(prefix)
    except ValueError:
        return str(number)


def _escaped(character: str) -> str:
    control = not character.isprintable() and character != " "
    return f"\\u{ord(character):04x}" if control else character


def shown_text(text: str, kept: str = "") -> str:
    """Text that came from somebody else, as it may stand on a terminal: whatever a terminal would obey instead of showing it is \\uXXXX,
    but for the characters in `kept`."""
    return "".join(character if character in kept else _escaped(character) for character in text)


class StatesLost(ConnectionError):
    """States of a run did not arrive. The run itself is whole: `result` is its RunResult with the States that came, `missing` the ticks
    of those that did not."""

    def __init__(self, result: RunResult, missing: List[int]) -> None:
        self.result, self.missing = result, missing
        which = f"tick {missing[0]}" if len(missing) == 1 else f"ticks {missing[0]} to {missing[-1]}"
        super().__init__(f"{len(missing)} of {len(missing) + len(result.states)} States of the run were lost on the way ({which}); all ticks ran, "
                         "and .result has what came. Run on the server's own machine, where none is lost, subscribe to fewer sections or ticks, "
                         "or give collect=False where States are not needed.")


class RequestError(Exception):
    """The server refused a request, and has changed nothing. `code` is a name such as "NOT_OWNER", `path` the field it is about,
    `message` says what is wrong and what to do."""

    def __init__(self, result: answer_pb2.Result) -> None:
        self._code = result.code
        self.code = enum_name(answer_pb2.ResultCode, result.code, "RESULT_CODE_")
        self.path = shown_text(result.path)
        self.message = shown_text(result.message, kept="\n")
        # What is wrong with a text names its fields itself.
        path = "" if f"{self.path}: " in self.message else self.path
        super().__init__(": ".join(part for part in (self.code, path, self.message) if part))

    def of_file(self, file: str) -> "RequestError":
        """The same, of a text that the server has not read from a file, but that is one's."""
        result = answer_pb2.Result(code=self._code, path=self.path)
        result.message = re.sub("^inline:", lambda _: f"{shown_text(file)}:", self.message, flags=re.MULTILINE)
        return RequestError(result)


class ServerSilent(ConnectionError):
    """Nothing has come from the server for 3 s."""


class ServerFull(ConnectionError):
    """The server has as many sessions as it takes."""


class SessionLost(ConnectionError):
    """The server does not know the session any more, or was restarted: unanswered requests are lost."""


class SessionEnded(ConnectionError):
    """The session is over: closed here, or by the server's Bye. `reason` is a name such as "SHUTDOWN"."""

    def __init__(self, reason: int = 0, message: str = "") -> None:
        self.reason = enum_name(control_pb2.ByeReason, reason, "BYE_REASON_")
        self.message = shown_text(message, kept="\n")
        super().__init__(f"{self.reason}: {self.message}" if message else self.reason)


class ProtocolError(Exception):
    """The peer broke a rule of PROTOCOL.md. If it did so in what it sent as packets, the session ends with Bye PROTOCOL_ERROR; if it gave a
    run an answer that cannot be, only that run has failed."""
