"""Programs in German and Chinese locales, and names that are not UTF-8: numbers have a point, JSON is UTF-8, and such a name is used or
refused in plain words."""
import json
import os
import pathlib
import re
import subprocess
import sys
import tempfile
import unittest

import daemon

REPOSITORY = pathlib.Path(__file__).resolve().parents[2]
BIN = pathlib.Path(os.environ["HAPTICCTL"]).parent
LOCALES = {"de_DE.UTF-8": ("de_DE", "UTF-8"), "de_DE.ISO-8859-1": ("de_DE", "ISO-8859-1"), "zh_CN.GB2312": ("zh_CN", "GB2312")}
NO_TEXT = b"\xff\xfen"
OUT_OF_PROTOBUF = b"libprotobuf"
USAGE, REFUSED = 2, 1


def make_locales(folder):
    """Makes LOCALES in a folder; what is wrong, where they cannot be made."""
    for name, (language, charset) in LOCALES.items():
        try:
            done = subprocess.run(["localedef", "-c", "-i", language, "-f", charset, str(pathlib.Path(folder, name))], capture_output=True, text=True,
                                  check=False)
        except FileNotFoundError:
            return "there is no localedef"
        if not pathlib.Path(folder, name, "LC_NUMERIC").exists():
            return f"{name} cannot be made: {done.stderr}"
    return ""


def comma_of(environment):
    """Whether a program in this environment that follows its locale writes numbers with a comma."""
    done = subprocess.run([sys.executable, "-c", "import locale; locale.setlocale(locale.LC_ALL, ''); print(locale.str(1.5))"],
                          capture_output=True, text=True, check=False, env=environment)
    return done.stdout.strip() == "1,5"


def run(words, environment):
    done = subprocess.run(words, capture_output=True, timeout=60, check=False, env=environment, stdin=subprocess.DEVNULL)
    return done.returncode, done.stdout, done.stderr


class Locales(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        cls.folder = tempfile.TemporaryDirectory()
        cls.locales = tempfile.TemporaryDirectory()
        wrong = make_locales(cls.locales.name)
        if wrong:
            print(f"SKIPPED: {wrong}")
            sys.exit(77)

    @classmethod
    def tearDownClass(cls):
        cls.folder.cleanup()
        cls.locales.cleanup()

    def each(self):
        for name in LOCALES:
            environment = dict(os.environ, LOCPATH=self.locales.name, LC_ALL=name, LANG=name, LANGUAGE=name[:2], XDG_STATE_HOME=self.folder.name)
            yield name, environment

    def test_the_locales_are_in_force(self):
        self.assertEqual([True, True, False], [comma_of(environment) for _, environment in self.each()])

    def test_numbers_have_a_point_and_texts_are_the_same_everywhere(self):
        asked = [["get"], ["status"], ["run", "step", "3"], ["device", "info"], ["scene", "list"], ["--json", "get"], ["--json", "device", "info"]]
        without = self.answers(dict(os.environ, LC_ALL="C", XDG_STATE_HOME=self.folder.name), asked)
        self.assertIn(b"strings[0].decay_s=0.5\n", without[0][1])
        for name, environment in self.each():
            with self.subTest(name):
                self.assertEqual(without, self.answers(environment, asked))
                scene = ["hapticd-model", "check", "single_string"]
                plain = run([str(BIN / scene[0]), *scene[1:]], dict(os.environ, LC_ALL="C"))
                self.assertEqual(plain, run([str(BIN / scene[0]), *scene[1:]], environment))
                code, tree, _ = run([str(BIN / "hapticd-model"), "inspect", str(REPOSITORY / "deploy/models/plate_1000um.tree"), "--json", "-"], environment)
                self.assertEqual(0, code)
                self.assertGreater(json.loads(tree)["outer"], 0.0)

    @staticmethod
    def answers(environment, asked):
        locale = {name: value for name, value in environment.items() if name.startswith(("LC_", "LANG", "LOCPATH"))}
        with daemon.Daemon("--clock", "virtual", "--device", "scripted", "--scene", "single_string", environment=locale) as played:
            answers = [run([os.environ["HAPTICCTL"], "--server", played.address, *words], environment) for words in asked]
            address = played.address.encode()
        # How many datagrams there were until then is a matter of time.
        counted = re.compile(rb"(?m)^network .*$")
        return [(code, counted.sub(b"network", said).replace(address, b"A"), complaint) for code, said, complaint in answers]

    def test_a_decimal_comma_is_told_from_a_point(self):
        for name, environment in self.each():
            for words in (["hapticd", "--check", "--rate", "1,5kHz"], ["hapticctl", "--timeout", "1,5", "status"], ["haptic-osc", "--rate", "1,5"],
                          ["hapticd-model", "build", "model:plate", "--error", "1,5mm", "-o", "plate.tree"]):
                if (BIN / words[0]).exists():
                    with self.subTest(name, words=words):
                        code, said, complaint = run([str(BIN / words[0]), *words[1:]], environment)
                        self.assertEqual(USAGE, code)
                        self.assertIn(b"with a point", said + complaint)

    def bad_folder(self):
        folder = os.path.join(os.fsencode(self.folder.name), NO_TEXT)
        os.makedirs(folder, exist_ok=True)
        for source in ("scenes/wall", "gestures/press"):
            text = (REPOSITORY / f"deploy/{source}.textproto").read_bytes()
            with open(os.path.join(folder, source.split("/")[1].encode() + b".textproto"), "wb") as file:
                file.write(text)
        with open(os.path.join(folder, b"torn.textproto"), "wb") as file:
            file.write(b'name: "a"\ndescription: "\xff"\n')
        return folder

    def test_files_with_names_that_are_no_text_are_used(self):
        folder = self.bad_folder()
        for name, environment in self.each():
            with daemon.Daemon("--clock", "virtual", "--device", "scripted", "--scene", "wall") as played:
                ctl = [os.environ["HAPTICCTL"], "--server", played.address]
                keys = os.path.join(folder, name.encode())
                for words in ([*ctl, "scene", "load", folder + b"/wall.textproto"], [*ctl, "--json", "scene", "check", folder + b"/wall.textproto"],
                              [*ctl, "--json", "keygen", keys], [str(BIN / "hapticd-model"), "check", folder + b"/wall.textproto"],
                              [str(BIN / "hapticd-model"), "make", "plate", "-o", keys + b".ply"]):
                    with self.subTest(name, words=words):
                        code, said, complaint = run(words, environment)
                        self.assertEqual((0, b""), (code, complaint))
                        if "--json" in words:
                            json.loads(said.decode("utf-8"))
                self.assertTrue(os.path.exists(os.path.join(keys, b"view.key")))
                code, _, complaint = run([*ctl, "scene", "load", folder + b"/torn.textproto"], environment)
                self.assertEqual(REFUSED, code)
                self.assertIn(b"torn.textproto:2: is not text in UTF-8", complaint)
                code, _, complaint = run([*ctl, "scene", "load", folder + b"/"], environment)
                self.assertEqual(REFUSED, code)
                self.assertIn(b"is a folder", complaint)

    def test_names_that_are_no_text_are_refused_where_they_are_told_to_others(self):
        folder = self.bad_folder()
        with daemon.Daemon("--clock", "virtual", "--device", "scripted", "--scene", "wall") as played:
            server = ["--server", played.address]
            tried = {
                "hapticctl": [["scene", "load", NO_TEXT], ["gesture", "play", NO_TEXT], ["get", NO_TEXT], ["set", b"quality=" + NO_TEXT],
                              ["set", NO_TEXT + b"=1"], ["record", "start", NO_TEXT], ["record", "dump", NO_TEXT], [NO_TEXT], ["status", b"--" + NO_TEXT]],
                "hapticd": [["--check", "--scene", NO_TEXT], ["--check", "--scene", folder + b"/wall.textproto"], ["--check", "--gesture", NO_TEXT],
                            ["--keys", folder], ["--record", NO_TEXT], ["--device", NO_TEXT], [NO_TEXT]],
                "hapticd-model": [["check", NO_TEXT], ["make", NO_TEXT, "-o", folder + b"/x.ply"], ["inspect", NO_TEXT]],
                "haptic-web": [["--page", NO_TEXT, "--listen", "127.0.0.1:0"], ["--listen", NO_TEXT], ["--replay", NO_TEXT, "--listen", "127.0.0.1:0"]],
                "haptic-osc": [["--to", NO_TEXT], [NO_TEXT]],
                "haptic-relay": [["--prefix", NO_TEXT], [NO_TEXT]],
                "haptic-audio": [["--recording", NO_TEXT, "--render", folder + b"/x.wav"], [NO_TEXT]],
                "hapticd-oracle": [["gesture", NO_TEXT], [NO_TEXT]],
            }
            for name, environment in self.each():
                for program, lines in tried.items():
                    for words in lines if (BIN / program).exists() else []:
                        with self.subTest(name, program=program, words=words):
                            known = server if program in ("hapticctl", "haptic-osc", "haptic-relay") else []
                            code, said, complaint = run([str(BIN / program), *known, *words], environment)
                            self.assertIn(code, (REFUSED, USAGE))
                            self.assertTrue(complaint)
                            self.assertNotIn(OUT_OF_PROTOBUF, said + complaint)
                            self.assertNotIn(b"Traceback", said + complaint)


if __name__ == "__main__":
    unittest.main()
