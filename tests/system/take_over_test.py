"""Control is taken over from a session that has it: it and everyone else is told by whom and why, its run ends, nothing it asked for moves the tool
any more, and the force that it left fades."""
import math
import os
import random
import threading
import unittest

import daemon
import hapticd

CTL = os.environ["HAPTICCTL"]
LOCKSTEP = ("--clock", "virtual", "--device", "scripted", "--scene", "single_string")
FADED_TICKS = 51
"""As PROTOCOL.md, section 9, promises of a lease that ends."""


def pressed():
    """Poses from above the string to below it, in contact at the end."""
    return [(0, 0.012, 0)] * 300 + [(0, 0.012 - 1e-4 * min(k, 90), 0) for k in range(200)]


class TakeOver(unittest.TestCase):
    def test_a_run_ends_and_all_are_told_by_whom_and_why(self):
        with daemon.Daemon(*LOCKSTEP) as played, hapticd.Session(played.address) as first, hapticd.Session(played.address) as second:
            first.acquire("first")
            ended = []

            def run():
                try:
                    first.run(steps=500_000_000, collect=False)
                except hapticd.RequestError as error:
                    ended.append(error)
            runs = threading.Thread(target=run, daemon=True)
            runs.start()
            second.subscribe(1000)
            for state in second.states():
                if state.tick >= 2000:
                    break
            with self.assertRaises(hapticd.RequestError) as refused:
                second.acquire("second")
            self.assertEqual(refused.exception.code, "BUSY")
            lease = second.acquire("second", take_over="it runs for ever")
            runs.join(timeout=60)
            self.assertFalse(runs.is_alive())
            self.assertEqual((lease.yours, lease.taken_from, lease.reason), (True, "first", "it runs for ever"))
            self.assertEqual(ended[0].code, "NOT_OWNER")
            self.assertIn("taken over by 'second'", str(ended[0]))
            before = second.run(steps=1).next_tick
            self.assertEqual(second.run(steps=1).next_tick, before + 1)  # time stands still between its own runs
            with self.assertRaises(hapticd.RequestError) as refused:
                first.engage()
            self.assertEqual(refused.exception.code, "NOT_OWNER")
            self.assertEqual(played.end(), 0)
        self.assertIn("the lease is taken over by 'second' from 'first': it runs for ever", played.log)

    def test_what_it_had_queued_is_forgotten_and_its_force_fades(self):
        with daemon.Daemon(*LOCKSTEP) as played, hapticd.Session(played.address) as first, hapticd.Session(played.address) as second:
            first.acquire("first")
            first.subscribe(1)
            felt = first.run(poses=pressed()).states[-1].tools[0]
            self.assertGreater(felt.wrench_h_w[1], 0.05)
            first.poses([(0.01 * k, 0.05, 0) for k in range(400)])
            first.ping()
            second.acquire("second", take_over="enough")
            second.subscribe(1)
            states = second.run(steps=3 * FADED_TICKS).states
            at = {tuple(state.tools[0].p_wh_m) for state in states}
            self.assertEqual(len(at), 1, "poses of who lost the lease were played")
            forces = [math.hypot(*state.tools[0].wrench_h_w[:3]) for state in states]
            self.assertLess(max(forces), 1.2 * math.hypot(*felt.wrench_h_w[:3]))
            self.assertEqual(max(forces[FADED_TICKS:]), 0.0)

    def test_hapticctl_takes_over_with_a_reason_alone(self):
        with daemon.Daemon(*LOCKSTEP) as played, hapticd.Session(played.address) as first:
            first.acquire("first")
            at = [CTL, "--server", played.address]
            code, _, text = daemon.said(*at, "disengage")
            self.assertEqual(code, 1)
            self.assertIn("--take-over REASON", text)
            for bad in ("", "x" * 401, "\x1b[31m"):
                self.assertEqual(daemon.said(*at, "--take-over", bad, "disengage")[0], 2, bad)
            self.assertTrue(first.lease.yours)
            code, _, text = daemon.said(*at, "--take-over", "the desk was left", "disengage")
            self.assertEqual(code, 0, text)
            with self.assertRaises(hapticd.RequestError):
                first.engage()

    def test_whoever_takes_over_whenever_there_is_one_holder_and_a_larger_fence(self):
        draw = random.Random(seed := random.SystemRandom().getrandbits(48))
        with daemon.Daemon(*LOCKSTEP) as played:
            sessions = [hapticd.Session(played.address) for _ in range(4)]
            fence, holder = 0, None
            for step in range(200):
                where = f"seed {seed}, step {step}"
                asks = draw.randrange(len(sessions))
                kind = draw.choice(("acquire", "take over", "release", "run"))
                try:
                    if kind == "release":
                        sessions[asks].release()
                    elif kind == "run":
                        sessions[asks].run(steps=draw.randrange(1, 30), collect=False)
                    else:
                        lease = sessions[asks].acquire(str(asks), take_over="mine" if kind == "take over" else "")
                except hapticd.RequestError as error:
                    self.assertIn(error.code, ("BUSY", "NOT_OWNER"), where)
                    self.assertNotEqual(holder, asks, where)
                    self.assertTrue(kind != "take over" and (kind != "acquire" or holder is not None), where)
                    continue
                if kind in ("acquire", "take over"):
                    self.assertTrue(kind == "take over" or holder in (None, asks), where)
                    kept = kind == "acquire" and holder == asks
                    self.assertTrue(lease.fence == fence if kept else lease.fence > fence, where)
                    if not kept:
                        self.assertEqual(lease.taken_from, "" if holder is None else str(holder), where)
                    fence, holder = lease.fence, asks
                else:
                    self.assertEqual(holder, asks, where)
                    holder = None if kind == "release" else holder
            for session in sessions:
                session.close()


if __name__ == "__main__":
    unittest.main(verbosity=2)
