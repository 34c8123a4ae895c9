"""The files beside a scene's file that it names: its sphere-trees and meshes, which a server on another machine has to be brought."""
from __future__ import annotations

import hashlib
import os
import pathlib
from typing import Iterator, List, NamedTuple, Union

from google.protobuf import text_format

from hapticd.errors import shown_text
from hapticd.v1 import scene_pb2

PIECE = 65_536
"""Length of a piece of a file, bytes, but for the last one."""
MOST_BYTES, MOST_FILES = 64 << 20, 256
"""What the files of one scene come to at most."""
SMALLER = "Make coarser sphere-trees or meshes, or install them on the machine of hapticd"


class AssetFile(NamedTuple):
    """A file as the scene names it, with BLAKE2b-256 of its content."""

    name: str
    hash: bytes
    content: bytes


def _names(text: str) -> Iterator[str]:
    """What the scene names, each once; nothing of a text that is no scene, of which the server says what is wrong."""
    scene = scene_pb2.Scene()
    try:
        text_format.Parse(text, scene, allow_unknown_field=True)
    except text_format.ParseError:
        return iter(())
    shapes = [part.shape for tool in scene.tools for part in tool.parts] + [body.shape for body in scene.bodies]
    return iter(dict.fromkeys(name for shape in shapes for name in (shape.tree, shape.mesh) if name))


def _stays_below(name: str) -> bool:
    path = pathlib.PurePosixPath(name)
    return name == shown_text(name) and not path.is_absolute() and ".." not in path.parts


def beside(scene: Union[str, "os.PathLike[str]"], text: str) -> List[AssetFile]:
    """The files that `text`, which is in the file `scene`, names and that are in its folder or below. Any other name is left to the server,
    which knows those that are installed. ValueError, with the remedy, where they are too much for a server."""
    files: List[AssetFile] = []
    left = MOST_BYTES
    for name in _names(text):
        path = pathlib.Path(scene).parent / name
        if not _stays_below(name) or not path.exists():
            continue
        place = f"{os.fspath(scene)}: {name!r}"
        if not path.is_file():
            raise ValueError(f"{place} is not a file")
        size = path.stat().st_size
        if size == 0:
            raise ValueError(f"{place} is empty")
        if size > left or len(files) == MOST_FILES:
            raise ValueError(f"{place} and those before it are more than {MOST_BYTES} bytes or {MOST_FILES} files. {SMALLER}")
        content = path.read_bytes()
        left -= len(content)
        files.append(AssetFile(name, hashlib.blake2b(content, digest_size=32).digest(), content))
    return files
