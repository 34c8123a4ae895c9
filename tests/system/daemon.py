"""Starts hapticd for a test, on a port that it finds free itself, and ends it; and what tests in lockstep share."""
import os
import re
import signal
import socket
import subprocess
import sys
import threading
import time
import unittest

HAPTICD = os.environ["HAPTICD"]
START_TIMEOUT_S = 60.0


def free_port():
    """A port that is free now, for a program that cannot tell which one it takes."""
    with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as probe:
        probe.bind(("127.0.0.1", 0))
        return probe.getsockname()[1]


def run(*options, timeout=60):
    """A daemon that ends by itself: (exit code, what it wrote to stderr)."""
    done = subprocess.run([HAPTICD, *options], stderr=subprocess.PIPE, stdout=subprocess.PIPE, text=True, timeout=timeout)
    return done.returncode, done.stderr + done.stdout


def said(*command, **process):
    """(exit code, stdout, stderr)"""
    done = subprocess.run(command, capture_output=True, text=True, timeout=60, check=False, stdin=subprocess.DEVNULL, **process)
    return done.returncode, done.stdout, done.stderr


class Daemon:
    """Context manager: plays until the end of the block, at `address`; `log` has its lines afterwards."""

    def __init__(self, *options, state=None, host="127.0.0.1", port=None, environment=None, cwd=None):
        self.address = ""
        environment = dict(os.environ, XDG_STATE_HOME=state or "/nonexistent", **(environment or {}))
        self.process = subprocess.Popen([HAPTICD, "--listen", f"{host}:{port or 0}", *options], stdout=subprocess.PIPE,
                                        stderr=subprocess.STDOUT, text=True, env=environment, cwd=cwd)
        self.log = ""
        self.rest = []
        self.reader = None

    def __enter__(self):
        end = time.monotonic() + START_TIMEOUT_S
        lines = []
        for line in self.process.stdout:
            lines.append(line)
            listens = re.search(r"listening on (\S+): ", line)
            if listens:
                self.address = listens.group(1)
                break
            if time.monotonic() > end:
                raise RuntimeError("hapticd does not start:\n" + "".join(lines))
        self.log = "".join(lines)
        # A pipe that nobody reads is full after some hundred lines, and the daemon then waits in its log.
        self.reader = threading.Thread(target=lambda: self.rest.extend(self.process.stdout), daemon=True)
        self.reader.start()
        return self

    def end(self, how=signal.SIGTERM):
        """Exit code after the signal."""
        if self.process.poll() is None:
            self.process.send_signal(how)
        code = self.process.wait(timeout=START_TIMEOUT_S)
        if self.reader:
            self.reader.join(timeout=START_TIMEOUT_S)
        self.log += "".join(self.rest)
        self.rest.clear()
        self.process.stdout.close()
        return code

    def __exit__(self, error, *_):
        code = self.process.poll()
        if not self.process.stdout.closed:
            self.end(signal.SIGKILL)
        if error is not None:
            print(f"hapticd {'ran' if code is None else f'had ended with {code}'}; its log:\n{self.log}", file=sys.stderr)


class LockstepCase(unittest.TestCase):
    """Tests of one daemon with the virtual clock and scripted devices; `session` has the lease."""

    @classmethod
    def setUpClass(cls):
        import hapticd  # not every test has the package
        cls.played = Daemon("--clock", "virtual", "--device", "scripted", "--scene", "single_string")
        cls.played.__enter__()
        cls.session = hapticd.Session(cls.played.address)
        cls.session.__enter__()
        cls.session.acquire("test")

    @classmethod
    def tearDownClass(cls):
        cls.session.__exit__(None, None, None)
        cls.played.__exit__(None, None, None)
