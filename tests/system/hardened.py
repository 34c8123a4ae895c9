"""Reads the ELF files of a folder: what is shipped has stack protectors, checked library calls, a stack that is not executable, landing pads where
the processor has them, and addresses that are bound at the start and read-only from then on.
usage: hardened.py FOLDER...     prints every file that lacks something, and what; exit code 1 then, and where there is no ELF file"""
import pathlib
import re
import subprocess
import sys

LANDING_PADS = {"Advanced Micro Devices X86-64": b"\xf3\x0f\x1e\xfa", "AArch64": b"\x5f\x24\x03\xd5"}
"""endbr64 and bti c. No note says that a file has them where the C library's start files have none."""
CODE_PER_PAD = 1024
"""Bytes of code that have one at least: functions are shorter, and libraries that are linked in bring some hundred along."""


def read(path, *options):
    return subprocess.run(["readelf", "--wide", *options, str(path)], capture_output=True, text=True, check=True).stdout


def is_program(path):
    """An executable or shared library."""
    with path.open("rb") as file:
        start = file.read(18)
    return start[:4] == b"\x7fELF" and start[16] in (2, 3)


def lacks(path):
    """What the file is to have and has not."""
    header, segments, dynamic = read(path, "--file-header"), read(path, "--segments"), read(path, "--dynamic")
    symbols = read(path, "--dyn-syms")
    code = int(re.search(r" \.text\s+\S+\s+\S+\s+\S+\s+(\S+)", read(path, "--sections")).group(1), 16)
    machine = re.search(r"Machine:\s+(.*)", header).group(1).strip()
    has = {
        "a place chosen at the start (PIE)": "DYN" in header,
        "a stack that is not executable": re.search(r"GNU_STACK.* RW ", segments) is not None,
        "read-only relocations": "GNU_RELRO" in segments,
        "addresses bound at the start": re.search(r"\((FLAGS|FLAGS_1)\).*NOW", dynamic) is not None,
        "stack protectors": "__stack_chk_fail" in symbols,
        "checked library calls": re.search(r"__\w+_chk\b", symbols.replace("__stack_chk_fail", "")) is not None,
        "landing pads": machine not in LANDING_PADS or path.read_bytes().count(LANDING_PADS[machine]) * CODE_PER_PAD > code,
    }
    return [what for what, there in has.items() if not there]


def main():
    files = [path for folder in sys.argv[1:] for path in sorted(pathlib.Path(folder).rglob("*"))
             if path.is_file() and not path.is_symlink() and is_program(path)]
    poor = [(path, lacks(path)) for path in files]
    for path, missing in poor:
        if missing:
            print(f"{path} lacks {', '.join(missing)}")
    print(f"{len(files)} ELF files, {sum(1 for _, missing in poor if missing)} lack something")
    return 0 if files and not any(missing for _, missing in poor) else 1


if __name__ == "__main__":
    sys.exit(main())
