"""What one string adds to a tick on each rung of its ladder, in instructions: measured here as cost.py measures, kept in
server/model/string_costs.inc, printed by hapticd-model explain."""
import re
import subprocess
import tempfile

import cost
from playing import ROOT, Hand, String, line, scene

KEPT = ROOT / "server/model/string_costs.inc"
HEAD = """// What one string adds to a tick on each rung, instructions by callgrind: level, whether it stretches, modes, sub-steps of a
// millisecond; while nobody is near, while it rings and nobody is near, under one finger; -1: it does not ring. Of a string of
// 1.1 m, 30 N and 65.4 Hz, mean of 200 ticks, beyond a tick with nothing near. Written by
//   tests/one_string/string_costs --bin build/dev/bin --write
// never by hand.
"""
DOES_NOT_RING = -1
STRETCH_N = 2000.0
# Level, whether the string stretches, modes, sub-steps. What other modes and sub-steps cost follows from the three waves of each kind.
KNOBS = ((32, 32), (16, 16), (32, 16))
ROWS = (("kLine", False, 0, 0), ("kStatic", False, 0, 0), ("kFundamental", False, 0, 0),
        *(("kModes", stretches, *knobs) for stretches in (False, True) for knobs in KNOBS))
RUNGS = {"kLine": "RIGID", "kStatic": "STATIC", "kFundamental": "FUNDAMENTAL", "kModes": "WAVE"}
STATES = ("silent", "rings", "pressed")
# Knobs for which explain is asked, and its answer counted.
ASKED = ((8, 16), (16, 32), (64, 64))


def rings(level):
    return level in ("kFundamental", "kModes")


def knobs_text(modes, substeps):
    return f"wave {{ modes: {modes} substeps: {substeps} }}\n" if modes else ""


def string_of(level, stretches):
    return String(decay_s=1000.0, stretch_n=STRETCH_N if stretches else 0.0, rung=RUNGS[level])


def way():
    """A finger that stays away, plucks and stays away, comes back and presses: rows, and {state: the tick from which it is counted}"""
    rows, begin = cost.far(0), {}
    begin["silent"] = len(rows)
    rows += [rows[-1]] * cost.COUNTED
    pluck = cost.plucked(0)
    rows += line(rows[-1], (pluck[0][0], 50e-3, pluck[0][2]), 2.0) + line((pluck[0][0], 50e-3, pluck[0][2]), pluck[0], 2.0) + pluck
    begin["rings"] = len(rows)
    rows += [rows[-1]] * cost.COUNTED
    press = cost.pressing(0.3, cost.COUNTED)
    rows += line(rows[-1], (press[0][0], 50e-3, 0.0), 2.0) + line((press[0][0], 50e-3, 0.0), press[0], 2.0) + press
    begin["pressed"] = len(rows) - cost.COUNTED
    return rows, begin


def ticks_of(program, strings, extras=""):
    """{state: instructions of a tick}"""
    rows, begin = way()
    spans, at = [], 0
    for first in begin.values():
        spans += [first - at, cost.COUNTED]
        at = first + cost.COUNTED
    counted = cost.instructions(program, ([Hand(rows)], strings, extras), spans)
    return {state: counted[2 * k + 1] / cost.COUNTED for k, state in enumerate(begin)}


def measure(program, rows=ROWS):
    """{row: {state: what one string adds, or DOES_NOT_RING}}"""
    base = ticks_of(program, [])["silent"]
    found = {}
    for row in rows:
        level, stretches, modes, substeps = row
        counted = ticks_of(program, [string_of(level, stretches)], knobs_text(modes, substeps))
        found[row] = {state: DOES_NOT_RING if state == "rings" and not rings(level) else round(counted[state] - base) for state in STATES}
        print(*row, found[row], flush=True)
    return found


def text_of(found):
    """The file."""
    lines = [f"{{StringDetail::{level}, {str(stretches).lower()}, {modes}, {substeps}, {', '.join(str(of[state]) for state in STATES)}}},\n"
             for (level, stretches, modes, substeps), of in found.items()]
    return HEAD + "".join(lines)


def kept():
    """What is in the file: {row: {state: instructions}}"""
    rows = re.findall(r"^\{StringDetail::(\w+), (true|false), (\d+), (\d+), (-?\d+), (-?\d+), (-?\d+)\},$", KEPT.read_text(encoding="utf-8"),
                      re.MULTILINE)
    return {(level, stretches == "true", int(modes), int(substeps)): dict(zip(STATES, map(int, counts)))
            for level, stretches, modes, substeps, *counts in rows}


def explained(model, row):
    """What hapticd-model explain says of a scene of one such string: {state: instructions}"""
    level, stretches, modes, substeps = row
    with tempfile.NamedTemporaryFile("w", suffix=".textproto", encoding="utf-8") as file:
        file.write(scene([Hand(cost.far(0))], [string_of(level, stretches)], knobs_text(modes, substeps)))
        file.flush()
        said = subprocess.run([model, "explain", file.name], capture_output=True, text=True, check=True).stdout
    here = re.search(r"^  here: .*? +(\d+) +(\d+|-) +(\d+)$", said, re.MULTILINE)
    if not here:
        raise RuntimeError(f"explain says nothing of its string:\n{said}")
    return {state: DOES_NOT_RING if count == "-" else int(count) for state, count in zip(STATES, here.groups())}
