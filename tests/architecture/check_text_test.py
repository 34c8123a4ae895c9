#!/usr/bin/python3
"""The text check finds what it is there for."""
import unittest

import check_text

GOOD = "// What it is.\n#pragma once\n"


class CheckTextTest(unittest.TestCase):
    def assert_refused(self, path, text, reason):
        lines = check_text.violations(path, text)
        self.assertEqual(len(lines), 1, lines)
        self.assertIn(reason, lines[0])

    def test_a_plain_header_passes(self):
        self.assertEqual([], check_text.violations("core/math/a.h", GOOD))

    def test_long_files_are_refused(self):
        self.assertEqual([], check_text.violations("core/math/a.h", GOOD + "\n" * 597))
        self.assert_refused("core/math/a.h", GOOD + "\n" * 598, "600 lines")
        self.assert_refused("clients/web/page/src/a.js", "//" + "\n" * 600, "600 lines")

    def test_files_without_an_opening_comment_are_refused(self):
        self.assert_refused("core/math/a.h", "\n#pragma once\n", "does not start with a comment")
        self.assert_refused("core/math/a.cpp", "#include <array>\n", "does not start with a comment")
        self.assert_refused("clients/web/page/src/a.js", "import './b.js';\n", "does not start with a comment")
        self.assert_refused("tests/x.py", "#!/usr/bin/python3\nimport sys\n", "does not start with a comment")

    def test_headers_without_a_guard_are_refused(self):
        self.assert_refused("core/math/a.h", "// What it is.\n", "pragma once")

    def test_leftovers_are_refused_with_their_line(self):
        for word in ("TO" + "DO", "FIX" + "ME"):
            self.assert_refused("core/math/a.h", GOOD + f"// {word}: later\n", "core/math/a.h:3: a note")
        self.assert_refused("README.md", "see /hom" + "e/me/x\n", "README.md:1: a path of one machine")
        self.assert_refused("README.md", "see /wor" + "k/x\n", "a path of one machine")
        self.assert_refused("core/math/a.h", GOOD + "\tint a;\n", "a tab")
        self.assert_refused("core/math/a.h", GOOD + "int a; \n", "a space at the end")

    def test_relative_paths_and_urls_pass(self):
        self.assertEqual([], check_text.violations("README.md", "https://example.org/wor" + "k/x ./hom" + "e/x\n"))

    def test_the_top_level_is_fixed(self):
        self.assert_refused("src/a.md", "text\n", "no src")

    def test_folders_outside_the_build_are_refused(self):
        paths = ["CMakeLists.txt", "core/math/CMakeLists.txt", "core/math/peers/CMakeLists.txt", "core/rt/CMakeLists.txt"]
        self.assertEqual(["core/rt: not in the list of CMakeLists.txt"], check_text.unlisted(paths, "set(FOLDERS core/math)"))


if __name__ == "__main__":
    unittest.main()
