#!/usr/bin/python3
"""Builds the site and judges its HTML: whatever a page leads to or shows is there, headings included; nothing comes from another machine; search
works from files; every field of a scene, option of a program and public class is in the reference. CITATION.cff is of its format.

usage: site_test.py FOLDER VERSION
"""
import html.parser
import os
import pathlib
import re
import shutil
import subprocess
import sys
import unittest
import urllib.parse

import yaml

ROOT = pathlib.Path(__file__).resolve().parents[2]
WORK, VERSION = pathlib.Path("."), ""


class Page(html.parser.HTMLParser):
    """ids: what may be led to; links: where it leads; shown: what a browser loads with it."""

    def __init__(self, text):
        super().__init__()
        self.ids, self.links, self.shown = set(), [], []
        self.feed(text)

    def handle_starttag(self, tag, attrs):
        attrs = dict(attrs)
        self.ids.update(attrs[name] for name in ("id", "name") if attrs.get(name))
        if tag == "a" and "href" in attrs:
            self.links.append(attrs["href"])
        elif tag == "link" and attrs.get("rel") in ("stylesheet", "icon", "preload"):
            self.shown.append(attrs["href"])
        elif "src" in attrs:
            self.shown.append(attrs["src"])


def problems(folder):
    """What does not hold in the pages of a folder, and what they take from other machines."""
    pages = {path: Page(path.read_text(encoding="utf-8")) for path in sorted(folder.rglob("*.html"))}
    found = []
    for path, page in pages.items():
        here = path.relative_to(folder)
        found += [f"{here} takes {link} from another machine" for link in page.shown if re.match(r"[a-z]+:|//", link) and not link.startswith("data:")]
        for link in page.links + page.shown:
            parts = urllib.parse.urlsplit(link)
            if parts.scheme or parts.netloc:
                continue
            goal = pathlib.Path(os.path.normpath(path.parent / urllib.parse.unquote(parts.path))) if parts.path else path
            if not goal.is_file():
                found.append(f"{here}: there is no {link}")
            elif parts.fragment and goal in pages and urllib.parse.unquote(parts.fragment) not in pages[goal].ids:
                found.append(f"{here}: there is no place {link}")
    for path in folder.rglob("*.css"):
        found += [f"{path.name} takes {link} from another machine" for link in re.findall(r"url\(['\"]?((?:https?:)?//[^)'\"]*)", path.read_text(encoding="utf-8"))]
    return found


def words(path):
    """The text of a page, without its tags."""
    return re.sub(r"<[^>]*>", "", path.read_text(encoding="utf-8"))


class Check(unittest.TestCase):
    def test_what_does_not_hold_is_found(self):
        folder = WORK / "samples"
        shutil.rmtree(folder, ignore_errors=True)
        folder.mkdir(parents=True)
        (folder / "b.html").write_text('<h1 id="there">B</h1>', encoding="utf-8")
        for text, count in (('<a href="b.html#there">x</a><a href="https://example.org">y</a><a href="#z" id="z">z</a>', 0),
                            ('<a href="c.html">x</a>', 1), ('<a href="b.html#nothing">x</a>', 1), ('<img src="c.png">', 1), ('<a href="#no">x</a>', 1),
                            ('<link rel="stylesheet" href="//example.org/a.css">', 1), ('<script src="https://example.org/a.js"></script>', 1)):
            (folder / "a.html").write_text(text, encoding="utf-8")
            self.assertEqual(count, len(problems(folder)), text)


class Citation(unittest.TestCase):
    def test_it_has_what_its_format_requires(self):
        """Citation File Format 1.2.0."""
        citation = yaml.safe_load((ROOT / "CITATION.cff").read_text(encoding="utf-8"))
        self.assertEqual(("1.2.0", VERSION, "software"), (citation["cff-version"], citation["version"], citation["type"]))
        self.assertLessEqual({"message", "title", "authors"}, set(citation))
        for work in [citation, *citation["references"]]:
            self.assertLessEqual({"type", "title", "authors"}, set(work))
            for author in work["authors"]:
                self.assertTrue(author["name"])
        self.assertEqual(["10.1109/TOH.2016.2628369"], [work["doi"] for work in citation["references"]])


class Site(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        cls.html = WORK / "html"
        subprocess.run([sys.executable, "-B", ROOT / "deploy/docs/site/build_site.py", cls.html, WORK / "work", VERSION], check=True)

    def test_all_links_hold_and_nothing_comes_from_elsewhere(self):
        self.assertEqual([], problems(self.html))

    def test_no_script_is_a_module(self):
        """Browsers load modules from servers alone."""
        front = Page((self.html / "index.html").read_text(encoding="utf-8"))
        scripts = [link.partition("?")[0] for link in front.shown if ".js" in link]
        self.assertLess(3, len(scripts))
        for script in scripts:
            self.assertFalse(re.search(r"^(import|export) ", (self.html / script).read_text(encoding="utf-8"), re.MULTILINE), script)

    def test_every_page_of_the_project_is_in_the_sidebar(self):
        front = Page((self.html / "index.html").read_text(encoding="utf-8"))
        for page in ("README", "CONTRIBUTING", "CHANGELOG", "core/README", "proto/PROTOCOL", "device/hid/PROFILE", "tests/EXTREMES", "using"):
            self.assertIn(f"{page}.html", front.links)

    def test_the_search_finds_words_of_the_text_without_a_server(self):
        """A page opened from a file may load a script, and may not read a file."""
        index = (self.html / "searchindex.js").read_text(encoding="utf-8")
        self.assertTrue(index.startswith("Search.setIndex("))
        for word in ("penetr", "tension", "jack"):
            self.assertTrue(word in index, word)
        self.assertTrue("searchindex.js" in (self.html / "search.html").read_text(encoding="utf-8"))

    def test_every_field_of_the_messages_is_in_the_reference(self):
        for proto in (ROOT / "proto/hapticd/v1").glob("*.proto"):
            page = words(self.html / f"reference/{proto.stem}.html")
            fields = re.findall(r"^ +(?:repeated |optional )?[\w.]+ (\w+) = (\d+)", proto.read_text(encoding="utf-8"), re.MULTILINE)
            self.assertTrue(fields)
            for name, number in fields:
                self.assertTrue(re.search(rf"\b{name} = {number}\b", page), f"{proto.name}: {name}")
        self.assertTrue("kg/m; (0, 100]; absent = from tension, length and frequency" in words(self.html / "reference/scene.html"))

    def test_every_program_and_the_classes_of_the_library_are_in_the_reference(self):
        for manual in (ROOT / "deploy/man").glob("*.1"):
            page = words(self.html / f"reference/programs/{manual.stem}.html")
            for option in re.findall(r"\\-\\-([a-z]+)", manual.read_text(encoding="utf-8")):
                self.assertTrue(f"--{option}" in page, f"{manual.stem}: --{option}")
        api = words(self.html / "reference/cpp.html")
        for header in (ROOT / "clients/library").glob("*.h"):
            for name in re.findall(r"^(?:class|struct) (\w+) \{", header.read_text(encoding="utf-8"), re.MULTILINE):
                self.assertTrue(f"::{name}" in api, name)
        self.assertTrue("Sends what is due and takes what has arrived." in api)


if __name__ == "__main__":
    WORK, VERSION = pathlib.Path(sys.argv[1]).resolve(), sys.argv[2]
    unittest.main(argv=sys.argv[:1])
