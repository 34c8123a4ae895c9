"""hapticd writes entries with priority and fields into the journal, where its stderr is the journal's. The journal is this test: its socket, in
the format of https://systemd.io/JOURNAL_NATIVE_PROTOCOL."""
import os
import pathlib
import signal
import socket
import subprocess
import sys
import tempfile
import time
import unittest

import apart
import daemon
import hapticd

FOLDER = "/run/systemd/journal"
PATIENCE_S = 60.0


def parse(datagram):
    """{name: text} of an entry."""
    fields, rest = {}, datagram
    while rest:
        line, _, rest = rest.partition(b"\n")
        name, equals, value = line.partition(b"=")
        if not equals:
            size = int.from_bytes(rest[:8], "little")
            value, rest = rest[8:8 + size], rest[8 + size + 1:]
        fields[name.decode()] = value.decode()
    return fields


class JournalCase(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        apart.own_folder(FOLDER)

    def setUp(self):
        self.journal = socket.socket(socket.AF_UNIX, socket.SOCK_DGRAM)
        self.addCleanup(self.journal.close)
        path = pathlib.Path(FOLDER) / "socket"
        path.unlink(missing_ok=True)
        self.journal.bind(str(path))
        self.journal.settimeout(0.05)
        self.entries = []

    def start(self, *options, right=True):
        """hapticd whose stderr is a file that JOURNAL_STREAM names, or does not."""
        self.stderr = tempfile.TemporaryFile()
        self.addCleanup(self.stderr.close)
        status = os.fstat(self.stderr.fileno())
        stream = f"{status.st_dev}:{status.st_ino if right else status.st_ino + 1}"
        self.address = f"127.0.0.1:{daemon.free_port()}"
        process = subprocess.Popen([daemon.HAPTICD, "--listen", self.address, *options], stdout=subprocess.DEVNULL,
                                   stderr=self.stderr, env=dict(os.environ, JOURNAL_STREAM=stream, XDG_STATE_HOME="/nonexistent"))
        self.addCleanup(process.wait)
        self.addCleanup(process.kill)
        return process

    def written(self):
        self.stderr.seek(0)
        return self.stderr.read().decode()

    def wait_for(self, **wanted):
        """The first entry with these fields."""
        end = time.monotonic() + PATIENCE_S
        seen = 0
        while time.monotonic() < end:
            for entry in self.entries[seen:]:
                if all(entry.get(name) == value for name, value in wanted.items()):
                    return entry
            seen = len(self.entries)
            try:
                self.entries.append(parse(self.journal.recv(65536)))
            except TimeoutError:
                pass
        raise AssertionError(f"no {wanted} among {self.entries}")

    def test_a_fault_is_found_by_its_fields(self):
        self.start("--scene", "sphere", "--inject", "lost:1", "--clock", "virtual")
        with hapticd.Session(self.address) as session:
            session.acquire("test")
            session.run(steps=3000)
        fault = self.wait_for(HAPTICD_EVENT="fault")
        self.assertEqual(fault["HAPTICD_FAULT"], "INPUT_STALE")
        self.assertEqual(fault["PRIORITY"], "3")
        self.assertEqual((fault["HAPTICD_SCENE"], fault["HAPTICD_DEVICE"]), ("sphere", "simulated"))
        self.assertEqual(fault["SYSLOG_IDENTIFIER"], "hapticd")
        self.assertRegex(fault["MESSAGE_ID"], "^[0-9a-f]{32}$")
        # The text says the same as the fields.
        self.assertEqual(fault["MESSAGE"], f"fault INPUT_STALE latched at tick {fault['HAPTICD_TICK']}")
        self.assertEqual(self.wait_for(HAPTICD_STATE="ENGAGED")["PRIORITY"], "6")
        self.assertEqual(self.written(), "")

    def test_the_scene_of_an_entry_is_the_one_that_plays(self):
        with tempfile.TemporaryDirectory() as folder:
            path = pathlib.Path(folder) / "my.textproto"
            path.write_text('scene: "sphere"\n')
            process = self.start("--config", str(path))
            self.wait_for(HAPTICD_STATE="ENGAGED", HAPTICD_SCENE="sphere")
            path.write_text('scene: "wall"\n')
            process.send_signal(signal.SIGHUP)
            # Whatever it says at the end, it says it of the scene that plays then.
            with hapticd.Session(self.address, reconnect=False) as session:
                while session.scene.scene.name != "wall":
                    session.ping()
            process.send_signal(signal.SIGTERM)
            self.wait_for(HAPTICD_STATE="OVER", HAPTICD_SCENE="wall")

    def test_why_it_does_not_start_is_an_error_in_the_journal(self):
        process = self.start("--scene", "no_such_scene")
        refused = self.wait_for(HAPTICD_EVENT="refused")
        self.assertEqual(refused["PRIORITY"], "3")
        self.assertIn("no scene of this name", refused["MESSAGE"])
        self.assertEqual(process.wait(PATIENCE_S), 1)

    def test_another_stderr_is_written_to_as_ever(self):
        process = self.start("--scene", "no_such_scene", right=False)
        self.assertEqual(process.wait(PATIENCE_S), 1)
        self.assertIn("no scene of this name", self.written())
        with self.assertRaises(TimeoutError):
            self.journal.recv(65536)


if __name__ == "__main__":
    apart.go_apart()
    unittest.main(argv=sys.argv[:1])
