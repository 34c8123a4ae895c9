"""Each option that a program names when it is asked for help is in its page of the manual, and so are those of its commands."""
import os
import pathlib
import re
import subprocess
import unittest

REPOSITORY = pathlib.Path(__file__).resolve().parents[2]
BIN = pathlib.Path(os.environ["HAPTICCTL"]).parent
# Commands that another program carries out, which has a page of its own.
ELSEWHERE = {("hapticctl", "experiment"): "hapticd-lab"}


def helps(*words):
    """The words of each command of a program, and what it says of itself."""
    done = subprocess.run([BIN / words[0], *words[1:], "--help"], capture_output=True, text=True, timeout=60, stdin=subprocess.DEVNULL, check=True)
    yield words, done.stdout
    head, _, commands = done.stdout.partition("\nSubcommands:\n")
    if not commands:
        commands = head.partition("\n  COMMAND\n")[2]
    for name in re.findall(r"^ {2,4}([a-z][a-z0-9-]+)(?= |$)", commands, re.MULTILINE):
        yield from helps(*words, name)


class Manual(unittest.TestCase):
    def test_it_has_every_option(self):
        looked_at, lacking = 0, []
        for page in sorted((REPOSITORY / "deploy/man").glob("*.1")):
            if not (BIN / page.stem).exists():
                continue
            for words, text in helps(page.stem):
                manual = (page.parent / f"{ELSEWHERE.get(words[:2], page.stem)}.1").read_text(encoding="utf-8").replace("\\-", "-")
                for option in re.findall(r"^ +(?:-\w, ?)?(--[a-z][a-z0-9-]*)", text, re.MULTILINE):
                    if option != "--help" and not re.search(re.escape(option) + r"(?![\w-])", manual):
                        lacking.append(f"{' '.join(words)} {option}")
                looked_at += 1
        self.assertEqual([], lacking)
        self.assertGreater(looked_at, 30)


if __name__ == "__main__":
    unittest.main()
