#!/usr/bin/python3
"""Clients that stop, die, are slow or are many: force and ticks stay as they are.

usage: hard_clients.py [--seconds S] [--write]
Under the virtual clock the States of a session are compared, bit for bit by their chained hash, with those of a run that nobody
disturbs. Under the real clock, S seconds each, CPU time and punctuality of the ticks are told for: nobody, a client stopped by SIGSTOP,
one killed, eight that never read, and 32 that take every State. Asserts that hashes are equal, that no fault is latched and that nobody
else's States stay away. --write puts the report into tests/results."""
import argparse
import json
import os
import signal
import subprocess
import sys
import time

import show

import hapticd

WATCHER = "import sys, hapticd\ns = hapticd.Session(sys.argv[1])\ns.subscribe(divisor=1)\nprint('on', flush=True)\nfor _ in s.states(): pass\n"
MUTE = ("import sys, time, hapticd\ns = hapticd.Session(sys.argv[1], reconnect=False)\ns.subscribe(divisor=1)\nprint('on', flush=True)\n"
        "import os\nos.kill(os.getpid(), 19)\n")
CLIENTS = 31  # and the one that looks


def start(program, address):
    """A client in a process of its own, once it is subscribed."""
    process = subprocess.Popen([sys.executable, "-B", "-c", program, address], stdout=subprocess.PIPE, text=True, env=os.environ)
    process.stdout.readline()
    return process


def drag(ticks):
    return [(0.0, 0.0046, -0.02 + 0.0001 * max(0, tick - 220)) for tick in range(ticks)]


def hash_of(disturb):
    """Chained hash of 2000 ticks while `disturb(address)` gives processes that are ended afterwards."""
    with show.daemon.Daemon("--clock", "virtual", "--device", "scripted", "--scene", "single_string") as played:
        with hapticd.Session(played.address) as session:
            others = disturb(played.address)
            session.acquire("show")
            result = session.run(poses=drag(2000))
            for other in others:
                end(other)
            return result.state_hash


def end(process):
    if process.poll() is None:
        process.kill()
    process.communicate()


def stopped(address):
    process = start(WATCHER, address)
    process.send_signal(signal.SIGSTOP)
    return [process]


def killed(address):
    process = start(WATCHER, address)
    process.kill()
    process.communicate()
    return []


def mute(address):
    return [start(MUTE, address) for _ in range(8)]


def many(address, seconds):
    host, port = address.split(":")
    process = show.load("clients", host, port, CLIENTS, seconds)
    time.sleep(1.0)
    return process


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--seconds", type=float, default=1.0)
    parser.add_argument("--write", action="store_true")
    options = parser.parse_args()
    failures, late, lines = [], [], []
    cases = {"nobody else": lambda address: [], "a client stopped by SIGSTOP": stopped, "a client killed": killed, "eight clients that never read": mute}
    hashes = {name: hash_of(case) for name, case in cases.items()}
    equal = len(set(hashes.values())) == 1
    lines += [f"Virtual clock, 2000 ticks of a drag over a string: hashes of all States {'are equal' if equal else 'DIFFER'} for "
              + ", ".join(hashes) + ".", ""]
    if not equal:
        failures.append("States differ under the virtual clock")
    with show.folder() as folder:
        path = f"{folder}/session.mcap"
        spans, seen = {}, {}
        with show.daemon.Daemon("--record", path) as played, hapticd.Session(played.address) as session:
            session.subscribe(divisor=20, sections=["TOOLS"])
            next(session.states(1))
            time.sleep(1.0)

            def span(name, action):
                others = action(played.address)
                list(session.states(timeout=0))
                begin = list(session.states(1))[0].t_ns
                time.sleep(options.seconds)
                states = list(session.states(timeout=0))
                spans[name], seen[name] = (begin, states[-1].t_ns), len(states)
                for other in others:
                    end(other)

            # The crowd comes before those that do not say goodbye: their sessions stay for 10 s, and there are 32.
            crowd = many(played.address, options.seconds + 2.0)
            span("32 clients at 1 kHz", lambda address: [])
            counted = json.loads(crowd.communicate()[0])
            for name, case in cases.items():
                span(name, case)
            session.close()
            code = played.end()
        records = show.read(path)
    lines += ["Real clock, scene `guqin`, CPU time of the haptic thread per tick and distance of ticks from 1 ms:", "", *show.TABLE]
    for name, (begin, finish) in spans.items():
        ticks = [tick for tick in records.ticks if begin <= tick.t_ns < finish]
        lines.append(show.row(f"{name}: CPU", [tick.cpu_ns for tick in ticks]))
        lines.append(show.row(f"{name}: distance", [abs(tick.dt_ns - 1_000_000) for tick in ticks]))
        if seen[name] < 0.5 * 50 * options.seconds:
            late.append(f"the client that looks on got {seen[name]} States with {name}")
    each = sorted(counted["states"])
    lines += ["", f"The 31 clients beside the one that looks on got {each[0]} to {each[-1]} States each in {options.seconds + 2.0:.0f} s (they take "
              f"{counted['cpu_s']:.1f} s of CPU on the same machine; a client that loses more than a tenth is sent half as many). Sessions that ended: "
              f"{counted['ended']}. Gaps in the recorded ticks: {records.lost}."]
    own, held_up, explained = show.over_period([tick for tick in records.ticks if tick.cpu_ns], 1_000_000)
    lines += ["", *explained]
    if own:
        late.append(f"{len(own)} ticks took longer than the period by their own work")
    if code != 0 or any(tick.state == 6 for tick in records.ticks):
        failures.append("a fault was latched, or the daemon did not end well")
    if each[0] == 0 or counted["ended"]:
        failures.append("a session ended, or got no State")
    return show.finish("Hard clients", lines, failures, options.write, late, held_up)


if __name__ == "__main__":
    raise SystemExit(main())
