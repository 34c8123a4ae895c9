#!/usr/bin/python3
"""Reads a JUnit report of ctest for deploy/test.

usage: read_report.py REPORT

Prints "PASSED FAILED" and then a line for each test that was skipped or failed, with the last lines that a failed one printed. Its whole
output goes to stderr. A report without a test counts as one failure: nothing was proven.
"""
import re
import sys
import xml.etree.ElementTree as xml

LAST_LINES = 20


def main():
    try:
        cases = list(xml.parse(sys.argv[1]).iter("testcase"))
    except (OSError, xml.ParseError) as error:
        print(f"0 1\nfailed: no report of the tests: {error}")
        return
    if not cases:
        print("0 1\nfailed: there is no such test")
        return
    passed, failed, notes = 0, 0, []
    for case in cases:
        name, status, output = case.get("name"), case.get("status"), case.findtext("system-out") or ""
        reason = re.search(r"SKIPPED: (.*)", output)
        if status == "run":
            passed += 1
        elif status == "disabled" or case.find("skipped") is not None and reason:
            notes.append(f"skipped: {name}: {reason[1] if reason else 'disabled'}")
        else:
            failed += 1
            notes.append(f"failed: {name}")
            notes += [f"  | {line[:200]}" for line in output.strip().splitlines()[-LAST_LINES:]]
            print(f"-- {name}\n{output}", file=sys.stderr)
    print(f"{passed} {failed}", *notes, sep="\n")


main()
