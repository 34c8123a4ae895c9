"""What bash offers at the tab key: commands and options that the programs have, names and values of a running daemon, and nothing that a
daemon or a program with sound, of evil names, could have the shell run."""
import os
import pathlib
import re
import shlex
import stat
import subprocess
import tempfile
import unittest
import unittest.mock

import daemon

REPOSITORY = pathlib.Path(__file__).resolve().parents[2]
SCRIPTS = REPOSITORY / "deploy/completion"
BIN = pathlib.Path(os.environ["HAPTICCTL"]).parent


def offered(line, folder=BIN, cwd="/"):
    """What is offered at the end of a line, which bash splits at blanks, = and :."""
    words = [word for part in re.split(r"([=:])| ", line) if (word := part) is not None]
    words = [word for k, word in enumerate(words) if word or k == len(words) - 1]
    program = words[0]
    bash = (f"source {SCRIPTS / program}; COMP_WORDS=({' '.join(map(shlex.quote, words))}); COMP_CWORD={len(words) - 1}; "
            f"_{program.replace('-', '_')} {program}; printf '%s\\n' \"${{COMPREPLY[@]}}\"")
    done = subprocess.run(["bash", "-c", bash], capture_output=True, text=True, timeout=60, check=True, cwd=cwd,
                          env=dict(os.environ, PATH=f"{folder}:{os.environ['PATH']}"))
    return [each for each in done.stdout.split("\n") if each]


class Completion(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        cls.played = daemon.Daemon("--clock", "virtual", "--device", "scripted", "--scene", "single_string")
        cls.played.__enter__()

    @classmethod
    def tearDownClass(cls):
        cls.played.__exit__(None, None, None)

    def at(self, words):
        return offered(f"hapticctl --server {self.played.address} {words}")

    def test_names_of_the_daemon_are_offered(self):
        self.assertIn("guqin", self.at("scene load "))
        self.assertEqual(["strum"], self.at("gesture play strum"))
        self.assertIn("strings[0].tension_n=", self.at("set strings[0].t"))
        self.assertEqual(["0"], self.at("recentre --tool "))

    def test_values_are_offered_that_the_daemon_takes(self):
        for path, value in (("strings[0].tension_n", "30"), ("strings[0].youngs_modulus_pa", "1.9e+11"), ("tools[0].coupling.length_m", "0.032")):
            with self.subTest(path):
                self.assertEqual([value], self.at(f"set {path}="))
        for path in ("quality", "tones.level"):
            values = self.at(f"set {path}=")
            self.assertGreater(len(values), 1)
            for value in values:
                with self.subTest(path, value=value):
                    code, _, complaint = daemon.said(os.environ["HAPTICCTL"], "--server", self.played.address, "set", f"{path}={value}")
                    self.assertEqual((0, ""), (code, complaint))
        self.assertEqual(["auto"], self.at("set quality=a"))
        values = self.at("set quality=")
        self.assertEqual(sorted(set(values)), sorted(values))
        self.assertEqual(["30"], self.at("set quality=2 strings[0].tension_n="))

    def test_the_choices_that_are_offered_are_all(self):
        _, _, complaint = daemon.said(os.environ["HAPTICCTL"], "--server", self.played.address, "set", "tones.level=x")
        self.assertEqual(set(self.at("set tones.level=")), set(re.findall(r"TONE_LEVEL_\w+", complaint)))

    def test_every_option_and_command_that_is_offered_is_one(self):
        for script in sorted(SCRIPTS.iterdir()):
            program = BIN / script.name
            if not program.exists():
                continue
            code, said, _ = daemon.said(str(program), "--help")
            self.assertEqual(0, code)
            for word in offered(f"{script.name} --"):
                with self.subTest(script.name, option=word):
                    self.assertIn(word, said)

    def set_variable(self, name, value):
        patch = unittest.mock.patch.dict(os.environ, {name: value})
        patch.start()
        self.addCleanup(patch.stop)

    @staticmethod
    def fake(folder, program, said):
        """A program of this name that says so whatever it is asked."""
        path = pathlib.Path(folder, program)
        path.write_text(f"#!/bin/sh\ncat <<'END'\n{said}\nEND\n", encoding="utf-8")
        path.chmod(path.stat().st_mode | stat.S_IXUSR)

    def test_what_is_installed_is_offered_where_no_daemon_plays(self):
        with tempfile.TemporaryDirectory() as folder:
            for file in ("scenes/quiet.textproto", "gestures/tap.textproto", "scenes/$(>ran).textproto", "scenes/other.txt"):
                path = pathlib.Path(folder, file)
                path.parent.mkdir(exist_ok=True)
                path.touch()
            self.fake(folder, "hapticctl", "")
            self.fake(folder, "hapticd", "")
            self.set_variable("HAPTICD_DATA", folder)
            self.assertEqual(["quiet"], offered("hapticd --scene ", folder, "/var"))
            self.assertEqual(["tap"], offered("hapticd --gesture t", folder))

    def test_tools_offer_what_their_help_has(self):
        for line, right in (("hapticd-model b", ["build"]), ("hapticd-model build --le", ["--leaves", "--levels"]), ("hapticd-model build --unit i", ["in"]),
                            ("hapticd-oracle mea", ["measure"]), ("hapticd-oracle measure --se", ["--seed", "--setting"])):
            if (BIN / line.split()[0]).exists():
                with self.subTest(line):
                    self.assertEqual(right, offered(line))

    def test_tools_offer_installed_scenes_and_files_of_scenes(self):
        with tempfile.TemporaryDirectory() as folder:
            for file in ("scenes/guqin.textproto", "other.txt", "mine.textproto"):
                path = pathlib.Path(folder, file)
                path.parent.mkdir(exist_ok=True)
                path.touch()
            self.set_variable("HAPTICD_DATA", folder)
            for line in ("hapticd-model explain ", "hapticd-model check ", "hapticd-oracle measure --scene ", "hapticd-oracle measure --scene="):
                with self.subTest(line):
                    self.assertEqual(["guqin", "mine.textproto"], sorted(offered(line, folder, folder)))
                    self.assertEqual(["guqin"], offered(line + "g", folder, folder))

    @unittest.skipUnless((BIN / "hapticd-model").exists(), "hapticd-model is not built")
    def test_models_and_their_parameters_are_those_that_can_be_made(self):
        models = offered("hapticd-model make ")
        self.assertIn("pillar", models)
        self.assertEqual(models, offered("hapticd-model build model:"))
        self.assertEqual(["pillar"], offered("hapticd-model build model:pil"))
        self.assertEqual([], offered("hapticd-model make pillar --set radius="))
        _, _, complaint = daemon.said(str(BIN / "hapticd-model"), "make", "nothing", "-o", "x.ply")
        for model in models:
            self.assertIn(model, complaint)
        for model in ("pillar", "plate"):
            parameters = offered(f"hapticd-model make {model} --set ")
            self.assertGreater(len(parameters), 1)
            for parameter in parameters:
                _, _, complaint = daemon.said(str(BIN / "hapticd-model"), "make", model, "-o", "/dev/null", "--set", f"{parameter}1000000000")
                self.assertNotIn("no parameter", complaint)
            _, _, complaint = daemon.said(str(BIN / "hapticd-model"), "make", model, "-o", "/dev/null", "--set", "nothing=1000000000")
            self.assertIn("no parameter", complaint)

    def test_recordings_are_offered_by_their_names_and_as_files(self):
        with tempfile.TemporaryDirectory() as folder:
            for file in ("hapticd/recordings/take.mcap", "hapticd/recordings/$(>ran).mcap", "hapticd/recordings/notes.txt", "here.mcap"):
                path = pathlib.Path(folder, file)
                path.parent.mkdir(parents=True, exist_ok=True)
                path.touch()
            self.set_variable("XDG_STATE_HOME", folder)
            for line in ("hapticd export ", "hapticctl export ", "hapticctl replay ", "haptic-audio --recording ", "haptic-web --replay "):
                with self.subTest(line):
                    words = [word for word in offered(line, cwd=folder) if not word.startswith("--")]
                    self.assertEqual(["here.mcap", "take.mcap"], sorted(set(words) - {"hapticd"}))
                    self.assertEqual(["take.mcap"], offered(f"{line}t", cwd=folder))
        _, said, _ = daemon.said(os.environ["HAPTICD"], "export", "--help")
        for word in offered("hapticd export --"):
            self.assertIn(word, said)
        self.assertEqual(["--what"], offered("hapticd export --wh"))

    def test_an_option_with_an_equals_sign_has_the_choices_of_one_without(self):
        for line in ("hapticd --clock", "hapticd --device", "hapticctl --role", "hapticctl export --what", "haptic-osc --role", "haptic-web --role",
                     "hapticd-model build --unit", "hapticd-oracle measure --preset"):
            with self.subTest(line):
                choices = offered(f"{line} ")
                self.assertGreater(len(choices), 1)
                self.assertEqual(choices, offered(f"{line}="))
                self.assertEqual([word for word in choices if word.startswith(choices[0])], offered(f"{line}={choices[0]}"))
        self.assertIn("guqin", self.at("--role=control scene load "))

    def test_ports_of_sound_are_offered(self):
        with tempfile.TemporaryDirectory() as folder:
            self.fake(folder, "haptic-audio", "audio out system:playback_1\nmidi in synth/in:a-b.c")
            self.assertEqual(["system:playback_1"], offered("haptic-audio --connect ", folder))
            # What stands before the colon is on the line already.
            self.assertEqual(["playback_1"], offered("haptic-audio --connect system:play", folder))

    def test_a_daemon_or_a_port_with_an_evil_name_runs_nothing(self):
        for evil in ("$(>ran)", "`>ran`", "a$(>ran)b", "$(touch ran)", "x;>ran"):
            with tempfile.TemporaryDirectory() as folder, unittest.mock.patch.dict(os.environ, XDG_STATE_HOME=folder, HAPTICD_DATA=folder):
                self.fake(folder, "hapticctl", f"{evil}\n{evil}={evil}\nquality={evil}\ntool {evil}: 1")
                self.fake(folder, "haptic-audio", f"audio out {evil}:playback_FL")
                self.fake(folder, "hapticd-model", f"{evil} a model\nplate a model\n  {evil} 1 m")
                kept = pathlib.Path(folder, "hapticd/recordings", evil.replace("/", "") + ".mcap")
                kept.parent.mkdir(parents=True)
                kept.touch()
                pathlib.Path(folder, f"{evil}.textproto").touch()
                pathlib.Path(folder, f"{evil}.mcap").touch()
                files = sorted(os.listdir(folder))
                for line in ("hapticctl scene load ", "hapticctl gesture play ", "hapticctl get ", "hapticctl set ", "hapticctl set quality=",
                             f"hapticctl set {evil}=", "hapticctl recentre --tool ", "hapticd --scene ", "hapticd --gesture ",
                             "haptic-audio --connect ", "hapticctl export ", "hapticctl replay ", "hapticd export ", "haptic-audio --recording ",
                             "haptic-web --replay ", "hapticd-model make ", "hapticd-model make plate --set ", "hapticd-model build model:",
                             "hapticd-model explain ", "hapticd-oracle measure --scene ", f"hapticd export {evil}", f"hapticd --clock={evil}"):
                    with self.subTest(line, evil=evil):
                        offered(line, folder, folder)
                        self.assertEqual(files, sorted(os.listdir(folder)))


if __name__ == "__main__":
    unittest.main()
