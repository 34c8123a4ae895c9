#!/usr/bin/python3
"""Everything at once: clients that ask anything, take all, stop, die and come back, a flood of junk, and meanwhile scenes and gestures.

usage: chaos.py [--seconds S] [--seed N] [--write]
The crew has the view key; one session has the lease. Under the virtual clock that session loads scenes, plays gestures and sets parameters as
the seed decides, once alone and once with the crew: States and wrenches must be equal bit for bit. Under the real clock it does so for S
seconds; asserts that no force written to the device grew faster than the slew limit, that no fault is latched, that the lease is kept and that
every request of its holder is answered. --write puts the report into tests/results."""
import argparse
import contextlib
import hashlib
import json
import math
import os
import pathlib
import random
import signal
import subprocess
import sys
import time

import show

import hapticd
from hapticd.v1 import recording_pb2, stream_pb2
from random_requests_test import REQUESTS, Draw

PLAYED = "guqin_coarse"
SCENES = (PLAYED, PLAYED, "single_string", "sphere", "bunny")
GESTURES = ("pluck_each", "strum", "sweep", "hammer", "press_and_hold", "glide")
"""They fit into PLAYED."""
HOSTILE = 6
"""Processes with four sessions each: all places of those who look."""
FLOOD_PER_S = 20_000
SLEW_N_PER_S, LONGEST_STEP_S = 2200.0, 5e-3
"""Of growth, and the longest tick for which it is granted: core/safety/output_stage.h."""
FAULT = 6


class Crew:
    """Hostile clients until the end of the block: some are killed, some stopped, and others come in their place."""

    def __init__(self, address, keys, seed):
        self.address, self.keys, self.draw = address, keys, random.Random(seed)
        self.processes, self.killed, self.stopped, self.begun = [], 0, 0, 0

    def start(self):
        self.begun += 1
        command = [sys.executable, "-B", __file__, "--crew", self.address, "--keys", str(self.keys), "--seed", str(self.draw.getrandbits(32))]
        return subprocess.Popen(command, stdout=subprocess.PIPE, stderr=subprocess.DEVNULL)

    def __enter__(self):
        self.processes = [self.start() for _ in range(HOSTILE)]
        for process in self.processes:
            process.stdout.readline()
        return self

    def stir(self):
        """Something happens to one of them."""
        place = self.draw.randrange(HOSTILE)
        process = self.processes[place]
        if process.poll() is None and self.draw.random() < 0.3:
            process.send_signal(signal.SIGSTOP)
            self.stopped += 1
            return
        process.kill()
        process.communicate()
        self.killed += 1
        self.processes[place] = self.start()

    def __exit__(self, *_):
        for process in self.processes:
            process.kill()
            process.communicate()


def annoy(address, key, seed):
    """One of the crew, until it is killed: random requests, subscriptions and pings in four sessions. Says when the first is open."""
    draw, sessions = Draw(seed), [hapticd.Session(address, key=key, role="view", reconnect=False)]
    print("on", flush=True)
    while True:
        try:
            if len(sessions) < 4:
                sessions.append(hapticd.Session(address, key=key, role="view", reconnect=False))
            session = draw.choice(sessions)
            if draw.random() < 0.1:
                session.subscribe(divisor=draw.choice((1, 1, 10, 1000)))
            elif draw.random() < 0.02:
                sessions.remove(session)
                session.close()
            else:
                item = stream_pb2.Item()
                field = draw.choice(REQUESTS)
                getattr(item, field.name).SetInParent()
                draw.fill(getattr(item, field.name), 0.5)
                connection = session._connection  # a hostile client waits for nothing
                for _ in range(draw.choice((1, 1, 8, 64))):
                    connection.submit(item, awaited=False)
        except (OSError, ValueError, hapticd.RequestError, hapticd.ProtocolError):
            sessions = [each for each in sessions if draw.random() < 0.5]


class Player:
    """The holder of the lease: what it does, the seed decides."""

    def __init__(self, session, seed):
        self.session, self.draw, self.asked = session, random.Random(seed), 0

    def act(self):
        """The next scene, gesture or parameter."""
        scene = self.session.scene.scene.name
        choice = self.draw.random()
        self.asked += 1
        if choice < 0.3 or scene != PLAYED:
            self.session.load_scene(self.draw.choice(SCENES))
        elif choice < 0.8:
            self.session.play_gesture(self.draw.choice(GESTURES))
        else:
            self.session.set("strings[0].tension_n", self.draw.uniform(40.0, 60.0))


def virtual_run(keys, seed, pieces, crowd):
    """Hash of all States and of the wrenches in them, and what became of the crew."""
    digest = hashlib.sha256()
    with show.daemon.Daemon("--clock", "virtual", "--scene", PLAYED, "--keys", str(keys), "--budget-us", "0") as played:
        with hapticd.Session(played.address, key=(keys / "control.key").read_bytes()) as session:
            session.acquire("show")
            session.subscribe(divisor=1, sections=["TOOLS"])
            player, crew = Player(session, seed), Crew(played.address, keys, seed)
            with crew if crowd else contextlib.nullcontext():
                for _ in range(pieces):
                    player.act()
                    session.subscribe(divisor=1, sections=["TOOLS"])
                    result = session.run(steps=250)
                    digest.update(repr(result.state_hash).encode())
                    for state in result.states:
                        digest.update(repr([list(tool.wrench_h_w) for tool in state.tools]).encode())
                    if crowd:
                        crew.stir()
    return digest.hexdigest(), crew


def excess_growth(ticks):
    """By how much the force written in a tick is farther from what was written before, or from less of it, than the slew limit allows, N; and
    of how many ticks."""
    excess, pairs = 0.0, 0
    for old, new in zip(ticks, ticks[1:]):
        if new.t_ns - new.dt_ns != old.t_ns:
            continue  # a tick between them was not recorded
        square = sum(each * each for each in old.force_n)
        share = max(0.0, min(1.0, sum(map(lambda a, b: a * b, new.force_n, old.force_n)) / square)) if square else 0.0
        grown = math.dist(new.force_n, [share * each for each in old.force_n])
        excess = max(excess, grown - SLEW_N_PER_S * min(new.dt_ns * 1e-9, LONGEST_STEP_S))
        pairs += 1
    return excess, pairs


def real_run(keys, seed, seconds):
    """Recorded: (records, crew, what the holder of the lease asked, whether the daemon ended well, junk sent, did the lease stay, what the daemon
    counted)."""
    with show.folder() as folder:
        path = f"{folder}/session.mcap"
        with show.daemon.Daemon("--scene", PLAYED, "--keys", str(keys), "--record", path) as played:
            host, port = played.address.split(":")
            with hapticd.Session(played.address, key=(keys / "control.key").read_bytes()) as session:
                fence = session.acquire("show").fence
                player = Player(session, seed)
                with Crew(played.address, keys, seed) as crew:
                    flood = show.load("flood", host, port, FLOOD_PER_S, seconds, seed % 2**31)
                    end = time.monotonic() + seconds
                    while time.monotonic() < end:
                        player.act()
                        time.sleep(0.5)
                        if player.draw.random() < 0.5:
                            crew.stir()
                junk = json.loads(flood.communicate()[0])["sent"]
                kept = session.lease.yours and session.lease.fence == fence
                ask = stream_pb2.Item()
                ask.get_counts.SetInParent()
                counts = {each.cause: each.count for each in session.request(ask).counts.counts}
            ended = played.end() == 0
        return show.read(path), crew, player.asked, ended, junk, kept, counts


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--seconds", type=float, default=6.0)
    parser.add_argument("--seed", type=int, default=random.SystemRandom().getrandbits(32))
    parser.add_argument("--write", action="store_true")
    parser.add_argument("--crew", help=argparse.SUPPRESS)
    parser.add_argument("--keys", help=argparse.SUPPRESS)
    options = parser.parse_args()
    if options.crew:
        annoy(options.crew, (pathlib.Path(options.keys) / "view.key").read_bytes(), options.seed)
    failures = []
    with show.folder() as folder:
        keys = pathlib.Path(folder) / "keys"
        subprocess.run([os.environ["HAPTICCTL"], "keygen", str(keys)], check=True, stdout=subprocess.DEVNULL)
        pieces = max(8, int(options.seconds / 10))
        alone, _ = virtual_run(keys, options.seed, pieces, crowd=False)
        among, crew = virtual_run(keys, options.seed, pieces, crowd=True)
        lines = [f"Seed {options.seed}.", "", f"Virtual clock: {pieces} times a scene, a gesture or a parameter, and 250 ticks after each. With a crew of "
                 f"{HOSTILE} processes of 4 sessions, of which {crew.killed} were killed and {crew.stopped} stopped, States and wrenches "
                 f"{'are those' if alone == among else 'DIFFER from those'} of a run without, bit for bit."]
        if alone != among:
            failures.append("States or wrenches differ under the virtual clock")
        records, crew, asked, ended, junk, kept, counts = real_run(keys, options.seed, options.seconds)
    excess, pairs = excess_growth(records.ticks)
    strongest = max(math.hypot(*tick.force_n) for tick in records.ticks)
    lines += ["", f"Real clock, {options.seconds:.0f} s: {asked} scenes, gestures and parameters while {crew.begun} processes of 4 sessions came, "
              f"{crew.killed} of them were killed and {crew.stopped} stopped, and {junk} datagrams of junk were sent. The "
              f"daemon took {counts['received']} datagrams, of which {counts['bad_header']} "
              f"had a bad header, opened {counts['hello_welcomed']} sessions, and answered {counts['request_limited']} requests with BUSY, for there were "
              f"too many. Of {pairs} ticks with the one before "
              f"them none's force grew faster than the slew limit: {'yes' if excess <= 1e-9 else f'NO, by {excess:.3g} N'}. The largest force was "
              f"{strongest:.2f} N. Gaps in the recorded ticks: {records.lost}. The lease was kept: {'yes' if kept else 'NO'}."]
    own, held_up, explained = show.over_period([tick for tick in records.ticks if tick.cpu_ns], 1_000_000)
    late = [f"{len(own)} ticks took longer than the period by their own work"] if own else []
    if excess > 1e-9:
        failures.append("a force grew faster than the slew limit")
    if not ended or any(tick.state == FAULT for tick in records.ticks):
        failures.append("a fault was latched, or the daemon did not end well")
    if not kept or strongest == 0.0:
        failures.append("the lease was lost, or no force was written")
    if counts["hello_welcomed"] <= HOSTILE or counts["bad_header"] == 0:
        failures.append("there was no chaos")
    return show.finish("Chaos", [*lines, "", *explained], failures, options.write, late, held_up)


if __name__ == "__main__":
    raise SystemExit(main())
