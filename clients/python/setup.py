"""What pip needs beside pyproject.toml: the version, which stands in the project's CMakeLists.txt, and the wire types, which protoc makes of
the project's .proto files. A source archive has both in itself, so that it is installed anywhere. Nothing is written beside the sources."""
import pathlib
import re
import shutil
import subprocess
import tempfile

from setuptools import setup
from setuptools.command.build_py import build_py
from setuptools.command.sdist import sdist

HERE = pathlib.Path(__file__).resolve().parent
PROJECT = HERE.parent.parent
PROTOS = PROJECT / "proto"
ARCHIVE_FACTS = HERE / "PKG-INFO"  # only a source archive has it


def version():
    """Of the archive, or of the project."""
    source, pattern = PROJECT / "CMakeLists.txt", r"^project\(hapticd VERSION (\S+)"
    if ARCHIVE_FACTS.exists():
        source, pattern = ARCHIVE_FACTS, r"^Version: (\S+)"
    try:
        return re.search(pattern, source.read_text(encoding="utf-8"), re.MULTILINE)[1]
    except (OSError, TypeError):
        raise SystemExit(f"hapticd: {source} does not say which version this is. Install from the folder clients/python of hapticd's "
                         "sources, or from a source archive made there.") from None


def make_wire_types(package):
    """Writes the modules of the .proto files, with their types, into the folder of the package hapticd."""
    if ARCHIVE_FACTS.exists():
        return  # they came with it
    protoc = shutil.which("protoc")
    if protoc is None:
        raise SystemExit("hapticd: protoc makes the wire types and is not installed. On Debian: apt install protobuf-compiler")
    protos = sorted(str(path) for path in PROTOS.glob("hapticd/v1/*.proto"))
    out = package.parent
    made = subprocess.run([protoc, f"--proto_path={PROTOS}", f"--python_out={out}", f"--pyi_out={out}", *protos], check=False)
    if made.returncode != 0:
        raise SystemExit(f"hapticd: {protoc} cannot make the wire types; it has to be version 3.21 or newer")


class BuildPackage(build_py):
    """The package with its wire types."""

    def run(self):
        if self.editable_mode:
            raise SystemExit("hapticd: an editable install would have no wire types. Put clients/python of the build tree into PYTHONPATH "
                             "instead, or install without -e")
        super().run()
        make_wire_types(pathlib.Path(self.build_lib) / "hapticd")


class SourceArchive(sdist):
    """The archive with the wire types."""

    def make_release_tree(self, base_dir, files):
        super().make_release_tree(base_dir, files)
        make_wire_types(pathlib.Path(base_dir) / "hapticd")


with tempfile.TemporaryDirectory() as scratch:
    setup(version=version(), cmdclass={"build_py": BuildPackage, "sdist": SourceArchive},
          options={"build": {"build_base": scratch}, "egg_info": {"egg_base": scratch}})
