#!/usr/bin/python3
"""deploy/test names every label that a test has, and refuses a label that none has, saying which there are.

usage: check_labels.py BUILD-FOLDER CTEST
"""
import re
import subprocess
import sys

from source_tree import ROOT

DEPLOY_TEST = f"{ROOT}/deploy/test"


def main():
    build, ctest = sys.argv[1:]
    printed = subprocess.run([ctest, "--test-dir", build, "--print-labels"], capture_output=True, text=True, check=True).stdout
    had = set(re.findall(r"^  (\S+)$", printed, re.MULTILINE))
    help_text = subprocess.run([DEPLOY_TEST, "--help"], capture_output=True, text=True, check=True).stdout
    named = set(re.search(r"of that label only: (.*)\.$", help_text, re.MULTILINE)[1].split(", "))
    refused = subprocess.run([DEPLOY_TEST, "unti"], capture_output=True, text=True, check=False, timeout=60)
    problems = [f"deploy/test does not name the label {label}" for label in sorted(had - named)]
    if not had:
        problems.append("no test has a label")
    if refused.returncode != 2 or refused.stdout or "there is no label unti; there are unit," not in refused.stderr:
        problems.append(f"deploy/test unti: {refused.returncode} {refused.stdout}{refused.stderr}")
    print("\n".join(problems) or f"{len(had)} labels")
    return 1 if problems else 0


if __name__ == "__main__":
    sys.exit(main())
