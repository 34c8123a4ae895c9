#!/usr/bin/python3
"""check_extremes.py finds what a page of extremes may get wrong, and nothing else."""
import unittest

from check_extremes import cases, problems

SOURCE = 'TEST_CASE("one thing") {}\nTEST_CASE(\n    "a long "\n    "name") {}\nTEST_CASE("with \\"quotes\\"") {}\n'
HEAD = "| extreme | must happen | tests |\n|---|---|---|\n"


def read(file):
    return SOURCE if file == "core/a_test.cpp" else None


class CheckExtremesTest(unittest.TestCase):
    def test_names_are_put_together_from_their_pieces(self):
        self.assertEqual(cases(SOURCE), {"one thing", "a long name", 'with \\"quotes\\"'})

    def test_a_page_that_is_true_passes(self):
        self.assertEqual(problems(HEAD + "| x | y | `core/a_test.cpp: one thing`<br>`core/a_test.cpp: a long name` |\n", read), [])

    def test_whatever_does_not_exist_is_found(self):
        for page, word in ((HEAD + "| x | y | `core/a_test.cpp: one thin` |\n", "no case"), (HEAD + "| x | y | `core/b_test.cpp: one thing` |\n", "no tests/"),
                           (HEAD + "| x | y | none |\n", "no test"), (HEAD, "no rows")):
            self.assertEqual(len(problems(page, read)), 1, page)
            self.assertIn(word, problems(page, read)[0])


if __name__ == "__main__":
    unittest.main()
