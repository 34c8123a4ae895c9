"""An initial RAM disk for a guest: a static busybox, our programs with the shared libraries they need, and files.

Written in the kernel's own format (newc cpio, Documentation/driver-api/early-userspace/buffer-format.rst), with times and numbers that do not
depend on when or where it is made."""
import gzip
import pathlib
import shutil
import subprocess
import tempfile

from kernel import Missing

DIRECTORY, REGULAR, LINK = 0o040755, 0o100644, 0o120777
FOLDERS = ("bin", "dev", "lib", "lib64", "proc", "run", "sys", "tmp", "modules")


def busybox():
    found = shutil.which("busybox")
    if found is None:
        raise Missing("there is no busybox: install busybox-static")
    return pathlib.Path(found)


def libraries(program):
    """Shared objects a program is linked with, the loader among them, as {place in the guest: file here}."""
    listed = subprocess.run(["ldd", str(program)], capture_output=True, text=True, check=False).stdout
    needed = {}
    for line in listed.splitlines():
        words = line.split()
        place = words[2] if "=>" in words and len(words) > 2 else words[0]
        if place.startswith("/"):
            needed[place.lstrip("/")] = pathlib.Path(place).resolve()
    return needed


class Image:
    """Files of a guest, by place."""

    def __init__(self):
        self._entries = {}
        for folder in FOLDERS:
            self.folder(folder)
        self.file("bin/busybox", busybox().read_bytes(), executable=True)
        for name in ("sh", "mount", "insmod", "poweroff", "sleep", "cat", "ls", "kill", "echo", "mkdir", "chmod", "ip"):
            self.link(f"bin/{name}", "busybox")

    def folder(self, place):
        for parent in reversed(pathlib.PurePosixPath(place).parents):
            if str(parent) != ".":
                self._entries.setdefault(str(parent), (DIRECTORY, b""))
        self._entries.setdefault(place, (DIRECTORY, b""))

    def file(self, place, data, executable=False):
        self.folder(str(pathlib.PurePosixPath(place).parent))
        self._entries[place] = (REGULAR | (0o111 if executable else 0), data)

    def link(self, place, target):
        self._entries[place] = (LINK, target.encode())

    def program(self, path, place=None):
        """A program with its libraries, in /bin unless told, without what only a debugger reads."""
        path = pathlib.Path(path)
        with tempfile.NamedTemporaryFile() as stripped:
            subprocess.run(["strip", "-o", stripped.name, str(path)], check=True)
            self.file(place or f"bin/{path.name}", pathlib.Path(stripped.name).read_bytes(), executable=True)
        for target, source in libraries(path).items():
            self.file(target, source.read_bytes(), executable=True)

    def tree(self, path, place):
        """A folder with all in it."""
        for source in sorted(pathlib.Path(path).rglob("*")):
            if source.is_file():
                self.file(f"{place}/{source.relative_to(path)}", source.read_bytes())

    def write(self, path):
        """As gzipped cpio."""
        parts = []
        for number, place in enumerate(sorted(self._entries), start=1):
            mode, data = self._entries[place]
            parts.append(record(place, number, mode, data))
        parts.append(record("TRAILER!!!", 0, 0, b""))
        with gzip.GzipFile(path, "wb", compresslevel=1, mtime=0) as out:
            out.write(b"".join(parts))


def record(place, number, mode, data):
    name = place.encode() + b"\0"
    links = 2 if mode == DIRECTORY else 1
    fields = (number, mode, 0, 0, links, 0, len(data), 0, 0, 0, 0, len(name), 0)
    head = b"070701" + b"".join(b"%08x" % field for field in fields) + name
    return padded(head) + padded(data)


def padded(data):
    return data + b"\0" * (-len(data) % 4)
