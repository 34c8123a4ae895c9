#!/usr/bin/python3
"""The Guqin at 1 kHz for minutes: CPU time of every tick against the period, overruns, and the time from start to the first State,
beside a bare timer loop that runs in the same minutes.

usage: steady_ticks.py [--minutes M] [--write]
--write puts the report into tests/results, and asserts that the thread's CPU time stays below the period in every tick, but for those in which
the machine held it up, each of which is listed with its work. Without it what is asserted is what no busy machine can change."""
import argparse
import time

import show

import hapticd

PERIOD_NS = 1_000_000


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--minutes", type=float, default=0.07)
    parser.add_argument("--write", action="store_true")
    options = parser.parse_args()
    seconds = 60.0 * options.minutes
    with show.folder() as folder:
        path = f"{folder}/session.mcap"
        began = time.monotonic()
        with show.daemon.Daemon("--record", path) as played, hapticd.Session(played.address) as session:
            session.subscribe(divisor=50, sections=["TIMING", "TOOLS"])
            next(session.states(1))
            to_first_s = time.monotonic() - began
            doctor = show.Doctor(seconds)
            time.sleep(seconds)
            timing = session.latest.timing
            report = doctor.report()
            session.close()
            code = played.end()
        records = show.read(path)
    ticks = records.ticks
    measured = [tick for tick in ticks if tick.cpu_ns]
    distances = [abs(tick.dt_ns - PERIOD_NS) for tick in ticks[1:]]
    own, held_up, explained = show.over_period(measured, PERIOD_NS)
    lines = [f"The scene `guqin` with its demonstration gesture for {seconds:.0f} s at 1 kHz, recorded to a file meanwhile. From the "
             f"start of the process to the first State at a client: {to_first_s:.2f} s.", "", *show.TABLE,
             show.row("haptic thread, CPU per tick", [tick.cpu_ns for tick in measured]),
             show.row("haptic loop, distance of ticks from 1 ms", distances), *show.timer_rows(report), "",
             f"Periods skipped by the haptic loop: {timing.overruns}; ticks lost by the bare timer loop: {report['lost']}, and in "
             f"{report['held_up']} of its ticks the same work took longer than a period. Ticks recorded: {len(ticks)}, gaps in them: "
             f"{records.lost}. Bare loop: SCHED_FIFO {'granted' if report['fifo'] else 'refused'}.", "", *explained]
    failures, late = [], []
    if own:
        late.append(f"{len(own)} ticks took longer than the period by their own work")
    if len(measured) < 0.9 * 1000 * seconds:
        late.append(f"only {len(measured)} ticks")
    if code != 0 or any(tick.state == 6 for tick in ticks):
        failures.append("a fault was latched, or the daemon did not end well")
    return show.finish("Steady ticks", lines, failures, options.write, late, held_up)


if __name__ == "__main__":
    raise SystemExit(main())
