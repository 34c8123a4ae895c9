#!/usr/bin/python3
"""Links in all Markdown pages of the project: files and folders exist, and so do the headings behind a #. Links to other machines are listed and
not followed. README.md has 900 words at most."""
import os
import pathlib
import re
import sys
import unittest

ROOT = pathlib.Path(__file__).resolve().parents[2]
sys.path.insert(0, str(ROOT / "tests/architecture"))
import source_tree  # noqa: E402

MOST_WORDS = 900
LINK = re.compile(r"\[(?:[^][]|\[[^][]*\])*\]\(([^()\s]+(?:\([^()\s]*\))?)\)")
FENCED = re.compile(r"^(```+|~~~+).*?^\1", re.MULTILINE | re.DOTALL)


def prose(text):
    """A page without its code."""
    return re.sub(r"`[^`\n]+`", "", FENCED.sub("", text))


def anchors(text):
    """Names that headings of a page have in links, as GitHub and MyST make them."""
    seen, found = {}, set()
    for heading in re.findall(r"^#{1,6} +(.*?) *#*$", FENCED.sub("", text), re.MULTILINE):
        heading = re.sub(r"\[([^]]*)\]\([^)]*\)", r"\1", heading)
        name = re.sub(r"[^\w\- ]", "", heading.lower()).replace(" ", "-")
        found.add(f"{name}-{seen[name]}" if name in seen else name)
        seen[name] = seen.get(name, 0) + 1
    return found


def problems(page, text, read):
    """What of a page's links does not hold. `read`: text of a path, "" of a folder, None where there is nothing."""
    found = []
    for target in LINK.findall(prose(text)):
        if re.match(r"[a-z]+:", target):
            continue
        path, _, anchor = target.partition("#")
        path = os.path.normpath(os.path.join(os.path.dirname(page), path)) if path else page
        there = text if path == page else read(path)
        if there is None:
            found.append(f"{page}: there is no {target}")
        elif anchor and anchor not in anchors(there):
            found.append(f"{page}: there is no heading #{anchor} in {path}")
    return found


def read_file(path):
    file = ROOT / path
    if path.startswith("..") or not file.exists():
        return None
    return file.read_text(encoding="utf-8") if file.suffix == ".md" else ""


class Links(unittest.TestCase):
    def test_all_links_hold(self):
        outside, found = set(), []
        for page in source_tree.files():
            if page.endswith(".md"):
                text = source_tree.read(page)
                outside.update(link for link in LINK.findall(prose(text)) if re.match(r"[a-z]+:", link))
                found += problems(page, text, read_file)
        print("not followed:", *sorted(outside), sep="\n  ")
        self.assertEqual([], found)

    def test_what_does_not_hold_is_found(self):
        pages = {"b.md": "# A heading, `code` & more\n# Twice\n# Twice\n", "folder": ""}
        good = "[x](b.md) [y](b.md#a-heading-code--more) [z](#here) [t](b.md#twice-1) [f](folder) [o](https://example.org/a) `[c](no)`\n## Here\n"
        self.assertEqual([], problems("a.md", good, pages.get))
        for link in ("c.md", "b.md#nothing", "#nothing", "b.md#twice-2", "../b.md", "sub/b.md"):
            self.assertEqual(1, len(problems("a.md", f"# Here\n[x]({link})", pages.get)), link)

    def test_the_readme_is_short(self):
        words = len(source_tree.read("README.md").split())
        self.assertLessEqual(words, MOST_WORDS)


if __name__ == "__main__":
    unittest.main()
