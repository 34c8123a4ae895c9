"""hapticd-play starts what is beside it, and ends as the daemon ends."""
import os
import pathlib
import re
import subprocess
import tempfile
import unittest

import daemon

SCRIPT = pathlib.Path(__file__).resolve().parents[2] / "clients/play/hapticd-play"
PROGRAMS = pathlib.Path(daemon.HAPTICD).parent
WAIT_S = 30


def play(*words, environment=None):
    """(exit code, what was said) of the script without viewer and sound."""
    with tempfile.TemporaryDirectory() as files:
        done = subprocess.run([SCRIPT, "--programs", PROGRAMS, "--files", files, "--no-viewer", "--no-sound", *words], stdout=subprocess.PIPE,
                              stderr=subprocess.STDOUT, text=True, timeout=WAIT_S, check=False, env=environment, stdin=subprocess.DEVNULL)
        return done.returncode, done.stdout


class Play(unittest.TestCase):
    def test_it_ends_at_once_with_the_code_of_a_daemon_that_refuses(self):
        code, said = play("--", "--scene", "nosuch")
        self.assertEqual(1, code, said)
        self.assertIn("there is no scene of this name", said)
        self.assertNotIn("It plays", said)
        self.assertEqual(2, play("--", "--listen")[0])

    def test_another_daemon_at_the_port_is_not_taken_for_its_own(self):
        with daemon.Daemon("--scene", "wall") as other:
            code, said = play("--", "--listen", other.address)
        self.assertEqual(3, code, said)
        self.assertNotIn("It plays", said)

    def test_the_address_is_understood_in_both_spellings(self):
        for spelling in ("--listen {}", "--listen={}"):
            address = f"127.0.0.1:{daemon.free_port()}"
            code, said = play("--for", "1", "--", "--scene", "wall", *spelling.format(address).split())
            self.assertEqual(0, code, said)
            self.assertIn(f"It plays. Clients connect to {address}", said)

    def test_its_version_is_that_of_the_daemon_beside_it(self):
        self.assertEqual((0, daemon.said(daemon.HAPTICD, "--version")[1]), play("--version"))

    def test_an_option_of_hapticd_is_said_to_stand_behind_dashes(self):
        code, said = play("--scene", "wall", "--for", "1")
        self.assertEqual(2, code, said)
        written = re.search(r"--scene is an option of hapticd, and stands behind --: hapticd-play (-- --scene wall)\. ", said)
        self.assertTrue(written, said)
        code, said = play("--for", "1", *written.group(1).split(), "--listen", f"127.0.0.1:{daemon.free_port()}")
        self.assertEqual(0, code, said)
        self.assertIn(": scene wall, ", said)

    def test_a_port_that_is_none_and_a_folder_that_cannot_be_made_are_refused_before_anything_starts(self):
        for port in ("99999", "65536", "-1", "x", "1" * 30):
            self.assertEqual((2, "hapticd-play: --web-port needs a number from 0 to 65535. See hapticd-play --help.\n"), play("--web-port", port))
        with tempfile.TemporaryDirectory() as folder:
            file = pathlib.Path(folder, "file")
            file.touch()
            code, said = play("--listen", "127.0.0.1", "--files", f"{file}/under")
            self.assertEqual((2, f"hapticd-play: the folder {file}/under cannot be made; name another with --files. See hapticd-play --help.\n"), (code, said))

    def test_a_mistyped_option_is_named_with_the_one_that_was_meant(self):
        code, said = play("--no-sond")
        self.assertEqual((2, "hapticd-play: there is no option --no-sond. Did you mean --no-sound? See hapticd-play --help.\n"), (code, said))

    def test_seconds_may_have_their_unit(self):
        self.assertEqual(2, play("--for", "1,5")[0])
        code, said = play("--for", "1s", "--", "--scene", "wall", "--listen", f"127.0.0.1:{daemon.free_port()}")
        self.assertEqual(0, code, said)

    def test_without_a_home_keys_go_nowhere_by_themselves(self):
        environment = {name: value for name, value in os.environ.items() if name not in ("HOME", "XDG_STATE_HOME")}
        done = subprocess.run([SCRIPT, "--programs", PROGRAMS, "--for", "1"], capture_output=True, text=True, timeout=WAIT_S, check=False,
                              env=environment)
        self.assertEqual(2, done.returncode)
        self.assertIn("--files", done.stderr)


if __name__ == "__main__":
    unittest.main()
