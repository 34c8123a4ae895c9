"""Videos of recordings: haptic-web shows a recording to a headless Chromium, the page draws instant after instant, and ffmpeg makes WebM
of the pictures. A frame of the video is an instant of the recording, however slowly it is drawn; no clock takes part."""
from __future__ import annotations

import json
import math
import os
import pathlib
import re
import select
import shutil
import subprocess
import tempfile
import time
from typing import Callable, Iterator, List, Optional, Tuple
from urllib.parse import urlencode

from hapticd_lab import chromium
from hapticd_lab.chromium import Chromium

START_S = 60.0
"""What haptic-web gets to open the recording."""
END_S = 10.0
"""What a program gets to end itself before it is killed."""
LOADED_S = 60.0
"""What the page gets to be there."""
VP9 = ("-c:v", "libvpx-vp9", "-crf", "30", "-b:v", "0", "-deadline", "good", "-cpu-used", "5", "-row-mt", "1", "-pix_fmt", "yuv420p", "-g", "250")
"""Good enough for the thin lines of strings and plots, at about 20 frames/s on one core."""

Progress = Callable[[int, int], None]
"""Told after each frame: frames done, frames in all."""


class VideoError(RuntimeError):
    """A video cannot be made; the text says why, and what to do."""


def frame_times(duration_s: float, frames_per_s: float, speed: float = 1.0) -> List[float]:
    """Instants of the recording, from its beginning to its end at most: frame k is that of k `speed` / `frames_per_s`."""
    step = speed / frames_per_s
    return [k * step for k in range(math.floor(duration_s / step * (1.0 + 1e-12)) + 1)]


def _program(name: str, package: str) -> str:
    found = shutil.which(name)
    if found is None:
        raise VideoError(f"there is no {name}. Install it: apt-get install {package}")
    return found


def _end(process: "subprocess.Popen[bytes]") -> None:
    process.terminate()
    try:
        process.wait(END_S)
    except subprocess.TimeoutExpired:
        process.kill()
        process.wait()


class Gateway:
    """haptic-web with a recording, at `address`, by `with`."""

    def __init__(self, program: str, recording: pathlib.Path) -> None:
        command = [program, "--replay", str(recording), "--listen", "127.0.0.1:0"]
        try:
            self._process = subprocess.Popen(command, stdin=subprocess.DEVNULL, stdout=subprocess.PIPE, stderr=subprocess.STDOUT)
        except OSError as error:
            raise VideoError(f"haptic-web cannot be started: {error}. It is built and installed with hapticd") from None
        try:
            self.address = self._address()
        except BaseException:
            self.__exit__()
            raise

    def _address(self) -> str:
        output, said = self._process.stdout, b""
        assert output is not None
        end = time.monotonic() + START_S
        while time.monotonic() < end:
            if not select.select([output], [], [], max(0.0, end - time.monotonic()))[0]:
                break
            more = os.read(output.fileno(), 4096)
            said += more
            match = re.search(rb"Open (http://\S+)", said)
            if match:
                return match[1].decode()
            if not more:
                raise VideoError(said.decode(errors="replace").strip() or "haptic-web ended without a word")
        raise VideoError(f"haptic-web does not open {self._process.args[2]} within {START_S:.0f} s")

    def __enter__(self) -> "Gateway":
        return self

    def __exit__(self, *_: object) -> None:
        _end(self._process)
        assert self._process.stdout is not None
        self._process.stdout.close()


class Encoder:
    """ffmpeg: pictures in, WebM out, by `with`. The file is there when all went well, and not before."""

    def __init__(self, output: pathlib.Path, frames_per_s: float) -> None:
        self._output, self._part = output, output.with_name(f".{output.name}.part")
        self._log = tempfile.TemporaryFile()
        command = [_program("ffmpeg", "ffmpeg"), "-loglevel", "error", "-f", "image2pipe", "-c:v", "mjpeg", "-framerate", f"{frames_per_s:g}",
                   "-i", "-", "-an", *VP9, "-f", "webm", "-y", str(self._part)]
        self._process = subprocess.Popen(command, stdin=subprocess.PIPE, stdout=subprocess.DEVNULL, stderr=self._log)

    def add(self, picture: bytes) -> None:
        """The next frame, JPEG."""
        assert self._process.stdin is not None
        try:
            self._process.stdin.write(picture)
        except BrokenPipeError:
            raise VideoError(f"ffmpeg ended: {self._words()}") from None

    def _words(self) -> str:
        self._process.wait()
        self._log.seek(0)
        return self._log.read().decode(errors="replace").strip() or f"exit code {self._process.returncode}"

    def __enter__(self) -> "Encoder":
        return self

    def __exit__(self, kind: Optional[type], *_: object) -> None:
        try:
            if kind is None:
                assert self._process.stdin is not None
                self._process.stdin.close()
                if self._process.wait() != 0:
                    raise VideoError(f"ffmpeg: {self._words()}")
                self._part.replace(self._output)
            else:
                _end(self._process)
        finally:
            self._discard()
            self._log.close()

    def _discard(self) -> None:
        """Nothing of a film that was not finished stays."""
        assert self._process.stdin is not None
        try:
            self._process.stdin.close()
        except BrokenPipeError:
            pass  # what it did not take any more
        self._part.unlink(missing_ok=True)


def _load(browser: Chromium, address: str) -> None:
    browser.call("Page.navigate", url=address)
    end = time.monotonic() + LOADED_S
    while not browser.evaluate("Boolean(window.hapticd?.film)"):
        if time.monotonic() > end:
            raise VideoError(f"the page at {address} does not come. Is it built? Node's npm is needed for that")
        time.sleep(0.05)


def pictures(browser: Chromium, times_of: Callable[[float], List[float]], caption: str) -> Iterator[Tuple[bytes, int]]:
    """Pictures of a page that shows a recording, JPEG, and how many there will be; `times_of` the length, s, are the instants."""
    duration_s = browser.evaluate(f"hapticd.film.begin({json.dumps(caption)})")
    times = times_of(duration_s)
    for t_s in times:
        browser.evaluate(f"hapticd.film.frame({t_s!r})")
        yield browser.picture(), len(times)


def write_video(recording: pathlib.Path, output: pathlib.Path, *, frames_per_s: float = 25.0, size: Tuple[int, int] = (1280, 720),
                camera: str = "close", magnify: float = 1.0, speed: float = 1.0, caption: str = "", haptic_web: str = "haptic-web",
                progress: Optional[Progress] = None) -> int:
    """Writes `output`, WebM, of the whole recording; the number of its frames. `camera`: close, which goes along with the tool, or player
    or top, from which the whole scene is seen. `magnify`: strings and their vibration so much thicker. `speed`: recorded time per time of
    the video. Sizes are even. Raises VideoError or ChromiumError with what is missing or wrong, and what to do."""
    if size[0] % 2 or size[1] % 2:
        raise VideoError(f"{size[0]}x{size[1]}: a video has even sizes")
    count = 0
    # All that is missing is said before anything is started.
    _program("ffmpeg", "ffmpeg")
    gateway_program = _program(haptic_web, "hapticd")
    chromium.program()
    with Gateway(gateway_program, recording) as gateway, Chromium(size) as browser:
        # With the token behind it, since the film moves the recording.
        address, _, fragment = gateway.address.partition("#")
        _load(browser, f"{address}?{urlencode({'view': camera, 'magnify': magnify})}#{fragment}")
        with Encoder(output, frames_per_s) as encoder:
            for picture, total in pictures(browser, lambda length_s: frame_times(length_s, frames_per_s, speed), caption):
                encoder.add(picture)
                count += 1
                if progress is not None:
                    progress(count, total)
    return count
