"""Files that are asked for by name: --record and what else writes one, from any folder; a recording that cannot be begun refuses the start."""
import ctypes
import os
import pathlib
import resource
import signal
import stat
import subprocess
import sys
import tempfile
import time
import unittest

import daemon
import hapticd
from hapticd.v1 import answer_pb2

MAGIC = b"\x89MCAP0\r\n"
NO_RECORDING = 7


def bound_by_permissions():
    """What this process starts is held to the permissions of files, root too: CAP_DAC_OVERRIDE and CAP_DAC_READ_SEARCH go."""
    drop = 24  # PR_CAPBSET_DROP
    for capability in (1, 2) if os.geteuid() == 0 else ():
        if ctypes.CDLL(None, use_errno=True).prctl(drop, capability, 0, 0, 0) != 0:
            raise OSError(ctypes.get_errno(), "prctl")


class InFolder(unittest.TestCase):
    def setUp(self):
        holder = tempfile.TemporaryDirectory()
        self.addCleanup(holder.cleanup)
        self.addCleanup(os.chdir, os.getcwd())
        self.folder = pathlib.Path(holder.name).resolve()
        os.chdir(self.folder)

    def left(self):
        """Everything below the folder, by relative path."""
        return sorted(str(path.relative_to(self.folder)) for path in self.folder.rglob("*"))


class Recorded(InFolder):
    def played(self, *options):
        with daemon.Daemon("--clock", "virtual", "--device", "scripted", "--scene", "single_string", *options) as played:
            with hapticd.Session(played.address) as session:
                session.acquire("test")
                session.run(50)
            self.assertEqual(played.end(), 0, played.log)

    def whole(self, name):
        recorded = pathlib.Path(name).read_bytes()
        return recorded.startswith(MAGIC) and recorded.endswith(MAGIC) and len(recorded) > 5000

    def test_a_name_without_a_folder_with_one_and_with_missing_ones_is_recorded_for_its_owner_alone(self):
        os.makedirs("here")
        before = os.umask(0)  # the mode is the program's own doing
        self.addCleanup(os.umask, before)
        for name in ("take.mcap", "./take2.mcap", "here/take.mcap", "here/../take3.mcap", "made/by/hapticd/take.mcap", "no_ending", "Übung 1.mcap",
                     str(self.folder / "whole.mcap"), "x" * 250):
            with self.subTest(name):
                self.played("--record", name)
                self.assertTrue(self.whole(name), name)
                self.assertEqual(stat.S_IMODE(os.stat(name).st_mode), 0o600)

    def test_the_configuration_may_name_it_so(self):
        pathlib.Path("my.textproto").write_text('record: "take.mcap"\n')
        self.played("--config", "my.textproto")
        self.assertTrue(self.whole("take.mcap"))

    def test_recordings_asked_for_by_clients_lie_in_their_folder_for_their_owner_alone(self):
        environment = {"HAPTICCTL": os.environ["HAPTICCTL"]}
        with daemon.Daemon("--scene", "single_string", state=str(self.folder)) as played:
            for command in (["start", "take.mcap"], ["stop"], ["dump", "last.mcap"]):
                done = subprocess.run([environment["HAPTICCTL"], "--server", played.address, "record", *command], capture_output=True, text=True,
                                      timeout=60, check=False)
                self.assertEqual(done.returncode, 0, done.stderr)
            again = subprocess.run([environment["HAPTICCTL"], "--server", played.address, "record", "start", "take.mcap"], capture_output=True,
                                   text=True, timeout=60, check=False)
            self.assertEqual(again.returncode, 1, again.stdout)
            self.assertIn("File exists", again.stderr)
        for name in ("take.mcap", "last.mcap"):
            path = self.folder / "hapticd" / "recordings" / name
            self.assertTrue(path.read_bytes().startswith(MAGIC))
            self.assertEqual(stat.S_IMODE(path.stat().st_mode), 0o600)

    def written(self, session, count):
        """Waits until the folder has so many recordings."""
        end = time.monotonic() + 20
        while len(session.recordings()) < count:
            self.assertLess(time.monotonic(), end, session.recordings())

    def test_each_start_has_its_stop_however_close_they_are(self):
        with daemon.Daemon("--scene", "single_string", state=str(self.folder)) as played:
            with hapticd.Session(played.address) as session:
                session.acquire("test")
                for name in map(str, range(20)):
                    session.record("START", name)
                    with self.assertRaises(hapticd.RequestError) as refused:
                        session.record("START", "more")
                    self.assertEqual(refused.exception.code, "BUSY")
                    session.record("STOP")
                    with self.assertRaises(hapticd.RequestError) as refused:
                        session.record("STOP")
                    self.assertEqual(refused.exception.code, "WRONG_STATE")
                self.written(session, 20)
                # One that cannot begin is over by itself, however often.
                for _ in range(2):
                    with self.assertRaises(hapticd.RequestError) as refused:
                        session.record("START", "7")
                    self.assertEqual(refused.exception.code, "FAILED")
                    self.assertEqual(session.recorder.state, answer_pb2.RECORD_STATE_FAILED)
                folder = self.folder / "hapticd/recordings"
                # What is answered was told to everyone, and is in the file.
                self.assertEqual(session.record("START", "again"), str(folder / "again.mcap"))
                self.assertEqual(session.recorder.state, answer_pb2.RECORD_STATE_RECORDING)
                beside = session.record("DUMP", "beside")
                self.assertTrue(pathlib.Path(beside).read_bytes().endswith(MAGIC))
                self.assertEqual((session.recorder.state, session.recorder.file), (answer_pb2.RECORD_STATE_RECORDING, "again.mcap"))
                again = session.record("STOP")
                self.assertEqual(session.recorder.state, answer_pb2.RECORD_STATE_WRITTEN)
                self.assertTrue(pathlib.Path(again).read_bytes().endswith(MAGIC))
            self.assertEqual(played.end(), 0, played.log)
        folder = self.folder / "hapticd/recordings"
        for path in folder.iterdir():
            content = path.read_bytes()
            self.assertTrue(content.startswith(MAGIC) and content.endswith(MAGIC), path)

    def test_what_a_client_names_is_a_plain_name_with_or_without_its_ending(self):
        folder = self.folder / "hapticd/recordings"
        with daemon.Daemon("--scene", "single_string", state=str(self.folder)) as played:
            with hapticd.Session(played.address) as session:
                session.acquire("test")
                for name in ("", "a", "a-b_9", "take.mcap", "x" * 64, "y" * 64 + ".mcap"):
                    with self.subTest(name=name):
                        session.record("START", name)
                        session.record("STOP")
                named = {"a.mcap", "a-b_9.mcap", "take.mcap", "x" * 64 + ".mcap", "y" * 64 + ".mcap"}
                self.written(session, 6)
                by_time = [name for name in session.recordings() if name not in named]
                self.assertLessEqual(named, set(session.recordings()))
                self.assertEqual(len(by_time), 1)
                self.assertRegex(by_time[0], r"^session-\d{8}-\d{6}\.mcap$")
                before = sorted(os.listdir(folder))
                for name in ("..", ".", ".mcap", ".a.mcap", "../a.mcap", "a/b", "/tmp/a.mcap", "A", "a.txt", "a.b.mcap", "a b", "\x1b[2J", "ä", "x" * 65,
                             "x" * 100_000):
                    with self.subTest(name=name[:80]):
                        for mode in ("START", "DUMP"):
                            with self.assertRaises(hapticd.RequestError) as refused:
                                session.record(mode, name)
                            self.assertLess(len(str(refused.exception)), 400)
                self.assertEqual(sorted(os.listdir(folder)), before)
                self.assertEqual(self.left(), sorted(["hapticd", "hapticd/recordings", *(f"hapticd/recordings/{name}" for name in before)]))


class Refused(InFolder):
    def refused(self, name, *words, code=NO_RECORDING, options=(), before=None):
        there = self.left()
        done = subprocess.run([daemon.HAPTICD, "--listen", "127.0.0.1:0", "--scene", "single_string", *options,
                               *(() if name is None else ("--record", name))], capture_output=True, timeout=60, check=False, preexec_fn=before)
        said = (done.stderr + done.stdout).decode(errors="replace")
        self.assertEqual(done.returncode, code, said)
        for word in words:
            self.assertIn(word, said)
        self.assertNotIn("listening on", said)
        self.assertEqual(self.left(), there, said)

    def test_what_cannot_be_begun_refuses_the_start_and_leaves_nothing(self):
        pathlib.Path("there.mcap").write_bytes(b"mine")
        os.makedirs("folder")
        os.symlink("nowhere", "dangling.mcap")
        self.refused("there.mcap", "--record", "there.mcap", "File exists", "new file")
        self.assertEqual(pathlib.Path("there.mcap").read_bytes(), b"mine")
        self.refused("folder", "folder", "File exists")
        self.refused("folder/", "folder/")
        self.refused("missing/folder/", "missing/folder/")
        self.refused("there.mcap/take.mcap", "there.mcap", "Not a directory")
        self.refused("dangling.mcap", "dangling.mcap", "File exists")
        self.refused("/proc/take.mcap", "/proc/take.mcap")
        self.refused("/proc/deeper/take.mcap", "/proc/deeper")
        self.refused("y" * 300, "File name too long")
        self.refused("made/" + "y" * 300, "File name too long")
        self.refused("/", "--record")
        self.refused(".", "--record")

    def test_the_same_holds_for_the_configuration(self):
        pathlib.Path("my.textproto").write_text('record: "/proc/take.mcap"\n')
        self.refused(None, "--record", "/proc/take.mcap", options=("--config", "my.textproto"))

    def test_a_folder_that_may_not_be_written_to_refuses_the_start(self):
        os.makedirs("locked")
        os.chmod("locked", 0o500)
        self.refused("locked/take.mcap", "locked/take.mcap", "Permission denied", before=bound_by_permissions)
        self.refused("locked/deeper/take.mcap", "locked/deeper", "Permission denied", before=bound_by_permissions)

    def test_a_disk_that_is_full_refuses_the_start_and_leaves_no_file(self):
        def full():
            signal.signal(signal.SIGXFSZ, signal.SIG_IGN)
            resource.setrlimit(resource.RLIMIT_FSIZE, (room, room))
        for room in (0, 5, 100, 2000):
            self.refused("take.mcap", "take.mcap: cannot write: File too large", "room", before=full)
            self.refused("made/for/take.mcap", "take.mcap: cannot write: File too large", before=full)

    def test_a_name_that_is_no_text_is_no_sense(self):
        self.refused("", "--record", "empty", code=2)
        self.refused(b"take\xff.mcap", "--record", "UTF-8", code=2)
        self.refused("take\n.mcap", "--record", code=2)
        pathlib.Path("my.textproto").write_text('record: "take\\000.mcap"\n')
        self.refused(None, "--record", code=2, options=("--config", "my.textproto"))


class OtherPrograms(InFolder):
    def run_here(self, *command):
        done = subprocess.run(command, capture_output=True, text=True, timeout=60, check=False)
        self.assertEqual(done.returncode, 0, done.stderr)

    def test_keys_and_tables_are_written_where_the_programs_run(self):
        ctl = os.environ["HAPTICCTL"]
        for name in ("keys", "slash/", "deeper/keys/"):
            self.run_here(ctl, "keygen", name)
            self.assertEqual(stat.S_IMODE(os.stat(name).st_mode), 0o700, name)
        with daemon.Daemon("--clock", "virtual", "--device", "scripted", "--scene", "single_string", "--record", "take.mcap") as played:
            with hapticd.Session(played.address) as session:
                session.acquire("test")
                session.run(20)
            self.assertEqual(played.end(), 0, played.log)
        self.run_here(ctl, "export", "take.mcap", "--csv", "take.csv")
        self.assertEqual(len(pathlib.Path("take.csv").read_text().splitlines()), 21)
        self.run_here(ctl, "replay", "take.mcap", "--verify")


if __name__ == "__main__":
    sys.exit(unittest.main(verbosity=2))
