"""What a core dump of a daemon with keys would hold: no key of its folder, and none of a session. Judged by what the kernel would dump, searched byte
by byte while the daemon runs, after sessions of both roles, a Stop and a new client's key."""
import os
import pathlib
import re
import subprocess
import tempfile
import unittest
from unittest import mock

import daemon
import hapticd
from hapticd import noise

CTL = os.environ["HAPTICCTL"]
LEAST = 16
"""Bytes of a key in a row that are told from chance."""


def dumped(pid):
    """The memory that a core dump would hold: private and readable, but what is marked DONTDUMP."""
    first = end = 0
    with open(f"/proc/{pid}/smaps", encoding="ascii") as maps, open(f"/proc/{pid}/mem", "rb", buffering=0) as memory:
        for line in maps:
            if found := re.match(r"([0-9a-f]+)-([0-9a-f]+) (....)", line):
                first, end, rights = int(found[1], 16), int(found[2], 16), found[3]
            elif line.startswith("VmFlags:") and rights[0] == "r" and rights[3] == "p" and not {"dd", "io"} & set(line.split()[1:]):
                for at in range(first, end, 1 << 24):
                    try:
                        yield os.pread(memory.fileno(), min(1 << 24, end - at) + LEAST, at)
                    except OSError:
                        yield os.pread(memory.fileno(), min(1 << 24, end - at), at)


class SeenCipher(noise.Cipher):
    """Remembers the keys of sessions, which are both ends' alike."""

    keys = []

    def __init__(self, key):
        super().__init__(key)
        self.keys.append(bytes(key))


class SecretsInMemory(unittest.TestCase):
    def test_no_key_is_where_a_core_dump_would_find_it(self):
        with tempfile.TemporaryDirectory() as folder:
            keys = pathlib.Path(folder) / "keys"
            subprocess.run([CTL, "keygen", str(keys)], check=True, capture_output=True)
            subprocess.run([CTL, "keygen", "--client", "guest", "--role", "view", str(keys)], check=True, capture_output=True)
            with daemon.Daemon("--scene", "single_string", "--keys", str(keys)) as played:
                with mock.patch.object(noise, "Cipher", SeenCipher):
                    opened = [hapticd.Session(played.address, key=(keys / name).read_bytes(), role=role)
                              for name, role in (("view.key", "view"), ("control.key", "control"), ("clients/guest.key", "view"))]
                for session in opened:
                    session.ping()
                subprocess.run([CTL, "--server", played.address, "--key", str(keys / "control.key"), "stop"], check=True, capture_output=True)
                secrets = {"stop.key": (keys / "stop.key").read_bytes(), "server.key": (keys / "server.key").read_bytes()}
                for name in ("view.key", "control.key", "clients/guest.key"):
                    secrets[name] = (keys / name).read_bytes()[8:40]
                secrets |= {f"cipher {number}": key for number, key in enumerate(SeenCipher.keys)}
                where = {name: 0 for name in secrets}
                seen = 0
                for piece in dumped(played.process.pid):
                    seen += len(piece)
                    for name, secret in secrets.items():
                        where[name] += secret[:LEAST] in piece or secret[-LEAST:] in piece
                for session in opened:
                    session.close()
                self.assertEqual(played.end(), 0)
        self.assertGreater(seen, 1 << 20)
        self.assertGreaterEqual(len(secrets), 5 + 2 * 3)
        self.assertEqual(where, {name: 0 for name in secrets})


if __name__ == "__main__":
    unittest.main()
