"""A headless Chromium that is driven through a pair of pipes: DevTools messages, JSON with a NUL behind each, on its descriptors 3 and 4.
Needs nothing but Debian's package chromium; its profile is its own and goes with it."""
from __future__ import annotations

import base64
import fcntl
import json
import os
import select
import shutil
import signal
import tempfile
import time
from typing import Any, Dict, Optional, Tuple

FLAGS = ("--headless", "--no-sandbox", "--use-gl=angle", "--use-angle=gl-egl", "--ignore-gpu-blocklist", "--disable-background-networking",
         "--disable-quic", "--no-first-run", "--disable-sync", "--hide-scrollbars", "--mute-audio", "--remote-debugging-pipe")
ANSWER_S = 120.0
"""What one answer may take: the first picture of a busy machine without GPU takes seconds."""
END_S = 10.0
"""What it gets to end itself before it is killed."""
HIGH = 10
"""Descriptors below are free for the child's own numbers."""


class ChromiumError(RuntimeError):
    """It is missing, died, or refused something; the text is for people."""


def _pipe() -> Tuple[int, int]:
    ends = os.pipe()
    high = [fcntl.fcntl(end, fcntl.F_DUPFD_CLOEXEC, HIGH) for end in ends]
    for end in ends:
        os.close(end)
    return high[0], high[1]


def program() -> str:
    """Where it is."""
    found = shutil.which("chromium")
    if found is None:
        raise ChromiumError("there is no chromium. Install it: apt-get install chromium libgl1-mesa-dri libegl1")
    return found


class Chromium:
    """One browser with one page of `size` pixels, by `with`."""

    def __init__(self, size: Tuple[int, int]) -> None:
        command = program()
        self._folder = tempfile.mkdtemp(prefix="hapticd-chromium-")
        self._log = os.path.join(self._folder, "log")
        self._buffer = b""
        self._last_id = 0
        self._session: Optional[str] = None
        commands, self._write = _pipe()
        self._read, answers = _pipe()
        mode = os.O_WRONLY | os.O_CREAT | os.O_TRUNC
        actions = [(os.POSIX_SPAWN_DUP2, commands, 3), (os.POSIX_SPAWN_DUP2, answers, 4),
                   (os.POSIX_SPAWN_OPEN, 0, os.devnull, os.O_RDONLY, 0), (os.POSIX_SPAWN_OPEN, 1, self._log, mode, 0o600),
                   (os.POSIX_SPAWN_DUP2, 1, 2)]
        argv = [command, *FLAGS, f"--user-data-dir={os.path.join(self._folder, 'profile')}", f"--window-size={size[0]},{size[1]}", "about:blank"]
        self._process = os.posix_spawn(command, argv, dict(os.environ), file_actions=actions, setpgroup=0)
        os.close(commands)
        os.close(answers)
        try:
            target = self.call("Target.createTarget", url="about:blank")["targetId"]
            self._session = self.call("Target.attachToTarget", targetId=target, flatten=True)["sessionId"]
            self.call("Emulation.setDeviceMetricsOverride", width=size[0], height=size[1], deviceScaleFactor=1, mobile=False)
            self.call("Page.enable")
        except BaseException:
            self.close()
            raise

    def __enter__(self) -> "Chromium":
        return self

    def __exit__(self, *_: object) -> None:
        self.close()

    def _message(self, end: float) -> Dict[str, Any]:
        while b"\0" not in self._buffer:
            readable, _, _ = select.select([self._read], [], [], max(0.0, end - time.monotonic()))
            if not readable:
                raise ChromiumError(f"chromium does not answer within {ANSWER_S:.0f} s. Try again when the machine is less busy")
            more = os.read(self._read, 1 << 20)
            if not more:
                raise ChromiumError(f"chromium ended: {self._last_words()}")
            self._buffer += more
        message, _, self._buffer = self._buffer.partition(b"\0")
        return json.loads(message)

    def _last_words(self) -> str:
        try:
            with open(self._log, encoding="utf-8", errors="replace") as file:
                return file.read()[-500:].strip() or "it said nothing"
        except OSError:
            return "it said nothing"

    def call(self, method: str, **parameters: Any) -> Dict[str, Any]:
        """A DevTools command for the page; its result. Events that come meanwhile are left out."""
        self._last_id += 1
        request = {"id": self._last_id, "method": method, "params": parameters}
        if self._session is not None:
            request["sessionId"] = self._session
        rest = json.dumps(request).encode() + b"\0"
        try:
            while rest:
                rest = rest[os.write(self._write, rest):]
        except BrokenPipeError:
            raise ChromiumError(f"chromium ended: {self._last_words()}") from None
        end = time.monotonic() + ANSWER_S
        while True:
            answer = self._message(end)
            if answer.get("id") != self._last_id:
                continue
            if "error" in answer:
                raise ChromiumError(f"chromium refuses {method}: {answer['error'].get('message')}")
            return answer.get("result", {})

    def evaluate(self, expression: str) -> Any:
        """Value of an expression in the page; of a promise what it resolves to."""
        result = self.call("Runtime.evaluate", expression=expression, awaitPromise=True, returnByValue=True)
        if "exceptionDetails" in result:
            details = result["exceptionDetails"]
            raise ChromiumError(f"the page: {details.get('exception', {}).get('description', details.get('text'))}")
        return result["result"].get("value")

    def picture(self) -> bytes:
        """What the page looks like now, as JPEG."""
        return base64.b64decode(self.call("Page.captureScreenshot", format="jpeg", quality=95, optimizeForSpeed=True)["data"])

    def close(self) -> None:
        """Ends it, whatever it does, with all its processes, and takes its profile away."""
        self._session = None
        try:
            self.call("Browser.close")
            end = time.monotonic() + END_S
            while time.monotonic() < end:
                self._message(end)
        except (ChromiumError, OSError):
            pass  # it has ended, or is ended now
        try:
            os.killpg(self._process, signal.SIGKILL)
        except ProcessLookupError:
            pass
        os.waitpid(self._process, 0)
        os.close(self._read)
        os.close(self._write)
        shutil.rmtree(self._folder, ignore_errors=True)
