"""The study of speed against accuracy without a simulation: its plan, its shards, its front and knee, what levels it chooses."""
import argparse
import contextlib
import dataclasses
import io
import math
import os
import pathlib
import sys
import tempfile
import unittest
import unittest.mock

import numpy
from hapticd_lab import main, quality_table, tradeoff, tradeoff_instructions, tradeoff_plan, tradeoff_strings, tradeoff_table, tradeoff_units
from hapticd_lab.quality_table import NoLevels, Point
from hapticd_lab.tradeoff_plan import Plan
from hapticd_lab.tradeoff_table import Row

FAKE = pathlib.Path(__file__).resolve().parent / "fake_oracle.py"
PLAN = Plan(("bunny", "single_string"), 2, (0.5,), True)


class PlanAndShards(unittest.TestCase):
    def test_a_whole_study_has_five_scenes_and_twenty_gestures_at_each_speed(self):
        plan = Plan(tradeoff_plan.SCENES, tradeoff_plan.GESTURES, tradeoff_plan.SPEEDS)
        self.assertGreaterEqual(len(plan.scenes), 5)
        self.assertEqual(len(plan.units()), len(plan.scenes) * 20 * len(plan.speeds))
        self.assertEqual(len({unit.name for unit in plan.units()}), len(plan.units()))

    def test_shards_are_all_units_and_each_once(self):
        units = Plan(tradeoff_plan.SCENES, 3, (0.05, 0.5)).units()
        shards = [tradeoff_units.shard_of(units, f"{k}/4") for k in (1, 2, 3, 4)]
        self.assertEqual(sorted(unit.name for shard in shards for unit in shard), sorted(unit.name for unit in units))
        for bad in ("0/4", "5/4", "4", "a/b"):
            with self.assertRaises(tradeoff_units.BadStudy):
                tradeoff_units.shard_of(units, bad)

    def test_a_plan_is_the_same_when_it_is_read_back_and_another_one_is_refused(self):
        self.assertEqual(tradeoff_plan.read_plan(PLAN.text()).key(), PLAN.key())
        with tempfile.TemporaryDirectory() as folder:
            tradeoff_units.claim(pathlib.Path(folder), PLAN)
            with self.assertRaises(tradeoff_units.BadStudy):
                tradeoff_units.claim(pathlib.Path(folder), Plan(("bunny",), 2, (0.5,), True))

    def test_the_plan_of_shards_is_theirs_and_a_folder_that_is_none_is_named_and_left_alone(self):
        with tempfile.TemporaryDirectory() as folder:
            one, two, other, none = (pathlib.Path(folder) / name for name in ("one", "two", "other", "none"))
            for shard in (one, two):
                tradeoff_units.claim(shard, PLAN)
            tradeoff_units.claim(other, Plan(("bunny",), 2, (0.5,), True))
            self.assertEqual(tradeoff_units.plan_of_shards([one, two]).key(), PLAN.key())
            with self.assertRaisesRegex(tradeoff_units.BadStudy, "other holds another study than .*one"):
                tradeoff_units.plan_of_shards([one, other])
            with self.assertRaisesRegex(tradeoff_units.BadStudy, "none is not an output"):
                tradeoff_units.plan_of_shards([one, none])
            self.assertFalse(none.exists())
            (two / "plan.json").write_text('{"key": "0", "moons": 3}', encoding="utf-8")
            with self.assertRaisesRegex(tradeoff_units.BadStudy, "two: its plan is of another version"):
                tradeoff_units.plan_of_shards([one, two])


class FrontAndKnee(unittest.TestCase):
    def test_the_front_is_what_nothing_beats_in_both(self):
        costs, errors = [1.0, 2.0, 3.0, 3.0, 1.01], [9.0, 3.0, 1.0, 4.0, 9.0]
        self.assertEqual(tradeoff_table.front(costs, errors), [True, True, True, False, True])

    def test_the_knee_is_the_corner(self):
        self.assertEqual(tradeoff_table.knee([1.0, 2.0, 4.0, 8.0], [1.0, 0.01, 0.009, 0.008]), 1)

    def test_quantiles_add_up_over_histograms(self):
        self.assertAlmostEqual(tradeoff_table.quantile({0: 98, 160: 2}, 0.5), 2 ** (1 / 16))
        self.assertAlmostEqual(tradeoff_table.quantile({0: 98, 160: 2}, 0.99), 2 ** (161 / 16))

    def test_the_bound_is_above_the_error_and_is_the_error_where_all_gestures_are_alike(self):
        alike = numpy.array([[1.0, 100.0]] * 10)
        self.assertAlmostEqual(tradeoff_table.resampled_bound(alike), 0.1)
        uneven = numpy.array([[0.0, 100.0]] * 9 + [[10.0, 100.0]])
        self.assertGreater(tradeoff_table.resampled_bound(uneven), math.sqrt(10.0 / 1000.0))


def rungs():
    """A ladder on which everything is in order."""
    return [Point("ladder 1/10", 0.2, 0.5), Point("ladder 2/10", 0.05, 0.6), Point("ladder 4/10", 0.02, 0.7), Point("ladder 8/10", 0.008, 0.75),
            Point("ladder 16/1", 1e-3, 0.9), Point("ladder 32/1", 1e-4, 1.0), Point("ladder 64/0.1", 1e-5, 1.2), Point("ladder 64/10", 0.008, 0.9)]


def row(setting, **values):
    """A row of the setting, all zero but for these values."""
    numbers = {each.name: 0 for each in dataclasses.fields(Row)[3:] if each.default is each.default_factory}
    return Row("bunny", setting.split()[0], setting, **{**numbers, **values})


class Instructions(unittest.TestCase):
    def test_dumps_are_read_in_their_order_and_what_is_no_setting_s_is_left_out(self):
        with tempfile.TemporaryDirectory() as folder:
            for name, count in (("callgrind.out", 7), ("callgrind.out.10", 300), ("callgrind.out.2", 200), ("callgrind.out.1", 100)):
                (pathlib.Path(folder) / name).write_text(f"events: Ir\nfn=(1) step\ntotals: {count}\n")
            self.assertEqual(tradeoff_instructions._totals(pathlib.Path(folder)), [100, 200, 300])

    def test_the_table_has_a_row_for_each_scene_and_speed(self):
        with tempfile.TemporaryDirectory() as folder:
            tradeoff_instructions.write({("bunny", 0.5): [1.0, 2.0, 3.0, 4.0, 5.4]}, pathlib.Path(folder))
            text = (pathlib.Path(folder) / "instructions.csv").read_text()
        self.assertEqual(text.splitlines()[1], "bunny,0.5,1,2,3,4,5")


class Levels(unittest.TestCase):
    def test_five_levels_go_up_in_work_and_down_in_error_with_the_default_fourth(self):
        levels = quality_table.choose(rungs())
        self.assertEqual([level.name for level in levels][0::3], ["ladder 1/10", "ladder 32/1"])
        self.assertEqual(levels[4].name, "ladder 64/0.1")
        for below, above in zip(levels, levels[1:]):
            self.assertLess(below.work, above.work)
            self.assertGreater(below.error, above.error)

    def test_a_rung_that_errs_too_much_is_no_level(self):
        self.assertNotIn("ladder 1/20", [level.name for level in quality_table.choose([*rungs(), Point("ladder 1/20", 0.5, 0.3)])])

    def test_a_rung_that_is_beaten_is_no_level(self):
        self.assertNotIn("ladder 64/10", [level.name for level in quality_table.choose(rungs())])

    def test_a_level_that_saves_next_to_nothing_of_the_one_above_is_passed_over(self):
        dear = [Point("ladder 8/8", 0.028, 0.97), Point("ladder 16/2", 1.7e-3, 0.98)]
        spread = [Point("ladder 4/30", 0.04, 0.63), Point("ladder 8/10", 5e-3, 0.8)]
        chosen = quality_table.choose([*dear, *spread, Point("ladder 2/99", 0.2, 0.5), Point("ladder 32/1", 1e-4, 1.0), Point("ladder 64/0.1", 1e-5, 1.2)])
        self.assertEqual([level.name for level in chosen][1:3], ["ladder 4/30", "ladder 8/10"])

    def test_a_default_that_is_beaten_is_refused(self):
        with self.assertRaises(NoLevels):
            quality_table.choose([*rungs(), Point("ladder 48/1", 5e-5, 0.9)])

    def test_a_quick_study_and_one_without_touch_say_that_they_have_no_levels(self):
        with self.assertRaisesRegex(NoLevels, "quick"):
            quality_table.text_of(PLAN, [])
        free = [row(setting, touching=0) for setting in ("ladder 32/1", "level 3")]
        with self.assertRaisesRegex(NoLevels, "touches"):
            quality_table.text_of(PLAN, free)

    def test_bounds_are_rounded_up(self):
        for value, text in ((0.0611, "0.062"), (0.061, "0.061"), (1.234e-5, "1.3e-05"), (1e-7, "1e-07")):
            self.assertEqual(quality_table._up(value), text)


class ThroughTheOracle(unittest.TestCase):
    def setUp(self):
        os.environ["HAPTICD_ORACLE"] = os.environ["HAPTICD_MODEL"] = str(FAKE)
        self.folder = tempfile.TemporaryDirectory()
        self.addCleanup(self.folder.cleanup)
        self.path = pathlib.Path(self.folder.name)

    def test_what_is_done_is_not_played_again_and_what_is_missing_is_told(self):
        tradeoff_units.claim(self.path, PLAN)
        units = PLAN.units()
        tradeoff_units.play_all(units[:1], PLAN, self.path, 1)
        before = tradeoff_units.unit_path(self.path, units[0]).read_text()
        self.assertEqual(tradeoff_units.missing(PLAN, self.path), units[1:])
        tradeoff_units.play_all(units, PLAN, self.path, 2)
        self.assertEqual(tradeoff_units.unit_path(self.path, units[0]).read_text(), before)
        self.assertEqual(tradeoff_units.missing(PLAN, self.path), [])

    def test_scenes_are_played_in_turn_so_that_the_time_left_is_of_all_of_them(self):
        tradeoff_units.claim(self.path, PLAN)
        played = []
        with unittest.mock.patch.object(tradeoff_units, "play", side_effect=lambda unit, *_: played.append(unit.name) or 0.0):
            tradeoff_units.play_all(PLAN.units(), PLAN, self.path, 1)
        self.assertEqual(played, ["bunny-1-0.5", "single_string-1-0.5", "bunny-2-0.5", "single_string-2-0.5"])

    def test_a_study_of_a_scene_that_is_none_is_refused_before_anything_is_made(self):
        output = self.path / "study"
        with contextlib.redirect_stderr(io.StringIO()) as said, contextlib.redirect_stdout(said):
            self.assertEqual(main.main(["tradeoff", "--quick", "--scene", "bunny", "--scene", "nosuch", "--output", str(output)]), 1)
        self.assertEqual(said.getvalue(), "hapticd-lab tradeoff: --scene: nosuch: no such scene\n")
        self.assertFalse(output.exists())

    def test_a_study_that_could_not_be_begun_leaves_the_folder_to_another_one(self):
        plan = Plan(("nosuch",), 1, (0.5,), True)
        with contextlib.redirect_stderr(io.StringIO()), unittest.mock.patch.object(tradeoff, "plan_of", return_value=plan):
            self.assertEqual(main.main(["tradeoff", "--output", str(self.path)]), 1)
        self.assertEqual(list(self.path.iterdir()), [])
        tradeoff_units.claim(self.path, PLAN)

    def test_a_study_goes_into_the_folder_study_unless_another_is_named(self):
        parser = argparse.ArgumentParser()
        tradeoff.describe(parser)
        self.assertEqual(parser.parse_args(["--quick"]).output, pathlib.Path("study"))
        self.assertEqual(parser.parse_args(["--output", "mine"]).output, pathlib.Path("mine"))

    def test_strings_leave_tables_and_a_picture(self):
        shown = tradeoff_strings.write(self.path)
        self.assertEqual([row[0] for row in shown["touches"]], ["static", "8 modes", "16 modes"])
        self.assertIn("16 modes", (self.path / "strings_touch.csv").read_text())
        self.assertEqual((self.path / "strings_pitch.csv").read_text().splitlines()[1], "65.4,0.1,0.005,98,-98,-13")
        self.assertEqual((self.path / "strings_press.csv").read_text().splitlines()[1:], ["2,series,0.5,1", "2,coupled,0.001,0.002"])
        self.assertEqual([row[:3] for row in shown["presses"]], [["2", "series", "50 %"], ["2", "coupled", "0.1 %"]])
        self.assertTrue((self.path / "string_models.svg").is_file())

    def test_a_damaged_unit_is_named(self):
        tradeoff_units.claim(self.path, PLAN)
        tradeoff_units.unit_path(self.path, PLAN.units()[0]).write_text("{", encoding="utf-8")
        with self.assertRaisesRegex(tradeoff_units.BadStudy, "bunny-1-0.5.jsonl is damaged"):
            tradeoff_units.read_unit(self.path, PLAN.units()[0])

    def test_rows_pool_gestures_by_their_squares(self):
        plan = Plan(("single_string",), 3, (0.5,))
        tradeoff_units.claim(self.path, plan)
        tradeoff_units.play_all(plan.units(), plan, self.path, 2)
        rows = {row.setting: row for row in tradeoff_table.rows_of(plan, self.path)}
        lines = [tradeoff_units.read_unit(self.path, unit)["sub-steps 4"] for unit in plan.units()]
        pooled = math.sqrt(sum(line["felt_square"] for line in lines) / sum(line["truth_square"] for line in lines))
        self.assertAlmostEqual(rows["sub-steps 4"].error, pooled, places=12)
        self.assertTrue(math.isnan(rows["ladder 32/1"].penetration_m))
        self.assertEqual(rows["level 0"].penetration_m, 0.0)
        text = quality_table.text_of(plan, list(rows.values()))
        self.assertEqual(len([line for line in text.splitlines() if line.startswith("{")]), 5)


if __name__ == "__main__":
    sys.exit(unittest.main())
