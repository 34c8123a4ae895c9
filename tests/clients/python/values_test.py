"""Contacts and parameters as numbers and numbers as poses, with numpy and without: the expected numbers are written out here."""
import math
import unittest
from unittest import mock

import support  # noqa: F401
from hapticd import values
from hapticd.v1 import control_pb2, state_pb2


def plain(column):
    return column.tolist() if hasattr(column, "tolist") else column


class WithAndWithoutNumpy(unittest.TestCase):
    def both(self, check):
        check()
        if values.numpy is not None:
            with mock.patch.object(values, "numpy", None):
                check()

    def test_contacts_come_in_si_and_ill_formed_patches_are_ignored(self):
        def check():
            patch = state_pb2.ContactPatch(tool_sphere=[4, -3], p_wc_um=[1, 2, 3, 4, 5, 6], nhat_og_w_e4=[0, 10000, 0, 10000, 0, 0],
                                           gap_nanometres=[-20, 20000], force_mn=[1500, 0])
            table = values.contacts(patch)
            self.assertAlmostEqual(plain(table["p_wc_m"])[1][2], 6e-6, delta=1e-18)
            self.assertEqual(plain(table["nhat_og_w"]), [[0, 1, 0], [1, 0, 0]])
            self.assertEqual(plain(table["force_n"]), [1.5, 0])
            self.assertAlmostEqual(plain(table["gap_m"])[0], -2e-8, delta=1e-18)
            for column in ("p_wc_um", "nhat_og_w_e4", "gap_nanometres", "force_mn"):
                bad = state_pb2.ContactPatch()
                bad.CopyFrom(patch)
                getattr(bad, column).append(0)
                self.assertIsNone(values.contacts(bad), column)
        self.both(check)

    def test_what_numpy_makes_is_an_array(self):
        self.assertEqual(values.as_array([[1.0, 2.0]]).shape, (1, 2))


class Poses(unittest.TestCase):
    def test_each_batch_fits_an_item_and_ticks_go_on(self):
        batches = values.pose_batches([(0, 0, number) for number in range(35)], tool_id=2, first_tick=100)
        self.assertEqual([(batch.first_tick, len(batch.poses)) for batch in batches], [(100, 14), (114, 14), (128, 7)])
        for batch in values.pose_batches([(0.3,) * 7] * 100, 31, 2**63):
            self.assertLessEqual(batch.ByteSize() + 4, 1000)
        self.assertEqual(list(batches[1].poses[0].pose_dh.p_m), [0, 0, 14])
        self.assertEqual(list(batches[1].poses[0].pose_dh.q), [1, 0, 0, 0])
        self.assertEqual(batches[1].poses[0].tool_id, 2)

    def test_without_a_first_tick_they_follow_what_is_queued(self):
        self.assertFalse(values.pose_batches([(1, 2, 3, 0, 1, 0, 0)], 0, None)[0].HasField("first_tick"))
        self.assertEqual(list(values.pose_batches([(1, 2, 3, 0, 1, 0, 0)], 0, None)[0].poses[0].pose_dh.q), [0, 1, 0, 0])

    def test_other_rows_are_refused(self):
        for row in ((), (1, 2), (1, 2, 3, 4), range(8)):
            with self.assertRaises(ValueError):
                values.pose_batches([row], 0, None)

    def test_what_is_no_rows_of_numbers_is_refused_with_what_is(self):
        for bad in ({"p": [0, 0, 0]}, "path", b"path", [0.0, 0.0, 0.0], [(0, 0, 0), "up!"], [{"x": 1}], [(0, 0, None)], [(0, 0, "up")]):
            with self.assertRaisesRegex((TypeError, ValueError), "3 or 7 numbers"):
                values.pose_rows(bad)

    def test_what_is_not_finite_or_no_rotation_is_refused_by_the_number_of_its_row(self):
        good = (0, 0, 0, 1, 0, 0, 0)
        for norm in (0.5, 0.75, 1, 2):
            self.assertEqual(len(values.pose_rows([good, (0, 0, 0, 0, 0, norm, 0)])), 2)
        for bad in ((0, math.nan, 0), (math.inf, 0, 0), (0, 0, -math.inf, 1, 0, 0, 0), (0, 0, 0, 1, 0, 0, math.nan), (0, 0, 0, 0, 0, 0, 0),
                    (0, 0, 0, 0, 0.4999, 0, 0), (0, 0, 0, 3, 0, 0, 0), (0, 0, 0, 2, 0, 0, 0.1), (0, 0, 0, 1e200, 0, 0, 0)):
            with self.assertRaisesRegex(ValueError, r"\brow 2\b"):
                values.pose_batches([good, good, bad, good], 0, None)


class Assignments(unittest.TestCase):
    def test_values_keep_their_kind_there_and_back(self):
        for value in (True, False, 2.5, 0.0, "auto", [1.0, 2.0, 3.0]):
            assignment = control_pb2.Assignment()
            values.fill_value(assignment, value)
            back = plain(values.read_value(assignment))
            self.assertEqual((type(back), back), (type(value), value))


if __name__ == "__main__":
    unittest.main()
