#!/usr/bin/python3
"""Runs a program in a guest and ends as it ended.

usage: run_guest.py [--smp] [--program FILE]... [--tree FOLDER:PLACE]... [--udev FILE] -- COMMAND [ARGUMENT]...
--program puts a program, with its libraries, into the guest's /bin, --tree a folder. --udev adds systemd's udevd, to be started by the
command, with our rules and this program that they ask. --smp gives it two processors that really run at once. Where no kernel can be had the
test is skipped, as if packages were missing."""
import argparse
import shlex
import sys

import guest
from kernel import Missing

SKIPPED = 77  # SKIP_RETURN_CODE of every test


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--smp", action="store_true")
    parser.add_argument("--program", action="append", default=[])
    parser.add_argument("--tree", action="append", default=[])
    parser.add_argument("--udev")
    parser.add_argument("command", nargs="+")
    options = parser.parse_args()
    try:
        code, printed = guest.run(shlex.join(options.command) + "\n", programs=options.program,
                                  trees=[tree.split(":") for tree in options.tree], smp=options.smp, udev_helper=options.udev)
    except Missing as missing:
        print(f"SKIPPED: needs the group vm: {missing}")
        return SKIPPED
    print(printed)
    return code


if __name__ == "__main__":
    sys.exit(main())
