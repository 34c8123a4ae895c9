"""Commands about devices as a user runs them: without a daemon, and against one with a simulated device."""
import json
import os
import signal
import subprocess
import sys
import time
import unittest

from daemon import HAPTICD, Daemon, said

HAPTICCTL = os.environ["HAPTICCTL"]


class List(unittest.TestCase):
    def test_it_needs_no_daemon_and_its_exit_code_says_whether_all_may_be_opened(self):
        for program in (HAPTICD, HAPTICCTL):
            code, text, _ = said(program, "device", "list", "--json")
            devices = json.loads(text)["devices"]
            self.assertEqual(code, 0 if all(device["permitted"] for device in devices) else 1)

    def test_a_wrong_word_is_told(self):
        self.assertEqual(said(HAPTICD, "device", "lost")[0], 2)
        self.assertEqual(said(HAPTICD, "device")[0], 2)


class Simulated(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        cls.played = Daemon("--scene", "wall")
        cls.played.__enter__()

    @classmethod
    def tearDownClass(cls):
        cls.played.__exit__(None, None, None)

    def ctl(self, *words):
        return said(HAPTICCTL, "--server", self.played.address, *words)

    def test_its_numbers_come_with_their_sources(self):
        code, text, _ = self.ctl("device", "info")
        self.assertEqual(code, 0)
        self.assertIn("tool 0: simulated", text)
        self.assertRegex(text, r"peak_force_n +22 +\[")
        code, text, _ = self.ctl("device", "info", "--json")
        self.assertEqual(json.loads(text)["devices"][0]["driver"], "DRIVER_SIMULATED")

    def test_readings_come_one_state_a_line(self):
        code, text, _ = self.ctl("device", "monitor", "--json", "--for", "0.5")
        self.assertEqual(code, 0)
        states = [json.loads(line) for line in text.splitlines()]
        self.assertGreater(len(states), 3)
        ticks = [int(state["tick"]) for state in states]
        self.assertEqual(ticks, sorted(set(ticks)))
        for state in states:
            self.assertEqual(len(state["devices"][0]["p_dh_m"]), 3)
            self.assertIn("DEVICE_FLAG_ATTACHED", state["devices"][0]["flags"])

    def test_another_tool_has_no_readings(self):
        _, text, _ = self.ctl("device", "monitor", "--json", "--for", "0.3", "--tool", "7")
        self.assertTrue(text)
        self.assertFalse(any(json.loads(line)["devices"] for line in text.splitlines()))

    def test_ctrl_c_ends_the_readings_well(self):
        command = [HAPTICCTL, "--server", self.played.address, "device", "monitor", "--json"]
        with subprocess.Popen(command, stdout=subprocess.PIPE, text=True) as process:
            self.assertIn("tick", process.stdout.readline())
            process.send_signal(signal.SIGINT)
            process.stdout.read()
            self.assertEqual(process.wait(timeout=30), 0)

    def test_a_view_without_a_terminal_is_refused_with_the_remedy(self):
        code, _, complaint = self.ctl("device", "monitor")
        self.assertEqual(code, 2)
        self.assertIn("--json", complaint)

    def test_it_needs_no_check_and_its_force_stays(self):
        code, text, _ = self.ctl("device", "check")
        self.assertEqual(code, 0)
        self.assertIn("Nothing needs checking", text)
        self.assertNotIn("device check", self.ctl("status")[1])

    def test_it_has_no_calibration_of_its_own(self):
        code, _, complaint = self.ctl("device", "calibrate")
        self.assertEqual(code, 1)
        self.assertIn("refused", complaint)

    def test_a_check_that_nobody_answers_ends_with_the_force_off(self):
        code, text, complaint = self.ctl("device", "check", "--anyway")
        self.assertEqual(code, 1)
        self.assertIn("Move the handle", text)
        self.assertIn("nobody answers", complaint)
        end = time.monotonic() + 30
        while json.loads(self.ctl("status", "--json")[1])["state"]["loop_state"] == "LOOP_STATE_ENGAGED":
            self.assertLess(time.monotonic(), end)


if __name__ == "__main__":
    sys.exit(unittest.main(verbosity=2))
