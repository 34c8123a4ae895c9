"""Debian's own kernel for a guest: downloaded once as a package, never installed, and taken apart.

The package is kept in the cache folder of the user ($XDG_CACHE_HOME/hapticd/vm); what is made of it stands beside it, named after the
package, so that a newer kernel is a new folder."""
import lzma
import os
import pathlib
import re
import subprocess
import tarfile
from typing import NamedTuple

META_PACKAGE = "linux-image-amd64"
XZ_MAGIC = b"\xfd7zXZ\x00"
ELF_MAGIC = b"\x7fELF"
# In the order in which they can be loaded: each after what it needs.
MODULES = ("hid", "uhid", "hid-generic", "usb-common", "usbcore", "usbhid", "usbip-core", "vhci-hcd")
FOLDERS = ("drivers/hid/", "drivers/usb/")


class Missing(Exception):
    """The kernel cannot be had here; the text says why."""


class Kernel(NamedTuple):
    image: pathlib.Path  # ELF where it could be taken out of the bzImage, which boots faster
    modules: tuple  # files, in load order


def cache_folder():
    base = os.environ.get("XDG_CACHE_HOME") or pathlib.Path.home() / ".cache"
    return pathlib.Path(base) / "hapticd" / "vm"


def package_name():
    """The newest kernel the archive has: the meta package depends on it."""
    found = subprocess.run(["apt-cache", "depends", META_PACKAGE], capture_output=True, text=True, check=False)
    name = re.search(r"Depends: (linux-image-\S+)", found.stdout)
    if name is None:
        raise Missing(f"apt-cache knows no {META_PACKAGE}: {found.stderr.strip() or 'run apt-get update'}")
    return name.group(1)


def download(name, folder):
    """The package file; a part of one is never left behind under its name."""
    kept = sorted(folder.glob(f"{name}_*.deb"))
    if kept:
        return kept[-1]
    folder.mkdir(parents=True, exist_ok=True)
    done = subprocess.run(["apt-get", "download", name], cwd=folder, capture_output=True, text=True, check=False)
    kept = sorted(folder.glob(f"{name}_*.deb"))
    if done.returncode != 0 or not kept:
        raise Missing(f"apt-get download {name}: {(done.stderr or done.stdout).strip()}")
    return kept[-1]


def unpack(package, folder):
    """Kernel and the modules needed, flat in one folder."""
    process = subprocess.Popen(["dpkg", "--fsys-tarfile", str(package)], stdout=subprocess.PIPE)
    with tarfile.open(fileobj=process.stdout, mode="r|") as archive:
        for member in archive:
            name = pathlib.PurePosixPath(member.name)
            stem = name.name.split(".ko")[0].replace("_", "-")
            wanted = name.name.startswith("vmlinuz-") or (
                ".ko" in name.name and stem in MODULES and any(part in member.name for part in FOLDERS))
            if not wanted or not member.isfile():
                continue
            data = archive.extractfile(member).read()
            if name.suffix == ".xz":
                data = lzma.decompress(data)
            target = "bzImage" if name.name.startswith("vmlinuz-") else f"{stem}.ko"
            (folder / target).write_bytes(data)
    if process.wait() != 0:
        raise Missing(f"{package} cannot be read")


def take_out_elf(bzimage):
    """The kernel inside a bzImage, or nothing: a compressed ELF, wherever its magic stands."""
    data = bzimage.read_bytes()
    place = data.find(XZ_MAGIC)
    while place >= 0:
        try:
            kernel = lzma.LZMADecompressor().decompress(data[place:])
            if kernel.startswith(ELF_MAGIC):
                return kernel
        except lzma.LZMAError:
            pass
        place = data.find(XZ_MAGIC, place + 1)
    return None


def kernel():
    """The kernel and its modules, made on first use. Raises Missing."""
    package = download(package_name(), cache_folder())
    folder = package.with_suffix("")
    done = folder / "complete"
    if not done.exists():
        folder.mkdir(exist_ok=True)
        unpack(package, folder)
        elf = take_out_elf(folder / "bzImage")
        if elf is not None:
            (folder / "vmlinux").write_bytes(elf)
        done.touch()
    image = folder / "vmlinux"
    modules = tuple(folder / f"{name}.ko" for name in MODULES)
    absent = [module.name for module in modules if not module.exists()]
    if absent:
        raise Missing(f"{package.name} lacks {', '.join(absent)}")
    return Kernel(image if image.exists() else folder / "bzImage", modules)
