#!/usr/bin/python3
"""Builds the site: the pages of the source tree and those generated from sources, with navigation and search, as static HTML.

usage: build_site.py OUTPUT WORK VERSION

Pages are staged below WORK at their place in the source tree, those of deploy/docs at the top. Links between pages hold as they are; a link to
another file of the project leads to a copy of it, one to a folder to a page with its files. Warnings of Sphinx are errors. Needs the group docs of
deploy/packages.
"""
import os
import pathlib
import re
import shutil
import subprocess
import sys

import generated_pages

ROOT = pathlib.Path(__file__).resolve().parents[3]
HERE = pathlib.Path(__file__).resolve().parent
DOCS = "deploy/docs/"
LINK = re.compile(r"(!?\[(?:[^][]|\[[^][]*\])*\])\(([^()\s]+)\)")
FENCED = re.compile(r"(^(```+|~~~+).*?^\2$)", re.MULTILINE | re.DOTALL)
PAGES = ("*.md", "clients", "core", "deploy/docs", "device", "proto", "server", "tests")


def read_navigation():
    """[(section, [line])]"""
    sections = []
    for line in (HERE / "navigation").read_text(encoding="utf-8").splitlines():
        if line.startswith("  "):
            sections[-1][1].append(line.strip())
        elif line and not line.startswith("#"):
            sections.append((line, []))
    return sections


def all_pages():
    """Every page of the project, relative to the root."""
    found = set()
    for pattern in PAGES:
        found.update(ROOT.glob(pattern) if "*" in pattern else (ROOT / pattern).rglob("*.md"))
    return {str(path.relative_to(ROOT)) for path in found if "node_modules" not in path.parts}


def place(path):
    """Where a file of the project stands in the site."""
    if path == f"{DOCS}README.md":
        return "index.md"
    return path.removeprefix(DOCS)


class Site:
    """What is staged, and how links change on the way."""

    def __init__(self, source):
        self.source = source
        self.pages = all_pages()
        self.folders = set()

    def target(self, page, link):
        """The link of a page, as the site has it."""
        if re.match(r"[a-z]+:|#", link):
            return link
        path, mark, anchor = link.partition("#")
        path = os.path.normpath(os.path.join(os.path.dirname(page), path))
        there = ROOT / path
        if there.is_dir():
            self.folders.add(path)
            goal = f"folders/{path.replace('/', '_')}.md"
        elif re.fullmatch(r"proto/hapticd/v1/\w+\.proto", path):
            goal = f"reference/{there.stem}.md"
        elif path in self.pages:
            goal = place(path)
        elif there.is_file():
            goal = place(path)
            self.copy(path, goal)
        else:
            raise SystemExit(f"build_site.py: {page} has a link to {link}, which is not there")
        return os.path.relpath(goal, os.path.dirname(place(page)) or ".") + mark + anchor

    def copy(self, path, goal):
        file = self.source / goal
        file.parent.mkdir(parents=True, exist_ok=True)
        shutil.copyfile(ROOT / path, file)  # a copy to be read: no program

    def rewritten(self, page, text):
        """The text of a page with its links changed, code left alone."""
        parts = FENCED.split(text)
        out = []
        for index, part in enumerate(parts):
            if index % 3 == 2:
                continue  # the fence itself, captured to find its end
            out.append(part if index % 3 else self._change(page, part))
        return "".join(out)

    def _change(self, page, part):
        codes = []

        def hide(match):
            codes.append(match.group())
            return f"\0{len(codes) - 1}\0"

        hidden = re.sub(r"`[^`\n]+`", hide, part)
        changed = LINK.sub(lambda m: f"{m.group(1)}({self.target(page, m.group(2))})", hidden)
        return re.sub(r"\0(\d+)\0", lambda m: codes[int(m.group(1))], changed)

    def write(self, goal, text):
        file = self.source / goal
        file.parent.mkdir(parents=True, exist_ok=True)
        file.write_text(text, encoding="utf-8")

    def stage_pages(self):
        for page in sorted(self.pages):
            self.write(place(page), self.rewritten(page, (ROOT / page).read_text(encoding="utf-8")))

    def stage_folders(self):
        """A page for each folder that a page has a link to. Its own pages are led to, its other files are copied."""
        for folder in sorted(self.folders):
            lines = ["---", "orphan: true", "---", "", f"# {folder}", "", "| file |", "|---|"]
            for file in sorted((ROOT / folder).iterdir()):
                if file.is_file():
                    path = str(file.relative_to(ROOT))
                    if path not in self.pages:
                        self.copy(path, place(path))
                    lines.append(f"| [{file.name}]({os.path.relpath(place(path), 'folders')}) |")
            self.write(f"folders/{folder.replace('/', '_')}.md", "\n".join(lines) + "\n")


def matching(pattern, pages):
    """Pages of the project that a line of the navigation means, as the site has them."""
    return sorted(place(page) for page in pages if page.count("/") == pattern.count("/") and pathlib.PurePath(page).match(pattern))


def tables(sections, pages, generated):
    """Hidden tables of contents, for the sidebar. Every page has to be in one."""
    text, seen = "", {"index.md"}
    for section, lines in sections:
        text += f"\n```{{toctree}}\n:hidden:\n:caption: {section}\n\n"
        for line in lines:
            pattern, _, title = line.partition(" ")
            for page in [pattern] if pattern in generated else matching(pattern, pages):
                if page not in seen:
                    entry = page.removesuffix(".md")
                    text += f"{title} <{entry}>\n" if title else f"{entry}\n"
                    seen.add(page)
        text += "```\n"
    lost = {place(page) for page in pages} - seen
    if lost:
        raise SystemExit(f"build_site.py: deploy/docs/site/navigation has no line for {', '.join(sorted(lost))}")
    return text


def main():
    output, work, version = pathlib.Path(sys.argv[1]).resolve(), pathlib.Path(sys.argv[2]).resolve(), sys.argv[3]
    for folder in (output, work):
        shutil.rmtree(folder, ignore_errors=True)
    site = Site(work / "source")
    generated = generated_pages.write(ROOT, work, site.write)
    site.stage_pages()
    site.stage_folders()
    with open(site.source / "index.md", "a", encoding="utf-8") as index:
        index.write(tables(read_navigation(), site.pages, generated))
    environment = dict(os.environ, HAPTICD_VERSION=version, HAPTICD_DOXYGEN_XML=str(work / "doxygen/xml"), PYTHONDONTWRITEBYTECODE="1", LC_ALL="C.UTF-8")
    subprocess.run(["/usr/bin/sphinx-build", "-q", "-W", "--keep-going", "-b", "html", "-c", HERE, "-d", work / "doctrees", site.source, output],
                   env=environment, check=True)
    # Debian has the theme's script as a module, which browsers do not load from a file: here a script before it has what it would import.
    script = output / "_static/scripts/furo.js"
    script.write_text(re.sub(r"^import .*\n", "", script.read_text(encoding="utf-8"), flags=re.MULTILINE), encoding="utf-8")
    for name in (".buildinfo", "objects.inv"):
        (output / name).unlink(missing_ok=True)


if __name__ == "__main__":
    main()
