"""The Python client under check_client.py: it passes every check, and each of several faults put into it on purpose is found."""
import os
import subprocess
import sys
import unittest

import support

CHECKER = os.path.join(support.ROOT, "tests", "protocol", "conformance", "check_client.py")
CLIENT = os.path.join(os.path.dirname(os.path.abspath(__file__)), "asking_client.py")

# Each is run before the client, in its process, and makes it break the rule of one check.
FAULTS = {
    "a_counter_is_taken_once": "from hapticd import wire; wire.CounterWindow.is_new = lambda self, counter: True",
    "what_does_not_open_is_dropped": "from hapticd import wire; sound = wire.decode; "
                                     "wire.decode = lambda data: sound(b'H\\x01\\x05\\0' + data[4:])",
    "the_client_keeps_its_session_alive": "from hapticd import link; link.KEEP_ALIVE_NS *= 8\n"
                                          "import time; sleep = time.sleep; time.sleep = lambda seconds: sleep(20 * seconds)",
    "a_new_item_is_acknowledged_within_10_ms": "from hapticd import link; link.ACK_SPACING_NS *= 40",
    "a_gap_ends_the_session_unless_ahead_was_announced": "from hapticd import items; sound = items.Inbox.take\n"
                                     "def eager(self, packet):\n self.applied = max(self.applied, min(packet.first, 1 << 40) - 1)\n"
                                     " return sound(self, packet)\nitems.Inbox.take = eager",
    "ahead_is_announced_until_the_server_is_heard": "from hapticd import link; link.MOST_AHEAD = 33",
    "items_are_repeated_until_acknowledged": "from hapticd import items, link; items.REPEAT_EVERY_NS = 10**9; link.KEEP_ALIVE_NS = 10**9; "
                                             "items.REPEAT_AFTER_NS = (10**9,)",
    "states_are_counted": "from hapticd import link; sound = link.Link._take_state\n"
                          "def twice(self, state, counter):\n self.seen += 1\n return sound(self, state, counter)\nlink.Link._take_state = twice",
    "a_piece_out_of_place_ends_the_session": "from hapticd import items; items.Inbox._add_piece = lambda self, piece: False",
    "a_reset_begins_anew": "import secrets; secrets.randbelow = lambda most: 7",
}


def checker(client, only=""):
    command = [sys.executable, "-B", CHECKER, "--only", only, "--", *client]
    return subprocess.Popen(command, stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True)


class PythonClient(unittest.TestCase):
    def test_passes_every_check(self):
        running = checker([sys.executable, "-B", CLIENT])
        text = running.communicate()[0]
        self.assertEqual(running.returncode, 0, text)
        self.assertGreater(int(text.splitlines()[-1].split()[0]), 15)

    def test_with_a_fault_fails_the_check_of_that_rule(self):
        running = {}
        for name, fault in FAULTS.items():
            program = f"{fault}\nimport runpy, sys\nsys.argv = sys.argv[1:]\nrunpy.run_path(sys.argv[0], run_name='__main__')"
            running[name] = checker([sys.executable, "-B", "-c", program, CLIENT], name)
        texts = {name: each.communicate()[0] for name, each in running.items()}
        for name, text in texts.items():
            self.assertIn(f"{name}: ", text, f"the fault was not found: {text}")
            self.assertEqual(running[name].returncode, 1, name)


if __name__ == "__main__":
    unittest.main()
