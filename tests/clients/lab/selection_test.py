"""Figures by id and group."""
import unittest

from hapticd_lab import selection
from hapticd_lab.figure import Spec

PAPER = ["F1", "F2", "F8", "F10", "F11", "F12a", "F12b", "F12c", "F15a", "F15e", "S1.2", "S2.2", "T1"]
SPECS = [Spec(each, f"title {each}", "", None) for each in PAPER]


class Selection(unittest.TestCase):
    def ids(self, *names):
        return [spec.id for spec in selection.chosen(SPECS, names)]

    def test_an_id_is_that_figure_alone(self):
        self.assertEqual(self.ids("F1"), ["F1"])
        self.assertEqual(self.ids("F12b"), ["F12b"])
        self.assertEqual(self.ids("S1.2"), ["S1.2"])

    def test_a_group_is_all_of_its_figures(self):
        self.assertEqual(self.ids("F12"), ["F12a", "F12b", "F12c"])
        self.assertEqual(selection.groups(SPECS), {"F12": ["F12a", "F12b", "F12c"], "F15": ["F15a", "F15e"]})

    def test_the_order_is_that_of_the_paper_and_nothing_comes_twice(self):
        self.assertEqual(self.ids("T1", "F15", "F12a", "F2", "F12", "S1.2"), ["F2", "F12a", "F12b", "F12c", "F15a", "F15e", "S1.2", "T1"])

    def test_small_letters_will_do(self):
        self.assertEqual(self.ids("f12A", "t1"), ["F12a", "T1"])

    def test_nothing_named_is_nothing_chosen(self):
        self.assertEqual(self.ids(), [])

    def test_an_unknown_id_is_refused_with_what_there_is(self):
        for name in ("F3", "F12d", "F", "", "F1 ", "F15aa"):
            with self.assertRaises(selection.UnknownFigure) as refused:
                self.ids("F1", name)
            for known in (*PAPER, "F12", "F15"):
                self.assertIn(known, str(refused.exception).split("there are ")[1].split(", "))

    def test_every_figure_sorts_as_in_the_paper(self):
        self.assertEqual(sorted(reversed(PAPER), key=selection.order), PAPER)

    def test_what_is_shipped_is_found_once_and_in_order(self):
        specs = selection.offered()
        ids = [spec.id for spec in specs]
        self.assertEqual(ids, sorted(set(ids), key=selection.order))
        self.assertLessEqual({"F2", "F3", "F4", "F5", "S2.2"}, set(ids))
        for spec in specs:
            self.assertTrue(spec.title and spec.paper and spec.cost_s > 0, spec.id)


if __name__ == "__main__":
    unittest.main()
