"""The key of a server with keys, as a file of `hapticctl keygen` has it (PROTOCOL.md section 12): 72 bytes, "hapticd", the role, the psk, and
the public half of the daemon's own key, by which a client knows the daemon."""
from __future__ import annotations

import os
import stat
from typing import NamedTuple, Optional, Union

ROLES = {"view": 1, "control": 2}
KEY_BYTES = 32
_MARK = b"hapticd"
_FILE_BYTES = len(_MARK) + 1 + 2 * KEY_BYTES

KeyLike = Union[bytes, str, "os.PathLike[str]"]


class SessionKey(NamedTuple):
    """What is in a key file."""

    role: int
    psk: bytes
    server: bytes


def _read(path: "Union[str, os.PathLike[str]]") -> bytes:
    with open(path, "rb") as file:
        if stat.S_IMODE(os.fstat(file.fileno()).st_mode) & 0o077:
            raise ValueError(f"{os.fspath(path)}: others may access it. Run 'chmod 600 {os.fspath(path)}', and make new keys if they may have "
                             "read it")
        return file.read(_FILE_BYTES + 1)


def taken(key: KeyLike, role: Optional[str] = None) -> SessionKey:
    """The key in a file, or in its bytes; `role`, "view" or "control", instead of its own. ValueError with the remedy where it is none, or
    one of hapticd 0.1, or where others may access the file."""
    what = "" if isinstance(key, bytes) else f"{os.fspath(key)}: "
    data = key if isinstance(key, bytes) else _read(key)
    if len(data) == KEY_BYTES:
        raise ValueError(f"{what}a key of an earlier version, by which nobody can tell the daemon from another that has the key. Run 'hapticctl "
                         "keygen DIR' on the folder of hapticd --keys, which keeps its keys, and copy the file from there again")
    if len(data) != _FILE_BYTES or not data.startswith(_MARK) or data[len(_MARK)] not in ROLES.values():
        raise ValueError(f"{what}not a key: view.key, control.key and those of clients have {_FILE_BYTES} bytes, this has {len(data)}. Make "
                         "keys with 'hapticctl keygen DIR'")
    psk_at = len(_MARK) + 1
    own = data[len(_MARK)]
    return SessionKey(own if role is None else ROLES[role], data[psk_at:psk_at + KEY_BYTES], data[psk_at + KEY_BYTES:])
