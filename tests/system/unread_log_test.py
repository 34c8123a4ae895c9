"""A log that nobody reads costs the player nothing: sessions, Stop and the end go on, and what is lost of the log is told once it is read."""
import contextlib
import fcntl
import os
import re
import signal
import subprocess
import tempfile
import threading
import unittest

import daemon
import hapticd

STOPS = 150
"""Each latches a fault, which is logged: several pipes full of lines."""


def clear(session):
    session.poses([(0.0, 0.0153, 0.0, 1.0, 0.0, 0.0, 0.0)] * 20)
    # On a busy machine the poses may have run out by then.
    with contextlib.suppress(hapticd.RequestError):
        session.clear()


class UnreadLog(unittest.TestCase):
    def test_stop_is_answered_though_nobody_reads_the_log(self):
        folder = tempfile.TemporaryDirectory()
        process = subprocess.Popen([daemon.HAPTICD, "--listen", "127.0.0.1:0", "--device", "scripted"], stdout=subprocess.PIPE, text=True,
                                   env=dict(os.environ, XDG_STATE_HOME=folder.name))
        try:
            fcntl.fcntl(process.stdout, fcntl.F_SETPIPE_SZ, 8192)
            address = next(found.group(1) for found in (re.search(r"listening on (\S+): ", line) for line in process.stdout) if found)
            with hapticd.Session(address) as session:
                session.acquire("unread")
                for _ in range(STOPS):
                    session.stop()
                    clear(session)
            rest = []
            reader = threading.Thread(target=lambda: rest.extend(process.stdout), daemon=True)
            reader.start()
            with hapticd.Session(address) as session:
                session.acquire("read")
                clear(session)
            process.send_signal(signal.SIGTERM)
            self.assertEqual(process.wait(20), 0)
            reader.join(20)
            lost = [int(found.group(1)) for found in (re.search(r"(\d+) lines of the log are lost", line) for line in rest) if found]
            self.assertEqual(len(lost), 1, "".join(rest))
            self.assertGreater(lost[0], STOPS)
        finally:
            process.kill()
            process.wait()
            process.stdout.close()
            folder.cleanup()


if __name__ == "__main__":
    unittest.main()
