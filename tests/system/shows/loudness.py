#!/usr/bin/python3
"""How loud is a string that was let go at a force? A daemon with the preset `paper`, a script that presses each of seven strings to ten
depths and is gone within a tick, haptic-audio, JACK's dummy card, and what is captured there: rms of the first 0.3 s of each tone against
the force on the hand in the tick before the release. The force is the daemon's own, of the State; the loudness has passed event, packet,
client, synthesis and sound card.
usage: loudness.py [--write], with HAPTIC_AUDIO in the environment"""
import os
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
FORCES = 10 if WRITE or float(os.environ.get("HAPTICD_TEST_SCALE", "0.1")) >= 1 else 2
REFERENCE_N = 4.0
DELAY_S = 0.3
TONE_S = 0.7
STILL_TICKS = 500  # in which what a string did before has died away
ATTEMPTS = 5


class Player:
    """The script's hand."""

    def __init__(self, session):
        self.session = session
        self.at = (seven_strings.PLUCKED_X_M, seven_strings.ABOVE_M, 0.0)
        session.acquire("loudness")
        session.load_scene(seven_strings.scene(REFERENCE_N))
        session.subscribe(divisor=1, sections=["TOOLS"])
        self.run([self.at] * 300)  # the force comes in

    def run(self, places):
        self.at = places[-1]
        return self.session.run(poses=places).states

    def pluck(self, string, depth_m):
        """Force on the hand in the last tick before the release, N, and the tone."""
        above = seven_strings.over(string)
        held = seven_strings.pressed(string, depth_m)
        states = self.run(seven_strings.towards(self.at, above) + seven_strings.towards(above, held) + [held] * STILL_TICKS)
        list(self.session.events(timeout=0))
        self.run([above] * STILL_TICKS)
        tones = [event.body for event in self.session.events(timeout=0.2) if event.kind == "tone"]
        assert len(tones) == 1, f"{len(tones)} tones of one release"
        return float(numpy.linalg.norm(states[-1].tools[0].wrench_h_w[:3])), tones[0]


def play(player, plucks):
    """(string, depth, force, level, instant) of each."""
    played = []
    for string, depth_m in plucks:
        begin_s = time.monotonic()
        force_n, tone = player.pluck(string, depth_m)
        played.append((string, depth_m, force_n, tone.level, begin_s, time.monotonic()))
        time.sleep(TONE_S)
    time.sleep(DELAY_S + 0.5)
    return played


def listen(sound, played):
    """(string, force, level, rms) of the tones that arrived whole, and the plucks of the others."""
    whole, broken = [], []
    for string, depth_m, force_n, level, begin_s, end_s in played:
        onset = sound.onset(begin_s + DELAY_S, before_s=0.02, after_s=end_s - begin_s + 0.2)
        if onset is not None and abs(sound.cents_off(string.frequency_hz, onset, seven_strings.DECAY_S, 0.12, 0.06)) < 5:
            whole.append((string.name, force_n, level, sound.rms(onset)))
        else:
            broken.append((string, depth_m))
    return whole, broken


def measured(session):
    player = Player(session)
    left = [(string, depth_m) for depth_m in seven_strings.deepest(FORCES) for string in seven_strings.strings()]
    wanted, found, again = len(left), [], 0
    for _ in range(ATTEMPTS):
        with jack_rig.Capture() as capture:
            played = play(player, left)
        whole, left = listen(capture.sound, played)
        found += whole
        again += len(left)
        if not left:
            break
    return wanted, found, again


def main():
    with daemon.Daemon("--clock", "virtual", "--device", "scripted", "--scene", "single_string") as played, jack_rig.Jack(), \
            jack_rig.Program(os.environ["HAPTIC_AUDIO"], "--server", played.address, "--synth", "--delay-ms", str(DELAY_S * 1e3)) as audio:
        audio.wait_for("hears hapticd")
        with hapticd.Session(played.address) as session:
            wanted, found, again = measured(session)
    force, level, loudness = (numpy.array([row[i] for row in found]) for i in (1, 2, 3))
    r_squared, slope, intercept = jack_rig.line_through(force, loudness)
    intercept /= slope * force.max()
    lines = [f"{len(found)} of {wanted} tones of seven strings at {FORCES} depths, forces {force.min():.3f} to {force.max():.3f} N; {again} that the "
             "machine broke were played again.", "",
             f"Captured rms = {slope:.5f} per N x |F_d|: R^2 = {r_squared:.5f}, intercept {100 * intercept:+.3f} % of the loudest.",
             f"Level of the event against |F_d|: R^2 = {jack_rig.line_through(force, level)[0]:.5f}; captured rms against the level: "
             f"{jack_rig.line_through(level, loudness)[0]:.5f}.", "", "| string | forces N | rms per N, least and most |", "|---|---|---|"]
    for name in dict.fromkeys(row[0] for row in found):
        of_string = [row for row in found if row[0] == name]
        ratios = [row[3] / row[1] for row in of_string]
        lines.append(f"| {name} | {', '.join(f'{row[1]:.2f}' for row in sorted(of_string, key=lambda row: row[1]))} | {min(ratios):.5f} {max(ratios):.5f} |")
    failures = []
    if len(found) != wanted:
        failures.append(f"{wanted - len(found)} tones were not captured whole in {ATTEMPTS} attempts")
    if not r_squared > 0.99:
        failures.append("R^2 is not above 0.99")
    if not abs(intercept) <= 0.02:
        failures.append("the intercept exceeds 2 %")
    return show.finish("Loudness against the force at the release", lines, failures, WRITE)


if __name__ == "__main__":
    sys.exit(main())
