#!/usr/bin/python3
"""Does what a page says, as it stands there: saves the files of its blocks, types the commands of its blocks `sh` in order, in a folder and a home
of their own, and a network of their own, so that the ports are free. Each command has to end with 0; one that starts a daemon has to play. A
gesture is waited for, as a reader would. `watch` gets a terminal and the key q.

usage: commands_test.py PAGE PROGRAMS [--tree PRESET | --played]
  PROGRAMS  folder of the built programs; hapticd-play is that of the source tree
            the installed /usr/share/hapticd is share/hapticd beside it
  --tree    the page is read in a clone: deploy/play stands for that of the source tree with this preset, build/play/bin for PROGRAMS
  --played  of the programs there are those alone that deploy/play builds

A page that says how far it is to a sound of one's own is held to it: "after N commands, N files and N words". The pitch of every .wav that it
makes is that of the strings of its scene, by sqrt(tension / linear density) / (2 length).
"""
import math
import os
import pathlib
import pty
import re
import shlex
import signal
import subprocess
import sys
import tempfile
import time
import unittest

import numpy

ROOT = pathlib.Path(__file__).resolve().parents[2]
BLOCK = re.compile(r"^```(\w+)\n(.*?)^```$", re.MULTILINE | re.DOTALL)
MOST_COMMANDS = 10
LONGEST_S = 60
STARTS = re.compile(r"(env \w+=\w+ )?(deploy/play|hapticd-play|hapticd)(?= |$)(?!.*(--check|--version|doctor))")
PLAYED = ("hapticd", "hapticctl", "haptic-web", "haptic-audio")  # what the preset play leaves of all programs
CENTS = 10  # a tone's pitch, measured in a second of it that decays


class Reader:
    """Who follows the page, in a folder of their own."""

    def __init__(self, folder, programs, preset):
        self.folder, self.daemon, self.data = folder, None, programs.parent / "share/hapticd"
        bin_folder, programs_path = folder / "bin", f":{programs}"
        bin_folder.mkdir()
        play = bin_folder / "hapticd-play"
        play.write_text(f'#!/bin/bash\nexec {ROOT}/clients/play/hapticd-play --programs {programs} "$@"\n', encoding="utf-8")
        play.chmod(0o755)
        if preset == PLAYED:
            for name in PLAYED:
                (bin_folder / name).symlink_to(programs / name)
            play.write_text(play.read_text(encoding="utf-8").replace(f"--programs {programs}", f"--programs {bin_folder}"), encoding="utf-8")
            programs_path = ""
        elif preset:
            for name, text in (("deploy/play", f'exec {ROOT}/deploy/play --no-build --preset {preset} "$@"'),):
                (folder / name).parent.mkdir()
                (folder / name).write_text(f"#!/bin/bash\n{text}\n", encoding="utf-8")
                (folder / name).chmod(0o755)
            (folder / "build/play").mkdir(parents=True)
            (folder / "build/play/bin").symlink_to(programs)
        home = folder / "home"
        home.mkdir()
        self.environment = {**os.environ, "HOME": str(home), "PATH": f"{bin_folder}{programs_path}:/usr/bin:/bin", "TERM": "xterm",
                            "PYTHONPATH": str(programs.parent / "clients/python")}
        self.environment.pop("XDG_STATE_HOME", None)

    def run(self, command):
        return subprocess.run(["bash", "-c", command], cwd=self.folder, env=self.environment, capture_output=True, text=True, timeout=LONGEST_S,
                              check=False, stdin=subprocess.DEVNULL)

    def wait_for(self, what, answers):
        end = time.monotonic() + LONGEST_S
        while time.monotonic() < end:
            done = self.run("hapticctl --timeout 0.5 --json status")
            if done.returncode == 0 and answers(done.stdout):
                return
            if self.daemon.poll() is not None:
                break
            time.sleep(0.05)
        raise AssertionError(f"{what} does not come about: {done.stdout}{done.stderr}")

    def start(self, command):
        self.end()
        log = open(self.folder / "daemon.log", "w", encoding="utf-8")
        with log:
            self.daemon = subprocess.Popen(["bash", "-c", f"exec {command}"], cwd=self.folder, env=self.environment, stdout=log, stderr=log,
                                           stdin=subprocess.DEVNULL, start_new_session=True)
        self.wait_for(command, lambda answer: True)

    def end(self):
        """As Ctrl-C does."""
        if self.daemon is not None:
            self.daemon.send_signal(signal.SIGINT)
            self.daemon.wait(LONGEST_S)
            self.daemon = None

    def watch(self, command):
        """Exit code of a command in a terminal that is left with q."""
        ours, theirs = pty.openpty()
        shown = subprocess.Popen(["bash", "-c", command], cwd=self.folder, env=self.environment, stdin=theirs, stdout=theirs, stderr=theirs)
        os.close(theirs)
        seen = b""
        while b"gap" not in seen:  # a line of the picture
            seen += os.read(ours, 4096)
        os.write(ours, b"q")
        code = shown.wait(LONGEST_S)
        os.close(ours)
        return code

    def type(self, command):
        """Types one line of the page; what is said to it."""
        command = command.replace("/usr/share/hapticd", str(self.data))
        if STARTS.match(command):
            self.start(command)
            return ""
        if re.search(r"hapticctl\b.* watch$|hapticctl watch$", command):
            code, said = self.watch(command), ""
        else:
            done = self.run(command)
            code, said = done.returncode, done.stdout + done.stderr
        if code:
            raise AssertionError(f"{command}\nended with {code}:\n{said}")
        print(f"{command}\n{said}")
        if " gesture play " in command:  # as a reader would
            self.wait_for("the gesture", lambda answer: '"gestures":[{' in answer)
            self.wait_for("the end of the gesture", lambda answer: '"gestures":[]' in answer)
        return said


def steps(text):
    """("file", name, content) and ("command", line, None) of a page, in order, and where each stands."""
    for block in BLOCK.finditer(text):
        language, content = block.groups()
        named = re.match(r"(?:#|//) ([\w.]+\.\w+)\n", content)
        if language == "sh":
            for line in content.replace("\\\n", "").splitlines():
                line = re.sub(r"\s+#\s.*", "", line).strip()
                if line:
                    yield "command", line, None, block.end()
        elif named:
            yield "file", named.group(1), content, block.end()


def sound(path):
    """(samples, rate) of a WAV file of 32-bit floats with one channel or two."""
    data = path.read_bytes()
    at, rate, channels = 12, 0, 1
    while data[at:at + 4] != b"data":
        size = int.from_bytes(data[at + 4:at + 8], "little")
        if data[at:at + 4] == b"fmt ":
            form, channels, rate = int.from_bytes(data[at + 8:at + 10], "little"), data[at + 10], int.from_bytes(data[at + 12:at + 16], "little")
            assert form == 3, f"{path}: not floats"
        at += 8 + size + size % 2
    return numpy.frombuffer(data[at + 8:at + 8 + int.from_bytes(data[at + 4:at + 8], "little")], "<f4").astype(float)[::channels], rate


def pitch(samples, rate, lowest=60.0, highest=1000.0):
    """The fundamental: the shift at which a sound is most like itself, refined between samples."""
    size = 2 * len(samples)
    spectrum = numpy.fft.rfft(samples * numpy.hanning(len(samples)), size)
    likeness = numpy.fft.irfft(numpy.abs(spectrum) ** 2)[:len(samples)]
    first, last = int(rate / highest), int(rate / lowest)
    peaks = [k for k in range(first, last) if likeness[k - 1] < likeness[k] >= likeness[k + 1]]
    best = max(likeness[k] for k in peaks)
    k = next(k for k in peaks if likeness[k] > 0.9 * best)
    before, here, after = likeness[k - 1:k + 2]
    return rate / (k + 0.5 * (before - after) / (before - 2 * here + after))


def onsets(samples, rate):
    """Where sounds begin: a hundredth of a second ten times as loud as the one before."""
    step = rate // 100
    loud = [float(numpy.sqrt(numpy.mean(samples[k:k + step] ** 2))) for k in range(0, len(samples) - step, step)]
    found = []
    for k in range(1, len(loud)):
        if loud[k] > 1.5 * loud[k - 1] and loud[k] > 0.1 * max(loud) and (not found or k * step - found[-1] > rate // 2):
            found.append(k * step)
    return found


def tuned(scene, tensions):
    """Pitches of the strings of a scene's text, Hz."""
    found = []
    for index, line in enumerate(re.findall(r"^strings .*", scene, re.MULTILINE)):
        ends = [[float(x) for x in re.search(rf"p_w{end}_m: \[([^]]*)\]", line).group(1).split(",")] for end in "ab"]
        tension = tensions.get(index, float(re.search(r"tension_n: ([\d.]+)", line).group(1)))
        density = float(re.search(r"linear_density_kg_per_m: ([\d.]+)", line).group(1))
        found.append(math.sqrt(tension / density) / (2 * math.dist(*ends)))
    return found


class Page(unittest.TestCase):
    PAGE, PROGRAMS, PRESET = "", "", None

    def setUp(self):
        scratch = tempfile.TemporaryDirectory()
        self.addCleanup(scratch.cleanup)
        self.folder = pathlib.Path(scratch.name)
        self.text = pathlib.Path(self.PAGE).read_text(encoding="utf-8")

    def test_what_it_says_can_be_done(self):
        reader = Reader(self.folder, pathlib.Path(self.PROGRAMS).resolve(), self.PRESET)
        self.addCleanup(reader.end)
        scene, tensions, count, took_s = "", {}, 0, 0.0
        for kind, what, content, _ in steps(self.text):
            if kind == "file":
                (self.folder / what).write_text(content, encoding="utf-8")
                continue
            began = time.monotonic()
            said = reader.type(what)
            took_s += time.monotonic() - began
            count += 1
            if what.startswith("python3 "):  # the page tells what it says
                for number in re.findall(r": ([\d.]+ (?:N|Hz))\b", said):
                    self.assertIn(number, " ".join(self.text.split()))
            loaded = re.search(r"scene load (\S+\.textproto)$", what)
            if loaded:
                scene, tensions = (self.folder / loaded.group(1)).read_text(encoding="utf-8"), {}
            changed = re.search(r"set 'strings\[(\d+)\]\.tension_n=([\d.]+)N'", what)
            if changed:
                tensions[int(changed.group(1))] = float(changed.group(2))
            heard = re.search(r"--render (\S+\.wav) --recording", what)
            if heard:
                print(f"a sound of one's own after {count} commands, which took {took_s:.1f} s")
                self.judge_sound(self.folder / heard.group(1), tuned(scene, tensions))
        self.assertGreater(count, 0)

    def judge_sound(self, path, expected):
        """Its last tones are those of the strings, in order. A tone is measured between 0.1 and 0.9 s after it began."""
        samples, rate = sound(path)
        starts = onsets(samples, rate)[-len(expected):]
        measured = [pitch(samples[start + rate // 10:start + 9 * rate // 10], rate) for start in starts]
        print("measured:", ", ".join(f"{value:.2f} Hz" for value in measured), "expected:", ", ".join(f"{value:.2f} Hz" for value in expected))
        self.assertEqual(len(expected), len(measured), path.name)
        for value, truth in zip(measured, expected):
            self.assertLess(abs(1200 * math.log2(value / truth)), CENTS, path.name)
            self.assertRegex(self.text, rf"\b{truth:.1f} Hz")

    def test_it_is_as_far_as_it_says(self):
        said = re.search(r"after (\d+) commands, (\d+) files\s+and\s+(\d+)\s+words", self.text)
        if not said:
            return
        end = next(at for kind, what, _, at in steps(self.text) if "--render" in what)
        until = [(kind, what) for kind, what, _, at in steps(self.text) if at <= end]
        commands, files = sum(kind == "command" for kind, _ in until), sum(kind == "file" for kind, _ in until)
        words = len(BLOCK.sub("", self.text[:end]).split())
        print(f"{commands} commands, {files} files and {words} words")
        self.assertEqual((commands, files), tuple(int(number) for number in said.groups()[:2]))
        self.assertLessEqual(commands + files, MOST_COMMANDS)
        self.assertLessEqual(words, int(said.group(3)))
        self.assertGreater(words, int(said.group(3)) - 50)


def alone(words):
    """The same again in a network of its own; the code of its end."""
    inside = f"ip link set lo up && exec {shlex.join([sys.executable, '-B', __file__, *words])}"
    unshare = ["unshare", "--net", *([] if os.geteuid() == 0 else ["--map-root-user"])]
    if subprocess.run([*unshare, "true"], check=False, capture_output=True).returncode:
        print("SKIPPED: this kernel gives no network of its own")
        return 77
    return subprocess.run([*unshare, "bash", "-c", inside], env={**os.environ, "HAPTICD_ALONE": "1"}, check=False).returncode


if __name__ == "__main__":
    if "HAPTICD_ALONE" not in os.environ:
        sys.exit(alone(sys.argv[1:]))
    Page.PAGE, Page.PROGRAMS = sys.argv[1:3]
    Page.PRESET = PLAYED if "--played" in sys.argv else sys.argv[4] if len(sys.argv) > 4 else None
    unittest.main(argv=sys.argv[:1], verbosity=2)
