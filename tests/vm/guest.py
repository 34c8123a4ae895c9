"""A machine of its own for one command: Debian's kernel in QEMU, without root, network or /dev/kvm.

By default time in the guest follows the instructions executed (-icount) and not the host: a loop at 1 kHz is exact however loaded the host
is, and two runs print the same. `smp` gives up that for two processors that really run at once, to look for races."""
import os
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
# A guest that hangs is ended when the emulator has taken so much processor time, s: a busy host takes none of it. The longest test takes 60 s.
LONGEST_CPU_S = 400
COMMAND_LINE = "console=ttyS0 quiet panic=-1 nokaslr mitigations=off tsc=reliable"


def command(image, built, smp):
    timing = (["-accel", "tcg,thread=multi", "-smp", "2", "-cpu", "max"] if smp else
              ["-accel", "tcg,thread=single", "-icount", "shift=0,sleep=off", "-smp", "1", "-cpu", "max,-rdrand,-rdseed"])
    return [QEMU, "-M", "q35", *timing, "-rtc", "base=2024-01-01T00:00:00,clock=vm", "-seed", "1", "-m", "1024", "-nodefaults",
            "-no-user-config", "-display", "none", "-no-reboot", "-kernel", str(built.image), "-initrd", str(image), "-append", COMMAND_LINE,
            "-serial", "stdio"]


def cpu_s(pid):
    """Processor time a process has taken, s."""
    fields = pathlib.Path(f"/proc/{pid}/stat").read_text(encoding="utf-8").rsplit(")", 1)[1].split()
    return (int(fields[11]) + int(fields[12])) / os.sysconf("SC_CLK_TCK")


def bounded(arguments, output):
    """Runs the emulator until it ends or hangs. Gives what it printed."""
    with output.open("wb") as file, subprocess.Popen(arguments, stdin=subprocess.DEVNULL, stdout=file, stderr=subprocess.STDOUT) as emulator:
        while cpu_s(emulator.pid) < LONGEST_CPU_S:
            try:
                emulator.wait(1)
                return output.read_text(encoding="utf-8", errors="replace")
            except subprocess.TimeoutExpired:
                pass
        emulator.kill()
    return output.read_text(encoding="utf-8", errors="replace") + f"\nno end within {LONGEST_CPU_S} s of processor time"


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
        printed = bounded(command(path, built, smp), pathlib.Path(folder) / "printed")
    result = re.search(r"GUEST-RESULT (\d+)", printed)
    return (int(result.group(1)) if result else 124), printed
