"""hapticd announces itself and hapticctl finds it, through a real avahi-daemon on a network of their own. A neighbour with a malicious name is
found too, and changes no terminal."""
import contextlib
import json
import os
import pathlib
import re
import signal
import subprocess
import sys
import tempfile
import time
import unittest

import jsonschema

import apart
import daemon

PATIENCE_S = 60.0
SCHEMA = json.loads((pathlib.Path(__file__).resolve().parents[2] / "deploy/schema/discovery.schema.json").read_text(encoding="utf-8"))
BUS = """<busconfig>
  <type>system</type>
  <listen>unix:path={folder}/bus</listen>
  <auth>EXTERNAL</auth>
  <policy context="default">
    <allow send_destination="*"/>
    <allow receive_sender="*"/>
    <allow own="*"/>
    <allow user="*"/>
  </policy>
</busconfig>
"""
AVAHI = """[server]
host-name=tester
use-ipv6=no
enable-dbus=yes
[wide-area]
enable-wide-area=no
"""
# Changes a terminal's colour and title, where it is printed as it is.
HOSTILE = "\x1b[31mred\x1b]0;owned\x07"


def discover(*options):
    done = subprocess.run([os.environ["HAPTICCTL"], *options, "--discover"], capture_output=True, text=True, timeout=PATIENCE_S, check=False)
    return done.returncode, done.stdout, done.stderr


class Discovery(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        cls.stack = contextlib.ExitStack()
        cls.addClassCleanup(cls.stack.close)
        cls.folder = pathlib.Path(cls.stack.enter_context(tempfile.TemporaryDirectory()))
        apart.own_folder("/run/avahi-daemon")
        (cls.folder / "bus.conf").write_text(BUS.format(folder=cls.folder))
        (cls.folder / "avahi.conf").write_text(AVAHI)
        os.environ["PATH"] += ":/usr/sbin"
        os.environ["DBUS_SYSTEM_BUS_ADDRESS"] = f"unix:path={cls.folder}/bus"
        cls.serve("dbus-daemon", f"--config-file={cls.folder}/bus.conf", "--nofork", "--nopidfile")
        cls.wait_until((cls.folder / "bus").exists)
        cls.avahi = cls.serve("avahi-daemon", "--no-drop-root", "--no-chroot", "--no-rlimits", "--no-proc-title", "-f", str(cls.folder / "avahi.conf"))
        cls.wait_until(lambda: "nobody can be asked" not in discover()[2])
        subprocess.run([os.environ["HAPTICCTL"], "keygen", str(cls.folder / "keys")], check=True, stdout=subprocess.DEVNULL)

    @classmethod
    def serve(cls, *command):
        process = subprocess.Popen(command, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)
        cls.stack.callback(process.wait)
        cls.stack.callback(process.terminate)
        return process

    @staticmethod
    def wait_until(true):
        end = time.monotonic() + PATIENCE_S
        while not true():
            if time.monotonic() > end:
                raise AssertionError("it never happens")
            time.sleep(0.05)

    def found(self):
        said = json.loads(discover("--json")[1])
        jsonschema.validate(said, SCHEMA)
        return said["daemons"]

    def announced(self):
        return daemon.Daemon("--scene", "sphere", "--announce", "--keys", str(self.folder / "keys"), host="0.0.0.0")

    def test_an_announced_daemon_is_found_and_answers_where_it_is_said_to(self):
        self.assertEqual(discover()[0], 1)
        self.assertEqual(self.found(), [])
        with self.announced() as played:
            self.wait_until(lambda: self.found() != [])
            (here,) = self.found()
            self.assertEqual(here["name"], "hapticd on tester")
            self.assertEqual((here["keys"], here["protocol"]), (True, "1"))
            self.assertEqual(here["server"].rsplit(":", 1)[1], played.address.rsplit(":", 1)[1])
            code, text, _ = discover()
            self.assertEqual(code, 0)
            self.assertIn("needs --key", text)
            code, text, error = daemon.said(os.environ["HAPTICCTL"], "--server", here["server"], "--key", str(self.folder / "keys/view.key"), "status")
            self.assertEqual(code, 0, text + error)
            self.assertEqual(played.end(signal.SIGTERM), 0, played.log)
        self.wait_until(lambda: self.found() == [])

    def test_an_avahi_daemon_that_hangs_delays_neither_start_nor_end(self):
        unit = (pathlib.Path(__file__).resolve().parents[2] / "deploy/systemd/hapticd.service.in").read_text(encoding="utf-8")
        patience_s = float(re.search("^TimeoutStopSec=([0-9]+)$", unit, re.MULTILINE)[1])
        self.addCleanup(self.avahi.send_signal, signal.SIGCONT)
        with self.announced() as played:
            self.wait_until(lambda: self.found() != [])
            self.avahi.send_signal(signal.SIGSTOP)
            played.process.send_signal(signal.SIGTERM)
            self.assertEqual(played.process.wait(patience_s), 0)
        with self.announced() as played:
            played.process.send_signal(signal.SIGTERM)
            self.assertEqual(played.process.wait(patience_s), 0)
            # Nobody has waited until D-Bus gave up.
            played.end()
            self.assertNotIn("not announced", played.log)
        self.avahi.send_signal(signal.SIGCONT)
        self.wait_until(lambda: self.found() == [])

    def test_two_daemons_of_one_machine_have_two_names(self):
        with self.announced(), self.announced():
            self.wait_until(lambda: len(self.found()) == 2)
            self.assertEqual(sorted(each["name"] for each in self.found()), ["hapticd on tester", "hapticd on tester #2"])

    def test_no_character_of_a_name_reaches_the_terminal_as_a_command(self):
        neighbour = subprocess.Popen(["avahi-publish", "-s", HOSTILE, "_hapticd._udp", "4711", "protocol=\x1b[2J", "keys=no"],
                                     stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)
        self.addCleanup(neighbour.wait)
        self.addCleanup(neighbour.terminate)
        self.wait_until(lambda: self.found() != [])
        code, text, error = discover()
        self.assertEqual(code, 0)
        self.assertIn("?[31mred?]0;owned?", text)
        self.assertTrue(all(c == "\n" or " " <= c <= "~" for c in text + error), repr(text + error))
        (here,) = self.found()
        self.assertEqual((here["keys"], here["protocol"]), (False, ""))
        neighbour.terminate()
        self.wait_until(lambda: self.found() == [])


if __name__ == "__main__":
    apart.go_apart()
    unittest.main(argv=sys.argv[:1])
