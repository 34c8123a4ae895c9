#!/usr/bin/python3
"""Quality that follows a budget, on the real clock: what ticks took of several budgets in several scenes, and at which levels.

usage: kept_budgets.py [--minutes M] [--settling S] [--write]     M: of each scene with each budget
The price of work on this machine is learnt first: ticks of the first S seconds are not judged. --write puts the report into tests/results, and
asserts that at p99.9 a tick takes no more than a tenth beyond its budget, but for ticks in which the machine held it up."""
import argparse
import collections
import time

import show

import hapticd

SLACK = 1.1
CASES = (("guqin", "strum"), ("guqin", "press"), ("bunny", "bunny_two_lines"), ("stress", "slide_on_body"))
BUDGETS_US = (80, 160, 320)


def played(scene, gesture, budget_us, settling_s, seconds):
    """Ticks after the settling, of a daemon that follows the budget."""
    with show.folder() as folder:
        path = f"{folder}/session.mcap"
        options = ("--scene", scene, "--gesture", gesture, "--quality", "auto", "--budget-us", str(budget_us), "--record", path)
        with show.daemon.Daemon(*options) as run, hapticd.Session(run.address) as session:
            session.subscribe(divisor=50, sections=["QUALITY"])
            next(session.states(1))
            time.sleep(settling_s + seconds)
            session.close()
            code = run.end()
        ticks = show.read(path).ticks
    began = ticks[0].t_ns + settling_s * 1e9
    return [tick for tick in ticks if tick.cpu_ns and tick.t_ns > began], code


def told(scene, gesture, budget_us, ticks):
    """A row of the table, and how many ticks took too much by their own work and how many by the machine's."""
    budget_ns = 1e3 * budget_us
    over, own = show.over_limit(ticks, SLACK * budget_ns, budget_ns)
    costs = [f"{value / budget_us:.2f}" for value in show.percentiles([tick.cpu_ns for tick in ticks])]
    levels = collections.Counter(tick.level for tick in ticks)
    shares = ", ".join(f"{level}: {100 * count / len(ticks):.0f} %" for level, count in sorted(levels.items()))
    return f"| {scene}, {gesture} | {budget_us} | {len(ticks)} | {' | '.join(costs)} | {len(own)} | {len(over) - len(own)} | {shares} |", len(own), len(over) - len(own)


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--minutes", type=float, default=0.01)
    parser.add_argument("--settling", type=float, default=0.5)
    parser.add_argument("--write", action="store_true")
    options = parser.parse_args()
    lines = [f"`--quality auto` at 1 kHz for {60 * options.minutes:.0f} s each, after {options.settling:g} s in which the price of work is learnt. CPU time "
             f"of the haptic thread in a tick over its budget; ticks beyond {SLACK} budgets by their own work, and those held up: ticks with at least as much "
             "work of each kind kept within the budget. Where p50 is about 1, the least that the scene asks for in a tick takes the budget.", "",
             "| scene, gesture | budget us | ticks | p50 | p99 | p99.9 | max | beyond, own work | beyond, held up | ticks at level |",
             "|---|---|---|---|---|---|---|---|---|---|"]
    failures, late, held_up = [], [], 0
    for scene, gesture in CASES:
        for budget_us in BUDGETS_US:
            ticks, code = played(scene, gesture, budget_us, options.settling, 60.0 * options.minutes)
            if not ticks:
                failures.append(f"{scene} at {budget_us} us: no tick was recorded")
                continue
            row, own, others = told(scene, gesture, budget_us, ticks)
            lines.append(row)
            print(row, flush=True)
            held_up += others
            if code:
                failures.append(f"{scene} at {budget_us} us: the daemon ended with {code}")
            if own > 0.001 * len(ticks):
                late.append(f"{scene}, {gesture}, {budget_us} us: {own} of {len(ticks)} ticks beyond {SLACK} budgets")
    return show.finish("Kept budgets", lines, failures, options.write, late, held_up)


if __name__ == "__main__":
    raise SystemExit(main())
