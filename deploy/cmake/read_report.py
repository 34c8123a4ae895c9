#!/usr/bin/python3
"""Reads a JUnit report of ctest for deploy/test.

usage: read_report.py [--all-groups] REPORT

Prints "PASSED FAILED" and then a line for each test that was skipped or failed, with the last lines that a failed one printed; tests that
lack a group of packages share a line. Its whole output goes to stderr. A report without a test counts as one failure: nothing was proven.
--all-groups: all groups were to be installed, so a test that lacks one has failed.
"""
import collections
import re
import sys
import xml.etree.ElementTree as xml

LAST_LINES = 20
GROUP = re.compile(r"needs the group (\w+): (.*)")


def read(cases, all_groups):
    """(passed, failed, notes) of (name, status, output) of each test."""
    passed, failed, notes, lacking = 0, 0, [], collections.Counter()
    for name, status, output in cases:
        reasons = re.findall(r"SKIPPED: (.*)", output)
        group = next(filter(None, map(GROUP.match, reasons)), None)
        if status == "skipped" and group and not all_groups:
            lacking[group.groups()] += 1
        elif status == "run":
            passed += 1
            notes += [f"skipped in part: {name}: {reason}" for reason in reasons]
        elif status == "disabled" or status == "skipped" and reasons and not group:
            notes.append(f"skipped: {name}: {'; '.join(reasons) or 'disabled'}")
        else:
            failed += 1
            notes.append(f"failed: {name}")
            notes += [f"  | {line[:200]}" for line in output.strip().splitlines()[-LAST_LINES:]]
            print(f"-- {name}\n{output}", file=sys.stderr)
    for (group, remedy), count in sorted(lacking.items()):
        notes.append(f"skipped: {count} test{'s' if count > 1 else ''} that need{'' if count > 1 else 's'} the group {group}: {remedy}")
    return passed, failed, notes


def cases_of(report):
    for case in xml.parse(report).iter("testcase"):
        status = "skipped" if case.get("status") != "disabled" and case.find("skipped") is not None else case.get("status")
        yield case.get("name"), status, case.findtext("system-out") or ""


def main():
    all_groups = sys.argv[1] == "--all-groups"
    try:
        cases = list(cases_of(sys.argv[-1]))
    except (OSError, xml.ParseError) as error:
        print(f"0 1\nfailed: no report of the tests: {error}")
        return
    if not cases:
        print("0 1\nfailed: there is no such test")
        return
    passed, failed, notes = read(cases, all_groups)
    print(f"{passed} {failed}", *notes, sep="\n")


if __name__ == "__main__":
    main()
