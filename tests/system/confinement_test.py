"""hapticd gives up what its threads have no use for, and everything it does still works: with --confine strict any other call ends it."""
import os
import pathlib
import re
import shutil
import signal
import tempfile
import time
import unittest
from unittest import mock

import hapticd
from hapticd import stop_road

import daemon

CAP_DAC_OVERRIDE, CAP_DAC_READ_SEARCH, CAP_IPC_LOCK = 1, 2, 14
MOST = 1 << CAP_DAC_OVERRIDE | 1 << CAP_DAC_READ_SEARCH | 1 << CAP_IPC_LOCK
FILTERED = "2"
SHIPPED = pathlib.Path(__file__).parents[2] / "deploy"
SCENE = SHIPPED / "scenes/single_string.textproto"


def threads(pid):
    """Of each thread, by its name: the fields of its status."""
    found = {}
    for task in pathlib.Path(f"/proc/{pid}/task").iterdir():
        fields = dict(line.split(":\t", 1) for line in (task / "status").read_text().splitlines() if ":\t" in line)
        found[fields["Name"].strip()] = {name: value.strip() for name, value in fields.items()}
    return found


class Confinement(unittest.TestCase):
    def play_all(self, played):
        """What people do in a session."""
        with hapticd.Session(played.address) as session:
            session.acquire("test")
            session.subscribe()
            for scene in ("single_string", "guqin", "sphere"):
                session.load_scene(scene)
            for look in (session.scenes, session.gestures, session.recordings, session.devices, session.get):
                look()
            session.set("quality", 1)
            session.load_scene(SCENE.read_text())
            if not session.recorder.file:
                session.record("START", "a.mcap")
            list(session.states(count=50, timeout=20))
            session.record("DUMP", "b.mcap")
            session.stop()
            session.clear()
            answer = stop_road.StopRoad(port=session.scene.stop_port, session_port=int(played.address.rpartition(":")[2])).stop()
            self.assertEqual(answer.code, stop_road.DONE)
            session.clear()
            session.record("STOP")
            end = time.monotonic() + 20
            while "b.mcap" not in session.recordings():
                self.assertLess(time.monotonic(), end, "no dump was written")
        played.process.send_signal(signal.SIGHUP)
        with hapticd.Session(played.address) as session:
            session.subscribe()
            list(session.states(count=10, timeout=20))

    def test_a_whole_session_makes_no_call_outside_the_table(self):
        with tempfile.TemporaryDirectory() as name:
            folder = pathlib.Path(name)
            with daemon.Daemon("--scene", "single_string", "--confine", "strict", "--record", str(folder / "whole.mcap"), state=name) as played:
                self.play_all(played)
                self.assertEqual(played.end(), 0, played.log)
            code, log = daemon.run("--device", f"replay:{folder / 'whole.mcap'}", "--verify", "--confine", "strict", "--listen", "127.0.0.1:0")
            self.assertEqual(code, 0, log)

    def test_lockstep_makes_no_call_outside_the_table(self):
        with daemon.Daemon("--scene", "single_string", "--confine", "strict", "--clock", "virtual", "--device", "scripted") as played:
            with hapticd.Session(played.address) as session:
                session.acquire("test")
                session.run(500)
                session.load_scene("sphere")
                session.run(100)
            self.assertEqual(played.end(), 0, played.log)

    def test_every_thread_is_filtered_and_keeps_few_capabilities(self):
        with daemon.Daemon("--scene", "single_string", "--confine", "on") as played:
            with hapticd.Session(played.address) as session:
                session.ping()  # it serves: all have their roles
            found = threads(played.process.pid)
            self.assertLessEqual({"haptic", "guardian", "recorder", "stop", "hapticd"}, set(found))
            for name, status in found.items():
                with self.subTest(thread=name):
                    self.assertEqual(status["NoNewPrivs"], "1")
                    self.assertEqual(status["Seccomp"], FILTERED)
                    self.assertEqual(int(status["CapEff"], 16) & ~MOST, 0)
                    self.assertEqual(int(status["CapPrm"], 16) & ~MOST, 0)
            for name in ("haptic", "guardian"):
                self.assertEqual(int(found[name]["CapEff"], 16), 0)

    def test_calls_of_a_running_daemon_are_in_the_table(self):
        with tempfile.TemporaryDirectory() as name:
            with daemon.Daemon("--scene", "single_string", "--confine", "on", state=name) as played:
                self.play_all(played)
                self.assertEqual(played.end(), 0, played.log)
            self.assertNotIn("not confined", played.log)

    def test_without_confinement_no_thread_is_filtered(self):
        with daemon.Daemon("--scene", "single_string", "--confine", "off") as played:
            self.assertEqual({status["Seccomp"] for status in threads(played.process.pid).values()}, {"0"})

    def test_files_that_nothing_names_are_out_of_reach(self):
        with tempfile.TemporaryDirectory() as named, tempfile.TemporaryDirectory() as other:
            config, scene = pathlib.Path(named) / "config.textproto", pathlib.Path(other) / "other.textproto"
            recording = pathlib.Path(other) / "session.mcap"
            scene.write_text(SCENE.read_text())
            config.write_text('scene: "single_string"\n')
            with daemon.Daemon("--config", str(config), "--confine", "on", state=named) as played:
                config.write_text(f'scene: "{scene}"\nrecord: "{recording}"\n')
                played.process.send_signal(signal.SIGHUP)
                with hapticd.Session(played.address) as session:
                    session.subscribe()
                    list(session.states(count=500, timeout=20))
                    self.assertEqual(session.scene.scene.name, "single_string")
                self.assertEqual(played.end(), 0)
            self.assertFalse(recording.exists())
            for line in (str(scene), str(recording)):
                self.assertRegex(played.log, f"{re.escape(line)}.*Permission denied.*--confine")

    def test_what_links_in_its_folders_lead_to_is_in_reach(self):
        with tempfile.TemporaryDirectory() as named, tempfile.TemporaryDirectory() as other:
            elsewhere, data, state = pathlib.Path(other), pathlib.Path(named) / "data", pathlib.Path(named) / "state"
            shutil.copytree(SHIPPED / "scenes", data / "scenes")
            shutil.copytree(SHIPPED / "models", elsewhere / "models")
            (data / "models").mkdir()
            for model in (elsewhere / "models").iterdir():
                (data / "models" / model.name).symlink_to(model)
            for folder in ("gestures", "devices"):
                (data / folder).symlink_to(SHIPPED / folder)
            (elsewhere / "mine.textproto").write_text(SCENE.read_text())
            (pathlib.Path(named) / "mine.textproto").symlink_to(elsewhere / "mine.textproto")
            (elsewhere / "recordings").mkdir()
            (state / "hapticd").mkdir(parents=True)
            (state / "hapticd/recordings").symlink_to(elsewhere / "recordings")
            with mock.patch.dict(os.environ, HAPTICD_DATA=str(data)), \
                    daemon.Daemon("--scene", f"{named}/mine.textproto", "--confine", "on", state=str(state)) as played:
                with hapticd.Session(played.address) as session:
                    session.acquire("test")
                    session.load_scene("guqin_coarse")
                    session.record("START", "linked")
                    session.record("STOP")
                self.assertEqual(played.end(), 0, played.log)
            self.assertTrue((elsewhere / "recordings/linked.mcap").exists(), played.log)

    def test_other_words_are_refused(self):
        code, log = daemon.run("--confine", "sometimes", "--check")
        self.assertNotEqual(code, 0)
        self.assertIn("--confine", log)


if __name__ == "__main__":
    unittest.main()
