#!/usr/bin/python3
"""Checks the layout of every C++ and proto file with clang-format 14 and the scripts with shellcheck. Exit code 1 on any difference."""
import subprocess
import sys

import source_tree


def is_bash(path):
    with open(f"{source_tree.ROOT}/{path}", "rb") as file:
        return file.readline() in (b"#!/bin/bash\n", b"#!/bin/sh\n")


def main():
    files = source_tree.files()
    code = [path for path in files if path.endswith((".h", ".cpp", ".proto"))]
    scripts = [path for path in files if is_bash(path)]
    commands = [["clang-format-14", "--dry-run", "-Werror", *code], ["shellcheck", *scripts]]
    return max(subprocess.run(command, cwd=source_tree.ROOT, check=False).returncode for command in commands)


if __name__ == "__main__":
    sys.exit(main())
