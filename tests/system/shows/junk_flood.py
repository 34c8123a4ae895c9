#!/usr/bin/python3
"""A flood of junk datagrams from loopback: CPU time of the haptic thread's ticks with and without it, what that thread takes from the
allocator and from locks, and every event told exactly once.

usage: junk_flood.py [--seconds S] [--rate PACKETS_PER_S] [--write]
Half of the time is quiet. Asserts that no fault is latched, that the haptic thread never allocates or locks, that nothing overflowed between the threads, and that a client got every event
that was recorded, once and in order. --write puts the report into tests/results, and asserts too that no tick's own work exceeds the period."""
import argparse
import json
import time

import show

import hapticd

KINDS = ("tone", "contact", "string_radius", "string_sounding", "fault")


def told(session):
    """Events a client has, as bytes."""
    return [event.body.SerializeToString(deterministic=True) for event in session.events(timeout=0) if event.kind in KINDS]


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--seconds", type=float, default=4.0)
    parser.add_argument("--rate", type=float, default=100_000.0)
    parser.add_argument("--write", action="store_true")
    options = parser.parse_args()
    half = options.seconds / 2
    with show.folder() as folder:
        path = f"{folder}/session.mcap"
        witness = show.Witness(f"{folder}/witness.json")
        # The witness makes calls in the haptic thread that a confined one has no use for.
        with show.daemon.Daemon("--confine", "off", "--record", path, environment=witness.environment) as played, hapticd.Session(played.address) as session:
            session.subscribe(divisor=100, sections=["TOOLS"])
            next(session.states(1))
            time.sleep(1.0)
            host, port = played.address.split(":")
            quiet_from = list(session.states(1))[0].t_ns
            time.sleep(half)
            heard = told(session)
            flood_from = session.latest.t_ns
            flood = show.load("flood", host, port, options.rate, half, 7)
            flooded = json.loads(flood.communicate()[0])
            flood_to = session.latest.t_ns
            time.sleep(1.0)
            heard += told(session)
            recorder = session.recorder
            session.close()
            code = played.end()
        records = show.read(path)
        taken, failures = witness.report()
    sent = [getattr(each.item, each.item.WhichOneof("body")).SerializeToString(deterministic=True) for each in records.events]
    quiet = [tick.cpu_ns for tick in records.ticks if quiet_from <= tick.t_ns < flood_from]
    during = [tick.cpu_ns for tick in records.ticks if flood_from <= tick.t_ns < flood_to]
    rate = flooded["sent"] / flooded["seconds"]
    # The session began after the first events, and ended before the last.
    begin = sent.index(heard[0]) if heard and heard[0] in sent else -1
    same = begin >= 0 and heard == sent[begin:begin + len(heard)]
    answered = [line for line in played.log.splitlines() if "datagrams received" in line]
    own, held_up, explained = show.over_period([tick for tick in records.ticks if tick.cpu_ns], 1_000_000)
    lines = [f"The scene `guqin` for {half:.0f} s in quiet and {flooded['seconds']:.1f} s under {rate:.0f} datagrams a second: noise, and headers of every "
             f"kind with noise behind them, from loopback ({flooded['sent']} sent, {flooded['refused']} refused by the system, "
             f"{flooded['cpu_s']:.1f} s of CPU for the sender on the same machine).", "", *show.TABLE,
             show.row("haptic thread, CPU per tick, quiet", quiet), show.row("haptic thread, CPU per tick, flood", during), "",
             f"Events told to a client meanwhile: {len(heard)}, each once and in order: {'yes' if same else 'NO'}. Gaps in the recorded ticks: "
             f"{records.lost}; the recorder lost {recorder.lost_ticks} ticks. {' '.join(answered)}", "", taken, "", *explained]
    late = [f"{len(own)} ticks took longer than the period by their own work"] if own else []
    if not same or not heard:
        failures.append("events differ from those recorded")
    if code != 0 or any(tick.state == 6 for tick in records.ticks):
        failures.append("a fault was latched, or the daemon did not end well")
    if recorder.lost_ticks or records.lost:
        failures.append("a ring between the threads overflowed")
    if rate < 0.9 * options.rate:
        lines.append(f"\nThis machine could send only {rate:.0f} datagrams a second.")
    return show.finish("Junk flood", lines, failures, options.write, late, held_up)


if __name__ == "__main__":
    raise SystemExit(main())
