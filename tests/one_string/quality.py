"""What the knobs of a string buy: its modes and sub-steps, and whether its tension follows how it is bent. Loudness beside string_truth.md, the
pitch of a stopped string in the force that its finger feels, beside a closed form, and instructions as cost.py counts them."""
import math

import cost
import hearing
import numpy as np
from measures import KT, PLUCKED, STOP_DEPTH_M, first_mode, held_tension, pluck_rows, stopped, true_levels
from playing import LENGTH_M, TENSION_N, Hand, String

KNOBS = ((8, 16), (16, 16), (16, 32), (32, 32), (64, 64))  # modes, sub-steps of a millisecond
USUAL = (32, 32)
SPEEDS = (0.45, 0.6, 0.8, 1.0, 1.5)  # of the 54 plucks that have a truth, m/s
STOPS = (0.3, 0.4, 0.6)
FLESH_N_PER_M = 2e4  # of a finger that has held still, core/instrument/string_contacts.h
HZ, STRETCH_N = 65.4, 2000.0
SETTLED_S, HEARD_S = 0.3, 0.5  # after the tone: until the finger holds by its flesh, and for how long the force is looked at


def wave(modes, substeps):
    return f"wave {{ modes: {modes} substeps: {substeps} }}\n"


def loudness(stage, extras, stretch_n=0.0):
    """Of 30 plucks, dB off the truth; None of one that has not exactly one tone."""
    truth, found = true_levels(), []
    for hz, share in PLUCKED:
        for speed in SPEEDS:
            take = stage.play([Hand(pluck_rows(share, speed))], [String(hz=hz, stretch_n=stretch_n)], extras, sections=("TOOLS",))
            told = 1e3 * first_mode(take.tones[0]) if len(take.tones) == 1 else None
            found.append(20 * math.log10(told / truth[hz, share, speed]) if told else None)
    return found


def due_hz(share, stretch_n):
    """Of the part beyond a finger that holds the string by a spring: the root of cot(b a) + cot(b c) = -k / (T b), a and c the two parts."""
    tension = held_tension(share, stretch_n, STOP_DEPTH_M)
    speed = 2 * LENGTH_M * HZ * math.sqrt(tension / TENSION_N)
    near, far = share * LENGTH_M, (1 - share) * LENGTH_M

    def off(b):
        return 1 / math.tan(b * near) + 1 / math.tan(b * far) + FLESH_N_PER_M / (tension * b)
    low, high = 0.9 * math.pi / far, (1 - 1e-12) * math.pi / far
    for _ in range(80):
        middle = 0.5 * (low + high)
        low, high = (middle, high) if off(middle) > 0 else (low, middle)
    return speed * low / (2 * math.pi)


def stopped_cents(stage, extras, stretch_n):
    """How far the force on a finger that stops a string swings beside the closed form, cents, at each place."""
    found = []
    for share in STOPS:
        hands, _ = stopped([share] * 1000, share)
        take = stage.play(hands, [String(decay_s=2.0, loss_n2=0.002, stretch_n=stretch_n)], extras, sections=("TOOLS",))
        force = take.forces()[:, 1]
        begin = take.tones[0].t_ns * 1e-9 + SETTLED_S
        force = force - np.mean(force[round(1e3 * begin):round(1e3 * (begin + HEARD_S))])
        due = due_hz(share, stretch_n)
        found.append(float(hearing.cents(hearing.hz_near(force, 1000, begin + 0.5 * HEARD_S, due, HEARD_S - 0.05, 0.05), due)))
    return found


def instructions(program, extras, stretch_n=STRETCH_N):
    """Of a tick in which one finger presses."""
    return cost.per_tick(program, lambda ticks: [Hand(cost.pressing(0.3, ticks))], [String(decay_s=1000.0, stretch_n=stretch_n)], extras)


def of_knobs(stage, program, modes, substeps):
    """All of one row; without a program nothing is counted."""
    extras = wave(modes, substeps)
    return {"modes": modes, "substeps": substeps, "off_db": loudness(stage, extras), "stopped_cents": stopped_cents(stage, extras, 0.0),
            "instructions": instructions(program, extras) if program else None}


def of_tension(stage, program, what, stretch_n, glides):
    """What a tension that follows costs, and how far a stopped tone is from where it would be without."""
    extras = "vibration { pitch_glide {} }\n" if glides else ""
    return {"what": what, "stopped_cents": stopped_cents(stage, extras, stretch_n),
            "rise_cents": [float(hearing.cents(due_hz(share, stretch_n), due_hz(share, 0.0))) for share in STOPS],
            "instructions": instructions(program, extras, stretch_n)}


def measure(stage, program):
    """Rows of both tables."""
    knobs = []
    for modes, substeps in KNOBS:
        knobs.append(of_knobs(stage, program, modes, substeps))
        print(knobs[-1]["modes"], knobs[-1]["substeps"], knobs[-1]["instructions"], knobs[-1]["stopped_cents"], flush=True)
    tension = [of_tension(stage, program, *row) for row in (("E A 0", 0.0, False), ("E A 2 kN", STRETCH_N, False),
                                                           ("E A 2 kN, `pitch_glide`", STRETCH_N, True))]
    return {"knobs": knobs, "tension": tension}
