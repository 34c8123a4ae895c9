"""Which deviations are expected: the list is read, and every difference from it is seen."""
import pathlib
import tempfile
import unittest

import expectations

HERE = pathlib.Path(__file__).resolve().parent


def claim(figure, text, verdict="deviates"):
    return {"figure": figure, "claim": text, "verdict": verdict, "measured": "2 N", "demanded": "<= 1 N", "note": ""}


EXPECTED = [expectations.Expected("F5", "The cylinder", "why"), expectations.Expected("F16", "At 10 m/s", "why")]


class Expectations(unittest.TestCase):
    def read(self, text):
        with tempfile.TemporaryDirectory() as folder:
            path = pathlib.Path(folder) / "list.txt"
            path.write_text(text, encoding="utf-8")
            return expectations.read(path)

    def test_what_deviates_as_expected_is_no_difference(self):
        claims = [
            claim("F5", "The cylinder collides"),
            claim("F16", "At 10 m/s"),
            claim("F5", "fine", "reproduced"),
        ]
        self.assertEqual(expectations.differences(claims, EXPECTED), [])

    def test_what_deviates_unexpectedly_is_told_with_its_numbers(self):
        found = expectations.differences(
            [claim("F5", "The cylinder"), claim("F16", "At 10 m/s"), claim("F9", "The cylinder"), claim("F5", "The other")], EXPECTED
        )
        self.assertEqual(len(found), 2)
        self.assertIn("F9: deviates unexpectedly: The cylinder: 2 N, wants <= 1 N", found[0])

    def test_what_no_longer_deviates_is_told(self):
        found = expectations.differences([claim("F5", "The cylinder"), claim("F16", "At 10 m/s", "reproduced")], EXPECTED)
        self.assertEqual(found, ["F16: no longer deviates: At 10 m/s"])

    def test_figures_that_were_not_made_are_not_missed(self):
        self.assertEqual(expectations.differences([claim("F5", "The cylinder")], EXPECTED, {"F5"}), [])

    def test_lines_need_figure_claim_and_reason_and_come_once(self):
        self.assertEqual(self.read("# comment\n\nF5 | The cylinder | why\n"), EXPECTED[:1])
        for text in ("F5 | The cylinder\n", "F5 | The cylinder | \n", "F5 | a | b | c\n", "F5 | a | b\nF5 | a | c\n"):
            with self.assertRaises(ValueError):
                self.read(text)

    def test_the_committed_list_can_be_read(self):
        self.assertGreater(len(expectations.read(HERE / "expected_deviations.txt")), 0)


if __name__ == "__main__":
    unittest.main()
