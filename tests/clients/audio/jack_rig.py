"""A JACK server with its dummy sound card, haptic-audio playing to it, and what is captured from it, for tests and shows.

The server waits for its clients, so a busy machine delays blocks and loses none; each captured block carries the instant that JACK
says it began at, so that an onset can be read as a time of CLOCK_MONOTONIC whatever the machine did between two blocks."""
import fcntl
import os
import pickle
import re
import resource
import subprocess
import sys
import tempfile

import numpy

RATE = 48000


def server_name():
    """One of four that no other test uses now. JACK has room for eight names of servers and gives that of one that was killed to nobody but its
    namesake."""
    for number in range(4):
        lock = open(os.path.join(tempfile.gettempdir(), f"hapticd-test-{number}.lock"), "w", encoding="utf-8")
        try:
            fcntl.flock(lock, fcntl.LOCK_EX | fcntl.LOCK_NB)
        except BlockingIOError:
            continue
        return f"hapticd-test-{number}", lock
    raise RuntimeError("four tests with JACK servers run at once")


SERVER_NAME, SERVER_LOCK = server_name()
ENVIRONMENT = dict(os.environ, JACK_DEFAULT_SERVER=SERVER_NAME, JACK_NO_AUDIO_RESERVATION="1", JACK_NO_START_SERVER="1")


def may_be_realtime():
    return resource.getrlimit(resource.RLIMIT_RTPRIO)[0] >= 20 or os.geteuid() == 0


def command(*words, **options):
    return subprocess.Popen(words, env=ENVIRONMENT, stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True, **options)


class Jack:
    """A JACK server with the dummy card, for the length of the block; `patient`: it waits for its clients, also for one that is stopped."""

    def __init__(self, block=4096, realtime=False, patient=True):
        self.block, self.options = block, ["--realtime", "-P", "20"] if realtime else ["--no-realtime"]
        self.options += ["-S", "-t", "5000"] if patient else []

    def __enter__(self):
        self.process = subprocess.Popen(["jackd", *self.options, "-n", SERVER_NAME, "-d", "dummy", "-r", str(RATE),
                                         "-p", str(self.block)], env=ENVIRONMENT, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)
        subprocess.run(["jack_wait", "-s", SERVER_NAME, "-w", "-t", "30"], env=ENVIRONMENT, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL,
                       check=True)
        return self

    def __exit__(self, *_):
        self.process.terminate()
        try:
            self.process.wait(timeout=10)
        except subprocess.TimeoutExpired:  # it waits for a client that was killed
            self.process.kill()
            self.process.wait()


class Program:
    """haptic-audio or another that plays, started with `words`; `log` has its lines after the block, `code` its exit code."""

    def __init__(self, *words):
        self.words, self.lines = words, []

    def __enter__(self):
        self.process = command(*self.words)
        return self

    def wait_for(self, text):
        for line in self.process.stdout:
            self.lines.append(line)
            if text in line:
                return
        raise RuntimeError(f"{self.words[0]} never said '{text}':\n" + "".join(self.lines))

    def end(self):
        if self.process.poll() is None:
            self.process.terminate()
        with self.process.stdout:
            self.lines.append(self.process.stdout.read())  # communicate() would lose what wait_for has read ahead
        return self.process.wait()

    def __exit__(self, *_):
        self.code = self.end()
        self.log = "".join(self.lines)

    def counts(self):
        """haptic-audio's tones, played, late."""
        return [int(number) for number in re.search(r"tones (\d+), played (\d+), late (\d+)", self.log).groups()]


class Capture:
    """Records what `port` plays from the beginning of the block on; `sound` afterwards. Another process records, where nobody holds
    Python's lock while JACK waits for it."""

    def __init__(self, port="haptic-audio:out"):
        self.port = port

    def __enter__(self):
        self.process = subprocess.Popen([sys.executable, "-B", os.path.join(os.path.dirname(os.path.abspath(__file__)), "jack_capture.py"), self.port],
                                        env=ENVIRONMENT, stdin=subprocess.PIPE, stdout=subprocess.PIPE)
        if self.process.stdout.readline() != b"captures\n":
            raise RuntimeError(f"nothing to capture at {self.port}")
        return self

    def __exit__(self, *_):
        to_ear_s, blocks = pickle.loads(self.process.communicate(timeout=60)[0])
        self.sound = Sound(blocks, to_ear_s)


class Sound:
    """Captured samples, and when each is heard: s of CLOCK_MONOTONIC."""

    def __init__(self, blocks, to_ear_s):
        self.samples = numpy.concatenate([numpy.frombuffer(data, dtype="<f4") for _, data in blocks]).astype(float)
        self.block = len(blocks[0][1]) // 4
        self.begins_s = numpy.array([begin_us for begin_us, _ in blocks]) * 1e-6 + to_ear_s

    def time_of(self, frame):
        block = min(int(frame) // self.block, len(self.begins_s) - 1)
        return self.begins_s[block] + (frame - block * self.block) / RATE

    def frame_at(self, time_s):
        block = max(int(numpy.searchsorted(self.begins_s, time_s, side="right")) - 1, 0)
        return block * self.block + min(int((time_s - self.begins_s[block]) * RATE), self.block - 1)

    def onset(self, near_s, before_s=0.1, after_s=0.2):
        """The first frame around the instant that stands out of what was before; None where nothing does."""
        first, last = self.frame_at(near_s - before_s), self.frame_at(near_s + after_s)
        before = max(numpy.max(numpy.abs(self.samples[max(first - 960, 0):first]), initial=0.0), 1e-6)
        loud = numpy.abs(self.samples[first:last]) > 1.5 * before
        return first + int(numpy.argmax(loud)) if loud.any() else None

    def rms(self, frame, length_s=0.3):
        return float(numpy.sqrt(numpy.mean(self.samples[frame:frame + int(length_s * RATE)] ** 2)))

    def sine(self, frequency, frame, length_s):
        piece = self.samples[frame:frame + int(length_s * RATE)]
        frames = numpy.arange(frame, frame + len(piece))
        return numpy.sum(piece * numpy.hanning(len(piece)) * numpy.exp(-2j * numpy.pi * frequency * frames / RATE))

    def cents_off(self, frequency, frame, decay_s, window_s=0.2, apart_s=0.1):
        """By how many cents the sine near `frequency` differs from it: how its phase advances between two windows. Infinite when its
        amplitude does not decay between them as told: then it is another sound, or a piece is missing."""
        begin = frame + int(0.02 * RATE)
        turn = self.sine(frequency, begin + int(apart_s * RATE), window_s) / self.sine(frequency, begin, window_s)
        if not abs(abs(turn) * numpy.exp(apart_s / decay_s) - 1) < 0.03:
            return numpy.inf
        return 1200 * numpy.log2(1 + numpy.angle(turn) / (2 * numpy.pi * apart_s) / frequency)


def line_through(x, y):
    """R^2 of y against x, and slope and intercept of the line."""
    slope, intercept = numpy.polyfit(x, y, 1)
    rest = y - slope * x - intercept
    return 1 - numpy.sum(rest**2) / numpy.sum((y - y.mean()) ** 2), slope, intercept
