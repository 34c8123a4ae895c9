"""Instructions of a tick of the daemon's loop by callgrind: the same on a busy machine. Each case is played up to where its fingers are in place,
and counted for a while beyond."""
import math
import os
import pathlib
import re
import signal
import subprocess
import tempfile
import time
from unittest import mock

import playing
from hapticd import conversation
from playing import STRING_M, Hand, String, line, x_of

COUNTED = 200  # ticks
TRIES = 5
SILENCE_NS = 300 * 10**9  # a client takes a daemon for gone after 3 s; one that is counted on a busy machine is silent for longer
TIP_M = 0.005
REACH_M = TIP_M + STRING_M
# What each case is compared with.
REFERENCE = "one finger presses"


class NotCounted(RuntimeError):
    """Instructions cannot be counted here."""


def pressing(share, ticks):
    """A finger that presses 2 mm into a string, 0.5 mm up and down four times a second."""
    x, low = x_of(share), REACH_M - 2e-3
    way = line((x, REACH_M + 2e-3, 0.0), (x, low, 0.0), 0.1)
    return way + [(x, low + 0.5e-3 * math.sin(2e-3 * math.pi * 4 * k), 0.0) for k in range(100 + ticks)]


def plucked(ticks):
    """A finger that plucks and goes 50 mm away."""
    x = x_of(0.25)
    way = line((x, 3e-3, -12e-3), (x, 3e-3, 30e-3), 1.0)
    way += line(way[-1], (x, 50e-3, 30e-3), 2.0)
    return way + [way[-1]] * (30 + ticks)


def far(ticks):
    return [(x_of(0.25), 50e-3, 0.0)] * (30 + ticks)


def cases():
    """{what: (hands for so many further ticks, strings)}"""
    one = [String(decay_s=1000.0, stretch_n=2000.0)]
    seven = [String(decay_s=1000.0, stretch_n=2000.0, z=0.02 * k) for k in range(7)]
    wide = tuple(0.02 * k for k in range(7))
    return {
        "nobody near, the string silent": (lambda n: [Hand(far(n))], one),
        "nobody near, the string rings": (lambda n: [Hand(plucked(n))], one),
        "one finger presses, a string that does not sound": (lambda n: [Hand(pressing(0.3, n))], [String(stretch_n=2000.0, silent=True)]),
        "one finger presses, a string that does not stretch": (lambda n: [Hand(pressing(0.3, n))], [String(decay_s=1000.0)]),
        REFERENCE: (lambda n: [Hand(pressing(0.3, n))], one),
        "two fingers press one string": (lambda n: [Hand(pressing(share, n)) for share in (0.3, 0.7)], one),
        "three fingers press one string": (lambda n: [Hand(pressing(share, n)) for share in (0.2, 0.5, 0.8)], one),
        "seven fingertips of one hand, a string each": (lambda n: [Hand(pressing(0.3, n), across=wide)], seven),
    }


def dumped(folder):
    """Totals of callgrind's dumps, in order."""
    parts = sorted((path for path in folder.glob("callgrind.out.*")), key=lambda path: int(path.suffix[1:]))
    totals = [re.search(r"^totals: (\d+)", path.read_text(encoding="utf-8"), re.MULTILINE) for path in parts]
    return [int(each[1]) if each else 0 for each in totals]


def instructions(program, play, spans):
    """Of each of those many ticks of a play, tried again where the machine is so busy that daemon and client take each other for gone."""
    for _ in range(TRIES - 1):
        try:
            return counted(program, play, spans)
        except (playing.hapticd.ServerSilent, playing.hapticd.SessionLost):
            pass
    return counted(program, play, spans)


def counted(program, play, spans):
    """Of each of those many ticks of a play, one after the other. `play`: hands, strings and what else the scene has. What one Run counts is
    dumped before the next, so the daemon starts once."""
    hands = play[0]
    with tempfile.TemporaryDirectory(prefix="one_string_") as name:
        folder = pathlib.Path(name)
        scene, log = folder / "scene.textproto", folder / "log"
        scene.write_text(playing.scene(*play), encoding="utf-8")
        with open(log, "w", encoding="utf-8") as out:
            process = subprocess.Popen(
                ["valgrind", "--fair-sched=try", "--tool=callgrind", f"--callgrind-out-file={folder}/callgrind.out",
                 "--toggle-collect=hapticd::HapticLoop::tick_once(*", "--dump-before=hapticd::VirtualTime::run(*", program,
                 "--listen", "127.0.0.1:0", "--clock", "virtual", "--device", "scripted", "--scene", str(scene), "--budget-us", "0"],
                stdout=out, stderr=subprocess.STDOUT, env=dict(os.environ, XDG_STATE_HOME="/nonexistent"))
        try:
            address = None
            while address is None and process.poll() is None:
                said = re.search(r"listening on (\S+): ", log.read_text(encoding="utf-8"))
                address = said.group(1) if said else None
                time.sleep(0.1)
            if "corrupted debuginfo" in log.read_text(encoding="utf-8"):
                raise NotCounted("this valgrind cannot read what the compiler says for debuggers")
            with mock.patch.object(conversation, "SILENCE_NS", SILENCE_NS), playing.hapticd.Session(address) as session:
                session.acquire("cost")
                for tool_id, hand in enumerate(hands):
                    session.poses([tuple(map(float, row)) for row in hand.rows], first_tick=0, tool_id=tool_id)
                for ticks in (*spans, 1):
                    session.run(ticks)
            process.send_signal(signal.SIGTERM)
            process.wait(120)
        finally:
            if process.poll() is None:
                process.kill()
                process.wait()
        totals = dumped(folder)[1:1 + len(spans)]
    if len(totals) < len(spans) or not all(totals):
        raise RuntimeError("callgrind did not count every Run: was the daemon built without symbols?")
    return totals


def per_tick(program, hands_for, strings, extras=""):
    """Instructions of a tick, mean of the last COUNTED of a play."""
    hands = hands_for(COUNTED)
    before = len(hands[0].rows) - COUNTED
    return instructions(program, (hands, strings, extras), (before, COUNTED))[1] / COUNTED


def measure(program):
    """{what: instructions per tick}"""
    found = {}
    for what, (hands_for, strings) in cases().items():
        found[what] = per_tick(program, hands_for, strings)
        print(f"{what}: {found[what]:.0f}", flush=True)
    return found
