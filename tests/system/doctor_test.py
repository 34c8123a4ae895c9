"""The doctor as a user runs it: without a daemon, without privileges, and through hapticctl."""
import json
import os
import pathlib
import subprocess
import sys
import unittest

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parents[1] / "support"))
import skipping  # noqa: E402

HAPTICD = os.environ["HAPTICD"]
HAPTICCTL = str(pathlib.Path(HAPTICD).parent / "hapticctl")
NOBODY = 65534


def examined(*command, **process):
    done = subprocess.run([*command, "--seconds", "0.3", "--json"], capture_output=True, text=True, timeout=60, check=False, **process)
    return done.returncode, json.loads(done.stdout)


class Doctor(unittest.TestCase):
    def check(self, code, report):
        causes = [finding for finding in report["findings"] if finding["verdict"] == "cause"]
        self.assertEqual(report["fit"], not causes)
        self.assertEqual(code, 6 if causes else 0)
        for finding in report["findings"]:
            self.assertEqual(finding["fix"] != "", finding["verdict"] != "good", finding)
        self.assertGreaterEqual(report["ticks"] + report["lost"], 299)

    def test_it_measures_and_judges_and_its_exit_code_says_the_same(self):
        self.check(*examined(HAPTICD, "doctor"))

    def test_hapticctl_runs_it_without_a_daemon(self):
        self.check(*examined(HAPTICCTL, "doctor"))

    @unittest.skipIf(os.getuid() != 0, "only root can become somebody without rights")
    def test_somebody_without_rights_is_told_which_are_missing_and_how_to_get_them(self):
        def give_up_rights():
            import resource
            resource.setrlimit(resource.RLIMIT_MEMLOCK, (1 << 16, 1 << 16))
            resource.setrlimit(resource.RLIMIT_RTPRIO, (0, 0))
            os.setgroups([])
            os.setgid(NOBODY)
            os.setuid(NOBODY)
        code, report = examined(f"/proc/self/fd/{self.program}", "doctor", preexec_fn=give_up_rights, pass_fds=[self.program])
        self.check(code, report)
        named = {finding["name"]: finding for finding in report["findings"]}
        self.assertEqual((named["rtprio"]["verdict"], named["memlock"]["verdict"]), ("cause", "cause"))
        self.assertIn("--rtprio=90", named["rtprio"]["fix"])
        self.assertIn("SCHED_FIFO", report["refused"])
        self.assertEqual((report["fifo"], report["locked"], code), (False, False, 6))

    @classmethod
    def setUpClass(cls):
        # The folder of the program may be closed to others; an open file is not.
        cls.program = os.open(HAPTICD, os.O_RDONLY)

    @classmethod
    def tearDownClass(cls):
        os.close(cls.program)


if __name__ == "__main__":
    skipping.main()
