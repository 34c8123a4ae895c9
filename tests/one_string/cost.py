"""Instructions of a tick of the daemon's loop by callgrind: the same on a busy machine. Each case is played twice, up to where its fingers are
in place and for a while beyond; the difference is what is counted."""
import math
import os
import pathlib
import re
import signal
import subprocess
import tempfile
import time

import playing
from playing import STRING_M, Hand, String, line, x_of

COUNTED = 200  # ticks
TIP_M = 0.005
REACH_M = TIP_M + STRING_M
# What each case is compared with.
REFERENCE = "one finger presses"


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


def instructions(program, hands, strings):
    """Of all ticks of a play."""
    text = playing.scene(hands, strings)
    with tempfile.TemporaryDirectory(prefix="one_string_") as folder:
        scene, log = pathlib.Path(folder) / "scene.textproto", pathlib.Path(folder) / "log"
        scene.write_text(text, encoding="utf-8")
        with open(log, "w", encoding="utf-8") as out:
            process = subprocess.Popen(
                ["valgrind", "--tool=callgrind", "--callgrind-out-file=/dev/null", "--toggle-collect=hapticd::HapticLoop::tick_once(*", program,
                 "--listen", "127.0.0.1:0", "--clock", "virtual", "--device", "scripted", "--scene", str(scene), "--budget-us", "0"],
                stdout=out, stderr=subprocess.STDOUT, env=dict(os.environ, XDG_STATE_HOME="/nonexistent"))
        try:
            address = None
            while address is None and process.poll() is None:
                said = re.search(r"listening on (\S+): ", log.read_text(encoding="utf-8"))
                address = said.group(1) if said else None
                time.sleep(0.1)
            with playing.hapticd.Session(address) as session:
                session.acquire("cost")
                for tool_id, hand in enumerate(hands):
                    session.poses([tuple(map(float, row)) for row in hand.rows], first_tick=0, tool_id=tool_id)
                session.run(len(hands[0].rows))
            process.send_signal(signal.SIGTERM)
            process.wait(120)
        finally:
            if process.poll() is None:
                process.kill()
                process.wait()
        return int(re.search(r"Collected : (\d+)", log.read_text(encoding="utf-8")).group(1))


def measure(program):
    """{what: instructions per tick}"""
    found = {}
    for what, (hands_for, strings) in cases().items():
        short, long = (instructions(program, hands_for(ticks), strings) for ticks in (0, COUNTED))
        found[what] = (long - short) / COUNTED
        print(f"{what}: {found[what]:.0f}", flush=True)
    return found
