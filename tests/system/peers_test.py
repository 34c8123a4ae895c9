"""What peers may ask of a daemon: names of what is installed and no file of the machine; scenes that everybody can be told; and a Stop,
whatever others ask for."""
import os
import pathlib
import subprocess
import sys
import tempfile
import unittest

import daemon
import hapticd
from hapticd.v1 import stream_pb2

CTL = os.environ["HAPTICCTL"]
SECRET = "word_of_a_secret"
FINGER = ('tools { name: "f" parts { name: "t" shape { spheres { centre_m: [0, 0, 0] radius_m: 0.005 } } } '
          'pose_wg { p_m: [0, 1, 0] } }\n')


def ctl(played, *words):
    done = subprocess.run([CTL, "--server", played.address, *map(str, words)], capture_output=True, text=True, timeout=60)
    return done.returncode, done.stdout + done.stderr


def too_long(points=180_000):
    """A scene within the limit of its text whose SceneInfo is longer than a blob."""
    return FINGER + 'name: "x" lines { name: "l" radius_m: 0.001 points_w_m: [' + ",".join(["1", "2", "1"] * points) + "] }\n"


class Peers(unittest.TestCase):
    def setUp(self):
        self.folder = tempfile.TemporaryDirectory()
        self.addCleanup(self.folder.cleanup)
        self.path = pathlib.Path(self.folder.name)

    def answer(self, session, kind, name):
        item = stream_pb2.Item()
        getattr(item, kind).name = name
        with self.assertRaises(hapticd.RequestError) as caught:
            session.request(item)
        return str(caught.exception)

    def test_a_peer_opens_no_file_by_its_path(self):
        private = self.path / "private.textproto"
        private.write_text(f"{SECRET}: 42\n")
        scene = self.path / "scene.textproto"
        scene.write_text(f'name: "{SECRET}"\n' + FINGER)
        with daemon.Daemon("--scene", "single_string") as played, hapticd.Session(played.address) as session:
            session.acquire("test")
            for kind in ("load_scene", "play_gesture"):
                missing = self.answer(session, kind, str(self.path / "nothing.textproto"))
                for name in (private, scene, self.path, "/etc/passwd", "../" * 20 + str(scene)[1:]):
                    answer = self.answer(session, kind, str(name))
                    self.assertNotIn(SECRET, answer)
                    self.assertEqual(answer, missing)
                for name in ("", "a" * 257, "a" * 100_000, "\x1b[31m", "."):
                    self.assertLess(len(self.answer(session, kind, name)), 500)
            self.assertEqual(session.scene.scene.name, "single_string")
            # What a scene names is looked for below the folders of models alone.
            for tree in (str(private), "../" * 20 + str(private)[1:]):
                with self.assertRaises(hapticd.RequestError) as caught:
                    session.load_scene(FINGER + f'name: "x" bodies {{ name: "b" shape {{ tree: "{tree}" }} }}\n')
                self.assertIn("below the folders of models", str(caught.exception))

    def test_the_owner_starts_with_any_file_and_a_local_tool_sends_what_is_in_it(self):
        scene = self.path / "scene.textproto"
        scene.write_text('name: "of_a_file"\n' + FINGER)
        gesture = self.path / "gesture.textproto"
        gesture.write_text('name: "wave" tracks { waypoints { pose_wh {} } waypoints { pose_wh {} duration_s: 1 } }\n')
        with daemon.Daemon("--scene", str(scene)) as played, hapticd.Session(played.address) as session:
            self.assertEqual(session.scene.scene.name, "of_a_file")
            self.assertEqual(ctl(played, "scene", "load", "single_string")[0], 0)
            self.assertEqual(ctl(played, "scene", "load", scene)[0], 0)
            self.assertEqual(ctl(played, "scene", "check", scene)[0], 0)
            self.assertEqual(ctl(played, "gesture", "play", gesture)[0], 0)

    def test_a_scene_that_cannot_be_told_is_refused_and_everybody_plays_on(self):
        scene = self.path / "long.textproto"
        scene.write_text(too_long())
        code, text = daemon.run("--scene", str(scene), "--listen", "127.0.0.1:0")
        self.assertEqual(code, 1, text)
        for word in (str(scene), "4193280", "Put spheres into tree files"):
            self.assertIn(word, text)
        with daemon.Daemon("--scene", "single_string") as played, hapticd.Session(played.address) as session:
            session.acquire("test")
            for check_only in (True, False):
                with self.assertRaises(hapticd.RequestError) as caught:
                    session.load_scene(too_long(), check_only=check_only)
                self.assertEqual(caught.exception.code, "INVALID")
                self.assertIn("4193280", str(caught.exception))
            session.ping()
            session.release()
            self.assertEqual(ctl(played, "stop")[0], 0)
            with hapticd.Session(played.address) as other:
                self.assertEqual(other.scene.scene.name, "single_string")

    def test_bytes_that_are_no_text_are_refused_and_everybody_can_be_greeted_and_asks_for_lists(self):
        installed = pathlib.Path(daemon.HAPTICD).resolve().parent.parent / "share" / "hapticd"
        for folder in ("scenes", "devices", "models"):
            (self.path / folder).symlink_to(installed / folder)
        (self.path / "gestures").mkdir()
        for file in (installed / "gestures").iterdir():
            (self.path / "gestures" / file.name).symlink_to(file)
        for name in (b"a\xffb", b"good", b"\xc3", b"a\nb"):
            (self.path / "gestures" / os.fsdecode(name + b".textproto")).write_text("")
        bad = (('name: "x" description: "a\\377b"\n' + FINGER, "description"),
               ('name: "a\\377b"\n' + FINGER, "name"),
               ('name: "x"\n' + FINGER.replace('"f"', '"f\\303"'), "tools[0].name"),
               ('name: "x"\n' + FINGER + 'bodies { name: "b" shape { tree: "\\200.tree" } }', "bodies[0].shape.tree"))
        with daemon.Daemon("--scene", "single_string", environment={"HAPTICD_DATA": str(self.path)}) as played, \
                hapticd.Session(played.address) as session:
            session.acquire("test")
            for text, path in bad:
                for check_only in (True, False):
                    with self.assertRaises(hapticd.RequestError) as caught:
                        session.load_scene(text, check_only=check_only)
                    self.assertEqual((caught.exception.code, caught.exception.path), ("INVALID", path))
            # What is said of a text that cannot be read may quote anything.
            with self.assertRaises(hapticd.RequestError):
                session.load_scene('name: "x" preset: "\\377"')
            self.assertIn("good", session.gestures())
            with hapticd.Session(played.address) as other:
                self.assertEqual(other.scene.scene.name, "single_string")

    def test_listings_of_others_are_all_answered_and_a_stop_between_them(self):
        with daemon.Daemon("--scene", "single_string") as played:
            others = [hapticd.Session(played.address) for _ in range(20)]
            for other in others:
                self.assertIn("demonstration", other.gestures())
                self.assertIn("single_string", other.scenes())
            self.assertEqual(ctl(played, "stop")[0], 0)
            for other in others:
                other.close()


if __name__ == "__main__":
    sys.exit(unittest.main(verbosity=2))
