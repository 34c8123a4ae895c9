"""Requests and scenes at random, with the strangest numbers, words and bytes in every field, against the daemon: whatever it is asked, it answers
once, lives, gives the hand a finite wrench within the device's limits, sends no more text than 400 bytes, and hears a Stop."""
import math
import os
import pathlib
import random
import sys
import unittest

from google.protobuf import text_format

import daemon
import hapticd
from hapticd.v1 import answer_pb2, scene_pb2, state_pb2, stream_pb2

SCENES = pathlib.Path(__file__).resolve().parents[2] / "deploy/scenes"
BY_SERVERS = {"tone", "contact", "string_radius", "string_sounding", "fault", "result", "lease_info", "record_info", "scene_info", "chunk", "bye"}
REQUESTS = [field for field in stream_pb2.Item.DESCRIPTOR.oneofs_by_name["body"].fields if field.name not in BY_SERVERS]
BITS = {"UINT32": (0, 2**32 - 1), "UINT64": (0, 2**64 - 1), "INT32": (-2**31, 2**31 - 1), "INT64": (-2**63, 2**63 - 1),
        "FIXED32": (0, 2**32 - 1), "FIXED64": (0, 2**64 - 1), "SFIXED32": (-2**31, 2**31 - 1), "SFIXED64": (-2**63, 2**63 - 1),
        "SINT32": (-2**31, 2**31 - 1), "SINT64": (-2**63, 2**63 - 1), "ENUM": (-2**31, 2**31 - 1)}
REALS = (0.0, -0.0, 1.0, -1.0, math.nan, math.inf, -math.inf, 1e-320, 5e-324, 1e-30, 1e-9, 1e-3, 0.5, 10.0, 1e3, 1e6, 1e9, 1e30, 1.7e308, -1e30, 2.0**63)
WORDS = ("", "a", "single_string", "../../etc/passwd", "/dev/zero", "\x1b[31m", "\n\n", "\u202e", "x" * 300, "strings[0].tension_n", "strings[-1]",
         "strings[99999999999999999999].x", "tools[0].parts[0].shape", "%s%n", "con", ".", "..", "\U0001f600" * 40)
MOST_TEXT = 400
PEAK_N, PEAK_N_M = 22.0, 0.6


def scaled(count):
    return max(1, int(count * float(os.environ.get("HAPTICD_TEST_SCALE", "0.1"))))


def kind_of(field):
    return next(name[5:] for name in dir(field) if name.startswith("TYPE_") and getattr(field, name) == field.type)


class Draw(random.Random):
    def number(self, kind):
        least, most = BITS[kind]
        near = (0, 1, 2, 3, 7, 15, 16, 17, 31, 32, 64, 255, 4095, 4096, 65535, 2**31 - 1, 2**31, 2**32 - 1, 2**63, most, most - 1, least, -1)
        return self.choice([each for each in near if least <= each <= most] + [self.randint(least, most)])

    def value(self, field):
        kind = kind_of(field)
        if kind in ("DOUBLE", "FLOAT"):
            return self.choice(REALS) if self.random() < 0.7 else self.choice((-1, 1)) * 10 ** self.uniform(-12, 12)
        if kind == "BOOL":
            return self.random() < 0.5
        if kind == "STRING":
            return self.choice(WORDS)
        if kind == "BYTES":
            return self.randbytes(self.choice((0, 1, 16, 300)))
        if kind == "ENUM" and self.random() < 0.8:
            return self.choice(field.enum_type.values).number
        return self.number(kind)

    def fill(self, message, share, depth=0):
        """Random values in that share of the fields of a message."""
        for field in message.DESCRIPTOR.fields:
            if self.random() >= share:
                continue
            repeated = field.label == field.LABEL_REPEATED
            if field.message_type is not None:
                for _ in range(self.choice((1, 1, 2, 3)) if repeated else 1):
                    below = getattr(message, field.name).add() if repeated else getattr(message, field.name)
                    below.SetInParent() if not repeated else None
                    if depth < 5:
                        self.fill(below, share, depth + 1)
            elif repeated:
                getattr(message, field.name).extend(self.value(field) for _ in range(self.choice((0, 1, 2, 3, 3, 4, 6, 20))))
            else:
                setattr(message, field.name, self.value(field))

    def spoil(self, message, changes):
        """A few changes somewhere in a message that made sense."""
        for _ in range(changes):
            place = message
            while True:
                below = [child for field, value in place.ListFields() if field.message_type is not None
                         for child in (value if field.label == field.LABEL_REPEATED else [value])]
                if not below or self.random() < 0.3:
                    break
                place = self.choice(below)
            if not place.DESCRIPTOR.fields:
                continue
            field = self.choice(place.DESCRIPTOR.fields)
            repeated = field.label == field.LABEL_REPEATED
            if field.message_type is not None:
                if self.random() < 0.3:
                    place.ClearField(field.name)
                    continue
                if repeated and len(getattr(place, field.name)) and self.random() < 0.5:
                    getattr(place, field.name).add().CopyFrom(self.choice(getattr(place, field.name)))
                else:
                    self.fill(getattr(place, field.name).add() if repeated else getattr(place, field.name), 0.5)
            elif repeated:
                values = getattr(place, field.name)
                if len(values) and self.random() < 0.7:
                    values[self.randrange(len(values))] = self.value(field)
                else:
                    values.append(self.value(field))
            else:
                setattr(place, field.name, self.value(field))


class RandomRequests(unittest.TestCase):
    def setUp(self):
        self.seed = int(os.environ.get("HAPTICD_TEST_SEED") or random.SystemRandom().getrandbits(48))
        self.draw = Draw(self.seed)
        self.played = daemon.Daemon("--clock", "virtual", "--device", "scripted", "--scene", "single_string")
        self.played.__enter__()
        self.addCleanup(self.played.__exit__, None, None, None)

    def session(self):
        session = hapticd.Session(self.played.address, reconnect=False)
        session.acquire("anybody")
        session.subscribe(1)
        return session

    def ask(self, session, item):
        """Its Result. No request is left without, and none gets two."""
        connection = session._connection
        result = connection.result(connection.submit(item, awaited=True))
        self.assertTrue(answer_pb2.ResultCode.Name(result.code), self.where(item))
        if result.code != answer_pb2.RESULT_CODE_OK:
            self.assertLessEqual(len(result.message.encode()), MOST_TEXT, self.where(item))
        for text in (result.message,):
            self.assertFalse([each for each in text if ord(each) < 32 and each != "\n" or ord(each) in (127, 0x202e)], (text, self.where(item)))
        return result

    def where(self, item):
        return f"seed {self.seed}: {str(item)[:2000]}"

    def play(self, session, item, ticks=60):
        """The first tool wanders over whatever is there; what it feels is a wrench."""
        tool_id = session.devices()[0].tool_id
        at = [self.draw.uniform(-0.02, 0.02) for _ in range(3)]
        poses = [(0.002 * math.sin(k / 7) + at[0], 0.012 - 4e-4 * min(k, 40) + at[1], at[2]) for k in range(ticks)]
        for state in session.run(poses=poses, tool_id=tool_id).states:
            for tool in state.tools:
                for first, most in ((0, PEAK_N), (3, PEAK_N_M)):
                    size = math.sqrt(sum(each**2 for each in tool.wrench_h_w[first:first + 3]))
                    self.assertLessEqual(size, most, self.where(item))  # false for NaN
                for each in tool.p_wg_m:
                    self.assertTrue(math.isfinite(each), self.where(item))
        return session

    def check_alive(self, item):
        self.assertIsNone(self.played.process.poll(), self.where(item))
        with self.session() as session:
            session.stop()
            session.run(steps=1)
            session.clear()
            session.load_scene("single_string")
            session.run(poses=[(0, 0.012, 0)] * 250)
            state = session.run(poses=[(0, 0.012 - 1e-4 * min(k, 90), 0) for k in range(100)]).states[-1]
            self.assertEqual(state.loop_state, state_pb2.LOOP_STATE_ENGAGED, self.where(item))
            self.assertGreater(state.tools[0].wrench_h_w[1], 0.01, self.where(item))

    def test_any_request(self):
        # Not asked for: a recording that fills a disk.
        kinds = [field for field in REQUESTS if field.name not in ("record", "bye")]
        for _ in range(scaled(60)):
            session = self.session()
            for _ in range(25):
                field = self.draw.choice(kinds)
                item = stream_pb2.Item()
                getattr(item, field.name).SetInParent()
                self.draw.fill(getattr(item, field.name), self.draw.choice((0.2, 0.5, 0.9)))
                if item.HasField("run"):
                    item.run.steps %= 300
                if item.HasField("pose_batch"):
                    session._connection.submit(item)  # answered where it is refused alone
                    continue
                self.ask(session, item)
                try:
                    session.halt()
                except hapticd.RequestError:
                    pass  # the lease was released, or a PoseBatch before was refused
            session.close()
            self.check_alive(item)

    def test_any_scene_with_a_few_fields_spoilt(self):
        texts = [(SCENES / f"{name}.textproto").read_text() for name in ("single_string", "five_fingers", "stress", "cabin", "guqin_coarse")
                 if (SCENES / f"{name}.textproto").is_file()]
        taken = 0
        for _ in range(scaled(600)):
            scene = text_format.Parse(self.draw.choice(texts[:1] * 4 + texts), scene_pb2.Scene())
            self.draw.spoil(scene, self.draw.choice((1, 1, 2, 4)))
            item = stream_pb2.Item()
            item.load_scene.text = text_format.MessageToString(scene)
            with self.session() as session:
                result = self.ask(session, item)
                if result.code == answer_pb2.RESULT_CODE_OK:
                    taken += 1
                    session.run(steps=120)
                    self.play(session, item)
            if self.draw.random() < 0.05:
                self.check_alive(item)
        self.check_alive(item)
        self.assertGreater(taken, 0)

    def test_any_number_set_live(self):
        with self.session() as session:
            session.load_scene("single_string")
            names = list(session.get())
        for _ in range(scaled(300)):
            with self.session() as session:
                item = stream_pb2.Item()
                for _ in range(self.draw.choice((1, 1, 2, 5))):
                    assignment = item.set_parameter.assignments.add(path=self.draw.choice(names))
                    assignment.number = self.draw.choice(REALS) if self.draw.random() < 0.3 else 10 ** self.draw.uniform(-9, 9)
                self.ask(session, item)
                self.play(session, item, 120)
        self.check_alive(item)


if __name__ == "__main__":
    sys.exit(unittest.main(verbosity=2))
