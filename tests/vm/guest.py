"""A machine of its own for one command: Debian's kernel in QEMU, without root, network or /dev/kvm.

By default time in the guest follows the instructions executed (-icount) and not the host: a loop at 1 kHz is exact however loaded the host
is, and two runs print the same. `smp` gives up that for two processors that really run at once, to look for races."""
import pathlib
import re
import shutil
import subprocess
import tempfile

from image import Image
from kernel import Missing, kernel
from udev import add_udev

HERE = pathlib.Path(__file__).resolve().parent
QEMU = "qemu-system-x86_64"
# A guest that hangs is ended after this, s. Booting takes 10 s on an idle machine.
LONGEST_S = 540
COMMAND_LINE = "console=ttyS0 quiet panic=-1 nokaslr mitigations=off tsc=reliable"


def command(image, built, smp):
    timing = (["-accel", "tcg,thread=multi", "-smp", "2", "-cpu", "max"] if smp else
              ["-accel", "tcg,thread=single", "-icount", "shift=0,sleep=off", "-smp", "1", "-cpu", "max,-rdrand,-rdseed"])
    return [QEMU, "-M", "q35", *timing, "-rtc", "base=2024-01-01T00:00:00,clock=vm", "-seed", "1", "-m", "1024", "-nodefaults",
            "-no-user-config", "-display", "none", "-no-reboot", "-kernel", str(built.image), "-initrd", str(image), "-append", COMMAND_LINE,
            "-serial", "stdio"]


def run(script, programs=(), trees=(), smp=False, udev_helper=None):
    """Runs a shell script in a guest that has these programs in /bin, and these (folder, place) trees. Gives (exit code, what it printed).
    `udev_helper`: with udevd, our rules and this program that they ask. Raises Missing where QEMU, busybox or the kernel cannot be had."""
    if shutil.which(QEMU) is None:
        raise Missing(f"there is no {QEMU}: install qemu-system-x86")
    built = kernel()
    image = Image()
    image.file("init", (HERE / "init").read_bytes(), executable=True)
    image.file("command", script.encode(), executable=True)
    for module in built.modules:
        image.file(f"modules/{module.name}", module.read_bytes())
    image.file("modules/order", "".join(f"{module.name}\n" for module in built.modules).encode())
    for program in programs:
        image.program(program)
    for folder, place in trees:
        image.tree(folder, place)
    if udev_helper is not None:
        add_udev(image, udev_helper)
    with tempfile.TemporaryDirectory(prefix="hapticd_vm_") as folder:
        path = pathlib.Path(folder) / "initrd"
        image.write(path)
        try:
            done = subprocess.run(command(path, built, smp), stdin=subprocess.DEVNULL, capture_output=True, text=True, errors="replace",
                                  timeout=LONGEST_S, check=False)
            printed = done.stdout + done.stderr
        except subprocess.TimeoutExpired as late:
            printed = (late.stdout or b"").decode(errors="replace") + f"\nno end within {LONGEST_S} s"
    result = re.search(r"GUEST-RESULT (\d+)", printed)
    return (int(result.group(1)) if result else 124), printed
