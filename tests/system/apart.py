"""A test with mounts and a network of its own, so that it may put its own things where the system has them, such as the socket of the journal."""
import os
import shutil
import subprocess
import sys

MARK = "HAPTICD_TEST_APART"
SKIPPED = 77


def skip(reason):
    print(f"SKIPPED: {reason}")
    sys.exit(SKIPPED)


def go_apart():
    """Starts the test again where mounts and network are its own. Ends with the skip code where this machine does not allow it."""
    if MARK in os.environ:
        subprocess.run(["ip", "link", "set", "lo", "up"], check=True)
        return
    if shutil.which("unshare") is None:
        skip("there is no unshare")
    command = ["unshare", "--mount", "--net"]
    if os.geteuid() != 0:
        command += ["--user", "--map-root-user"]
    tried = subprocess.run([*command, "true"], capture_output=True, text=True, check=False)
    if tried.returncode != 0:
        skip(f"no namespaces here: {tried.stderr.strip()}")
    os.execvpe(command[0], [*command, sys.executable, *sys.orig_argv[1:]], dict(os.environ, **{MARK: "1"}))


def own_folder(path):
    """An empty folder at this place; the machine's own is behind it."""
    os.makedirs(path, exist_ok=True)
    subprocess.run(["mount", "-t", "tmpfs", "tmpfs", path], check=True)
