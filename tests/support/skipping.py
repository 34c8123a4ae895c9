"""Runs the cases of a test and names those that were skipped: for what this kernel or machine cannot do. What packages can bring is said by
REQUIRES in CMake."""
import sys
import unittest

SKIPPED = 77
"""SKIP_RETURN_CODE of every test."""


def main():
    """Ends as unittest.main does; and as skipped if no case ran."""
    result = unittest.main(module="__main__", exit=False).result
    for case, reason in result.skipped:
        print(f"SKIPPED: {case.id().rpartition('.')[2]}: {reason}")
    if not result.wasSuccessful():
        sys.exit(1)
    sys.exit(SKIPPED if result.skipped and len(result.skipped) == result.testsRun else 0)
