"""haptic-audio and a model of the daemon that tells it what to play, for tests with a JACK server, real or scripted."""
import os
import random
import sys
import time

ROOT = os.path.join(os.path.dirname(os.path.abspath(__file__)), "..", "..", "..")
sys.path.insert(0, os.path.join(ROOT, "tests", "protocol", "conformance"))

from jack_rig import Program  # noqa: E402
from model_server import ModelServer  # noqa: E402

HAPTIC_AUDIO = sys.argv.pop(1)
TUNING = [65.4, 73.4, 87.3, 98.0, 110.0, 130.8, 146.8]
NAMES = ["C2", "D2", "F2", "G2", "A2", "C3", "D3"]
DECAY_S = 0.5  # of the recordings that are shipped


class LossySocket:
    """Loses a share of the datagrams of both directions."""

    def __init__(self, socket, share):
        self.socket, self.share, self.random = socket, share, random.Random(1)

    def recvfrom(self, size):
        while True:
            data = self.socket.recvfrom(size)
            if self.random.random() >= self.share:
                return data

    def sendto(self, data, address):
        if self.random.random() >= self.share:
            self.socket.sendto(data, address)

    def close(self):
        self.socket.close()


class Player(Program):
    """haptic-audio, playing what `tone` tells it."""

    def __init__(self, *options, loss=0.0):
        self.model = ModelServer(virtual=False)
        self.model.socket = LossySocket(self.model.socket, loss)
        del self.model.world.scene.strings[:]
        for name, frequency in zip(NAMES, TUNING):
            self.model.world.scene.strings.add(name=name, frequency_hz=frequency)
        host, port = self.model.address
        super().__init__(HAPTIC_AUDIO, "--server", f"{host}:{port}", *options)

    def __enter__(self):
        self.model.start()
        super().__enter__()
        self.wait_for("hears hapticd")
        return self

    def __exit__(self, *error):
        super().__exit__(*error)
        self.model.stop()

    def tone(self, string, level, decay_s=DECAY_S):
        """Plucks now; the instant on the daemon's clock, which is this machine's, s."""
        t_ns = time.monotonic_ns()
        for remote in self.model.remotes.values():
            self.model.tell(remote, tone={"t_ns": t_ns, "string_index": string, "frequency_hz": TUNING[string], "level": level,
                                          "lambda": 0.13, "decay_s": decay_s})
        return t_ns * 1e-9

    def damp(self, string):
        """A finger touches the ringing string."""
        for remote in self.model.remotes.values():
            self.model.tell(remote, string_radius={"t_ns": time.monotonic_ns(), "string_index": string, "phase": "STRING_RADIUS_PHASE_DAMP",
                                                   "r_max_m": 1e-3, "decay_s": 0.015})
