#!/usr/bin/python3
"""A day of playing in virtual time, in which nothing may grow: memory, descriptors, threads, losses.

usage: long_day.py [--hours H] [--pieces N] [--seed N] [--write]
One daemon with a simulated hand; H hours of ticks in N pieces. Each begins with a scene, a gesture that repeats until the next and a parameter as
the seed decides, and with clients that come, ask for lists, and leave or fall silent. Asserts that the second half of the day needs no more
memory, descriptors or threads than the first, that no count of a loss moves, and that no fault is latched. --write puts the report into
tests/results."""
import argparse
import os
import pathlib
import random
import signal
import time

import show

import hapticd
from hapticd.v1 import gesture_pb2, state_pb2, stream_pb2

GESTURES = {"guqin_coarse": ("pluck_each", "strum", "sweep", "glide", "hammer", "extreme_presses"), "single_string": (),
            "bunny": ("bunny_single_region", "bunny_two_lines")}
"""They fit into these scenes. On the single string the hand taps as the seed decides."""
SHARES = (1, 10, 1)
"""How often each scene: their ticks differ in price."""
TICKS_PER_H = 3_600_000
KEPT_TICKS = 61_000
"""What the recorder keeps in memory, and a little more: each scene has filled it before the day begins."""
MEBIBYTE = 2**20
GROWTH = 4 * MEBIBYTE
"""Of memory, between the most of the first half and the most of the second: an allocator's, not a leak of bytes per tick."""
WORK = ("received", "hello_welcomed", "sent", "session_backlog", "session_silence")
"""Counts of what is no loss: of guests that are gone without a word, too."""


def needs(pid):
    """Resident memory in bytes, descriptors and threads of a process."""
    place = pathlib.Path(f"/proc/{pid}")
    status = dict(line.split(":\t", 1) for line in (place / "status").read_text(encoding="utf-8").splitlines() if ":\t" in line)
    return int(status["VmRSS"].split()[0]) * 1024, len(os.listdir(place / "fd")), int(status["Threads"])


def counts(session):
    ask = stream_pb2.Item()
    ask.get_counts.SetInParent()
    return {each.cause: each.count for each in session.request(ask).counts.counts}


def visit(address, draw):
    """Clients that come, look, and leave or are gone without a word."""
    for _ in range(draw.randrange(1, 5)):
        guest = hapticd.Session(address, reconnect=False)
        guest.subscribe(draw.choice((1, 10, 1000)))
        for ask in draw.sample((guest.scenes, guest.gestures, guest.get, guest.devices), 2):
            ask()
        if draw.random() < 0.7:
            guest.close()


def tap(draw):
    """To the single string, past it or into it, and back."""
    gesture = gesture_pb2.Gesture(name="tap")
    track = gesture.tracks.add()
    for height in (0.03, draw.uniform(-0.004, 0.006), 0.03):
        point = track.waypoints.add(hold_s=draw.uniform(0.0, 0.2))
        if len(track.waypoints) > 1:
            point.speed_m_per_s = draw.uniform(0.1, 0.6)
        point.at_string.CopyFrom(gesture_pb2.StringTarget(string_index=0, offset_m=[0, height, 0], **{"lambda": draw.uniform(0.1, 0.9)}))
    return gesture


def play(session, draw, scene):
    """A scene, a gesture until the next, a parameter."""
    session.load_scene(scene)
    session.play_gesture(draw.choice(GESTURES[scene]) if GESTURES[scene] else tap(draw), repeat=0)
    if scene != "bunny":
        session.set("strings[0].tension_n", draw.uniform(40.0, 60.0))


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--hours", type=float, default=0.01)
    parser.add_argument("--pieces", type=int, default=8)
    parser.add_argument("--seed", type=int, default=random.SystemRandom().getrandbits(32))
    parser.add_argument("--write", action="store_true")
    options = parser.parse_args()
    draw, failures, rows = random.Random(options.seed), [], []
    steps = max(1, int(options.hours * TICKS_PER_H / options.pieces))
    began = time.monotonic()
    with show.daemon.Daemon("--clock", "virtual", "--scene", "single_string") as played, hapticd.Session(played.address) as session:
        session.acquire("show")
        session.subscribe(997)
        before = counts(session)
        touched = 0
        for scene in GESTURES:
            play(session, draw, scene)
            session.run(steps=KEPT_TICKS)
        for piece in range(options.pieces):
            visit(played.address, draw)
            play(session, draw, draw.choices(tuple(GESTURES), SHARES)[0])
            result = session.run(steps=steps)
            touched += sum(any(tool.wrench_h_w) for state in result.states for tool in state.tools)
            if any(state.loop_state == state_pb2.LOOP_STATE_FAULT for state in result.states):
                failures.append(f"a fault in piece {piece}")
            if result.steps != steps:
                failures.append(f"piece {piece} ended after {result.steps} ticks")
            rows.append(needs(played.process.pid))
        lost = {cause: count - before[cause] for cause, count in counts(session).items() if cause not in WORK and count != before[cause]}
        ended = played.end(signal.SIGTERM)
    half = options.pieces // 2
    early, late = ([max(each) for each in zip(*part)] for part in (rows[:half], rows[half:]))
    seconds = time.monotonic() - began
    lines = [f"Seed {options.seed}. {options.pieces * steps} ticks, {options.hours:g} hours of playing, in {options.pieces} pieces and {seconds:.0f} s; "
             f"States looked at in which the hand felt something: {touched}.", "",
             "| | first piece | most of the first half | most of the second half | last piece |", "|---|---|---|---|---|"]
    for name, at, unit in (("resident memory, MiB", 0, MEBIBYTE), ("descriptors", 1, 1), ("threads", 2, 1)):
        lines.append(f"| {name} | " + " | ".join(f"{each[at] / unit:.1f}" if unit > 1 else str(each[at]) for each in (rows[0], early, late, rows[-1])) + " |")
    lines += ["", "Losses counted: " + (", ".join(f"{cause} {count}" for cause, count in lost.items()) or "none") + "."]
    if late[0] > early[0] + GROWTH or late[1] > early[1] or late[2] > early[2]:
        failures.append("the second half needed more than the first")
    if lost:
        failures.append("something was lost")
    if touched == 0 and options.hours >= 0.1:
        failures.append("the hand felt nothing")
    if ended != 0:
        failures.append(f"the daemon ended with {ended}")
    return show.finish("A day", lines, failures, options.write)


if __name__ == "__main__":
    raise SystemExit(main())
