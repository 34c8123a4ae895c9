#!/usr/bin/python3
"""Do eye and ear agree? A daemon plays plucks in real time; haptic-audio sounds them on JACK's dummy card, haptic-web's page draws them in
headless Chromium, both at t_ns + D. The captured onset and the frame that first shows the tone's ring are put on one clock, and held against
each other and against t_ns + D. Times are reported; asserted is that every pluck is seen and heard once. That each of the two schedules
errs by 1 ms at most is asserted in virtual time, by schedule_test.cpp and schedule_test.js.
usage: one_clock.py [--write], with HAPTIC_AUDIO, HAPTIC_WEB, HAPTICD_NODE, HAPTICD_PAGE_SOURCE in the environment"""
import json
import os
import re
import subprocess
import sys
import time

import show  # first: it knows where the rest is
import daemon
import hapticd
import numpy
import seven_strings

sys.path.insert(0, str(show.ROOT / "tests/clients/audio"))
import jack_rig  # noqa: E402

WRITE = "--write" in sys.argv
PLUCKS = 100 if WRITE or float(os.environ.get("HAPTICD_TEST_SCALE", "0.1")) >= 1 else 10
REALTIME = WRITE and jack_rig.may_be_realtime()
DELAY_S = 0.04  # D of both: two blocks of 256, a network and a busy machine fit into it
DEPTH_M = 0.003
SPEED_M_PER_S = 0.3


def path(count):
    """Places of the hand, a tick each: string after string is pressed and let go."""
    strings = seven_strings.strings()
    at = (seven_strings.PLUCKED_X_M, seven_strings.ABOVE_M, 0.0)
    places = [at] * 500
    for n in range(count):
        string = strings[n % len(strings)]
        above, held = seven_strings.over(string), seven_strings.pressed(string, DEPTH_M)
        places += seven_strings.towards(places[-1], above, SPEED_M_PER_S) + seven_strings.towards(above, held, SPEED_M_PER_S)
        places += [held] * 100 + [above] * 100
    return places


def play(session):
    """Plays the plucks in real time; (string, t_ns) of their tones."""
    places = path(PLUCKS)
    for first in range(0, len(places), 1000):
        session.poses(places[first:first + 1000])
        if first:  # a second's supply is always there
            time.sleep(1.0)
    time.sleep(3.0)
    return [(event.body.string_index, event.body.t_ns) for event in session.events(timeout=0.2) if event.kind == "tone"]


class Page:
    """Chromium on what haptic-web serves, with the processors that the others leave: without a GPU it takes all it gets. `result` has what
    was drawn after the block."""

    def __init__(self, gateway):
        gateway.wait_for("http")
        address = re.search(r"http\S+", gateway.lines[-1])[0]
        self.process = subprocess.Popen(["nice", "-n", "19", os.environ["HAPTICD_NODE"],
                                         str(show.ROOT / "tests/system/shows/drawn_onsets.js"), address],
                                        stdin=subprocess.PIPE, stdout=subprocess.PIPE, text=True)

    def __enter__(self):
        if not self.process.stdout.readline():
            raise RuntimeError("the page was never seen")
        return self

    def __exit__(self, *_):
        self.result = json.loads(self.process.communicate(timeout=120)[0].splitlines()[-1])


def drawn_after(onsets, string, t_s):
    """The ring of this tone, s: the first of its string since, before the string can sound again."""
    return next((ns * 1e-9 for index, ns in onsets if index == string and t_s < ns * 1e-9 < t_s + 1.0), None)


def row(name, errors_s):
    errors = numpy.array(errors_s) * 1e3
    spread = numpy.sqrt(numpy.mean((errors - numpy.median(errors)) ** 2))
    return (f"| {name} | {len(errors)} | {numpy.median(errors):+.2f} | {spread:.2f} | {numpy.percentile(numpy.abs(errors), 99):.2f} | "
            f"{numpy.max(numpy.abs(errors)):.2f} |")


def measured():
    """Tones, their rings on the screen, their sound, and the programs' own words."""
    with daemon.Daemon("--device", "scripted", "--scene", "single_string") as played, jack_rig.Jack(256, REALTIME), \
            hapticd.Session(played.address) as session, \
            jack_rig.Program(os.environ["HAPTIC_AUDIO"], "--server", played.address, "--synth", "--delay-ms", str(DELAY_S * 1e3)) as audio, \
            jack_rig.Program(os.environ["HAPTIC_WEB"], "--server", played.address, "--listen", "127.0.0.1:0", "--delay", str(DELAY_S)) as gateway:
        audio.wait_for("hears hapticd")
        session.acquire("one clock")
        session.load_scene(seven_strings.scene(2.0))
        with Page(gateway) as page, jack_rig.Capture() as capture:
            list(session.events(timeout=0))
            tones = play(session)
    return tones, page.result, capture.sound, audio


def main():
    tones, drawn, sound, audio = measured()
    heard, seen, between = [], [], []
    for string, t_ns in tones:
        due_s = t_ns * 1e-9 + DELAY_S
        onset = sound.onset(due_s, before_s=0.02)
        ring_s = drawn_after(drawn["onsets"], string, t_ns * 1e-9)
        if onset is not None:
            heard.append(sound.time_of(onset) - due_s)
        if ring_s is not None:
            seen.append(ring_s - due_s)
        if onset is not None and ring_s is not None:
            between.append(ring_s - sound.time_of(onset))
    told, played, late = audio.counts()
    lines = [f"{len(tones)} plucks, D = {DELAY_S * 1e3:.0f} ms, JACK's dummy card with blocks of 256 at 48 kHz{' (realtime)' if REALTIME else ''}, the page by software GL at "
             f"{drawn['frames_per_s']:.0f} frames a second (its clock known within {drawn['clock_error_ms']:.2f} ms). haptic-audio played {played} tones "
             f"and counted {late} of them late: it was woken too late for them. "
             f"Work waiting for the machine's {os.cpu_count()} processors: {os.getloadavg()[0]:.1f} on average.", "",
             "| ms | tones | median | rms about it | p99 of the amount | largest |", "|---|---|---|---|---|---|",
             row("heard, against t_ns + D", heard), row("drawn, against t_ns + D", seen), row("drawn, against heard", between), "",
             "A tone is drawn by the first frame after its instant, so half a frame late in the middle, and as late as frames are slow."]
    failures = []
    if len(tones) != PLUCKS or (told, played) != (PLUCKS, PLUCKS):
        failures.append(f"of {PLUCKS} plucks {len(tones)} were told, {played} played")
    if len(drawn["onsets"]) != PLUCKS:
        failures.append(f"of {PLUCKS} plucks {len(drawn['onsets'])} were drawn")
    return show.finish("One clock for eye and ear", lines, failures, WRITE)


if __name__ == "__main__":
    sys.exit(main())
