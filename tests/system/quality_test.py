"""Quality from the command line, from a scene, from a client, and following a budget."""
import math
import sys
import time
import unittest
from random import Random

import daemon
import hapticd

REASON = hapticd.v1.state_pb2
VIRTUAL = ("--clock", "virtual", "--device", "scripted", "--scene", "single_string")
# Longest time a governor may take to come to its level, s.
PATIENCE_S = 30.0
# Time of a unit of work under the virtual clock, ns.
NOMINAL_NS, NOMINAL_SHARE = 1.4, 1.02


def quality_of(session, poses=40):
    session.subscribe(divisor=1, sections=["QUALITY"])
    result = session.run(poses=[(0.0, 0.01, 0.0)] * poses)
    return result.states[-1].quality


class Fixed(unittest.TestCase):
    def test_what_is_no_quality_is_refused_by_name(self):
        for bad in ("5", "-1", "best", "3.5", "44"):
            code, text = daemon.run(f"--quality={bad}")
            self.assertEqual(code, 2, text)
            self.assertIn("--quality", text)
        for bad in ("-0.1", "-3", "1e7", "nan", "inf"):
            code, text = daemon.run(f"--budget-us={bad}")
            self.assertEqual(code, 2, text)
            self.assertIn("--budget-us", text)

    def test_a_level_given_is_played_in_every_scene_and_can_be_changed(self):
        with daemon.Daemon(*VIRTUAL, "--quality", "1") as played, hapticd.Session(played.address) as session:
            session.acquire("test")
            quality = quality_of(session)
            self.assertEqual((quality.level, quality.automatic, quality.reason), (1, False, REASON.QUALITY_REASON_CHOSEN))
            self.assertEqual(session.get("quality"), 1)
            session.load_scene("sphere")
            self.assertEqual(quality_of(session).level, 1)
            session.set("quality", 4)
            self.assertEqual(quality_of(session, 80).level, 4)

    def test_without_it_the_scene_says(self):
        with daemon.Daemon(*VIRTUAL) as played, hapticd.Session(played.address) as session:
            session.acquire("test")
            self.assertEqual(quality_of(session).level, 3)

    def governed(self, budget, ticks=3000):
        """Qualities of a finger that presses and leaves a string, and the hash of what came of it."""
        with daemon.Daemon(*VIRTUAL, "--quality", "auto", "--budget-us", budget) as played, hapticd.Session(played.address) as session:
            session.acquire("test")
            self.assertEqual(session.get("quality"), "auto")
            self.assertEqual(session.get("quality.automatic.budget_us"), float(budget))
            session.subscribe(divisor=1, sections=["QUALITY"])
            poses = [(0.0, 0.004 * (1 + math.cos(0.01 * k)), 0.0) for k in range(ticks)]
            result = session.run(poses=poses)
            return [state.quality for state in result.states], result.state_hash

    def test_automatic_quality_under_the_virtual_clock_follows_counts_and_comes_to_the_same_bits_twice(self):
        for budget, level, reason in (("0.1", 0, REASON.QUALITY_REASON_BUDGET), ("1e6", 4, REASON.QUALITY_REASON_ROOM)):
            qualities, bits = self.governed(budget)
            self.assertTrue(all(quality.automatic for quality in qualities))
            self.assertEqual((qualities[-1].level, qualities[-1].reason), (level, reason))
            self.assertEqual(qualities[-1].work_budget, int(NOMINAL_SHARE * (1e3 * float(budget)) / NOMINAL_NS))
            self.assertEqual(any(quality.cut_short for quality in qualities), budget == "0.1")
            self.assertTrue(all(quality.work > 0 for quality in qualities))
            again, bits_again = self.governed(budget)
            self.assertEqual(qualities, again)
            self.assertEqual(bits, bits_again)


class Bounded(unittest.TestCase):
    """Fixed levels: the work of a tick is bounded unless that is lifted."""

    def told(self, *options, ask=lambda session: None):
        """Quality of every tick of a Run, from the first on, after what `ask` asks for."""
        with daemon.Daemon(*VIRTUAL, *options) as played, hapticd.Session(played.address) as session:
            session.acquire("test")
            ask(session)
            session.subscribe(divisor=1, sections=["QUALITY"])
            result = session.run(poses=[(0.0, 0.01 - 0.0003 * k, 0.0) for k in range(60)])
            qualities = [state.quality for state in session.states(result.steps)]
            self.assertEqual(len(qualities), 60)
            # From here on the log is all there is.
            self.assertEqual(played.end(), 0, played.log)
            return qualities, played.log

    def check(self, qualities, budget_us):
        for quality in qualities:
            self.assertTrue(quality.HasField("budget_us"))
            self.assertAlmostEqual(quality.budget_us, budget_us, delta=1e-5 * budget_us)
            self.assertEqual(quality.work_budget, int(NOMINAL_SHARE * (1e3 * budget_us) / NOMINAL_NS))

    def test_with_nothing_said_every_tick_is_bounded_to_half_the_period_from_the_first_on(self):
        for options, rate in (((), 1000.0), (("--quality", "0"), 1000.0), (("--quality", "4", "--rate", "250"), 250.0),
                              (("--rate", "10000"), 10000.0), (("--quality", "auto"), 1000.0)):
            qualities, _ = self.told(*options)
            self.check(qualities, 0.5e6 / rate)

    def test_a_budget_given_is_kept_by_any_level_that_is_given_later_and_in_the_next_scene(self):
        self.check(self.told("--budget-us", "80")[0], 80.0)
        self.check(self.told("--budget-us", "80", ask=lambda session: session.set("quality", 4))[0], 80.0)
        self.check(self.told("--budget-us", "80", ask=lambda session: session.load_scene("sphere"))[0], 80.0)

        def automatic_and_back(session):
            session.set("quality", "auto")
            self.assertEqual(session.get("quality.automatic.budget_us"), 80.0)
            session.set("quality.automatic.budget_us", 200)
            session.run(poses=[(0.0, 0.01, 0.0)] * 5)
            session.set("quality", 2)
            session.run(poses=[(0.0, 0.01, 0.0)] * 5)

        self.check(self.told("--budget-us", "80", ask=automatic_and_back)[0], 80.0)

    def test_the_budget_changes_at_the_tick_of_the_change_and_no_sooner(self):
        """Any number of changes that wait, in any order: each tick has the budget of the change that began last."""
        random = Random(27)
        for options, first in ((("--budget-us", "0"), 0.0), (("--budget-us", "80"), 80.0), ((), 500.0)):
            fixed = first
            for _ in range(4):
                with daemon.Daemon(*VIRTUAL, *options) as played, hapticd.Session(played.address) as session:
                    session.acquire("test")
                    session.subscribe(divisor=1, sections=["QUALITY"])
                    begin = session.run(poses=[(0.0, 0.01, 0.0)] * 3).next_tick
                    told, budget, automatic = {}, first, False
                    # In the order of their ticks: what is asked for later builds on what was asked for before.
                    for tick in sorted(random.sample(range(begin + 1, begin + 150), 5)):
                        if automatic and random.random() < 0.5:
                            budget = random.choice((40.0, 120.0, 200.0, 350.0))  # far apart: a smaller step is not told
                            session.set("quality.automatic.budget_us", budget, at_tick=tick)
                        elif automatic:
                            budget, automatic = fixed, False
                            session.set("quality", random.randrange(5), at_tick=tick)
                        else:
                            budget, automatic = fixed or 500.0, True
                            session.set("quality", "auto", at_tick=tick)
                        told[tick] = budget
                    result = session.run(poses=[(0.0, 0.01, 0.0)] * 200)
                    budget, seen = first, 0
                    for state in session.states(result.steps + 3, 1.0):
                        if state.tick >= begin:
                            seen += 1
                            budget = told.get(state.tick, budget)
                        self.assertAlmostEqual(state.quality.budget_us, budget, delta=1e-4, msg=(state.tick, told))
                        self.assertEqual(state.quality.work_budget, int(NOMINAL_SHARE * (1e3 * budget) / NOMINAL_NS), (state.tick, told))
                    self.assertEqual(seen, 200)

    def test_a_budget_of_nought_lifts_the_bound_aloud(self):
        for options in (("--budget-us", "0"), ("--budget-us", "0", "--quality", "4")):
            qualities, log = self.told(*options)
            for quality in qualities:
                self.assertTrue(quality.HasField("budget_us"))
                self.assertEqual((quality.budget_us, quality.work_budget, quality.cut_short), (0.0, 0, False))
            self.assertIn("no bound", log)
        self.assertNotIn("no bound", self.told()[1])
        # Automatic quality keeps one of its own.
        self.check(self.told("--budget-us", "0", ask=lambda session: (session.set("quality", "auto"), session.run(poses=[(0.0, 0.01, 0.0)] * 5)))[0], 500.0)
        code, text = daemon.run("--quality=auto", "--budget-us=0")
        self.assertEqual(code, 2, text)
        self.assertIn("--budget-us", text)

    def test_under_the_real_clock_it_is_bounded_too_and_the_state_says_in_what(self):
        for options, budget_us in (((), 500.0), (("--budget-us", "250"), 250.0), (("--budget-us", "0"), 0.0)):
            with daemon.Daemon("--scene", "single_string", *options) as played, hapticd.Session(played.address) as session:
                session.subscribe(divisor=1, sections=["QUALITY"])
                seen = 0
                for state in session.states():
                    self.assertEqual(state.quality.budget_us, budget_us)
                    self.assertEqual(state.quality.work_budget > 0, budget_us > 0)
                    seen += 1
                    if seen == 200:
                        break
                self.assertEqual(played.end(), 0, played.log)

    def test_the_work_of_no_tick_of_a_wild_hand_goes_beyond_the_bound(self):
        """A finger led anywhere within the Guqin at 1 m/s, all that the daemon does by itself."""
        random = Random(14)
        with daemon.Daemon("--clock", "virtual", "--device", "scripted", "--scene", "guqin") as played, \
                hapticd.Session(played.address) as session:
            session.acquire("test")
            session.subscribe(divisor=1, sections=["QUALITY"])
            poses, place = [], (0.0, 0.05, 0.0)
            for _ in range(20):
                goal = (random.uniform(-0.4, 0.4), random.uniform(-0.08, 0.03), random.uniform(-0.1, 0.1))
                ticks = int(math.dist(place, goal) / 1e-3) + 1
                poses += [tuple(a + (b - a) * k / ticks for a, b in zip(place, goal)) for k in range(1, ticks + 1)]
                place = goal
            qualities = []
            for first in range(0, len(poses), 250):
                result = session.run(poses=poses[first:first + 250])
                qualities += [state.quality for state in session.states(result.steps)]
            self.assertEqual(len(qualities), len(poses))
            self.assertGreater(sum(quality.qp_iterations > 0 for quality in qualities), len(qualities) // 20)
            self.assertLessEqual(max(quality.work / quality.work_budget for quality in qualities), 1.5)


class Following(unittest.TestCase):
    def wait_for(self, session, wanted, words):
        end = time.monotonic() + PATIENCE_S
        for state in session.states():
            if wanted(state.quality):
                return state.quality
            self.assertLess(time.monotonic(), end, f"{words}, but {state.quality}")

    def test_it_descends_from_a_budget_nothing_fits_and_climbs_where_everything_does(self):
        with daemon.Daemon("--scene", "single_string", "--quality", "auto", "--budget-us", "0.5") as played, \
                hapticd.Session(played.address) as session:
            session.acquire("test")
            session.subscribe(divisor=20, sections=["QUALITY"])
            low = self.wait_for(session, lambda q: q.level == 0 and q.reason == REASON.QUALITY_REASON_BUDGET, "level 0 for its budget")
            self.assertTrue(low.automatic)
            # Every level was too much once, so each waits: a fixed level and automatic again forgets that.
            session.set("quality", 2)
            self.wait_for(session, lambda q: q.level == 2 and not q.automatic and q.reason == REASON.QUALITY_REASON_CHOSEN, "2, chosen")
            session.set("quality", "auto")
            session.set("quality.automatic.budget_us", 1e6)
            self.wait_for(session, lambda q: q.level == 4 and q.reason == REASON.QUALITY_REASON_ROOM, "level 4 for its room")
            self.assertEqual(session.get("quality"), "auto")
            self.assertEqual(played.end(), 0, played.log)
        self.assertIn("quality 0 for a budget of 0.5 us", played.log)


if __name__ == "__main__":
    sys.exit(unittest.main(verbosity=2))
