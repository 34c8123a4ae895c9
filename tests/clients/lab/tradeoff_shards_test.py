"""The study shared among jobs: four shards under GNU parallel and as a Slurm array on this one node, one of them killed and started again; put together
they are the table of one run. The simulation is stood for by numbers. usage: tradeoff_shards_test.py HAPTICD_LAB"""
import os
import pathlib
import shutil
import signal
import socket
import subprocess
import sys
import tempfile
import time
import unittest

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parents[2] / "support"))
import skipping  # noqa: E402

PROGRAM = str(pathlib.Path(sys.argv.pop(1) if len(sys.argv) > 1 else shutil.which("hapticd-lab")).resolve())
FAKE = pathlib.Path(__file__).resolve().parent / "fake_oracle.py"
STUDY = ["--scene", "bunny", "--scene", "single_string", "--gestures", "2"]
PATIENCE_S = 120

SLURM_CONF = """ClusterName=lab
SlurmctldHost={host}(127.0.0.1)
SlurmctldPort={port}
SlurmdPort={slurmd_port}
AuthType=auth/munge
AuthInfo=socket={folder}/munge.socket
CryptoType=crypto/munge
SlurmUser=root
SlurmdUser=root
StateSaveLocation={folder}/state
SlurmdSpoolDir={folder}/spool
SlurmctldPidFile={folder}/slurmctld.pid
SlurmdPidFile={folder}/slurmd.pid
SlurmctldLogFile={folder}/slurmctld.log
SlurmdLogFile={folder}/slurmd.log
ProctrackType=proctrack/pgid
TaskPlugin=task/none
SwitchType=switch/none
MpiDefault=none
ReturnToService=2
SelectType=select/cons_tres
JobRequeue=1
MailProg=/bin/true
NodeName={host} NodeAddr=127.0.0.1 CPUs={cpus} State=UNKNOWN
PartitionName=all Nodes={host} Default=YES MaxTime=INFINITE State=UP OverSubscribe=FORCE:4
"""


def environment(seconds=0.0):
    """With numbers instead of a simulation, each call taking so long."""
    return {**os.environ, "HAPTICD_ORACLE": str(FAKE), "HAPTICD_MODEL": str(FAKE), "FAKE_ORACLE_S": str(seconds)}


def tradeoff(*options, **more):
    """hapticd-lab tradeoff; its process, which has ended."""
    return subprocess.run([PROGRAM, "tradeoff", *options], capture_output=True, text=True, check=False, timeout=PATIENCE_S, **more)


def study(*options, **more):
    """The same, of the small study."""
    return tradeoff(*STUDY, *options, **more)


def free_port():
    with socket.socket() as one:
        one.bind(("127.0.0.1", 0))
        return one.getsockname()[1]


class Shards(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        cls.folder = tempfile.TemporaryDirectory()
        cls.path = pathlib.Path(cls.folder.name)
        done = study("--jobs", "2", "--output", str(cls.path / "whole"), env=environment())
        assert done.returncode == 0, done.stderr

    @classmethod
    def tearDownClass(cls):
        cls.folder.cleanup()

    def merged_is_whole(self, shards):
        """The shards, put together, are the table of one run; times aside."""
        output = self.path / f"{shards}.merged"
        done = tradeoff("--merge", *(str(self.path / f"{shards}.{k}") for k in (1, 2, 3, 4)), "--output", str(output), env=environment())
        self.assertEqual(done.returncode, 0, done.stderr)
        self.assertEqual((output / "results.csv").read_bytes(), (self.path / "whole" / "results.csv").read_bytes())
        self.assertTrue((output / "report.html").exists())

    def killed_in_the_middle(self, shards):
        """Starts shard 2 so that it is slow, and kills it when it has done some and not all."""
        output = self.path / f"{shards}.2"
        slow = subprocess.Popen([PROGRAM, "tradeoff", *STUDY, "--jobs", "1", "--shard", "2/4", "--output", str(output)], env=environment(1.0),
                                stderr=subprocess.DEVNULL, start_new_session=True)
        deadline = time.monotonic() + PATIENCE_S
        while len(list(output.glob("units/*.jsonl"))) < 1 and time.monotonic() < deadline:
            time.sleep(0.02)
        os.killpg(slow.pid, signal.SIGKILL)
        slow.wait()
        self.assertEqual(len(list(output.glob("units/*.jsonl"))), 1)

    def test_a_merge_without_all_shards_says_what_is_missing(self):
        done = study("--shard", "1/4", "--output", str(self.path / "part"), env=environment())
        self.assertEqual(done.returncode, 0, done.stderr)
        done = study("--merge", str(self.path / "part"), "--output", str(self.path / "too_few"), env=environment())
        self.assertEqual(done.returncode, 1)
        self.assertIn("6 of 8 units are not there", done.stderr)

    def test_four_shards_under_gnu_parallel_one_killed_and_resumed_are_one_run(self):
        self.killed_in_the_middle("parallel")
        subprocess.run(["parallel", "--will-cite", "--jobs", "2", PROGRAM, "tradeoff", *STUDY, "--jobs", "1", "--shard", "{}/4", "--output",
                        f"{self.path}/parallel.{{}}", ":::", "1", "2", "3", "4"], env=environment(), check=True, capture_output=True, timeout=PATIENCE_S)
        self.merged_is_whole("parallel")

    def test_four_shards_as_a_slurm_array_one_killed_and_resumed_are_one_run(self):
        with Slurm(self) as slurm:
            self.killed_in_the_middle("slurm")
            script = self.path / "study.sh"
            script.write_text(f'#!/bin/sh\nexec {PROGRAM} tradeoff {" ".join(STUDY)} --jobs 1 --shard "$SLURM_ARRAY_TASK_ID/4" '
                              f'--output "{self.path}/slurm.$SLURM_ARRAY_TASK_ID"\n', encoding="utf-8")
            slurm.run("sbatch", "--wait", "--array=1-4", f"--output={self.path}/slurm-%a.log", str(script))
        self.merged_is_whole("slurm")


class Slurm:
    """Slurm on this machine alone, with a state, a key and ports of its own; skips the test with the reason where it cannot start."""

    def __init__(self, test):
        self.test, self.processes = test, []
        self.folder = test.path / "slurm"

    def __enter__(self):
        if os.geteuid() != 0:
            self.test.skipTest("Slurm's daemons want to be root")
        for name in ("state", "spool"):
            (self.folder / name).mkdir(parents=True)
        host = socket.gethostname().split(".")[0]
        (self.folder / "slurm.conf").write_text(SLURM_CONF.format(host=host, port=free_port(), slurmd_port=free_port(), folder=self.folder,
                                                                  cpus=os.cpu_count()), encoding="utf-8")
        key = self.folder / "munge.key"
        key.write_bytes(os.urandom(128))
        key.chmod(0o400)
        self.environment = {**environment(), "SLURM_CONF": str(self.folder / "slurm.conf"), "PATH": f"{os.environ['PATH']}:/usr/sbin"}
        self.start("munged", "--foreground", "--force", f"--key-file={key}", f"--socket={self.folder}/munge.socket", f"--pid-file={self.folder}/munged.pid",
                   f"--log-file={self.folder}/munged.log", f"--seed-file={self.folder}/munged.seed")
        self.start("slurmctld", "-D", "-i", "-f", str(self.folder / "slurm.conf"))
        self.start("slurmd", "-D", "-f", str(self.folder / "slurm.conf"), "-N", host)
        deadline = time.monotonic() + 30.0
        while time.monotonic() < deadline:
            told = subprocess.run(["sinfo", "-h", "-o", "%T"], env=self.environment, capture_output=True, text=True, check=False, timeout=PATIENCE_S)
            if told.stdout.strip() in ("idle", "mixed"):
                return self
            time.sleep(0.3)
        logs = "; ".join((path.read_text(errors="replace").splitlines() or [""])[-1] for path in sorted(self.folder.glob("*.log")))
        self.__exit__()
        self.test.skipTest(f"Slurm does not start here: {told.stdout.strip() or told.stderr.strip()}: {logs}")
        return self

    def start(self, *command):
        self.processes.append(subprocess.Popen(command, env=self.environment, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL, start_new_session=True))

    def run(self, *command):
        done = subprocess.run(command, env=self.environment, capture_output=True, text=True, check=False, timeout=PATIENCE_S)
        self.test.assertEqual(done.returncode, 0, done.stdout + done.stderr)

    def __exit__(self, *_):
        for each in reversed(self.processes):
            each.terminate()
        for each in reversed(self.processes):
            try:
                each.wait(20)
            except subprocess.TimeoutExpired:
                each.kill()
                each.wait()


if __name__ == "__main__":
    skipping.main()
