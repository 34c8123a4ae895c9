"""Every answer of every command that has --json is one line of JSON as its schema in deploy/schema says; and a command that has none refuses
--json. The commands are those that the programs' own help names."""
import copy
import json
import os
import pathlib
import re
import subprocess
import sys
import tempfile
import unittest

import jsonschema

import daemon
from daemon import said

REPOSITORY = pathlib.Path(__file__).resolve().parents[2]
SCHEMAS = REPOSITORY / "deploy/schema"
BIN = pathlib.Path(os.environ["HAPTICCTL"]).parent
USAGE = 2
# What follows a command so that it does something. Each is run in order, in a folder of its own: {address} is a daemon with the real clock,
# {virtual} one with the virtual clock and scripted devices.
REAL, VIRTUAL = ["--server", "{address}"], ["--server", "{virtual}"]
EXAMPLES = {
    "hapticctl status": [REAL, VIRTUAL],
    "hapticctl scene list": [REAL],
    "hapticctl scene check": [["wall", *REAL]],
    "hapticctl scene load": [["guqin_coarse", *REAL]],
    "hapticctl get": [REAL, ["strings[*].tension_n", *REAL]],
    "hapticctl set": [["quality=2", *REAL]],
    "hapticctl disengage": [REAL],
    "hapticctl stop": [REAL],
    "hapticctl clear": [REAL],
    "hapticctl engage": [VIRTUAL],  # a scripted hand stays where it is clear of the scene
    "hapticctl recentre": [REAL],
    "hapticctl clutch": [["open", *REAL], ["close", *REAL]],
    "hapticctl gesture list": [REAL],
    "hapticctl gesture play": [["strum", "--repeat", "0", *REAL]],
    "hapticctl device info": [REAL, VIRTUAL],
    "hapticctl device monitor": [["--for", "0.5", *REAL]],
    "hapticctl gesture end": [REAL],
    "hapticctl record list": [REAL],
    "hapticctl record start": [["take.mcap", *REAL]],
    "hapticctl record stop": [REAL],
    "hapticctl record dump": [["last.mcap", *REAL]],
    "hapticctl run step": [["3", *VIRTUAL]],
    "hapticctl run live": [VIRTUAL],
    "hapticctl run stop": [VIRTUAL],
    "hapticctl pose": [["poses.csv", *VIRTUAL]],
    "hapticctl doctor": [["--seconds", "0"], ["--seconds", "0.2"]],
    "hapticctl keygen": [["keys"], ["keys", "--client", "stage", "--role", "view"], ["keys", "--list"], ["keys", "--revoke", "stage"]],
    "hapticctl export": [["state/hapticd/recordings/take.mcap", "--csv", "ticks.csv"]],
    "hapticctl device list": [[]],
    "hapticd doctor": [["--seconds", "0"]],
    "hapticd device list": [[]],
    "hapticd export": [["state/hapticd/recordings/take.mcap", "--npy", "ticks.npy", "--what", "ticks"]],
    "hapticd-model build": [["model:pillar", "--error", "2mm", "--quiet", "-o", "pillar.tree"]],
    "hapticd-model list": [[], ["--parameters"]],
    "hapticd-model check": [["good.textproto"], ["good.textproto", "wrong.textproto", "no_such_scene"]],
    "hapticd-model explain": [["single_string"], ["good.textproto", "--quality", "0"]],
    "hapticd-model inspect": [["pillar.tree"], ["pillar.tree", "--mesh", "model:pillar"]],
}
# These end with a verdict on the machine they run on.
VERDICTS = {"hapticctl doctor": (0, 6), "hapticd doctor": (0, 6), "hapticctl device list": (0, 1), "hapticd device list": (0, 1),
            "hapticd-model check": (0, 1)}
TEXTS = {"hapticctl experiment"}  # takes every word after it for another program


def help_of(words):
    done = subprocess.run([BIN / words[0], *words[1:], "--help"], capture_output=True, text=True, timeout=60, check=False)
    usage = re.search(r"^Usage: (.*?)(?: \[OPTIONS\]| SUBCOMMAND|$)", done.stdout, re.MULTILINE)
    return done.stdout if done.returncode == 0 and usage and usage.group(1).split()[-1] == words[-1] else ""


def commands(words, inherited=""):
    """All commands without further ones below `words`, each with its --json option or "": from --help alone."""
    text = help_of(words)
    own = re.search(r"^  --json( TEXT)?", text, re.MULTILINE)
    option = own.group().strip() if own else inherited
    _, _, listed = text.partition("\nSubcommands:\n")
    # hapticd names its commands in prose.
    below = re.findall(r"^  ([a-z]+) ", listed, re.MULTILINE) or sorted(set(re.findall(rf"\b{words[-1]} ([a-z]+)", text)))
    below = [word for word in below if " ".join([*words, word]) in TEXTS or help_of([*words, word])]
    if not below:
        return {" ".join(words): option}
    found = {}
    for word in below:
        found.update({f"{words[0]} {word}": option} if f"{words[0]} {word}" in TEXTS else commands([*words, word], option))
    return found


# A ball that can be played, with a field that does nothing; and one whose radius is negative, on line 5.
GOOD = """name: "ball"
tools { name: "finger" parts { name: "tip" shape { spheres { centre_m: [0, 0, 0] radius_m: 0.005 } } } pose_wg { p_m: [0, 0.07, 0] } }
friction {}
bodies { name: "ball" shape {
  spheres { centre_m: [0, 0, 0] radius_m: 0.05 } } }
"""
WRONG = GOOD.replace("radius_m: 0.05 ", "radius_m: -0.05 ")


class Schemas:
    def __init__(self):
        loaded = {path.name: json.loads(path.read_text(encoding="utf-8")) for path in SCHEMAS.glob("*.schema.json")}
        store = {(SCHEMAS / name).as_uri(): schema for name, schema in loaded.items()}
        self.of, self.validators = {}, {}
        for name, schema in loaded.items():
            resolver = jsonschema.RefResolver((SCHEMAS / name).as_uri(), schema, store=store)
            self.validators[name] = jsonschema.Draft202012Validator(schema, resolver=resolver)
            for command in schema.get("commands", []):
                if command in self.of:
                    raise ValueError(f"{command} has two schemas")
                self.of[command] = name


class JsonTest(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        programs = [words for words in (["hapticctl"], ["hapticd"], ["hapticd-model"]) if (BIN / words[0]).exists()]
        cls.commands = {}
        for words in programs:
            cls.commands.update(commands(words))
        cls.schemas = Schemas()

    def test_a_schema_is_one(self):
        for name, validator in self.schemas.validators.items():
            with self.subTest(name):
                jsonschema.Draft202012Validator.check_schema(validator.schema)

    def test_the_messages_are_those_of_the_protocol(self):
        done = subprocess.run([sys.executable, "-B", SCHEMAS / "messages_of_protocol.py"], capture_output=True, text=True, check=False)
        self.assertEqual((0, ""), (done.returncode, done.stdout))

    def test_every_command_with_json_has_a_schema_and_is_tried(self):
        without = {command for command, option in self.commands.items() if option and command not in self.schemas.of}
        for command in sorted(without):
            with self.subTest(command):  # it says that it has none
                words = command.split()
                code, _, text = said(str(BIN / words[0]), "--json", *words[1:], *(["x"] if command == "hapticctl replay" else []))
                self.assertEqual(USAGE, code, text)
                self.assertIn("--json has no meaning here", text)
        with_schema = {command for command in self.schemas.of if (BIN / command.split()[0]).exists()}
        self.assertEqual(set(), with_schema - {command for command, option in self.commands.items() if option})
        self.assertEqual(with_schema, {command for command in EXAMPLES if (BIN / command.split()[0]).exists()})

    def test_every_answer_is_as_its_schema_says_and_lacks_nothing(self):
        with tempfile.TemporaryDirectory() as folder:
            state = str(pathlib.Path(folder, "state"))
            pathlib.Path(folder, "good.textproto").write_text(GOOD, encoding="utf-8")
            pathlib.Path(folder, "wrong.textproto").write_text(WRONG, encoding="utf-8")
            pathlib.Path(folder, "poses.csv").write_text("0,0,0\n0,0.01,0\n", encoding="utf-8")
            with daemon.Daemon("--scene", "wall", state=state) as real, \
                    daemon.Daemon("--scene", "guqin_coarse", "--clock", "virtual", "--device", "scripted") as virtual:
                for command, examples in EXAMPLES.items():
                    for example in examples:
                        if command in self.commands:
                            words = [word.format(address=real.address, virtual=virtual.address) for word in example]
                            self.answer(command, words, folder)

    @unittest.skipUnless((BIN / "hapticd-model").exists(), "hapticd-model is not built")
    def test_a_check_says_of_each_scene_what_is_wrong_and_where(self):
        model = str(BIN / "hapticd-model")
        with tempfile.TemporaryDirectory() as folder:
            pathlib.Path(folder, "good.textproto").write_text(GOOD, encoding="utf-8")
            pathlib.Path(folder, "wrong.textproto").write_text(WRONG, encoding="utf-8")
            code, text, complaint = said(model, "check", "--json", "good.textproto", "wrong.textproto", cwd=folder)
            good, wrong = json.loads(text)["scenes"]
            self.assertEqual((1, ""), (code, complaint))
            self.assertEqual({"tools": 1, "bodies": 1, "lines": 0, "strings": 0}, {key: good[key] for key in ("tools", "bodies", "lines", "strings")})
            self.assertEqual([True, False], [good["good"], wrong["good"]])
            self.assertEqual({True}, {problem["warning"] for problem in good["problems"]})
            faults = [problem for problem in wrong["problems"] if not problem["warning"]]
            self.assertEqual([("wrong.textproto", 5)], [(fault["file"], fault["line"]) for fault in faults])
            self.assertIn("radius_m", faults[0]["field"])
            # People are told the same.
            _, _, told = said(model, "check", "wrong.textproto", cwd=folder)
            self.assertIn(f"wrong.textproto:5:{faults[0]['column']}: error: {faults[0]['field']}: {faults[0]['message']}", told)

    @unittest.skipUnless((BIN / "hapticd-model").exists(), "hapticd-model is not built")
    def test_an_explanation_has_the_numbers_that_it_prints(self):
        model = str(BIN / "hapticd-model")
        _, printed, _ = said(model, "explain", "guqin_coarse")
        _, text, _ = said(model, "explain", "guqin_coarse", "--json")
        scene, = json.loads(text)["scenes"]
        for shape in [*scene["tools"][0]["parts"], *scene["bodies"]]:
            found, = re.findall(rf"^  {shape['name']}(?: \(soft\))?: (\d+) spheres?(?: of level (\d+))? of (\S+), at most (\S+) um", printed, re.MULTILINE)
            self.assertEqual([shape["spheres"], shape["level"], shape["tree"]], [int(found[0]), int(found[1] or 0), found[2]])
            self.assertAlmostEqual(shape["outside_um"], float(found[3]), delta=0.01 * float(found[3]))
        lines = " ".join(printed.split())
        for line in [*scene["modelled"], *scene["not_modelled"]]:
            self.assertIn(" ".join(line.split()), lines)
        self.assertEqual([str(-(-scene["memory_bytes"] // 1024))], re.findall(r"^memory: (\d+) KiB", printed, re.MULTILINE))
        self.assertIn(f"strings: {len(scene['strings'])}\n", printed)
        for cost in scene["string_costs"]:
            self.assertRegex(printed, rf"here: {cost['strings']} strings?, {re.escape(cost['rung'])} ")

    def test_a_refusal_of_the_daemon_is_a_result(self):
        with daemon.Daemon("--scene", "wall", "--clock", "virtual", "--device", "scripted") as played:
            for words, code in ((["set", "quality=99"], "RESULT_CODE_OUT_OF_RANGE"), (["get", "nonsense"], "RESULT_CODE_NOT_FOUND"),
                                (["scene", "load", "no_such_scene"], "RESULT_CODE_NOT_FOUND")):
                with self.subTest(words=words):
                    exit_code, text, complaint = said(str(BIN / "hapticctl"), "--server", played.address, "--json", *words)
                    self.assertEqual(1, exit_code)
                    self.assertEqual(1, len(text.splitlines()), text)
                    result = json.loads(text)
                    self.assertEqual(code, result["code"])
                    self.check(self.schemas.validators["result.schema.json"], result)
                    self.assertIn(result["message"].splitlines()[0], complaint)
                    self.assertEqual("", said(str(BIN / "hapticctl"), "--server", played.address, *words)[1])

    def answer(self, command, words, folder):
        program, *rest = command.split()
        option = ["--json", "-"] if self.commands[command].endswith("TEXT") else ["--json"]
        code, text, complaint = said(str(BIN / program), *rest, *words, *option, cwd=folder)
        with self.subTest(command, words=words):
            self.assertIn(code, VERDICTS.get(command, (0,)), complaint)
            lines = text.splitlines()
            self.assertTrue(lines if command == "hapticctl device monitor" else len(lines) == 1, text)
            for line in lines:
                self.check(self.schemas.validators[self.schemas.of[command]], json.loads(line))

    def check(self, validator, value):
        self.assertEqual([], [f"{list(error.absolute_path)}: {error.message}" for error in validator.iter_errors(value)])
        # A schema that holds for less, or for more, would say little.
        for name in value:
            poorer = {key: kept for key, kept in value.items() if key != name}
            if name in required(validator):
                self.assertFalse(validator.is_valid(poorer), f"without {name}")
        richer = copy.deepcopy(value)
        richer["unknown"] = 1
        self.assertFalse(validator.is_valid(richer))


def required(validator):
    schema = validator.schema
    if "$ref" in schema:
        _, schema = validator.resolver.resolve(schema["$ref"])
    return schema["required"]


if __name__ == "__main__":
    unittest.main()
