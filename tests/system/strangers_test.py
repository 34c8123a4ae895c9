"""What strangers send to a daemon with keys is counted where its operator looks, and keeps nobody out; and no control character of a peer
reaches a terminal: not of a client by its name, nor of a daemon by anything it says."""
import json
import os
import pathlib
import random
import re
import secrets
import socket
import struct
import subprocess
import tempfile
import threading
import time
import unittest

import daemon
import hapticd
from hapticd.errors import shown_text
from hapticd.v1 import answer_pb2, stream_pb2

CTL = os.environ["HAPTICCTL"]
HOSTILE = "\x1b]0;owned\x07\x1b[31mred\u009b2J\u202eback\x7f\tx\r\nsecond\u2028line"
VIEW_NN, VIEW_NK = 2, 4  # the role of a HELLO to view: of NNpsk0, the old kind, and of NKpsk0
CONTROL = re.compile("[\x00-\x09\x0b-\x1f\x7f-\x9f\u200e\u200f\u202a-\u202e\u2066-\u2069\u2028\u2029]")


def ctl(address, *words):
    done = subprocess.run([CTL, "--server", address, *map(str, words)], capture_output=True, timeout=60, check=False)
    return done.returncode, (done.stdout + done.stderr).decode()


def header(kind, session=0, counter=0):
    return struct.pack("<BBBBIQ", 0x48, 1, kind, 0, session, counter)


class HostileDaemon:
    """A server of PLAIN sessions that puts HOSTILE wherever a text may stand."""

    def __init__(self):
        self.socket = socket.socket(socket.AF_INET, socket.SOCK_DGRAM)
        self.socket.bind(("127.0.0.1", 0))
        self.address = f"127.0.0.1:{self.socket.getsockname()[1]}"
        self.sessions = {}

    def __enter__(self):
        self.thread = threading.Thread(target=self.serve, daemon=True)
        self.thread.start()
        return self

    def __exit__(self, *_):
        self.socket.sendto(b"", self.socket.getsockname())
        self.thread.join()
        self.socket.close()

    def serve(self):
        while True:
            data, client = self.socket.recvfrom(2048)
            if not data:
                return
            session = struct.unpack_from("<I", data, 4)[0]
            packet = stream_pb2.Packet.FromString(data[16:])
            mine = self.sessions.setdefault((client, session), {"applied": 0, "items": self.greeting(), "acked": 0, "counter": 0})
            mine["acked"] = max(mine["acked"], packet.ack)
            for number, item in enumerate(packet.items, packet.first):
                if number == mine["applied"] + 1:
                    mine["applied"] = number
                    if item.WhichOneof("body") != "bye":
                        mine["items"].append(stream_pb2.Item(result=self.result(number, item.WhichOneof("body"))))
            answer = stream_pb2.Packet(boot_id=7, ack=mine["applied"], first=mine["acked"] + 1,
                                       items=mine["items"][mine["acked"]:mine["acked"] + 2])
            self.socket.sendto(header(5, session, mine["counter"]) + answer.SerializeToString(), client)
            mine["counter"] += 1

    @staticmethod
    def greeting():
        scene = stream_pb2.Item()
        scene.scene_info.server_version = scene.scene_info.scene.name = HOSTILE
        scene.scene_info.scene_id, scene.scene_info.rate_hz = 1, 1000
        lease = stream_pb2.Item(lease_info=answer_pb2.LeaseInfo(fence=3, holder=HOSTILE[:50], key_name=HOSTILE[:50]))
        return [scene, lease, stream_pb2.Item(record_info=answer_pb2.RecordInfo(state=1, file=HOSTILE, message=HOSTILE))]

    @staticmethod
    def result(number, kind):
        result = answer_pb2.Result(item_id=number, code=answer_pb2.RESULT_CODE_OK)
        if kind.startswith("list_"):
            result.listing.names.append(HOSTILE)
            result.listing.descriptions.append(HOSTILE)
        elif kind == "get_device_info":
            device = result.devices.devices.add()
            for field in device.DESCRIPTOR.fields:
                if field.type == field.TYPE_STRING and field.label != field.LABEL_REPEATED:
                    setattr(device, field.name, HOSTILE)
        elif kind == "get_counts":
            result.counts.counts.add(cause=HOSTILE, count=3)
        elif kind == "get_parameters":
            result.parameters.values.add(path=HOSTILE, text=HOSTILE)
        elif kind != "subscribe":
            result.code = answer_pb2.RESULT_CODE_NOT_FOUND
            result.path = result.message = HOSTILE
        return result


class Strangers(unittest.TestCase):
    def setUp(self):
        self.folder = tempfile.TemporaryDirectory()
        self.addCleanup(self.folder.cleanup)
        self.keys = pathlib.Path(self.folder.name) / "keys"
        subprocess.run([CTL, "keygen", str(self.keys)], check=True, capture_output=True)

    def plain(self, text, what):
        found = CONTROL.search(text)
        self.assertIsNone(found, f"{what}: {text!r}")

    def test_what_is_dropped_is_counted_by_cause_in_status_and_log(self):
        forged, keyless, old, short = (random.randrange(1, 400) for _ in range(4))
        with daemon.Daemon("--scene", "single_string", "--keys", str(self.keys)) as played:
            host, port = played.address.split(":")
            target = (host, int(port))
            with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as sender, \
                    hapticd.Session(played.address, key=(self.keys / "view.key").read_bytes(), role="view") as viewer:
                for count, datagram in ((forged, header(4, 5, 1) + bytes(100)), (short, b"H"),
                                        (keyless, header(1) + bytes([VIEW_NK, 0]) + secrets.token_bytes(1182)),
                                        (old, header(1) + bytes([VIEW_NN, 0]) + secrets.token_bytes(1182))):
                    for number in range(count):
                        sender.sendto(datagram, target)
                        if number % 50 == 49:
                            viewer.ping()  # answered once those before it are read: more at once than the system holds would be lost
                code, text = ctl(played.address, "--key", self.keys / "control.key", "--json", "status")
                self.assertEqual(code, 0, text)
                network = json.loads(text)["network"]
                self.assertEqual((network["unknown_session"], network["bad_header"]), (forged, short))
                shown, limited = network["hello_forged"], network["hello_limited"]
                self.assertEqual(shown + limited, keyless + old)
                self.assertLessEqual(limited, max(0, old - 100))  # of the old kind alone, once its 100 in reserve are spent
                code, text = ctl(played.address, "--key", self.keys / "control.key", "status")
                self.assertIn(f"hello_forged {shown}", text)
            self.assertEqual(played.end(), 0)
        self.assertRegex(played.log, rf"network: .*hello_forged \d+ \({shown} so far\)")

    def test_the_client_is_in_beside_hellos_from_its_own_address(self):
        with daemon.Daemon("--scene", "single_string", "--keys", str(self.keys)) as played:
            host, port = played.address.split(":")
            over = threading.Event()

            def flood():
                with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as sender:
                    while not over.wait(0.002):
                        for cookie in (b"", secrets.token_bytes(48)):
                            hello = header(1) + bytes([2, len(cookie)]) + cookie + secrets.token_bytes(48)
                            sender.sendto(hello.ljust(1200, b"\0"), (host, int(port)))
            thread = threading.Thread(target=flood)
            thread.start()
            try:
                for _ in range(3):
                    with hapticd.Session(played.address, key=(self.keys / "control.key").read_bytes()) as session:
                        session.ping()
            finally:
                over.set()
                thread.join()

    def test_a_name_with_controls_is_refused_to_a_client(self):
        with daemon.Daemon("--scene", "single_string") as played, hapticd.Session(played.address) as session:
            for name in (HOSTILE[:40], "a\nb", "\x9b", "\u202e", "x" * 65):
                with self.assertRaises(hapticd.RequestError):
                    session.acquire(name)
            session.acquire("Hölderlin 3")
            self.plain(ctl(played.address, "status")[1], "status")
            self.assertIn("Hölderlin 3", ctl(played.address, "scene", "load", "sphere")[1])
        self.plain(played.log.replace("\x1b[", ""), "log")

    def test_nothing_that_a_daemon_says_is_obeyed_by_a_terminal(self):
        with HostileDaemon() as hostile:
            for words in (("status",), ("scene", "list"), ("scene", "load", "x"), ("gesture", "list"), ("get",), ("device", "info"), ("stop",),
                          ("record", "list"), ("engage",), ("gesture", "play", "x")):
                for options in ((), ("--json",)):
                    _, text = ctl(hostile.address, "--timeout", "2", *options, *words)
                    self.assertTrue(text)
                    self.plain(text, " ".join([*options, *words]))
            with hapticd.Session(hostile.address) as session:
                with self.assertRaises(hapticd.RequestError) as refused:
                    session.stop()
                self.plain(str(refused.exception), "a Python exception")
                self.assertIn("owned", str(refused.exception))

    def test_every_control_is_shown_by_its_number(self):
        self.assertEqual(shown_text("a\x1b[0m\n\u202eb\u009bü"), "a\\u001b[0m\\u000a\\u202eb\\u009bü")


if __name__ == "__main__":
    unittest.main()
