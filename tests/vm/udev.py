"""systemd's udevd for a guest, with our rules alone: its package is downloaded once and taken apart, never installed."""
import pathlib
import subprocess

from image import libraries
from kernel import Missing, cache_folder, download

HERE = pathlib.Path(__file__).resolve().parent
RULES = HERE.parent.parent / "deploy" / "udev" / "70-hapticd.rules"
# The group that udev_suite.cpp looks for, and root.
GROUPS = "root:x:0:\nhapticd:x:990:\n"
USERS = "root:x:0:0::/:/bin/sh\n"


def udevadm():
    """The program that is both udevd and its control. Raises Missing."""
    package = download("udev", cache_folder())
    program = package.with_suffix("") / "bin" / "udevadm"
    if not program.exists():
        done = subprocess.run(["dpkg", "--extract", str(package), str(package.with_suffix(""))], capture_output=True, text=True, check=False)
        if done.returncode != 0 or not program.exists():
            raise Missing(f"{package} cannot be read: {done.stderr.strip()}")
    absent = [place for place, source in libraries(program).items() if not source.exists()]
    if absent:
        raise Missing(f"udevd needs {', '.join(absent)}")
    return program


def add_udev(image, helper):
    """udevd as systemd-udevd in /bin, the rules, and the program they ask."""
    image.program(udevadm())
    image.link("bin/systemd-udevd", "udevadm")
    image.file("etc/udev/rules.d/70-hapticd.rules", RULES.read_bytes())
    image.file("etc/group", GROUPS.encode())
    image.file("etc/passwd", USERS.encode())
    image.program(helper, "lib/udev/hapticd_id")
