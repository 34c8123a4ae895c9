#!/usr/bin/python3
"""Scripts name what somebody meant who mistyped an option, a label, a preset or a group of packages. Truth: the distance between two words
by its recurrence, from their ends.

usage: hints_test.py CMAKE INSTALL-SCRIPT [PRESET]
  INSTALL-SCRIPT  installs clients/play
  PRESET          whose build is in build/PRESET
"""
import functools
import os
import pathlib
import random
import re
import subprocess
import sys
import tempfile
import unittest

ROOT = pathlib.Path(__file__).resolve().parents[2]
NEAREST = ROOT / "clients/play/nearest_name"
SCRIPTS = ("deploy/play", "deploy/test", "deploy/package", "deploy/release", "clients/play/hapticd-play")
LETTERS = "abcdefghijklmnopqrstuvwxyz-"


@functools.cache
def distance(a, b):
    """Letters wrong, missing, too many or exchanged with the next."""
    if not a or not b:
        return len(a) + len(b)
    choices = [distance(a[:-1], b[:-1]) + (a[-1] != b[-1]), distance(a[:-1], b) + 1, distance(a, b[:-1]) + 1]
    if a[-2:] == b[-2:][::-1] and len(a) > 1:
        choices.append(distance(a[:-2], b[:-2]) + 1)
    return min(choices)


def nearest(word, names):
    """Those that may be meant."""
    def edits(name):
        return min(1, distance(word, name)) if len(word) >= 3 and name.startswith(word) and name != word else distance(word, name)
    least = min(edits(name) for name in names)
    return {name for name in names if edits(name) == least} if least <= max(1, len(word) // 3) else set()


def mistyped(word, chance):
    """One edit behind the dashes."""
    at = chance.randrange(2, len(word))
    kind = chance.randrange(4)
    if kind == 0:
        return word[:at] + word[at + 1:]
    if kind == 1:
        return word[:at] + chance.choice(LETTERS) + word[at:]
    if kind == 2:
        return word[:at] + chance.choice(LETTERS) + word[at + 1:]
    return word[:at] + word[at:at + 2][::-1] + word[at + 2:]


def said(*command):
    done = subprocess.run(command, capture_output=True, text=True, timeout=60, check=False, stdin=subprocess.DEVNULL)
    return done.returncode, done.stdout, done.stderr


def meant(text):
    found = re.search(r"\. Did you mean (\S+)\?", text)
    return found and found.group(1)


class Hints(unittest.TestCase):
    def test_the_nearest_name_is_that_of_the_recurrence(self):
        chance = random.Random(1)
        for _ in range(300):
            letters = LETTERS[:chance.randint(2, 4)]
            word, *names = ("".join(chance.choice(letters) for _ in range(chance.randint(1, 9))) for _ in range(5))
            code, text, complaint = said(str(NEAREST), word, *names)
            self.assertEqual((0, ""), (code, complaint))
            found = meant(text)
            self.assertIn(found, nearest(word, names) or {None}, (word, names))

    def test_case_does_not_count_and_what_is_empty_or_long_means_nothing(self):
        self.assertEqual(". Did you mean Tidy?", said(str(NEAREST), "TIYD", "Tidy")[1])
        for word in ("", "a" * 65):
            self.assertEqual((0, "", ""), said(str(NEAREST), word, "a", "a" * 66))

    def check_options(self, script, name):
        options = sorted(set(re.findall(r"^ +(--[a-z][a-z-]*)", said(str(script), "--help")[1], re.MULTILINE)))
        self.assertIn("--help", options)
        chance = random.Random(2)
        for option in options:
            typed = mistyped(option, chance)
            if typed in options or typed == "--":
                continue
            code, text, complaint = said(str(script), typed)
            self.assertEqual((2, ""), (code, text), complaint)
            self.assertIn(meant(complaint), nearest(typed, options), complaint)
            self.assertTrue(complaint.endswith(f"? See {name} --help.\n"), complaint)
        code, _, complaint = said(str(script), "--qqqqqqqq")
        self.assertEqual((2, f"{name}: there is no option --qqqqqqqq. See {name} --help.\n"), (code, complaint))

    def test_every_script_names_the_option_that_was_meant(self):
        for script in SCRIPTS:
            with self.subTest(script):
                self.check_options(ROOT / script, script.removeprefix("clients/play/"))

    def test_an_option_of_hapticd_is_said_to_stand_behind_dashes(self):
        # Before anything is built the manual tells which options there are.
        for preset in ("none", *filter(None, [PRESET])):
            for words, right in (("--scene wall", "--scene wall"), ("--arm firm", "--arm firm"), ("--announce --no-sound", "--announce"),
                                 ("--clock virtual", "--clock virtual"), ("--record", "--record VALUE")):
                code, _, complaint = said(str(ROOT / "deploy/play"), "--preset", preset, "--no-build", *words.split())
                name = right.split()[0]
                self.assertEqual((2, f"deploy/play: {name} is an option of hapticd, and stands behind --: deploy/play -- {right}. "
                                  "See deploy/play --help.\n"), (code, complaint))

    def test_the_label_the_preset_and_the_group_that_were_meant_are_named(self):
        for words, name in ((("deploy/test", "unti"), "unit"), (("deploy/test", "--preset", "tdy"), "tidy"),
                            (("deploy/play", "--preset", "relaese"), "release"), (("deploy/install_packages", "audoi"), "audio")):
            code, _, complaint = said(str(ROOT / words[0]), *words[1:])
            self.assertEqual((2, name), (code, meant(complaint)), complaint)

    def test_an_empty_label_is_seen_to_be_one(self):
        code, text, complaint = said(str(ROOT / "deploy/test"), "")
        self.assertEqual((2, ""), (code, text))
        self.assertIn("there is no label ''; there are unit, ", complaint)

    def test_hapticd_play_does_so_where_it_is_installed(self):
        with tempfile.TemporaryDirectory() as prefix:
            subprocess.run([CMAKE, f"-DCMAKE_INSTALL_PREFIX={prefix}", "-P", INSTALL], env=dict(os.environ, DESTDIR=""), check=True,
                           stdout=subprocess.DEVNULL)
            self.check_options(pathlib.Path(prefix, "bin/hapticd-play"), "hapticd-play")


if __name__ == "__main__":
    CMAKE, INSTALL, *PRESET = sys.argv[1:]
    PRESET = PRESET and PRESET[0]
    unittest.main(argv=sys.argv[:1], verbosity=2)
