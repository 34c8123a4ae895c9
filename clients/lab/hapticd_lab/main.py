"""The command line of hapticd-lab: one entry of COMMANDS for each command, each with --output DIR."""
from __future__ import annotations

import argparse
import difflib
import importlib
import io
import os
import re
import subprocess
import sys
from typing import List, NoReturn, Optional

from hapticd_lab.oracle import find_program

COMMANDS = {"repro": "hapticd_lab.repro", "fit": "hapticd_lab.fit", "experiment": "hapticd_lab.experiment",
            "group": "hapticd_lab.group", "tradeoff": "hapticd_lab.tradeoff"}
"""Command to the module that has it: SUMMARY, describe(parser) and run(options) -> exit code."""


class Parser(argparse.ArgumentParser):
    """Names what somebody meant who mistyped an option or a command."""

    def known(self) -> List[str]:
        """All options and commands."""
        names: List[str] = []
        for action in self._actions:
            names += action.option_strings
            if isinstance(action, argparse._SubParsersAction):
                for name, below in action.choices.items():
                    names += [name, *below.known()]
        return names

    def error(self, message: str) -> NoReturn:
        known = self.known()
        mistyped = re.search(r"unrecognized arguments: (\S+)|invalid choice: '([^']*)'", message)
        words = [mistyped.group(1) or mistyped.group(2)] if mistyped else [word for word in sys.argv[1:] if word.startswith("--")]
        strange = [word.split("=")[0] for word in words if word.split("=")[0] not in known]
        near = difflib.get_close_matches(strange[0], known, 1) if strange else []
        number = re.search(r"invalid (int|float) value: '([-+]?\d+),(\d+)'", message)
        right = "" if number is None else ". Give a whole number" if number[1] == "int" else f". Write {number[2]}.{number[3]}, with a point"
        super().error(message + right + (f". Did you mean {near[0]}?" if near else ""))


def parser() -> argparse.ArgumentParser:
    """All commands with their options."""
    top = Parser(
        prog="hapticd-lab", description="Sessions with a real hapticd in lockstep, measured: the figures of the paper, reproduced; its experiment; measured "
        "forces, fitted; what accuracy costs.",
        epilog="hapticd-lab COMMAND --help says more. man hapticd-lab")
    top.add_argument("--version", action="store_true", help="its version, which is that of the hapticd that it starts")
    commands = top.add_subparsers(dest="command", metavar="COMMAND", required=True)
    for name, module_name in COMMANDS.items():
        module = importlib.import_module(module_name)
        one = commands.add_parser(name, help=module.SUMMARY, description=module.__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
        module.describe(one)
        one.set_defaults(run=module.run)
    return top


def show_version() -> int:
    """Says which hapticd it starts, in its own name; the exit code, which is 1 where there is none."""
    program = ""
    try:
        program = find_program("hapticd")
        told = subprocess.run([program, "--version"], stdout=subprocess.PIPE, text=True, check=False)
    except OSError as error:
        print(f"hapticd-lab --version: {f'{program}: {error.strerror}' if program else error}", file=sys.stderr)
        return 1
    print(f"hapticd-lab {told.stdout.strip().removeprefix('hapticd ')}")
    return told.returncode


def main(arguments: Optional[List[str]] = None) -> int:
    """Runs a command; exit code of the process."""
    # Paths are bytes: one that is no text in this locale is printed as it is.
    for stream in (sys.stdout, sys.stderr):
        if isinstance(stream, io.TextIOWrapper):
            stream.reconfigure(errors="surrogateescape")
    if (sys.argv[1:] if arguments is None else arguments) == ["--version"]:
        return show_version()
    options = parser().parse_args(arguments)
    try:
        code = options.run(options)
        sys.stdout.flush()
        return code
    except BrokenPipeError:
        # Who reads has seen enough, and what is left in the buffer would complain at exit.
        os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())
        return 0
    except OSError as error:
        what = f"{error.filename}: {error.strerror}" if error.filename else error
        print(f"hapticd-lab {options.command}: {what}", file=sys.stderr)
        return 1
    except KeyboardInterrupt:
        return 130
