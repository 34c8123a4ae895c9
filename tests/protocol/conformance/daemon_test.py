"""The daemon of the build under check_server.py, with the real clock, the virtual clock, and keys, several daemons side by side since most checks wait;
and the five-minute script of clients/python against it. usage: daemon_test.py HAPTICD FOLDER-OF-THE-PYTHON-PACKAGE"""
import csv
import os
import subprocess
import sys
import tempfile
import unittest

HERE = os.path.dirname(os.path.abspath(__file__))
ROOT = os.path.join(HERE, "..", "..", "..")
PARTS = 5
HAPTICD, PACKAGE = sys.argv[1:3] if len(sys.argv) > 2 else ("hapticd", "")
ENVIRONMENT = {**os.environ, "HAPTICD_DATA": os.path.join(ROOT, "deploy"), "PYTHONPATH": PACKAGE}


class Daemon(unittest.TestCase):
    def test_all_quick_checks_pass_under_both_clocks_and_with_keys(self):
        commands = [[sys.executable, "-B", f"{HERE}/check_server.py", "--hapticd", HAPTICD, "--quick", "--part", f"{part}/{PARTS}"]
                    for part in range(1, PARTS + 1)]
        running = [subprocess.Popen(command, stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True, env=ENVIRONMENT) for command in commands]
        texts = [checker.communicate()[0] for checker in running]
        for checker, text in zip(running, texts):
            self.assertEqual(checker.returncode, 0, text)
        self.assertGreater(sum(int(text.splitlines()[-1].split()[0]) for text in texts), 160)

    def test_the_five_minute_script_plucks_the_string_the_same_way_twice(self):
        import check_server
        process, (host, port) = check_server.started(HAPTICD, "virtual")
        self.addCleanup(process.stderr.close)
        self.addCleanup(process.wait)
        self.addCleanup(process.terminate)
        said = []
        with tempfile.TemporaryDirectory() as folder:
            for _ in range(2):
                command = [sys.executable, "-B", f"{ROOT}/clients/python/examples/pluck.py", f"{host}:{port}", folder]
                said.append(subprocess.run(command, check=True, capture_output=True, text=True, env=ENVIRONMENT, timeout=60).stdout)
            with open(os.path.join(folder, "pluck.csv"), encoding="utf-8") as file:
                rows = list(csv.DictReader(file))
        self.assertEqual(said[0], said[1])  # the hash of all States is in it
        self.assertIn("string 0 sounds at 65.4 Hz", said[0])
        self.assertEqual(len(rows), 293)
        self.assertGreater(max(abs(float(row["wrench_h_w_fy [N]"])) for row in rows), 0.01)


if __name__ == "__main__":
    os.environ.update(ENVIRONMENT)
    unittest.main(argv=sys.argv[:1])
