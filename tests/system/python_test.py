"""The Python client against the daemon in virtual time: each run has the events of its own ticks, files have what was played, an event loop gets
the same bits, and the examples and the blocks of clients/python/README.md run as they stand."""
import asyncio
import csv
import math
import os
import pathlib
import re
import subprocess
import sys
import tempfile
import textwrap
import unittest

import daemon
import hapticd

CLIENT = pathlib.Path(__file__).resolve().parents[2] / "clients" / "python"
sys.path.insert(0, str(CLIENT / "examples"))
import pluck  # noqa: E402

TICK_NS = 10**6
TIMED = ("tone", "contact", "string_radius", "fault")


def timed(events):
    return [(event.kind, event.body.SerializeToString(deterministic=True)) for event in events if event.kind in TIMED]


class Runs(daemon.LockstepCase):
    def setUp(self):
        self.session.load_scene("single_string")
        list(self.session.events(timeout=0))

    def test_each_run_has_the_events_of_its_own_ticks(self):
        path = list(pluck.path())
        for pieces in ([len(path)], [100, 100, len(path) - 200], [158, 1, 1, len(path) - 160], [50] * 5 + [len(path) - 250]):
            self.session.load_scene("single_string")
            list(self.session.events(timeout=0))
            at, collected = 0, []
            for length in pieces:
                result = self.session.run(poses=path[at:at + length])
                for event in result.events:
                    self.assertTrue((at - 1) * TICK_NS < event.body.t_ns <= (at + length - 1) * TICK_NS, (at, length, event.body.t_ns))
                collected += timed(result.events)
                at += length
            self.assertEqual(collected, timed(self.session.events(timeout=0)))
            self.assertEqual([kind for kind, _ in collected].count("tone"), 1)

    def test_events_of_time_that_was_let_run_before_are_not_the_runs(self):
        path = list(pluck.path())
        self.session.poses(path)
        self.session.run_live()
        heard = next(event for event in self.session.events(timeout=30) if event.kind == "tone")
        self.session.halt()
        result = self.session.run(steps=3)
        begin_ns = (result.next_tick - 3 - 1) * TICK_NS
        self.assertGreater(begin_ns, heard.body.t_ns)
        self.assertTrue(all(event.body.t_ns > begin_ns for event in result.events))

    def test_a_run_that_collects_nothing_has_no_events(self):
        result = self.session.run(poses=list(pluck.path()), collect=False)
        self.assertEqual((result.states, result.events), ([], []))
        self.assertEqual([event.kind for event in self.session.events(timeout=0)].count("tone"), 1)

    def test_files_have_what_was_played(self):
        self.session.subscribe(1, ["TOOLS"])
        result = self.session.run(poses=list(pluck.path()))
        self.session.subscribe(0)
        with tempfile.TemporaryDirectory() as folder:
            paths = result.export(pathlib.Path(folder) / "deep" / "run")
            self.assertEqual([path.name for path in paths], ["tool_0.csv", "tone.csv", "contact.csv", "string_radius.csv", "string_sounding.csv", "fault.csv"])
            rows = {}
            for path in paths:
                with open(path, newline="", encoding="utf-8") as file:
                    rows[path.stem] = list(csv.DictReader(file))
        # C2 in equal temperament, and one touch that begins and ends; the hand moves at 0.2 m/s along the path that was sent.
        self.assertAlmostEqual(float(rows["tone"][0]["frequency_hz [Hz]"]), 440 * 2 ** (-33 / 12), delta=0.05)
        self.assertEqual([row["phase"] for row in rows["contact"]], ["BEGIN", "END"])
        self.assertLess(float(rows["contact"][0]["t_s [s]"]), float(rows["tone"][0]["t_s [s]"]) + 1e-12)
        self.assertEqual(rows["fault"], [])
        sent = list(pluck.path())
        self.assertEqual(len(rows["tool_0"]), len(sent))
        for row, place in zip(rows["tool_0"], sent):
            self.assertTrue(all(math.isclose(float(row[f"p_wh_m_{axis} [m]"]), each, abs_tol=1e-12) for axis, each in zip("xyz", place)))

    def test_poses_that_are_no_numbers_are_refused_before_a_tick_and_the_next_run_is_as_ever(self):
        self.session.subscribe(1, ["TOOLS"])
        for number in (math.nan, math.inf, -math.inf):
            with self.assertRaisesRegex(ValueError, "row 5"):
                self.session.run(poses=[(0, 0.0153, 0)] * 5 + [(0, number, 0)] * 10)
            self.assertEqual([state.tick for state in self.session.run(poses=[(0, 0.0153, 0)] * 5).states], [0, 1, 2, 3, 4])
            self.session.load_scene("single_string")
        self.session.subscribe(0)

    def test_an_event_loop_gets_the_same_bits(self):
        async def play():
            async with hapticd.AsyncSession(self.played.address) as session:
                await session.acquire("async")
                await session.load_scene("single_string")
                await session.subscribe(1, ["TOOLS", "STRINGS"])
                return await session.run(poses=list(pluck.path()))
        table, _ = pluck.pluck(self.session)
        self.session.load_scene("single_string")
        blocking = self.session.run(poses=list(pluck.path()))
        self.session.release()
        try:
            awaited = asyncio.run(play())
        finally:
            self.session.acquire("test")
        self.assertEqual((awaited.state_hash, timed(awaited.events)), (blocking.state_hash, timed(blocking.events)))
        self.assertEqual(awaited.table()["wrench_h_w"].tolist(), table["wrench_h_w"].tolist())


class AsWritten(unittest.TestCase):
    def setUp(self):
        self.played = self.enterContext(daemon.Daemon("--clock", "virtual", "--device", "scripted", "--scene", "single_string"))
        self.folder = self.enterContext(tempfile.TemporaryDirectory())

    def said(self, *command):
        done = subprocess.run([sys.executable, "-B", *command], capture_output=True, text=True, timeout=60, check=False, cwd=self.folder)
        self.assertEqual(done.returncode, 0, done.stderr)
        return done.stdout

    def test_the_blocks_of_the_page_run(self):
        blocks = re.findall(r"```python\n(.*?)```", (CLIENT / "README.md").read_text(encoding="utf-8"), re.DOTALL)
        script, awaited = (block.replace("127.0.0.1:47800", self.played.address) for block in blocks)
        lines = self.said("-c", script).splitlines()
        self.assertRegex(lines[0], r"^0\.\d+ N, N m$")
        self.assertRegex(lines[1], r"^\[65\.4\d*\] Hz$")
        self.assertTrue(os.path.exists(os.path.join(self.folder, "run", "tone.csv")))
        poses = re.search(r"^ *(poses = .*)$", script, re.MULTILINE)[1]
        whole = f"import asyncio, hapticd\nasync def main():\n    {poses}\n{textwrap.indent(awaited, '    ')}\nasyncio.run(main())\n"
        self.assertIn("tone", self.said("-c", whole).split())

    def test_an_event_loop_tells_of_a_pluck_while_it_is_played(self):
        lines = self.said(str(CLIENT / "examples" / "pluck_async.py"), self.played.address).splitlines()
        self.assertEqual(lines[:-1], ["touched", "let go", "a tone of 65.4 Hz"])
        self.assertRegex(lines[-1], r"^293 ticks, 293 States, \d+ events$")


if __name__ == "__main__":
    sys.exit(unittest.main(verbosity=2))
