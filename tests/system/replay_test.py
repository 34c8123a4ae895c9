"""A real hapticd recorded and replayed: the same bits, found when they are not, refused when they cannot be; and recordings as tables."""
import csv
import os
import pathlib
import sys
import tempfile
import time
import unittest

import daemon
import hapticd
import numpy
from hapticd.v1 import recording_pb2

sys.path.append(str(pathlib.Path(__file__).parent.parent / "server/recorder"))
import read_recording

EXIT_INPUT = 1
EXIT_DIFFERS = 5
EXIT_PHYSICS = 8
SHOWN = ("STRINGS", "CONTACTS", "ENERGY", "STIFFNESS")
KEPT = pathlib.Path(__file__).parent.parent / "server/daemon/kept"


def replay(file, *options):
    return daemon.run("--device", f"replay:{file}", "--clock", "virtual", "--listen", "127.0.0.1:0", *options, timeout=300)


def messages_of(file, topic):
    """The messages of a topic, in the order of the file."""
    reader = read_recording.Recording()
    for _, opcode, content in read_recording.records(file.read_bytes(), 8):
        if opcode == 0x0F:
            break
        reader.take(opcode, content)
    return [content for channel, _, content in reader.messages if reader.channels[channel][0] == topic]


class Replay(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        cls.folder = tempfile.TemporaryDirectory()
        cls.path = pathlib.Path(cls.folder.name)
        cls.real = cls.path / "real.mcap"
        with daemon.Daemon("--scene", "guqin_coarse", "--record", str(cls.real), state=str(cls.path)) as played:
            with hapticd.Session(played.address) as session:
                session.acquire("test")
                session.set("tools[0].force_gain", 0.5)
                time.sleep(1.5)
                session.stop()
                session.clear()
                session.load_scene("single_string")
                time.sleep(0.7)
            played.end()
        cls.virtual = cls.path / "virtual.mcap"
        with daemon.Daemon("--scene", "single_string", "--device", "scripted", "--clock", "virtual", "--record", str(cls.virtual),
                           state=str(cls.path)) as played:
            with hapticd.Session(played.address) as session:
                session.acquire("test")
                session.subscribe(sections=SHOWN)
                cls.states = session.run(poses=[(0.0, 0.0046, -0.02 + 0.0001 * max(0, tick - 220)) for tick in range(1500)]).states
            played.end()

    @classmethod
    def tearDownClass(cls):
        cls.folder.cleanup()

    def test_what_was_recorded_is_replayed_to_the_bit(self):
        for file in (self.real, self.virtual):
            code, said = replay(file, "--verify")
            self.assertEqual(code, 0, said)
            self.assertIn("identical: every wrench to the bit", said)

    def test_a_recording_of_format_2_is_replayed_from_the_first_tick_and_its_poses_are_compared(self):
        code, said = replay(KEPT / "from_first_tick.mcap", "--verify")
        self.assertEqual(code, EXIT_PHYSICS, said)
        self.assertIn("replayed 300 of 300 ticks", said)
        self.assertIn("compared: poses, not forces", said)

    def test_a_recording_that_begins_with_a_state_of_an_older_version_is_refused(self):
        code, said = replay(KEPT / "from_snapshot.mcap", "--verify")
        self.assertEqual(code, EXIT_INPUT, said)
        self.assertIn("begins with a state of hapticd 0.1; play it with that version", said)

    def test_quality_that_followed_its_budget_is_replayed_to_the_bit(self):
        file = self.path / "automatic.mcap"
        with daemon.Daemon("--scene", "guqin_coarse", "--quality", "auto", "--budget-us", "2", "--clock", "virtual", "--record", str(file),
                           state=str(self.path)) as played:
            with hapticd.Session(played.address) as session:
                session.acquire("test")
                session.run(steps=1500)
            played.end()
        self.assertIn("for a budget of 2 us", played.log)
        code, said = replay(file, "--verify")
        self.assertEqual(code, 0, said)
        self.assertIn("identical: every wrench to the bit", said)

    def test_a_recording_shows_of_every_tick_what_clients_were_shown(self):
        ticks = [recording_pb2.TickRecord.FromString(content) for content in messages_of(self.virtual, "/hapticd/tick")]
        self.assertEqual(len(ticks), len(self.states))
        for tick, state in zip(ticks, self.states):
            self.assertEqual(tick.tick, state.tick)
            for string in state.strings:
                string.ClearField("sounding")  # it repeats an event of another tick
            for field in ("strings", "contacts", "stiffness"):
                self.assertEqual(list(getattr(tick.shown, field)), list(getattr(state, field)), (field, tick.tick))
            self.assertEqual(tick.shown.energy, state.energy)
        self.assertTrue(any(tick.shown.strings and tick.shown.contacts for tick in ticks))

    def test_of_a_recording_with_other_physics_poses_are_compared_and_it_is_said(self):
        data = self.virtual.read_bytes()
        header = messages_of(self.virtual, "/hapticd/header")[0]
        self.assertEqual(recording_pb2.RecordHeader.FromString(header).physics, 2)
        # Its last field: the same length with another number.
        self.assertEqual(header[-2:], b"\x50\x02")
        data = bytearray(data.replace(header, header[:-1] + b"\x01"))
        for place, opcode, _ in read_recording.records(bytes(data), 8):
            # CRCs of chunks and of all data: 0 says that there is none.
            if opcode == 0x06:
                data[place + 33:place + 37] = bytes(4)
            if opcode == 0x0F:
                data[place + 9:place + 13] = bytes(4)
                break
        other = self.path / "other_physics.mcap"
        other.write_bytes(data)
        code, said = replay(other, "--verify")
        self.assertEqual(code, EXIT_PHYSICS, said)
        self.assertIn("recorded with physics 1; compared: poses, not forces", said)

    def test_a_replay_tells_clients_where_it_is_and_lets_nobody_in(self):
        with daemon.Daemon("--device", f"replay:{self.real}", "--clock", "realtime") as played:
            with hapticd.Session(played.address) as session:
                session.acquire("test")
                session.subscribe(divisor=10, sections=["REPLAY"])
                state = next(iter(session.states(1)))
                self.assertTrue(state.HasField("replay"))
                self.assertGreater(state.replay.last_tick, 0)
                with self.assertRaises(hapticd.RequestError) as refused:
                    session.load_scene("guqin")
                self.assertIn("replayed", str(refused.exception))

    def test_what_can_not_be_replayed_is_refused_with_the_remedy(self):
        code, said = replay(self.path / "missing.mcap")
        self.assertEqual(code, EXIT_INPUT)
        self.assertIn("missing.mcap", said)
        text = self.path / "text.mcap"
        text.write_text("no recording")
        code, said = replay(text)
        self.assertEqual(code, EXIT_INPUT)
        self.assertIn("Name a file that hapticd recorded", said)
        code, said = daemon.run("--verify")
        self.assertEqual(code, 2)
        self.assertIn("--device replay:FILE", said)

    def test_a_recording_becomes_a_table(self):
        out = self.path / "ticks.csv"
        code, said = daemon.run("export", str(self.virtual), "--csv", str(out))
        self.assertEqual(code, 0, said)
        with out.open() as file:
            rows = list(csv.DictReader(file))
        self.assertEqual([int(row["tick"]) for row in rows], list(range(1500)))
        self.assertEqual({int(row["dt_ns"]) for row in rows[1:]}, {1000000})
        self.assertAlmostEqual(float(rows[1000]["tool0_wh_z_m"]), -0.02 + 0.0001 * 780, places=12)
        self.assertTrue(any(float(row["tool0_fy_n"]) > 0 for row in rows))
        out = self.path / "ticks.npy"
        self.assertEqual(daemon.run("export", str(self.virtual), "--npy", str(out))[0], 0)
        table = numpy.load(out)
        self.assertEqual(len(table), 1500)
        self.assertEqual([float(row["tool0_fy_n"]) for row in rows], list(table["tool0_fy_n"]))
        out = self.path / "events.npy"
        self.assertEqual(daemon.run("export", str(self.virtual), "--npy", str(out), "--what", "events")[0], 0)
        self.assertIn(1, numpy.load(out)["kind"])


if __name__ == "__main__":
    os.environ.setdefault("XDG_STATE_HOME", tempfile.gettempdir())
    unittest.main()
