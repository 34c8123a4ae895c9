"""A scene with a sphere-tree and a mesh of its own on the client's machine plays on a daemon that has neither, to the bit as on one that has; what a
hostile peer sends instead gains nothing. Seeds are fresh in every run and told where it fails; BROUGHT_SCENE_SEED repeats one."""
import hashlib
import math
import os
import pathlib
import random
import re
import struct
import subprocess
import sys
import tempfile
import unittest

import daemon
import hapticd
from hapticd.v1 import stream_pb2

CTL = os.environ["HAPTICCTL"]
SEED = int(os.environ.get("BROUGHT_SCENE_SEED", "0")) or random.SystemRandom().getrandbits(48)
LOCKSTEP = ("--clock", "virtual", "--device", "scripted", "--confine", "strict")
PIECE, MOST = 65_536, 64 << 20
FINGER = 'tools { name: "f" parts { name: "t" shape { spheres { centre_m: [0, 0, 0] radius_m: 0.005 } } } pose_wg { p_m: [0, 0.05, 0] } }\n'
STONE = f'name: "stone"\n{FINGER}bodies {{\n  name: "stone"\n  shape {{\n    tree: "parts/stone.tree"\n    mesh: "stone.ply"\n  }}\n}}\n'


def random_tree(dice):
    """A sphere-tree of one node, as server/scene_io/sphere_tree_file.h has it: spheres around the origin that fill a flat stone."""
    leaves = [(0, -0.011, 0, dice.uniform(0.01, 0.012))]  # under the finger
    leaves += [(dice.uniform(-0.01, 0.01), dice.uniform(-0.012, -0.01), dice.uniform(-0.01, 0.01), dice.uniform(0.008, 0.012))
               for _ in range(dice.randrange(4))]
    bound = max(math.dist(leaf[:3], (0, 0, 0)) + leaf[3] for leaf in leaves) * 1.01
    content = b"HDTREE\r\n" + struct.pack("<5I", 1, len(leaves), 1, 1, 5) + bytes(32) + struct.pack("<2d", 0.001, 0.001)
    content += struct.pack("<4d", 0, 0, 0, bound) + struct.pack("<I2d", len(leaves), 0.001, 0.001) + b"stone"
    content += b"".join(struct.pack("<4d", *leaf) for leaf in leaves)
    content += struct.pack("<2B", (1 << len(leaves)) - 1, 0) + b"".join(struct.pack("<I", k) for k in range(len(leaves)))
    return content + hashlib.blake2b(content, digest_size=32).digest()


def ctl(played, *words):
    done = subprocess.run([CTL, "--server", played.address, *map(str, words)], capture_output=True, text=True, timeout=120)
    return done.returncode, done.stdout + done.stderr


def put(content, at=0, piece=None, **changed):
    item = stream_pb2.Item()
    item.put_asset.hash, item.put_asset.size, item.put_asset.offset = hashlib.blake2b(content, digest_size=32).digest(), len(content), at
    item.put_asset.bytes = content[at:at + PIECE] if piece is None else piece
    for name, value in changed.items():
        setattr(item.put_asset, name, value)
    return item


def received(session):
    """Datagrams that the daemon has had."""
    item = stream_pb2.Item()
    item.get_counts.SetInParent()
    return next(each.count for each in session.request(item).counts.counts if each.cause == "received")


def resident(played):
    """Memory of the daemon, bytes."""
    status = pathlib.Path(f"/proc/{played.process.pid}/status").read_text()
    return 1024 * int(re.search(r"VmRSS:\s+(\d+)", status)[1])


class BroughtScene(unittest.TestCase):
    def setUp(self):
        self.dice = random.Random(SEED)
        self.folder = tempfile.TemporaryDirectory()
        self.addCleanup(self.folder.cleanup)
        self.path = pathlib.Path(self.folder.name)
        (self.path / "parts").mkdir()
        self.mesh = self.dice.randbytes(self.dice.randrange(600_000, 900_000))
        (self.path / "stone.ply").write_bytes(self.mesh)
        (self.path / "parts/stone.tree").write_bytes(random_tree(self.dice))
        self.scene = self.path / "stone.textproto"
        self.scene.write_text(STONE)

    def played(self, session):
        """What it is, and what it feels like to press on it."""
        poses = [(0.001 * math.sin(k / 9), 0.02 - 1e-4 * min(k, 200), 0) for k in range(300)]
        session.subscribe(divisor=1, sections=["TOOLS"])
        run = session.run(poses=poses)
        self.assertGreater(max(state.tools[0].wrench_h_w[1] for state in run.states), 0.1, f"nothing is pressed; seed {SEED}")
        told = session.scene
        return bytes(run.state_hash), told.hash, list(told.assets), told.scene

    def test_it_plays_as_it_does_beside_its_files(self):
        for _ in range(3):
            (self.path / "parts/stone.tree").write_bytes(random_tree(self.dice))
            with self.subTest(seed=SEED):
                with daemon.Daemon("--scene", str(self.scene), *LOCKSTEP) as local, hapticd.Session(local.address) as session:
                    session.acquire("test")
                    expected = self.played(session)
                with daemon.Daemon("--scene", "single_string", *LOCKSTEP) as played, hapticd.Session(played.address) as session:
                    session.acquire("test")
                    session.load_scene(self.scene)
                    self.assertEqual(self.played(session), expected)
                    session.load_scene("single_string")
                    session.release()
                    code, text = ctl(played, "scene", "load", self.scene)
                    self.assertEqual((code, text), (0, "loaded\n"))
                    session.acquire("test")
                    self.assertEqual(self.played(session), expected)

    def test_the_second_load_sends_nothing(self):
        with daemon.Daemon("--scene", "single_string", *LOCKSTEP) as played, hapticd.Session(played.address) as session:
            counts = [received(session)]
            for words in (("scene", "check"), ("scene", "load"), ("scene", "load")):
                code, text = ctl(played, *words, self.scene)
                self.assertEqual(code, 0, text)
                counts.append(received(session))
            first, second, third = (later - sooner for sooner, later in zip(counts, counts[1:]))
            self.assertGreater(first, len(self.mesh) // 1200)
            for again in (second, third):
                self.assertLess(again, len(self.mesh) // 2400, f"{counts}")

    def test_what_is_told_can_be_sent_back_with_the_files_that_were_brought(self):
        with daemon.Daemon("--scene", "single_string", *LOCKSTEP) as played, hapticd.Session(played.address) as session:
            session.acquire("test")
            told = session.load_scene(self.scene)
            item = stream_pb2.Item()
            item.load_scene.text = STONE.replace("0.005", "0.004")
            for asset in told.assets:
                item.load_scene.assets.add(name=asset.name, hash=asset.hash)
            session.request(item)
            self.assertEqual(list(session.scene.assets), list(told.assets))

    def test_a_mistake_is_named_with_file_line_and_remedy(self):
        with daemon.Daemon("--scene", "single_string", *LOCKSTEP) as played, hapticd.Session(played.address) as session:
            (self.path / "parts/stone.tree").write_bytes(b"no tree")
            code, text = ctl(played, "scene", "load", self.scene)
            self.assertEqual(code, 1)
            self.assertRegex(text, re.escape(str(self.scene)) + r":6:\d+: .*'parts/stone.tree' is not a sphere-tree")
            (self.path / "parts/stone.tree").unlink()
            code, text = ctl(played, "scene", "load", self.scene)
            self.assertEqual(code, 1)
            self.assertRegex(text, re.escape(str(self.scene)) + r":6:\d+: .*there is no file 'parts/stone.tree'")
            with open(self.path / "parts/stone.tree", "wb") as large:
                large.truncate(MOST + 1)
            code, text = ctl(played, "scene", "load", self.scene)
            self.assertEqual(code, 1)
            self.assertRegex(text, re.escape(str(self.scene)) + r":6: 'parts/stone.tree' .*67108864 bytes\. Make coarser")
            session.acquire("test")
            with self.assertRaisesRegex(ValueError, "Make coarser"):
                session.load_scene(self.scene)

    def test_a_name_that_leads_out_of_the_folder_is_not_sent_and_opens_nothing(self):
        secret = self.path / "secret.tree"
        secret.write_bytes(random_tree(self.dice))
        inner = self.path / "inner"
        inner.mkdir()
        (inner / "link.tree").symlink_to(secret)
        with daemon.Daemon("--scene", "single_string", *LOCKSTEP) as played, hapticd.Session(played.address) as session:
            session.acquire("test")
            for name in ("../secret.tree", str(secret), "parts/../../secret.tree"):
                (inner / "x.textproto").write_text(STONE.replace("parts/stone.tree", name).replace('mesh: "stone.ply"', ""))
                with self.assertRaises(hapticd.RequestError) as caught:
                    session.load_scene(inner / "x.textproto")
                self.assertIn("does not name a file below", str(caught.exception))
                # Nor does a file that was brought make it a name.
                item = stream_pb2.Item()
                item.load_scene.text = (inner / "x.textproto").read_text()
                content = secret.read_bytes()
                session.request(put(content))
                item.load_scene.assets.add(name=name, hash=hashlib.blake2b(content, digest_size=32).digest())
                with self.assertRaises(hapticd.RequestError) as caught:
                    session.request(item)
                self.assertIn("does not name a file below", str(caught.exception))
            # A link on the client's side is the client's own file; one on the daemon's side is opened for nobody.
            text = STONE.replace("parts/stone.tree", str(inner / "link.tree")).replace('mesh: "stone.ply"', "")
            with self.assertRaises(hapticd.RequestError):
                session.load_scene(text)

    def test_nobody_brings_anything_without_right_and_lease(self):
        keys = self.path / "keys"
        subprocess.run([CTL, "keygen", str(keys)], check=True, capture_output=True)
        content = self.dice.randbytes(5000)
        with daemon.Daemon("--scene", "single_string", *LOCKSTEP, "--keys", str(keys)) as played, \
                hapticd.Session(played.address, key=(keys / "view.key").read_bytes(), role="view") as viewer, \
                hapticd.Session(played.address, key=(keys / "control.key").read_bytes()) as holder:
            for session, refusal in ((viewer, "NOT_PERMITTED"), (holder, "NOT_OWNER")):
                with self.assertRaises(hapticd.RequestError) as caught:
                    session.request(put(content))
                self.assertEqual(caught.exception.code, refusal)
            holder.acquire("test")
            self.assertEqual(holder.request(put(content, piece=b"")).asset.received, 0)
            self.assertEqual(holder.request(put(content)).asset.received, len(content))
            unfinished = self.dice.randbytes(2 * PIECE)
            self.assertEqual(holder.request(put(unfinished)).asset.received, PIECE)
            holder.release()
            holder.acquire("test")
            self.assertEqual(holder.request(put(unfinished, piece=b"")).asset.received, 0)
            self.assertEqual(holder.request(put(content, piece=b"")).asset.received, len(content))

    def test_a_hostile_holder_gains_no_memory_and_no_file(self):
        files = [self.dice.randbytes(self.dice.randrange(1, 3 * PIECE)) for _ in range(8)]
        with daemon.Daemon("--scene", "single_string", *LOCKSTEP) as played, hapticd.Session(played.address) as session:
            session.acquire("test")
            session.ping()
            before = resident(played)
            codes = set()
            for turn in range(400):
                content = self.dice.choice(files)
                offset = PIECE * self.dice.randrange(3)
                changed = self.dice.choice(({}, {}, {"size": self.dice.randrange(2**32)}, {"offset": self.dice.randrange(2**32)},
                                            {"hash": self.dice.randbytes(32), "size": self.dice.randrange(1, MOST + 1)},
                                            {"hash": self.dice.randbytes(self.dice.randrange(64))},
                                            {"bytes": self.dice.randbytes(self.dice.randrange(900))}))
                try:
                    session.request(put(content, offset, **changed))
                    codes.add("OK")
                except hapticd.RequestError as error:
                    codes.add(error.code)
                    self.assertTrue(error.message, f"seed {SEED}, turn {turn}")
                    self.assertLessEqual(len(error.message.encode()), 400)
            self.assertEqual(codes - {"OK", "INVALID", "OUT_OF_RANGE"}, set(), f"seed {SEED}")
            self.assertLess(resident(played) - before, 20 << 20, f"seed {SEED}")
            # What is said to be there is what was meant.
            text, load = f'name: "x"\n{FINGER}', stream_pb2.Item()
            for k, content in enumerate(files):
                there = session.request(put(content, piece=b"")).asset.received
                while there < len(content):
                    there = session.request(put(content, there)).asset.received
                load.load_scene.assets.add(name=f"{k}.ply", hash=hashlib.blake2b(content, digest_size=32).digest())
                text += f'bodies {{ name: "b{k}" shape {{ spheres {{ centre_m: [0, -1, 0] radius_m: 0.1 }} mesh: "{k}.ply" }} }}\n'
            load.load_scene.text = text
            session.request(load)
            self.assertEqual([(asset.name, asset.hash) for asset in session.scene.assets],
                             [(asset.name, asset.hash) for asset in load.load_scene.assets], f"seed {SEED}")
            self.assertEqual(session.run(10).steps, 10)
            self.assertIsNone(played.process.poll())


if __name__ == "__main__":
    sys.exit(unittest.main(verbosity=2))
