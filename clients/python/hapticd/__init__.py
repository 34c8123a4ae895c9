"""hapticd from Python: a session with the haptic daemon over UDP, in pure Python on python3-protobuf. Begin with `Session`; README.md
has a script of five minutes. The wire types are in `hapticd.v1`; numpy is used where it is installed."""
from hapticd.clock import ClockEstimate
from hapticd.connection import Event
from hapticd.errors import ProtocolError, RequestError, ServerFull, ServerSilent, SessionEnded, SessionLost, StatesLost
from hapticd.session import RunResult, Session
from hapticd.values import as_array, columns, contacts, tool_state

__all__ = ["ClockEstimate", "Event", "ProtocolError", "RequestError", "RunResult", "ServerFull", "ServerSilent", "Session", "SessionEnded",
           "SessionLost", "StatesLost", "as_array", "columns", "contacts", "tool_state"]
