#!/usr/bin/python3
"""The shared library exports the C interface, the namespace of its version and the messages, each under one version of symbols, and
nothing else. The list in data/symbols.txt has all but the messages: a line that goes breaks programs that were built before, and needs
another SOVERSION, namespace and version of symbols; a new one is added to the list.

usage: symbols_test.py LIBRARY"""
import pathlib
import re
import subprocess
import sys
import unittest

LIST = pathlib.Path(__file__).parent / "data" / "symbols.txt"
VERSION = "@@HAPTICD_CLIENT_0"
MESSAGES = re.compile(r"(vtable for |typeinfo for |typeinfo name for |.*)hapticd::v1::|descriptor_table_hapticd_|google::protobuf::.*hapticd::v1::"
                      r"|.*google::protobuf::.*<hapticd::v1::")
OURS = re.compile(r"hapticd_\w+$|(vtable for |typeinfo for |typeinfo name for )?hapticd::client::abi_0::")


def exported(library, *options):
    """(type, name) of each symbol."""
    lines = subprocess.run(["nm", "-D", "--defined-only", *options, library], capture_output=True, text=True, check=True).stdout.splitlines()
    return [tuple(line.split(maxsplit=2)[1:]) for line in lines]


class Symbols(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        cls.found = [(kind, name) for kind, name in exported(cls.library, "-C") if name != "HAPTICD_CLIENT_0" and kind != "A"]

    def test_all_have_the_version(self):
        self.assertGreater(len(self.found), 1000)
        self.assertEqual([name for _, name in self.found if not name.endswith(VERSION)], [])

    def test_nothing_of_the_inside_is_exported(self):
        names = {name.removesuffix(VERSION) for _, name in self.found}
        self.assertEqual(sorted(name for name in names if not OURS.match(name) and not MESSAGES.match(name)), [])

    def test_the_list_is_exported_and_nothing_beside_it(self):
        # Weak ones are copies of what headers define inline: which there are is for the compiler.
        names = {name.removesuffix(VERSION) for kind, name in self.found if kind != "W" and OURS.match(name.removesuffix(VERSION))}
        listed = LIST.read_text(encoding="utf-8").splitlines()
        self.assertEqual(sorted(names), [line for line in listed if not line.startswith("#")])

    def test_every_message_can_be_used(self):
        names = {name.removesuffix(VERSION) for _, name in self.found}
        for message in ("State", "Item", "Result", "SceneInfo", "Tone", "Contact", "Scene", "Gesture", "TickRecord"):
            self.assertIn(f"vtable for hapticd::v1::{message}", names)
            self.assertIn(f"hapticd::v1::{message}::~{message}()", names)


if __name__ == "__main__":
    Symbols.library = sys.argv.pop()
    sys.exit(unittest.main(verbosity=2))
