"""hapticd from Python: a session with the haptic daemon over UDP, in pure Python on python3-protobuf. Begin with `Session`, or in asyncio with
`AsyncSession`; README.md has a script of five minutes. The wire types are in `hapticd.v1`; numpy is used where it is installed."""
from typing import TYPE_CHECKING

from hapticd.async_session import AsyncSession
from hapticd.clock import ClockEstimate
from hapticd.conversation import Event
from hapticd.errors import ProtocolError, RequestError, ServerFull, ServerSilent, SessionEnded, SessionLost, StatesLost
from hapticd.run import RunResult
from hapticd.session import Session
from hapticd.soundings import sounding_at
from hapticd.stop_road import Heartbeat, StopRoad, stop
from hapticd.tables import Table, event_table, table
from hapticd.values import as_array, contacts, tool_state

__all__ = ["AsyncSession", "ClockEstimate", "Event", "Heartbeat", "ProtocolError", "RequestError", "RunResult", "ServerFull", "ServerSilent", "Session",
           "SessionEnded", "SessionLost", "StatesLost", "StopRoad", "Table", "as_array", "contacts", "event_table", "sounding_at", "stop",
           "table", "tool_state"]

if TYPE_CHECKING:
    __version__: str
else:
    def __getattr__(name):
        """`__version__` is that of the installed package, or of the build tree."""
        if name == "__version__":
            from importlib import metadata  # takes as long as the rest of the package
            return metadata.version("hapticd")
        raise AttributeError(f"module 'hapticd' has no attribute {name!r}")
