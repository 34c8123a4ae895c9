"""One thread of another process stands still while the others run: a debugger's hold on it, by ptrace(2). The process is a child of this one."""
import ctypes
import os
import pathlib
import time

PTRACE_DETACH, PTRACE_SEIZE, PTRACE_INTERRUPT = 17, 0x4206, 0x4207
WALL = 0x40000000  # __WALL: waitpid() for threads too
PATIENCE_S = 60.0
LIBC = ctypes.CDLL(None, use_errno=True)


def trace(request, thread):
    if LIBC.ptrace(request, thread, None, None) != 0:
        raise OSError(ctypes.get_errno(), f"ptrace {request:#x} of {thread}")


def thread_named(pid, name):
    """Number of the thread of a process, once there is one."""
    end = time.monotonic() + PATIENCE_S
    while time.monotonic() < end:
        for task in pathlib.Path(f"/proc/{pid}/task").iterdir():
            if (task / "comm").read_text().strip() == name:
                return int(task.name)
    raise AssertionError(f"no thread {name}")


class HeldThread:
    """Context manager: held until the end of the block. Without a name it is the main thread."""

    def __init__(self, pid, name=None):
        self.thread = thread_named(pid, name) if name else pid

    def __enter__(self):
        trace(PTRACE_SEIZE, self.thread)
        trace(PTRACE_INTERRUPT, self.thread)
        os.waitpid(self.thread, WALL)
        return self

    def __exit__(self, *_):
        trace(PTRACE_DETACH, self.thread)
