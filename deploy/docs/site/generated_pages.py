"""The reference pages that are made from sources: message types from the .proto files, programs from their manual pages, the C++ API from the
headers by doxygen."""
import re
import subprocess
from xml.etree import ElementTree

import proto_pages

# Folders with headers that programs outside the project may use. Those that are there are documented.
PUBLIC_HEADERS = ("clients/sdk", "clients/library")
# What is private, and what only serves the programs of the project.
DOXYFILE = """
PROJECT_NAME = hapticd
INPUT = {folders}
FILE_PATTERNS = *.h
RECURSIVE = YES
STRIP_FROM_PATH = {root}
OUTPUT_DIRECTORY = {output}
GENERATE_XML = YES
GENERATE_HTML = NO
GENERATE_LATEX = NO
XML_PROGRAMLISTING = NO
JAVADOC_AUTOBRIEF = YES
EXTRACT_ALL = YES
EXTRACT_STATIC = YES
QUIET = YES
WARN_IF_UNDOCUMENTED = NO
"""
PROTOCOL = """# Messages

Generated from the comments of the `.proto` files. The rules of the exchange are in [PROTOCOL.md](../proto/PROTOCOL.md).

| file | what |
|---|---|
"""


def program_page(name, path):
    """A manual page as it is shown in a terminal."""
    text = subprocess.run(["groff", "-man", "-Tutf8", "-P-cbou", "-rLL=110n", "-Kutf8", path], capture_output=True, check=True).stdout.decode()
    return f"# {name}\n\n```text\n" + re.sub(r"\n{3,}", "\n\n", text).strip("\n") + "\n```\n"


def compounds(xml, kinds):
    """(kind, full name, header, XML) of what doxygen has found of these kinds, private things left out."""
    for path in sorted(xml.glob("*.xml")):
        compound = ElementTree.parse(path).find("compounddef")
        if compound is not None and compound.get("kind") in kinds and compound.get("prot", "public") == "public":
            yield compound.get("kind"), compound.findtext("compoundname"), compound.find("location").get("file"), compound


def cpp_page(root, work):
    """The page of the C++ API. doxygen's XML is left in `work`."""
    folders = [folder for folder in PUBLIC_HEADERS if list((root / folder).rglob("*.h"))]
    output = work / "doxygen"
    output.mkdir(parents=True)
    config = DOXYFILE.format(folders=" ".join(f'"{root / folder}"' for folder in folders), root=f'"{root}"', output=f'"{output}"')
    subprocess.run(["doxygen", "-"], input=config, text=True, check=True)
    lines = ["# C++ API", "", "Generated from the headers by doxygen. How a client is written is in [the C++ library](../clients/library/README.md).", ""]
    parts = [(kind, name, f"Of `{header}`.") for kind, name, header, _ in compounds(output / "xml", ("class", "struct"))]
    parts += [("namespace", name, "Functions, constants and types of the namespace.")
              for _, name, _, compound in compounds(output / "xml", ("namespace",)) if compound.find("sectiondef") is not None]
    for kind, name, where in parts:
        extent = "   :content-only:" if kind == "namespace" else "   :members:"
        lines += [f"## {name}", "", where, "", "```{eval-rst}", f".. doxygen{kind}:: {name}", extent, "```", ""]
    return "\n".join(lines)


def write(root, work, write_page):
    """Writes all of them with write_page(path in the site, text); the paths."""
    protos = sorted((root / "proto/hapticd/v1").glob("*.proto"))
    names = [str(path.relative_to(root / "proto")) for path in protos]
    texts = {f"reference/{name}": text for name, text in proto_pages.pages("protoc", root / "proto", names).items()}
    manuals = {path.stem: path for path in sorted((root / "deploy/man").glob("*.1"))}
    texts.update({f"reference/programs/{name}.md": program_page(name, path) for name, path in manuals.items()})

    rows = ""
    for path in protos:
        first = re.match(r"(?:// ?(.*)\n)+?(?=// .*|[^/])", path.read_text(encoding="utf-8"))
        opening = re.match(r"// ([^.\n]*(?:\n// [^.\n]*)*)\.", path.read_text(encoding="utf-8"))
        what = (opening or first).group(1).replace("\n// ", " ")
        rows += f"| [{path.name}]({path.stem}.md) | {proto_pages.plain(what)} |\n"
    contents = "\n```{toctree}\n:hidden:\n\n" + "\n".join(path.stem for path in protos if path.stem != "scene") + "\n```\n"
    texts["reference/protocol.md"] = PROTOCOL + rows + contents
    texts["reference/programs.md"] = ("# Programs\n\nThe manual pages, which are installed too: `man hapticd`.\n\n" +
                                      "".join(f"- [{name}](programs/{name}.md)\n" for name in manuals) +
                                      "\n```{toctree}\n:hidden:\n\n" + "\n".join(f"programs/{name}" for name in manuals) + "\n```\n")
    texts["reference/cpp.md"] = cpp_page(root, work)
    for path, text in texts.items():
        write_page(path, text)
    return set(texts)
