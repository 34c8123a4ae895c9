"""The reference pages that are made from sources: message types from the .proto files, programs from their manual pages, the C++ API from the
headers by doxygen."""
import re
import subprocess
import textwrap
from xml.etree import ElementTree

import proto_pages

# Folders with headers that programs outside the project may use. Those that are there are documented.
PUBLIC_HEADERS = ("clients/sdk/include", "clients/library")
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
# How much of each kind a directive of breathe shows. Classes have an entry of their own, and C has a typedef of each of its structs.
EXTENT = {"class": "   :members:", "struct": "   :members:", "namespace": "   :content-only:", "file": "   :sections: func enum var define"}
PROTOCOL = """# Messages

Generated from the comments of the `.proto` files. The rules of the exchange are in [PROTOCOL.md](../proto/PROTOCOL.md).

| file | what |
|---|---|
"""


def program_page(name, path):
    """A manual page, its sections as sections, their text as in a terminal."""
    source = path.read_text(encoding="utf-8").replace(".SH ", ".ad l\n.nh\n.SH ")
    text = subprocess.run(["groff", "-man", "-Tutf8", "-P-cbou", "-rLL=88n", "-Kutf8"], input=source.encode(), capture_output=True,
                          check=True).stdout.decode()
    body = text.strip("\n").split("\n", 1)[1].rsplit("\n", 1)[0]  # without head and foot
    page = f"# {name}\n"
    for section in re.split(r"^(?=\S)", body, flags=re.MULTILINE)[1:]:
        title, _, lines = section.partition("\n")
        page += f"\n## {title.capitalize()}\n\n```text\n{textwrap.dedent(lines).rstrip()}\n```\n"
    return page


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
    parts += [("file", name, f"Functions, constants and types of `{path}`, outside of namespaces.")
              for _, name, path, compound in compounds(output / "xml", ("file",)) if compound.find("sectiondef") is not None]
    for kind, name, where in parts:
        lines += [f"## {name}", "", where, "", "```{eval-rst}", f".. doxygen{kind}:: {name}", EXTENT[kind], "```", ""]
    return "\n".join(lines)


def hidden_contents(pages):
    """A table of contents that only the sidebar shows."""
    return "\n```{toctree}\n:hidden:\n\n" + "\n".join(pages) + "\n```\n"


def protocol_page(protos):
    """The list of the message files, each with the first sentence of its opening comment."""
    text = PROTOCOL
    for path in protos:
        comment = re.match(r"(?:// .*\n)+", path.read_text(encoding="utf-8")).group().replace("\n// ", " ").removeprefix("// ")
        text += f"| [{path.name}]({path.stem}.md) | {proto_pages.plain(comment.partition('. ')[0])} |\n"
    return text + hidden_contents(path.stem for path in protos if path.stem != "scene")  # which has a line of the navigation


def write(root, work, write_page):
    """Writes all of them with write_page(path in the site, text); the paths."""
    protos = sorted((root / "proto/hapticd/v1").glob("*.proto"))
    names = [str(path.relative_to(root / "proto")) for path in protos]
    texts = {f"reference/{name}": text for name, text in proto_pages.pages("protoc", root / "proto", names).items()}
    texts["reference/protocol.md"] = protocol_page(protos)
    manuals = {path.stem: path for path in sorted((root / "deploy/man").glob("*.1"))}
    texts.update({f"reference/programs/{name}.md": program_page(name, path) for name, path in manuals.items()})
    texts["reference/programs.md"] = ("# Programs\n\nThe manual pages, which are installed too: `man hapticd`.\n\n" +
                                      "".join(f"- [{name}](programs/{name}.md)\n" for name in manuals) +
                                      hidden_contents(f"programs/{name}" for name in manuals))
    texts["reference/cpp.md"] = cpp_page(root, work)
    for path, text in texts.items():
        write_page(path, text)
    return set(texts)
