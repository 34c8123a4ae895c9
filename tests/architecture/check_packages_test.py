#!/usr/bin/python3
"""The check of packages finds a file in none, in two, and a package without files."""
import pathlib
import subprocess
import sys
import tempfile
import unittest

import check_packages

CMAKE = sys.argv.pop()
PROJECT = """cmake_minimum_required(VERSION 3.25)
project(sample LANGUAGES NONE)
install(FILES CMakeLists.txt DESTINATION share/a COMPONENT one)
install(FILES CMakeLists.txt DESTINATION share/b COMPONENT two)
set(CPACK_COMPONENTS_ALL one two)
include(CPack)
"""


class Packages(unittest.TestCase):
    def problems(self, text):
        with tempfile.TemporaryDirectory() as folder:
            build = pathlib.Path(folder).resolve()
            (build / "CMakeLists.txt").write_text(text)
            subprocess.run([CMAKE, "-S", build, "-B", build], check=True, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)
            parts = {name: check_packages.installed(build, CMAKE, name) for name in check_packages.packages_of(build)}
            return check_packages.problems_of(check_packages.installed(build, CMAKE), parts)

    def test_what_is_in_one_package_each_is_let_pass(self):
        self.assertEqual([], self.problems(PROJECT))

    def test_what_is_in_no_package_is_named(self):
        self.assertEqual(["share/c/CMakeLists.txt is installed, but in no package"],
                         self.problems(PROJECT + "install(FILES CMakeLists.txt DESTINATION share/c)\n"))

    def test_what_is_in_two_packages_is_named(self):
        self.assertEqual(["share/a/CMakeLists.txt is in one and in two"],
                         self.problems(PROJECT + "install(FILES CMakeLists.txt DESTINATION share/a COMPONENT two)\n"))

    def test_what_comes_only_when_it_is_asked_for_is_named(self):
        self.assertEqual(["share/c/CMakeLists.txt is in one alone, and not installed with all"],
                         self.problems(PROJECT + "install(FILES CMakeLists.txt DESTINATION share/c COMPONENT one EXCLUDE_FROM_ALL)\n"))

    def test_a_package_without_files_is_named(self):
        self.assertEqual(["the package three is empty"], self.problems(PROJECT.replace("one two)", "one two three)")))


if __name__ == "__main__":
    sys.exit(unittest.main())
