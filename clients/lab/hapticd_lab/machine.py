"""What a report was made on: machine, system, versions of hapticd and of the libraries, and the state of the source tree."""
from __future__ import annotations

import importlib.metadata
import os
import pathlib
import platform
import re
import subprocess
from typing import Dict

from hapticd_lab.oracle import find_program


def _first(path: str, pattern: str) -> str:
    try:
        match = re.search(pattern, pathlib.Path(path).read_text(encoding="utf-8"), re.MULTILINE)
    except OSError:
        match = None
    return match[1] if match else "unknown"


def _output(*command: str) -> str:
    try:
        return subprocess.run(command, capture_output=True, text=True, timeout=30, check=True).stdout.strip()
    except (OSError, subprocess.SubprocessError):
        return ""


def _commit() -> str:
    """Of the source tree that was built from, where this is no installation."""
    for folder in pathlib.Path(__file__).resolve().parents:
        source = _first(str(folder / "CMakeCache.txt"), r"^CMAKE_HOME_DIRECTORY:\w+=(.*)")
        commit = _output("git", "-C", source, "rev-parse", "--short=12", "HEAD") if source != "unknown" else ""
        if commit:
            changes = _output("git", "-C", source, "status", "--porcelain", "--untracked-files=no")
            return f"{commit}, with changes" if changes else commit
    return "unknown: an installation"


def facts() -> Dict[str, str]:
    """Name to value, in the order in which they are shown."""
    cores = os.cpu_count() or 1
    megabytes = int(_first("/proc/meminfo", r"^MemTotal:\s+(\d+)").replace("unknown", "0")) // 1024
    libraries = " ".join(f"{name} {importlib.metadata.version(name)}" for name in ("numpy", "scipy", "matplotlib"))
    return {
        "processor": f"{_first('/proc/cpuinfo', r'^model name.*: (.*)')}, {cores} {'core' if cores == 1 else 'cores'}",
        "memory": f"{megabytes} MB",
        "system": f"{_first('/etc/os-release', r'^PRETTY_NAME=.(.*).$')}, Linux {platform.release()}",
        "hapticd": _output(find_program("hapticd"), "--version") or "unknown",
        "commit": _commit(),
        "python": f"{platform.python_version()}, {libraries}",
        "load at the start": f"{os.getloadavg()[0]:.2f}",
    }


def write(values: Dict[str, str], path: pathlib.Path) -> None:
    """One fact a line."""
    path.write_text("".join(f"{name}: {value}\n" for name, value in values.items()), encoding="utf-8")
