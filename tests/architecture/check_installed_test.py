#!/usr/bin/python3
"""The check of what is installed finds a program, a file and a folder that the target `installed` does not build.

usage: check_installed_test.py NINJA
"""
import pathlib
import sys
import tempfile
import unittest

import check_installed

NINJA = sys.argv.pop()
RULES = """rule make
  command = touch $out
build bin/a: make a.cpp
build bin/b: make b.cpp
build share/page/index.html: make
build page: phony share/page/index.html
build sub/more: phony bin/b || page
build installed: phony {installed}
"""
SCRIPT = """file(INSTALL DESTINATION "${{P}}/bin" TYPE EXECUTABLE FILES "{build}/bin/a")
file(INSTALL DESTINATION "${{P}}/bin" TYPE FILE FILES
    "{build}/bin/b"
    "/elsewhere/man.1"
    )
file(INSTALL DESTINATION "${{P}}/share" TYPE DIRECTORY OPTIONAL FILES "{build}/share/page" FILES_MATCHING REGEX "/[^/]*$")
"""


class Installed(unittest.TestCase):
    def problems(self, installed, script=SCRIPT):
        with tempfile.TemporaryDirectory() as folder:
            build = pathlib.Path(folder).resolve()
            (build / "build.ninja").write_text(RULES.format(installed=installed))
            (build / "sub").mkdir()
            (build / "sub" / "cmake_install.cmake").write_text(script.format(build=build))
            return check_installed.problems_of(build, NINJA)

    def test_what_is_all_built_is_let_pass(self):
        self.assertEqual(self.problems("bin/a bin/b share/page/index.html"), [])
        self.assertEqual(self.problems("bin/a | sub/more"), [])

    def test_what_is_left_out_is_named(self):
        for built, missing in (("bin/a bin/b", "share/page"), ("bin/b share/page/index.html", "bin/a"), ("bin/a share/page/index.html", "bin/b")):
            (problem,) = self.problems(built)
            self.assertTrue(problem.startswith(missing + " is installed"), problem)

    def test_what_cmake_writes_and_links_to_libraries_are_let_pass(self):
        rules = RULES.replace("build installed", "build lib/liba.so.0.1: make a.cpp\nbuild lib/liba.so.0 lib/liba.so: CMAKE_SYMLINK_LIBRARY lib/liba.so.0.1\n"
                              "build liba: phony lib/liba.so\nbuild installed").replace("rule make", "rule CMAKE_SYMLINK_LIBRARY\n  command = ln $out\nrule make")
        script = 'file(INSTALL DESTINATION "${{P}}" TYPE FILE FILES "{build}/lib/liba.so.0.1" "{build}/lib/liba.so.0" "{build}/configured/a.pc")\n'
        for installed, written, problems in (("liba", True, 0), ("liba", False, 1), ("bin/a", True, 2)):
            with tempfile.TemporaryDirectory() as folder:
                build = pathlib.Path(folder).resolve()
                (build / "build.ninja").write_text(rules.format(installed=installed))
                for name in ("lib", "configured"):
                    (build / name).mkdir()
                (build / "lib" / "liba.so.0").symlink_to("liba.so.0.1")
                if written:
                    (build / "configured" / "a.pc").touch()
                (build / "cmake_install.cmake").write_text(script.format(build=build))
                self.assertEqual(len(check_installed.problems_of(build, NINJA)), problems)

    def test_a_build_that_installs_nothing_is_a_problem(self):
        self.assertEqual(self.problems("bin/a", script=""), ["nothing is installed"])


if __name__ == "__main__":
    sys.exit(unittest.main())
