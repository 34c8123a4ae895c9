"""hapticd lives on without memory: what there is none for is refused, or ends one session.

Seeds are fresh in every run and told where it fails; LITTLE_MEMORY_SEED repeats one, LITTLE_MEMORY_RUNS makes more."""
import hashlib
import os
import random
import resource
import signal
import tempfile
import time
import unittest

import hapticd
from hapticd.v1 import stream_pb2

import daemon

SEED = int(os.environ.get("LITTLE_MEMORY_SEED", "0")) or random.SystemRandom().getrandbits(48)
RUNS = int(os.environ.get("LITTLE_MEMORY_RUNS", "3"))
TOOL = 'tools { name: "f" parts { name: "t" shape { spheres { centre_m: [0, 0, 0] radius_m: 0.005 } } } pose_wg { p_m: [0, 1, 0] } }\n'


def scene_of(spheres, dice):
    centres = ",".join(f"{dice.random():.4f}" for _ in range(3 * spheres))
    return f'name: "x"\n{TOOL}bodies {{ name: "b" shape {{ spheres {{ centre_m: [{centres}] radius_m: [{",".join(["0.001"] * spheres)}] }} }} }}\n'


def file_of(dice):
    """The whole of a small file for scenes, or the first piece of a large one."""
    content = dice.randbytes(dice.choice((3000, 65_536)))
    item = stream_pb2.Item()
    item.put_asset.hash, item.put_asset.bytes = hashlib.blake2b(content, digest_size=32).digest(), content
    item.put_asset.size = len(content) if len(content) < 65_536 else dice.randrange(65_537, 64 << 20)
    return item


def tried(function, *arguments):
    """What it gives; None where the session has ended or the request is refused."""
    try:
        return function(*arguments)
    except (hapticd.RequestError, OSError):
        return None


class LittleMemory(unittest.TestCase):
    def ticks(self, address):
        with hapticd.Session(address) as session:
            session.subscribe()
            return [state.tick for state in session.states(count=2, timeout=20)]

    def assert_serves(self, played):
        """With memory again: time goes on, a scene is loaded, a Stop latches and is cleared."""
        self.assertIsNone(played.process.poll(), f"hapticd has ended; seed {SEED}")
        first, second = self.ticks(played.address)
        self.assertGreater(second, first)
        with hapticd.Session(played.address) as session:
            end = time.monotonic() + 20
            while tried(session.acquire, "test") is None:  # the lease of a session that has fallen ends after 2 s
                self.assertLess(time.monotonic(), end, f"nobody gets the lease; seed {SEED}")
            while tried(session.load_scene, "single_string") is None:  # one that was being built comes first
                self.assertLess(time.monotonic(), end, f"no scene can be loaded any more; seed {SEED}")
            session.stop()
            session.clear()

    def test_daemon_lives_on_while_allocations_fail(self):
        dice = random.Random(SEED)
        for run in range(RUNS):
            one_in = int(10 ** dice.uniform(0.7, 3.5))
            with self.subTest(seed=SEED, run=run, one_in=one_in), tempfile.TemporaryDirectory() as folder:
                shim = {"LD_PRELOAD": os.environ["FAILING_MEMORY"], "FAILING_MEMORY_SEED": str(dice.getrandbits(48)),
                        "FAILING_MEMORY_ONE_IN": str(one_in)}
                with daemon.Daemon("--scene", "single_string", state=folder, environment=shim) as played:
                    before = self.ticks(played.address)[0]
                    played.process.send_signal(signal.SIGUSR1)
                    self.ask_for_much(played, dice)
                    self.assertIsNone(played.process.poll(), "hapticd has ended")
                    played.process.send_signal(signal.SIGUSR2)
                    self.assertGreater(self.ticks(played.address)[0], before)
                    self.assert_serves(played)
                    self.assertEqual(played.end(), 0)
                self.assertIn("memory is short", played.log)

    def test_virtual_time_goes_on_where_allocations_have_failed(self):
        dice = random.Random(SEED)
        for run in range(RUNS):
            one_in = int(10 ** dice.uniform(0.4, 3))
            with self.subTest(seed=SEED, run=run, one_in=one_in), tempfile.TemporaryDirectory() as folder:
                shim = {"LD_PRELOAD": os.environ["FAILING_MEMORY"], "FAILING_MEMORY_SEED": str(dice.getrandbits(48)),
                        "FAILING_MEMORY_ONE_IN": str(one_in)}
                options = ("--scene", "single_string", "--clock", "virtual", "--device", "scripted")
                with daemon.Daemon(*options, state=folder, environment=shim) as played:
                    self.step_in_shortage(played, dice)
                    with hapticd.Session(played.address) as session:
                        end = time.monotonic() + 20
                        while tried(session.acquire, "test") is None:
                            self.assertLess(time.monotonic(), end, f"nobody gets the lease; seed {SEED}")
                        before = session.run(3000).next_tick  # snapshots, which are made every second, find room again
                        self.assertEqual(session.run(100).next_tick, before + 100)
                    self.assertEqual(played.end(), 0)

    def step_in_shortage(self, played, dice):
        with hapticd.Session(played.address, False) as session:
            session.acquire("test")
            session.record("START", "a.mcap")
            session.run(dice.randrange(1, 50))
            played.process.send_signal(signal.SIGUSR1)
            tried(session.run, 5000)
            played.process.send_signal(signal.SIGUSR2)
            tried(session.close)

    def ask_for_much(self, played, dice):
        """Everything a peer may ask for, again and again, over sessions that may fall at any time."""
        for k in range(6):
            session = tried(hapticd.Session, played.address, False)
            if session is None:
                continue
            tried(session.subscribe, 1, ("TOOLS", "STRINGS", "CONTACTS", "TIMING"))
            tried(session.acquire, "test")
            asks = [(session.load_scene, scene_of(dice.randrange(1, 300), dice)), (session.load_scene, "guqin"), (session.scenes,),
                    (session.gestures,), (session.recordings,), (session.devices,), (session.get,), (session.engage,), (session.disengage,),
                    (session.stop,), (session.clear,), (session.record, "START", f"r{k}.mcap"), (session.record, "DUMP", f"d{k}.mcap"),
                    (session.record, "STOP"), (session.set, "solver.damping_ratio", 0.5), (session.play_gesture, None)]
            asks += [(session.request, file_of(dice)) for _ in range(6)]
            dice.shuffle(asks)
            end = time.monotonic() + 3
            for ask in asks:
                if time.monotonic() < end and played.process.poll() is None:
                    tried(*ask)
            tried(session.close)

    def test_a_scene_larger_than_the_address_space_is_refused(self):
        dice = random.Random(SEED)
        text = scene_of(dice.randrange(20_000, 80_000), dice)
        for megabytes in sorted(dice.sample(range(60, 400), RUNS)):
            with self.subTest(seed=SEED, megabytes=megabytes), tempfile.TemporaryDirectory() as folder:
                self.refuse_in(megabytes, text, folder)

    def refuse_in(self, megabytes, text, folder):
        before = resource.getrlimit(resource.RLIMIT_AS)
        try:
            with daemon.Daemon("--scene", "single_string", state=folder) as played:
                resource.prlimit(played.process.pid, resource.RLIMIT_AS, (megabytes << 20, before[1]))
                with hapticd.Session(played.address) as session:
                    tried(session.acquire, "test")
                    tried(session.load_scene, text)
                resource.prlimit(played.process.pid, resource.RLIMIT_AS, before)
                self.assert_serves(played)
                self.assertEqual(played.end(), 0)
        except RuntimeError as error:
            self.fail(error)

    def test_without_memory_to_start_it_says_so_and_ends(self):
        for megabytes in random.Random(SEED).sample(range(20, 130), RUNS):
            with self.subTest(seed=SEED, megabytes=megabytes):
                limit = ("prlimit", f"--as={megabytes << 20}", daemon.HAPTICD, "--scene", "guqin", "--check")
                code, out, log = daemon.said(*limit)
                self.assertGreaterEqual(code, 0, f"a signal ended it: {out}{log}")
                self.assertTrue(code == 0 or log or out, "it ended without a word")


if __name__ == "__main__":
    unittest.main()
