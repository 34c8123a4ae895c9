"""Numbers that make no sense, in every field of every request, against the daemon: each is refused by name or does what is written, no fault
comes of it, and whoever has the lease next finds an empty queue."""
import os
import pathlib
import random
import sys
import tempfile
import unittest

import daemon
import hapticd
from hapticd.v1 import answer_pb2, state_pb2, stream_pb2

VIRTUAL = ("--clock", "virtual", "--scene", "single_string")
BY_SERVERS = {"tone", "contact", "string_radius", "string_sounding", "fault", "result", "lease_info", "record_info", "scene_info", "chunk", "bye"}
REQUESTS = [field for field in stream_pb2.Item.DESCRIPTOR.oneofs_by_name["body"].fields if field.name not in BY_SERVERS]
NO_ENUM = (9999, 77, -1, 2**31 - 1, -2**31)
WHOLE = {"uint32": 2**32, "uint64": 2**64, "int32": 2**31, "int64": 2**63, "enum": 2**31}
FAULT = state_pb2.LOOP_STATE_FAULT


def scaled(count):
    return max(1, int(count * float(os.environ.get("HAPTICD_TEST_SCALE", "0.1"))))


def kind_of(field):
    names = {field.TYPE_UINT32: "uint32", field.TYPE_UINT64: "uint64", field.TYPE_ENUM: "enum", field.TYPE_INT32: "int32",
             field.TYPE_INT64: "int64"}
    return names.get(field.type, "message" if field.type == field.TYPE_MESSAGE else "")


def put(message, field, number):
    if field.label == field.LABEL_REPEATED:
        getattr(message, field.name).append(number)
    else:
        setattr(message, field.name, number)


def below(message, field):
    return getattr(message, field.name).add() if field.label == field.LABEL_REPEATED else getattr(message, field.name)


def choices(descriptor, path=()):
    """Paths, as tuples of fields, of all enums below a message."""
    for field in descriptor.fields:
        if kind_of(field) == "enum":
            yield path + (field,)
        elif kind_of(field) == "message":
            yield from choices(field.message_type, path + (field,))


class Hand:
    """A session that asks with any Item and says what became of it."""

    def __init__(self, address):
        self.session = hapticd.Session(address, reconnect=False)
        self.session.acquire("hostile")

    def ask(self, item):
        connection = self.session._connection
        return connection.result(connection.submit(item, awaited=True))

    def next_tick(self):
        return self.session.run(steps=1).next_tick


class Enums(unittest.TestCase):
    def check(self, device):
        refused = 0
        with daemon.Daemon(*VIRTUAL, "--device", device) as played:
            hand = Hand(played.address)
            hand.session.subscribe(1)
            for request in REQUESTS:
                for path in choices(request.message_type):
                    for number in NO_ENUM:
                        item = stream_pb2.Item()
                        message = getattr(item, request.name)
                        message.SetInParent()
                        for field in path[:-1]:
                            message = below(message, field)
                        put(message, path[-1], number)
                        result = hand.ask(item)
                        where = (request.name, [field.name for field in path], number)
                        if request.name == "subscribe":
                            self.assertEqual(result.code, answer_pb2.RESULT_CODE_OK, where)
                        else:
                            self.assertEqual(result.code, answer_pb2.RESULT_CODE_INVALID, where)
                            self.assertTrue(result.path.startswith(request.name + "."), (where, result.path))
                            self.assertIn(path[-1].name, result.path)
                            self.assertIn(str(number), result.message)
                            refused += 1
                        hand.session.subscribe(1)
                        for state in hand.session.run(3).states:
                            self.assertNotEqual(state.loop_state, FAULT, where)
            if device == "simulated":
                hand.session.play_gesture(None, arm="FIRM")
                self.assertEqual(hand.session.run(500).states[-1].loop_state, state_pb2.LOOP_STATE_ENGAGED)
            hand.session.close()
            self.assertEqual(played.end(), 0, played.log)
        self.assertGreater(refused, 30)

    def test_no_enum_of_any_request_takes_a_number_that_it_has_not_with_a_simulated_hand(self):
        self.check("simulated")

    def test_no_enum_of_any_request_takes_a_number_that_it_has_not_with_a_script(self):
        self.check("scripted")

    def test_a_configuration_with_such_a_number_is_refused_with_its_line(self):
        with tempfile.TemporaryDirectory() as folder:
            path = pathlib.Path(folder) / "my.textproto"
            for field in ("arm", "clock", "realtime", "pace"):
                for number in (9, 77, -1):
                    path.write_text(f'scene: "single_string"\n\n  {field}: {number}\n')
                    code, text = daemon.run("--config", str(path), "--check")
                    self.assertEqual(code, 1, text)
                    self.assertIn(f"{path}:3:", text)
                    self.assertIn(f"{field}: {number} is not a value of ", text)
            path.write_text('scene: "single_string"\ndevice { tool_id: 32 source: "simulated" }\n')
            self.assertEqual(daemon.run("--config", str(path), "--check")[0], 2)


class Scripts(unittest.TestCase):
    """Two sessions, one after the other."""

    def setUp(self):
        self.played = daemon.Daemon(*VIRTUAL, "--device", "scripted")
        self.played.__enter__()
        self.addCleanup(self.played.__exit__, None, None, None)

    def check_next_can_script(self, why):
        """Whoever comes next scripts from the first tick on, sets what may be set, and feels force."""
        with hapticd.Session(self.played.address, reconnect=False) as session:
            session.acquire("next")
            session.poses([(0, 0.012, 0)] * 16)
            self.assertEqual(session.run(steps=16).held_inputs, 0, why)
            try:
                session.clear()  # a Stop of the one before
            except hapticd.RequestError as error:
                self.assertEqual(error.code, "WRONG_STATE")
            session.set("strings[0].tension_n", 31.0)
            session.run(poses=[(0, 0.012, 0)] * 100)
            self.assertEqual(session.get("strings[0].tension_n"), 31.0, why)
            session.load_scene("single_string")  # recentred or clutched, the tool is elsewhere
            session.subscribe(1)
            result = session.run(poses=[(0, 0.012 - 1e-4 * min(tick, 90), 0) for tick in range(400)])
            self.assertEqual(result.held_inputs, 0, why)
            self.assertEqual(result.states[-1].loop_state, state_pb2.LOOP_STATE_ENGAGED, why)
            self.assertGreater(result.states[-1].tools[0].wrench_h_w[1], 0.01, why)

    def test_a_batch_beyond_the_queue_is_refused_and_changes_nothing(self):
        with hapticd.Session(self.played.address) as session:
            session.acquire("test")
            for ahead in (4082, 4083, 4095, 4096, 10**6, 2**32, 2**63, 2**64 - 15, 2**64 - 14, 2**64 - 2, 2**64 - 1):
                next_tick = session.run(poses=[(0, 0.01, 0)]).next_tick
                first = ahead if ahead > 2**40 else next_tick + ahead
                session.poses([(0, 0.02, 0)] * 14, first_tick=first)  # one batch
                if ahead == 4082:  # the last that fits
                    session.ping()
                    session.load_scene("single_string")
                else:
                    with self.assertRaises(hapticd.RequestError) as refused:
                        session.ping()
                    self.assertEqual((refused.exception.code, refused.exception.path), ("BUSY", "pose_batch.first_tick"))
                session.poses([(0, 0.01, 0)] * 16)
                self.assertEqual(session.run(steps=16).held_inputs, 0, first)
        self.check_next_can_script("beyond the queue")

    def test_poses_of_one_lease_are_gone_in_the_next(self):
        for how in ("release", "close"):
            session = hapticd.Session(self.played.address)
            session.acquire("first")
            next_tick = session.run(steps=1).next_tick
            session.poses([(0, 0.02, 0)] * 16, first_tick=next_tick + 4080)
            session.poses([(0, 0.02, 0)] * 300, first_tick=next_tick)
            session.ping()
            getattr(session, how)()
            session.close()
            self.check_next_can_script(how)

    def test_a_change_for_a_tick_too_far_away_is_refused(self):
        with hapticd.Session(self.played.address) as session:
            session.acquire("test")
            next_tick = session.run(steps=5).next_tick
            for tick in (next_tick - 1, next_tick + 10**6 + 1, 2**32, 2**63, 2**64 - 1):
                with self.assertRaises(hapticd.RequestError) as refused:
                    session.set("strings[0].tension_n", 50.0, at_tick=tick)
                self.assertEqual((refused.exception.code, refused.exception.path), ("OUT_OF_RANGE", "set_parameter.at_tick"))
            self.assertEqual(session.get("strings[0].tension_n"), 30.0)
            session.set("strings[0].tension_n", 50.0, at_tick=next_tick + 10**6)

    def test_changes_that_wait_are_gone_with_the_lease(self):
        session = hapticd.Session(self.played.address)
        session.acquire("first")
        session.set("strings[0].tension_n", 40.0)
        next_tick = session.run(steps=100).next_tick
        for taken in range(100):
            try:
                session.set("strings[0].tension_n", 50.0 + taken, at_tick=next_tick + 10 * taken)
            except hapticd.RequestError as error:
                self.assertEqual(error.code, "BUSY")
                break
        self.assertEqual(taken, 63)
        self.assertEqual(session.get("strings[0].tension_n"), 112.0)
        session.run(steps=15)  # the first two begin
        session.release()
        self.assertEqual(session.get("strings[0].tension_n"), 51.0)
        session.close()
        with hapticd.Session(self.played.address) as other:
            other.acquire("second")
            other.run(steps=2000)
            self.assertEqual(other.get("strings[0].tension_n"), 51.0)
            other.set("strings[0].tension_n", 35.0)
            other.run(steps=100)
            self.assertEqual(other.get("strings[0].tension_n"), 35.0)

    def test_changes_that_wait_come_back_by_no_request_of_the_next_holder(self):
        """Release, Acquire and a change in one breath, while the loop has not heard of the lost lease yet."""
        with daemon.Daemon("--scene", "single_string") as played, hapticd.Session(played.address) as session:
            session.acquire("first")
            session.subscribe(1)
            for k in range(scaled(100)):
                tick = [state for state in session.states(5, 5.0)][-1].tick
                session.set("tools[0].force_gain", 0.5, at_tick=tick + 50_000)
                self.assertEqual(session.get("tools[0].force_gain"), 0.5)
                items = [stream_pb2.Item() for _ in range(5)]
                items[0].release.SetInParent()
                items[1].acquire.holder = f"next {k}"
                items[2].get_parameters.paths.append("tools[0].force_gain")
                items[3].set_parameter.assignments.add(path="strings[0].decay_s", number=0.5 + k / 1000)
                items[4].get_parameters.paths.append("tools[0].force_gain")
                connection = session._connection
                results = [connection.result(each) for each in [connection.submit(item, awaited=True) for item in items]]
                self.assertEqual([result.code for result in results], [answer_pb2.RESULT_CODE_OK] * 5)
                for result in (results[2], results[4]):
                    self.assertEqual(result.parameters.values[0].number, 1.0, k)
                self.assertEqual(session.get("tools[0].force_gain"), 1.0, k)
                self.assertEqual(session.get("strings[0].decay_s"), 0.5 + k / 1000)
            self.assertEqual(played.end(), 0, played.log)

    def fill(self, draw, message, next_tick, depth=0):
        """Random extremes in some of the whole numbers of a message."""
        near = [next_tick + each for each in (-1, 0, 1, 15, 16, 4079, 4080, 4081, 4095, 4096, 4097)]
        for field in message.DESCRIPTOR.fields:
            kind = kind_of(field)
            if kind == "message":
                if draw.random() < 0.7 and depth < 4:
                    for _ in range(draw.choice((1, 1, 2, 16)) if field.label == field.LABEL_REPEATED else 1):
                        self.fill(draw, below(message, field), next_tick, depth + 1)
            elif kind and draw.random() < 0.7:
                most = WHOLE[kind]
                numbers = [0, 1, 2, 3, 9, 31, 32, 63, 64, 255, 4096, 2**31 - 1, 2**31, 2**32 - 1, 2**63 - 1, 2**63, 2**64 - 17, 2**64 - 16,
                           2**64 - 2, 2**64 - 1, draw.randrange(2**64), *near]
                put(message, field, draw.choice([each for each in numbers if 0 <= each < most]))
            elif field.type == field.TYPE_DOUBLE and draw.random() < 0.5 and field.label == field.LABEL_REPEATED:
                getattr(message, field.name).extend([0.0, 0.012, 0.0] if field.name == "p_m" else [1.0, 0.0, 0.0, 0.0])

    def test_after_a_cloud_of_extremes_the_next_client_can_always_script(self):
        draw = random.Random(20261126)
        # Not asked for: another scene, and a recording that fills a disk.
        kinds = [each for each in REQUESTS if each.name not in ("load_scene", "record")]
        for lease in range(scaled(120)):
            hand = Hand(self.played.address)
            said = []
            for _ in range(draw.randrange(1, 30)):
                next_tick = hand.next_tick()
                field = draw.choice(kinds) if draw.random() < 0.6 else draw.choice(
                    [each for each in kinds if each.name in ("pose_batch", "set_parameter", "play_gesture", "run")])
                item = stream_pb2.Item()
                getattr(item, field.name).SetInParent()
                self.fill(draw, getattr(item, field.name), next_tick)
                if field.name == "set_parameter" and draw.random() < 0.7:
                    del item.set_parameter.assignments[:]
                    item.set_parameter.assignments.add(path="strings[0].tension_n", number=draw.uniform(20.0, 60.0))
                if field.name == "pose_batch" and draw.random() < 0.7:
                    del item.pose_batch.poses[:]
                    for _ in range(draw.choice((1, 2, 14))):
                        item.pose_batch.poses.add().pose_dh.p_m.extend((0.0, 0.012, 0.0))
                said.append(str(item).replace("\n", " "))
                hand.session._connection.submit(item)
                try:
                    if field.name == "run":
                        hand.session.halt()
                    hand.session.ping()
                    hand.session.acquire("hostile")
                    hand.session.set("strings[0].tension_n", 30.0)
                except hapticd.RequestError:
                    pass
            hand.session.close()
            self.check_next_can_script((lease, said))
        self.assertEqual(self.played.end(), 0, self.played.log)


if __name__ == "__main__":
    sys.exit(unittest.main(verbosity=2))
