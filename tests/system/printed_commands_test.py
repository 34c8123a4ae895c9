"""Whoever runs a command that a message, a manual page or a document shows is not told that there is no such command or option."""
import concurrent.futures
import functools
import os
import pathlib
import re
import signal
import subprocess
import tempfile
import unittest

import daemon
import printed_commands

REPOSITORY = pathlib.Path(__file__).resolve().parents[2]
BIN = pathlib.Path(os.environ["HAPTICCTL"]).parent
BESIDE = {"hapticd-play": REPOSITORY / "clients/play/hapticd-play"}  # not of the build tree
LONGEST_S = 2.0  # whoever runs longer has taken its command line
LEAST = 60  # commands that are shown today are more


def path_of(program):
    return BESIDE.get(program, BIN / program)


@functools.cache
def asked_help(words):
    done = subprocess.run([path_of(words[0]), *words[1:], "--help"], capture_output=True, text=True, timeout=60, check=False)
    return done.stdout if done.returncode == 0 else ""


def command_of(program):
    return printed_commands.Command(lambda words: asked_help(tuple(words)), [program])


class PrintedCommands(unittest.TestCase):
    def test_each_can_be_run(self):
        with tempfile.TemporaryDirectory() as folder, \
                daemon.Daemon("--clock", "virtual", "--device", "scripted", "--scene", "guqin_coarse", state=folder) as played:
            values = {"TEXT": "1", "FILE": "x", "DIR": "d", "NAME": "x", "ADDR:PORT": "127.0.0.1:0", "HOST:PORT": played.address,
                      "HOST:47800": played.address, "PATH=VALUE": "quality=2", "INT": "1", "UINT": "1", "FLOAT": "1", "N": "1", "HZ": "1000",
                      "ADDR": "127.0.0.1", "SECONDS": "0.1", "WHAT:SEED": "lost:1"}
            program_of = {name: command_of(name) for name in printed_commands.PROGRAMS if path_of(name).exists()}
            found, wrong = self.collected(program_of, values)
            self.assertEqual([], wrong)
            self.assertGreater(len(found), LEAST)
            with concurrent.futures.ThreadPoolExecutor(4) as pool:
                complaints = list(pool.map(lambda words: self.complaint(words, program_of[words[0]], played.address, folder), found))
        for (words, places), complaint in zip(found.items(), complaints):
            with self.subTest(" ".join(words), said_in=sorted(places)):
                self.assertEqual("", complaint)

    def test_the_one_that_the_log_shows_reaches_the_daemon_from_any_folder(self):
        with tempfile.TemporaryDirectory() as folder:
            keys = pathlib.Path(folder, "the lab's keys")
            subprocess.run([BIN / "hapticctl", "keygen", keys], capture_output=True, timeout=60, check=True)
            for more in ((), ("--keys", keys.name)):
                before = os.getcwd()
                os.chdir(folder)
                try:
                    playing = daemon.Daemon("--clock", "virtual", "--device", "scripted", "--scene", "single_string", *more)
                finally:
                    os.chdir(before)
                with self.subTest(more), playing as played:
                    shown = re.search(r"listening on \S+: (.*)", played.log)[1]
                    done = subprocess.run(shown, shell=True, capture_output=True, text=True, timeout=60, check=False, cwd="/",
                                          env=dict(os.environ, PATH=f"{BIN}:{os.environ['PATH']}"))
                    self.assertEqual((0, ""), (done.returncode, done.stderr), shown)

    @staticmethod
    def collected(program_of, values):
        found, wrong = {}, []
        for file, text in printed_commands.texts_of(REPOSITORY):
            for words, problem in printed_commands.commands_in(text, program_of, values):
                if problem:
                    wrong.append(f"{file}: {problem}")
                else:
                    found.setdefault(tuple(words), set()).add(file)
        return found, wrong

    @staticmethod
    def complaint(words, program, address, folder):
        """What a program says of a command line that makes no sense; empty where it takes it."""
        given, knows = list(words), program.options
        given = [re.sub(r"^(HOST|[a-z]+):\d+$", address, word) for word in given]
        if words[0] == "hapticd":
            given += ["--check"] if words[1].startswith("-") else []
        elif words[0] == "hapticd-play":
            given.insert(1, "--only-check")
        else:
            for option, value in (("--server", address), ("--listen", "127.0.0.1:0")):
                given[1:1] = [option, value] if option in knows and option not in given else []
        command = [str(path_of(given[0])), *given[1:]]
        environment = dict(os.environ, XDG_STATE_HOME=folder, PATH=f"{BIN}:{os.environ['PATH']}")
        # A session of its own, so that what it has started ends with it.
        with subprocess.Popen(command, stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True, cwd=folder, stdin=subprocess.DEVNULL,
                              env=environment, start_new_session=True) as process:
            try:
                said, _ = process.communicate(timeout=LONGEST_S)
            except subprocess.TimeoutExpired:
                os.killpg(process.pid, signal.SIGKILL)
                process.communicate()
                return ""
        return said if process.returncode == 2 and re.search(r"--help|^usage:", said, re.MULTILINE) else ""


class Reading(unittest.TestCase):
    """What is found in a text, and what is wrong there."""

    def commands(self, text, read=printed_commands.of_cpp):
        values = {"TEXT": "1", "FILE": "x", "DIR": "d"}
        programs = {"hapticctl": command_of("hapticctl"), "hapticd": command_of("hapticd")}
        return [result for each in read(text) for result in printed_commands.commands_in(each, programs, values)]

    def test_commands_in_prose_end_where_prose_goes_on(self):
        self.assertEqual([(["hapticctl", "clear"], None)], self.commands('"stopped; hapticctl clear ends it"'))
        self.assertEqual([], self.commands('"hapticd plays on"'))
        self.assertEqual([(["hapticctl", "device", "check"], None)], self.commands('"Pass hapticctl device "\n   "check, then"'))

    def test_what_is_filled_in_gets_a_value_that_the_help_allows(self):
        self.assertEqual([(["hapticd", "--device", "simulated"], None)], self.commands('"start with  hapticd --device " + choice + "\\n"'))
        self.assertEqual([(["hapticctl", "keygen", "d"], None)], self.commands("\"'hapticctl keygen DIR'\""))

    def test_what_is_no_command_is_found(self):
        for wrong in ('"run hapticctl cleer"', '"Start hapticd --scen bunny"', "\"'hapticctl devices'\"", '"hapticctl record dumb"'):
            with self.subTest(wrong):
                (words, problem), = self.commands(wrong)
                self.assertIsNone(words)
                self.assertTrue(problem)


if __name__ == "__main__":
    unittest.main()
