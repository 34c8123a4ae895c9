"""Whoever types something wrong is told what is right: following the hint works."""
import os
import pathlib
import re
import subprocess
import tempfile
import unittest

import daemon
from daemon import said

HAPTICCTL = os.environ["HAPTICCTL"]
HAPTIC_WEB = os.environ.get("HAPTIC_WEB")


def meant(text):
    """What a message supposes."""
    return re.search(r"Did you mean (\S+)\?", text).group(1)


class Hints(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        cls.played = daemon.Daemon("--clock", "virtual", "--device", "scripted", "--scene", "wall")
        cls.played.__enter__()

    @classmethod
    def tearDownClass(cls):
        cls.played.__exit__(None, None, None)

    def ctl(self, *words):
        return said(HAPTICCTL, "--server", self.played.address, *words)

    def test_every_scene_and_gesture_is_described_in_a_line(self):
        for kind in ("scene", "gesture"):
            code, text, _ = self.ctl(kind, "list")
            self.assertEqual(0, code)
            for line in text.splitlines():
                self.assertRegex(line, r"^\w+ +[A-Z].+", kind)

    def test_the_scene_that_was_meant_loads(self):
        code, _, text = self.ctl("scene", "load", "sinlge_string")
        self.assertEqual((1, "single_string"), (code, meant(text)))
        self.assertEqual(0, self.ctl("scene", "load", meant(text))[0])

    def test_the_gesture_that_was_meant_is_named_however_many_there_are(self):
        with daemon.Daemon("--clock", "virtual") as played:
            code, _, text = said(HAPTICCTL, "--server", played.address, "gesture", "play", "strm")
            self.assertEqual((1, "strum"), (code, meant(text)))
            self.assertEqual(0, said(HAPTICCTL, "--server", played.address, "gesture", "play", meant(text))[0])

    def test_the_parameter_that_was_meant_is_set_with_its_unit(self):
        self.ctl("scene", "load", "guqin")
        code, _, text = self.ctl("set", "strings[3].tension=45N")
        self.assertEqual((1, "strings[3].tension_n"), (code, meant(text)))
        self.assertEqual(0, self.ctl("set", f"{meant(text)}=45N")[0])
        self.assertEqual("strings[3].tension_n=45\n", self.ctl("get", meant(text))[1])
        code, _, text = self.ctl("set", "strings[3].tension_n=45,5")
        self.assertEqual(1, code)
        self.assertIn("Write 45.5, with a point.", text)

    def test_the_command_and_the_option_that_were_meant_are_named(self):
        self.assertEqual("status", meant(self.ctl("statsu")[2]))
        self.assertEqual("--json", meant(self.ctl("status", "--jsno")[2]))
        code, text = daemon.run("--scen", "wall")
        self.assertEqual((2, "--scene"), (code, meant(text)))
        code, text = daemon.run("--rate", "1,5kHz")
        self.assertEqual(2, code)
        self.assertIn("Write 1.5kHz, with a point.", text)
        self.assertEqual(0, daemon.run("--rate", "1.5kHz", "--check")[0])

    def test_numbers_of_every_program_may_have_a_unit(self):
        self.assertEqual(0, self.ctl("--timeout", "5000ms", "status")[0])
        folder = pathlib.Path(HAPTICCTL).parent
        # In range or not as the number in the unit that is asked for: each program says so before it does anything.
        for program, option, wrong, other, comma in (
                ("hapticctl", "--timeout", "3601s", "4Ms", "1,5"), ("haptic-web", "--delay", "1001ms", "20N", "0,05"),
                ("haptic-web", "--rate", "2kHz", "20s", "2,5"), ("haptic-audio", "--delay-ms", "1.001s", "20Hz", "7,5"),
                ("haptic-audio", "--gain-db", "41dB", "1N", "1,5"), ("haptic-audio", "--rate", "193kHz", "1s", "2,5"),
                ("haptic-osc", "--delay", "1001ms", "1Hz", "0,05"), ("haptic-relay", "--rate", "1.1kHz", "1s", "2,5")):
            if not (folder / program).exists():
                continue
            for typed, why in ((wrong, "not in range"), (other, "not in range" if other == "4Ms" else "cannot be read. Give "),
                               (comma, f"Write {comma.replace(',', '.')}, with a point.")):
                code, _, text = said(str(folder / program), option, typed)
                self.assertEqual(2, code, text)
                self.assertIn(f"{option}: ", text)
                self.assertIn(why, text)
        code, text = daemon.run("doctor", "--seconds", "3601000ms")
        self.assertEqual((2, True), (code, "not in range" in text), text)
        code, text = daemon.run("doctor", "--rate", "1,5kHz")
        self.assertEqual((2, True), (code, "Write 1.5kHz, with a point." in text), text)

    def test_whole_numbers_are_whole_and_in_range(self):
        for words, most in ((("gesture", "play", "strum", "--seed"), 2**64 - 1), (("device", "check", "--seed"), 2**64 - 1), (("run", "step"), 10**9)):
            for number in ("1e3", "1.5", "99999999999999999999999", "-1"):
                if words[0] == "run" and number == "-1":
                    continue  # an argument, not an option's: it would be an option
                code, _, text = self.ctl(*words, number)
                self.assertEqual(2, code, text)
                self.assertIn(f"'{number}' is not a whole number from {int(words[0] == 'run')} to {most}.", text)

    def test_an_index_that_is_none_is_told_the_range(self):
        self.ctl("scene", "load", "guqin")
        for index in ("7", "-1", "", "x", "3:5"):
            for words in (("get", f"strings[{index}].tension_n"), ("set", f"strings[{index}].tension_n=80")):
                code, _, text = self.ctl(*words)
                self.assertEqual(1, code)
                self.assertIn("The index of strings is a whole number, 0 to 6.", text)
        self.assertEqual(2, self.ctl("get", "")[0])

    def test_a_server_that_is_none_is_told_the_form(self):
        for words, why in ((["--server=", "status"], "Give --server HOST:PORT."), (["--server", "", "status"], "Give HOST:PORT."),
                           (["--server", "http://x", "status"], "is not HOST, HOST:PORT"), (["--server", "http://x:1", "status"], "is not HOST, HOST:PORT")):
            code, text, complaint = said(HAPTICCTL, *words)
            self.assertEqual((2, ""), (code, text))
            self.assertIn(why, complaint)

    def test_what_is_no_command_is_told_alone(self):
        self.assertEqual("--discover", meant(self.ctl("discover")[2]))
        for words in (("statsu",), ("discover",), ("watch", "--rate")):
            text = self.ctl(*words)[2]
            self.assertNotIn("is required", text)
            self.assertNotIn("--role", text)

    def test_a_file_that_is_not_there_is_told_as_a_file(self):
        for words in (("scene", "load"), ("scene", "check"), ("gesture", "play"), ("pose",)):
            for source in ("gugin.txt", "./missing"):
                code, text, complaint = self.ctl(*words, source)
                self.assertEqual((1, ""), (code, text))
                self.assertIn(f"{source}: there is no such file.", complaint)
        with tempfile.TemporaryDirectory() as folder:
            pathlib.Path(folder, "mine.txt").write_text('name: "mine"\n', encoding="utf-8")
            code, _, text = said(HAPTICCTL, "--server", self.played.address, "scene", "check", "mine.txt", cwd=folder)
            self.assertNotIn("no such file", text)

    def test_what_of_a_scene_is_without_effect_is_told(self):
        with tempfile.TemporaryDirectory() as folder:
            scene = pathlib.Path(folder, "mine.textproto")
            good = ('name: "mine"\ntools { name: "finger" pose_wg { p_m: [0, 0.05, 0] } parts { name: "tip" shape { spheres { centre_m: [0, 0, 0] radius_m: 0.005 } } } }\n'
                    'strings { name: "A" p_wa_m: [-0.55, 0, 0] p_wb_m: [0.55, 0, 0] }\n')
            for text, line in ((good, ""), (good + "tones {}\n", f"{scene}:4:")):
                scene.write_text(text, encoding="utf-8")
                for command, done in (("check", "good\n"), ("load", "loaded\n")):
                    code, told, complaint = self.ctl("scene", command, str(scene))
                    self.assertEqual((0, done), (code, told), complaint)
                    self.assertEqual(bool(line), bool(complaint), complaint)
                    self.assertIn(line, complaint)

    def test_what_is_no_pose_is_refused_with_its_line(self):
        with tempfile.TemporaryDirectory() as folder:
            table = pathlib.Path(folder, "poses.csv")
            for text, why in (("0,0,0\nnan,0,0\n", f"{table}:2: 'nan' cannot be read."), ("0,0,0,0,0,0,0\n", f"{table}:1: the norm of"),
                              ("abc\n0,0,0\n", f"{table}:1: 'abc' is not"), ("x,y,z\n# none\n", "there is no pose in it"), ("", "there is no pose in it")):
                table.write_text(text, encoding="utf-8")
                code, _, complaint = self.ctl("pose", str(table))
                self.assertEqual(1, code, text)
                self.assertIn(why, complaint)
            table.write_text("x,y,z\n100mm,0,0\n", encoding="utf-8")
            self.assertEqual((0, "1 pose sent, 0 ticks without one\n", ""), self.ctl("pose", str(table)))
            code, _, complaint = self.ctl("pose", folder)
            self.assertEqual(1, code)
            self.assertIn("is a folder", complaint)

    def test_the_choice_that_was_meant_is_named(self):
        self.assertEqual("firm", meant(self.ctl("gesture", "play", "strum", "--arm", "frm")[2]))
        for words, name in ((["--clock", "virtul"], "virtual"), (["docter"], "doctor")):
            code, text = daemon.run(*words)
            self.assertEqual((2, name), (code, meant(text)))
        model = pathlib.Path(HAPTICCTL).parent / "hapticd-model"
        if model.exists():
            code, _, text = said(str(model), "make", "guqin_bdy", "-o", os.devnull)
            self.assertEqual((2, "guqin_body"), (code, meant(text)))
            code, _, text = said(str(model), "make", "pillar", "--set", "heigth=20cm", "-o", os.devnull)
            self.assertEqual((2, "height"), (code, meant(text)))
            code, _, text = said(str(model), "make", "pillar", "--set", "height=20,5cm", "-o", os.devnull)
            self.assertEqual(2, code)
            self.assertIn("Write 20.5cm, with a point.", text)

    def test_an_address_that_is_none_is_refused_by_its_option(self):
        folder = pathlib.Path(HAPTICCTL).parent
        for program, option in (("haptic-osc", "--to"), ("haptic-osc", "--server"), ("haptic-relay", "--broker"), ("haptic-web", "--server"),
                                ("haptic-web", "--listen")):
            for address in ("x:y", "127.0.0.1:99999"):
                if (folder / program).exists():
                    code, _, text = said(str(folder / program), option, address)
                    self.assertEqual(2, code, text)
                    self.assertIn(f"{option}: '{address}' is not HOST, HOST:PORT or [V6]:PORT", text)

    @unittest.skipUnless(pathlib.Path(HAPTICCTL).with_name("haptic-relay").exists(), "there is no relay here")
    def test_what_the_relay_cannot_use_is_refused_by_its_option(self):
        relay = str(pathlib.Path(HAPTICCTL).with_name("haptic-relay"))
        with tempfile.TemporaryDirectory() as folder:
            empty = pathlib.Path(folder, "empty")
            empty.touch()
            for option, value, code, why in (
                    ("--cafile", f"{folder}/none", 1, f"{folder}/none: No such file or directory"), ("--cafile", folder, 1, f"{folder}: Is a directory"),
                    ("--password-file", f"{folder}/none", 1, f"{folder}/none: No such file or directory"),
                    ("--password-file", empty, 1, f"{empty} has no line"), ("--prefix", "a/#/b", 2, "'a/#/b' has '#' or '+'"),
                    ("--prefix", "a+", 2, "'a+' has '#' or '+'"), ("--prefix", "", 2, "it is empty"), ("--prefix", b"a\xff", 2, "not text in UTF-8")):
                found, _, text = said(relay, option, value)
                self.assertEqual(code, found, text)
                self.assertIn(f"{option}: ", text)
                self.assertIn(why, text)

    def test_who_waits_says_once_for_whom(self):
        folder = pathlib.Path(HAPTICCTL).parent
        server = f"127.0.0.1:{daemon.free_port()}"
        waited = f"no daemon answers at {server} yet; waiting for it."
        broker = "127.0.0.1:1"
        for program, options, texts in (("haptic-osc", [], [waited]), ("haptic-web", ["--listen", "127.0.0.1:0"], [waited]),
                                        ("haptic-relay", ["--broker", broker], [waited, f"no broker answers at {broker} yet; waiting for it."])):
            if not (folder / program).exists():
                continue
            with subprocess.Popen([str(folder / program), "--server", server, *options], stdout=subprocess.DEVNULL, stderr=subprocess.PIPE,
                                  text=True) as waiting:
                lines = [waiting.stderr.readline() for _ in texts]
                waiting.terminate()
                lines += waiting.stderr.read().splitlines()
            self.assertEqual(len(texts), len(lines), lines)
            for text in texts:
                self.assertEqual(1, sum(f"{program}: {text}" in line for line in lines), lines)

    def test_a_folder_is_no_recording(self):
        with tempfile.TemporaryDirectory() as place:
            folder = pathlib.Path(HAPTICCTL).parent
            for words in (["haptic-web", "--listen", "127.0.0.1:0", "--replay", place], ["haptic-audio", "--render", f"{place}/a.wav", "--recording", place],
                          ["hapticd-oracle", "path", place]):
                if (folder / words[0]).exists():
                    code, _, text = said(str(folder / words[0]), *words[1:])
                    self.assertNotEqual(0, code)
                    self.assertIn(f"{place} is a folder", text)

    @unittest.skipUnless(HAPTIC_WEB, "there is no viewer here")
    def test_a_key_that_is_none_is_refused_by_its_option(self):
        with tempfile.TemporaryDirectory() as folder:
            for option in ("--key", "--stop-key"):
                code, _, text = said(HAPTIC_WEB, option, folder, "--listen", "127.0.0.1:0")
                self.assertEqual(1, code)
                self.assertIn(f"haptic-web: {option}: {folder}: not a file", text)

    @unittest.skipUnless(HAPTIC_WEB, "there is no viewer here")
    def test_folders_that_are_none_are_refused(self):
        with tempfile.TemporaryDirectory() as folder:
            file = pathlib.Path(folder, "file")
            file.touch()
            # Recordings may have no folder yet: hapticd makes it.
            for option, path, why in (("--assets", f"{folder}/none", f"there is no folder {folder}/none"), ("--recordings", file, f"{file} is no folder"),
                                      ("--experiments", file, f"{file} is no folder")):
                code, _, text = said(HAPTIC_WEB, option, path, "--listen", "127.0.0.1:0")
                self.assertEqual(2, code)
                self.assertIn(why, text)

    def test_status_says_where_virtual_time_stands(self):
        with daemon.Daemon("--clock", "virtual", "--device", "scripted", "--scene", "wall") as played:
            def status():
                return said(HAPTICCTL, "--server", played.address, "status")[1].splitlines()[0]
            self.assertIn("no tick yet", status())
            said(HAPTICCTL, "--server", played.address, "run", "step", "7")
            self.assertIn("time stands before tick 7", status())

    def test_a_mistake_in_a_file_is_named_with_the_file(self):
        with tempfile.TemporaryDirectory() as folder:
            scene = pathlib.Path(folder, "mine.textproto")
            scene.write_text('name: "mine"\nstrings { nme: "A" }\n', encoding="utf-8")
            for command in ("check", "load"):
                code, _, text = self.ctl("scene", command, str(scene))
                self.assertEqual(1, code)
                self.assertIn(f"{scene}:2:", text)

    def test_who_asks_for_a_recording_is_told_its_whole_path(self):
        with tempfile.TemporaryDirectory() as state, daemon.Daemon("--scene", "wall", state=state) as played:
            folder = pathlib.Path(state, "hapticd/recordings")

            def record(*words):
                return said(HAPTICCTL, "--server", played.address, "record", *words)
            self.assertEqual((0, f"written {folder}/mine.mcap\n", ""), record("dump", "mine.mcap"))
            self.assertEqual((0, f"recording {folder}/take.mcap\n", ""), record("start", "take.mcap"))
            # A dump in between is told as itself.
            self.assertEqual((0, f"written {folder}/beside.mcap\n", ""), record("dump", "beside"))
            self.assertEqual((0, f"written {folder}/take.mcap\n", ""), record("stop"))
            for whole in ("mine.mcap", "beside.mcap", "take.mcap"):
                self.assertEqual(b"\x89MCAP0\r\n", folder.joinpath(whole).read_bytes()[-8:])
            # A name that is taken is told each time.
            for mode in ("dump", "start") * 2:
                code, text, complaint = record(mode, "mine.mcap")
                self.assertEqual((1, ""), (code, text))
                self.assertRegex(complaint, r": mine\.mcap: .*File exists")
        with tempfile.TemporaryDirectory() as elsewhere:
            take = pathlib.Path(elsewhere, "take.mcap")
            with daemon.Daemon("--scene", "wall", "--record", "take.mcap", cwd=elsewhere) as played:
                self.assertEqual((0, f"written {take}\n", ""), said(HAPTICCTL, "--server", played.address, "record", "stop"))
                self.assertEqual(b"\x89MCAP0\r\n", take.read_bytes()[-8:])

    @unittest.skipUnless(HAPTIC_WEB, "there is no viewer here")
    def test_a_page_that_is_none_is_refused(self):
        with tempfile.TemporaryDirectory() as folder:
            code, _, text = said(HAPTIC_WEB, "--page", folder, "--listen", "127.0.0.1:0")
            self.assertEqual(2, code)
            self.assertIn(f"there is no index.html in {folder}", text)


if __name__ == "__main__":
    unittest.main()
