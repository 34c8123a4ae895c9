"""What the measured shows share: a daemon that records itself, its ticks read back from the file, percentiles, and the report.

Every tick of a run is in its recording, or counted there as lost; so what is said of ticks here is said of each of them."""
import json
import os
import pathlib
import subprocess
import sys
import tempfile
from typing import NamedTuple

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parent.parent))
import daemon  # noqa: E402
from hapticd.v1 import recording_pb2  # noqa: E402

ROOT = pathlib.Path(__file__).resolve().parents[3]
LOAD = os.environ.get("HAPTICD_NETWORK_LOAD", "")
WITNESS = os.environ.get("HAPTICD_THREAD_WITNESS", "")
SHOWN_TICKS = 20


class Tick(NamedTuple):
    tick: int
    t_ns: int
    dt_ns: int
    cpu_ns: int
    state: int
    work: tuple  # sub-steps, sphere tests, iterations
    level: int  # of quality
    force_n: tuple  # F_H_W written to the first tool's device


class Records(NamedTuple):
    ticks: list
    events: list  # (topic, message) in order
    lost: int  # gaps in what was recorded


def u(data, place, size):
    return int.from_bytes(data[place:place + size], "little")


def walk(data, place, end):
    """(opcode, begin, end) of the records of an MCAP file or chunk."""
    while place + 9 <= end:
        size = u(data, place + 1, 8)
        yield data[place], place + 9, place + 9 + size
        place += 9 + size


def read(path):
    """Ticks and events of a recording, and how often ticks were lost on the way to it."""
    data, topics = pathlib.Path(path).read_bytes(), {}
    ticks, events = [], []

    def take(opcode, begin, end):
        if opcode == 0x04:
            length = u(data, begin + 4, 4)
            topics[u(data, begin, 2)] = data[begin + 8:begin + 8 + length].decode()
        elif opcode == 0x05:
            topic, body = topics[u(data, begin, 2)], data[begin + 22:end]
            if topic == "/hapticd/tick":
                record = recording_pb2.TickRecord.FromString(body)
                budget = record.budget
                ticks.append(Tick(record.tick, record.t_ns, record.dt_ns, record.cpu_ns, record.loop_state,
                                  (budget.substeps, budget.sphere_tests, budget.qp_iterations), budget.level,
                                  tuple(record.outputs[0].wrench_h_w.f_n)))
            elif topic == "/hapticd/event":
                events.append(recording_pb2.EventRecord.FromString(body))
        elif opcode == 0x06:
            place = begin + 28
            place += 4 + u(data, place, 4)
            size = u(data, place, 8)
            for inner in walk(data, place + 8, place + 8 + size):
                take(*inner)

    for record in walk(data, 8, len(data)):
        if record[0] == 0x0F:
            break
        take(*record)
    # A tick's dt counts from the tick before it, recorded or not.
    lost = sum(b.t_ns - a.t_ns - b.dt_ns > 50_000 for a, b in zip(ticks, ticks[1:]) if b.tick > a.tick)
    # The CPU time in a record is that of the tick before it, which a thread knows only afterwards.
    ticks = [tick._replace(cpu_ns=following.cpu_ns) for tick, following in zip(ticks, ticks[1:])]
    return Records(ticks, events, lost)


def percentiles(values):
    """p50, p99, p99.9 and the largest, in us of values in ns."""
    ordered = sorted(values)
    at = [ordered[min(len(ordered) - 1, int(share * len(ordered)))] for share in (0.5, 0.99, 0.999)]
    return [round(value / 1e3, 1) for value in (*at, ordered[-1])]


def row(name, values):
    return f"| {name} | {len(values)} | " + " | ".join(f"{value:.1f}" for value in percentiles(values)) + " |"


TABLE = ["| | count | p50 us | p99 us | p99.9 us | max us |", "|---|---|---|---|---|---|"]


def held_up(tick, ticks, enough_ns):
    """Whether ticks with at least as much work of each kind took less than `enough_ns`: then what this one took beyond was not its own."""
    return any(other.cpu_ns < enough_ns and all(a >= b for a, b in zip(other.work, tick.work)) for other in ticks)


def over_limit(ticks, limit_ns, enough_ns):
    """Ticks that took more, those of them whose work explains it; `enough_ns` as in held_up()."""
    over = [tick for tick in ticks if tick.cpu_ns > limit_ns]
    return over, [tick for tick in over if not held_up(tick, ticks, enough_ns)]


def over_period(ticks, period_ns):
    """Ticks whose CPU time exceeds the period and whose work explains it, how many others exceed it, and lines about all of them."""
    over, own = over_limit(ticks, period_ns, period_ns / 2)
    if not over:
        return own, 0, [f"Every one of {len(ticks)} ticks took less CPU time than the period."]
    shown = f" The first {SHOWN_TICKS} of them:" if len(over) > SHOWN_TICKS else ""
    lines = [f"{len(over)} of {len(ticks)} ticks took more CPU time than the period; the work of {len(own)} of them explains it. For the others there "
             "are ticks with at least as much work of each kind that took less than half the period: what they took beyond was not the haptic "
             "thread's. The kernel books on the thread that runs what a hypervisor, an interrupt or the firmware takes meanwhile." + shown, "",
             "| tick | CPU us | next tick came late by us | sub-steps, sphere tests, iterations | its own |", "|---|---|---|---|---|"]
    after = {tick.t_ns: following for tick, following in zip(ticks, ticks[1:])}
    for tick in over[:SHOWN_TICKS]:
        late = (after[tick.t_ns].dt_ns - period_ns) / 1e3 if tick.t_ns in after else 0.0
        lines.append(f"| {tick.tick} | {tick.cpu_ns / 1e3:.1f} | {late:.1f} | {tick.work} | {'yes' if tick in own else 'no'} |")
    return own, len(over) - len(own), lines


class Doctor:
    """A bare timer loop in the same minutes: hapticd doctor."""

    def __init__(self, seconds):
        self.process = subprocess.Popen([daemon.HAPTICD, "doctor", "--seconds", str(seconds), "--json"], stdout=subprocess.PIPE, text=True)

    def report(self):
        return json.loads(self.process.communicate()[0])


def timer_rows(report):
    """The bare timer loop: how late it was woken, and what the kernel booked for the work that is the same in each of its ticks."""
    named = (("bare timer loop, late by", "late_us"), ("bare timer loop, CPU of the same work in every tick", "work_us"))
    return [f"| {name} | {report['ticks']} | " + " | ".join(f"{report[key][at]:.1f}" for at in ("p50", "p99", "p99.9", "max")) + " |"
            for name, key in named]


class Witness:
    """Counts what the haptic thread of a daemon takes from the system; give `environment` to the daemon."""

    def __init__(self, path):
        self.path = pathlib.Path(path)
        self.environment = {"LD_PRELOAD": WITNESS, "HAPTICD_WITNESS": str(self.path)}

    def report(self):
        """A line about it and what did not hold, once the daemon has ended."""
        seen = json.loads(self.path.read_text(encoding="utf-8"))
        line = (f"Between its first sleep and its last ({seen['ticks']} sleeps) the haptic thread called the allocator {seen['allocations']} times, "
                f"took {seen['locks']} locks, gave the processor away {seen['waits']} times (once per sleep) and met {seen['page_faults']} page faults; "
                f"all threads together, start and end included, called the allocator {seen['all_allocations']} times and took {seen['all_locks']} locks.")
        wrong = [f"the haptic thread: {seen[what]} {what}" for what in ("allocations", "locks") if seen[what]]
        if seen["waits"] > seen["ticks"]:
            wrong.append("the haptic thread waited for more than its clock")
        if not all(seen[what] for what in ("ticks", "waits", "all_allocations", "all_locks")):
            wrong.append("the witness saw nothing")
        return line, wrong


def load(*arguments):
    return subprocess.Popen([LOAD, *(str(each) for each in arguments)], stdout=subprocess.PIPE, text=True)


def finish(title, lines, failures, write, late=(), held_up_ticks=0):
    """Prints the report, writes it where asked, and ends with what it came to. `late`: what did not hold of times; on a machine that does other
    work too they say more of it than of hapticd, so they count where a report is written and are only told elsewhere."""
    commit = subprocess.run(["git", "-C", str(ROOT), "rev-parse", "--short", "HEAD"], capture_output=True, text=True, check=False)
    machine = subprocess.run([daemon.HAPTICD, "doctor", "--seconds", "0", "--json"], capture_output=True, text=True, check=False)
    head = [f"# {title}", "", f"{json.loads(machine.stdout)['machine']}. Commit {commit.stdout.strip() or 'unknown'}. "
            f"Written by `tests/system/shows/{pathlib.Path(sys.argv[0]).name} {' '.join(sys.argv[1:])}`.", ""]
    if write:
        failures = [*failures, *late]
    elif late:
        lines = [*lines, "", "Not held by this machine now: " + "; ".join(late) + "."]
    held = f"Held, but for {held_up_ticks} ticks in which the machine held the haptic thread up." if held_up_ticks else "Held."
    verdict = ["", held if not failures else "NOT HELD: " + "; ".join(failures)]
    text = "\n".join(head + lines + verdict) + "\n"
    print(text)
    if write:
        target = ROOT / "tests/results" / (pathlib.Path(sys.argv[0]).stem + ".md")
        target.parent.mkdir(exist_ok=True)
        target.write_text(text, encoding="utf-8")
        print(f"wrote {target.relative_to(ROOT)}")
    return 1 if failures else 0


def folder():
    return tempfile.TemporaryDirectory(prefix="hapticd_show_")
