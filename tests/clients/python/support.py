"""What the tests of the Python package share: the scale of random tests, a lossy road between two links in virtual time, and the worked
datagrams of PROTOCOL.md."""
import os
import random
import re
import sys

ROOT = os.path.join(os.path.dirname(os.path.abspath(__file__)), "..", "..", "..")
sys.path.insert(0, os.path.join(ROOT, "tests", "protocol", "conformance"))

MS = 1_000_000


def scaled(count):
    """The share of a full count that is asked for, at least 1; as tests/support/scale.h."""
    return max(1, int(count * float(os.environ.get("HAPTICD_TEST_SCALE", "0.1"))))


class Road:
    """One direction between two links. Datagrams are lost, doubled and delayed, so that they overtake each other."""

    def __init__(self, seed, loss, doubled=0.25, most_delay_ns=50 * MS):
        self.random = random.Random(seed)
        self.loss, self.doubled, self.most_delay_ns = loss, doubled, most_delay_ns
        self.under_way = []

    def put(self, data, now_ns):
        for _ in range(1 + (self.random.random() < self.doubled)):
            if self.random.random() >= self.loss:
                self.under_way.append((now_ns + self.random.randrange(self.most_delay_ns), data))

    def take(self, now_ns):
        """What has arrived by now."""
        arrived = sorted(each for each in self.under_way if each[0] <= now_ns)
        self.under_way = [each for each in self.under_way if each[0] > now_ns]
        return [data for _, data in arrived]


def worked_datagrams():
    """Section 16 of PROTOCOL.md: (session, counter, text of the Packet, bytes) of each datagram."""
    with open(os.path.join(ROOT, "proto", "PROTOCOL.md"), encoding="utf-8") as file:
        text = file.read()
    found = re.findall(r"session (0x\w+), counter (\d+)\n\n```textproto\n(.*?)```\n\n```hex\n(.*?)```", text, re.DOTALL)
    return [(int(session, 16), int(counter), packet, bytes.fromhex(re.sub(r"#.*", "", hexadecimal)))
            for session, counter, packet, hexadecimal in found]
