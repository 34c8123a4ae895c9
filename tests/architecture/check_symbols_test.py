#!/usr/bin/python3
"""The symbol check finds each forbidden kind in a library that holds them all.

usage: check_symbols_test.py LIBRARY
"""
import sys
import unittest

import check_symbols

FORBIDDEN = ("operator new(", "operator delete(", "malloc", "free", "__cxa_throw", "std::__throw_", "__cxa_guard_acquire",
             "pthread_mutex_lock", "printf", "sin", "pow")


class CheckSymbolsTest(unittest.TestCase):
    library = ""

    def test_every_forbidden_kind_is_found(self):
        lines = check_symbols.violations(self.library)
        for name in FORBIDDEN:
            self.assertTrue(any(f"needs {name}" in line for line in lines), f"{name} not in {lines}")

    def test_names_that_only_begin_like_allowed_ones_are_refused(self):
        allowed = check_symbols.allowed()
        for name in ("sqrtl_fast", "abort_later", "malloc", "spdlog::info()", "std::vector<hapticd::Row>::at(unsigned long)"):
            self.assertFalse(allowed.fullmatch(name), name)
        for name in ("sqrt", "memcpy", "hapticd::Simulation::step(hapticd::Tick&)"):
            self.assertTrue(allowed.fullmatch(name), name)


if __name__ == "__main__":
    CheckSymbolsTest.library = sys.argv.pop()
    unittest.main()
