#!/usr/bin/python3
"""Stands for hapticd-oracle measure and strings in tests of the study: numbers that follow from the arguments alone, times that never repeat. FAKE_ORACLE_S: seconds
each call takes. It knows every scene but "nosuch"."""
import hashlib
import json
import math
import os
import sys
import time

LEVELS = ((1, 1e-5), (4, 1e-5), (8, 1e-5), (32, 1e-6), (64, 1e-8))
"""Sub-steps and tolerance."""


def number(*parts):
    """In [0, 1), by what is asked."""
    return int(hashlib.sha256(repr(parts).encode()).hexdigest()[:12], 16) / 16.0**12


def line(name, text, scene, seed, speed):
    """As hapticd-oracle measure prints it."""
    knobs = dict(each.split("=") for each in text.split(",") if "=" in each)
    steps, tolerance = LEVELS[int(knobs.get("level", 3))]
    steps, tolerance = int(knobs.get("sub_steps", steps)), float(knobs.get("stop_tolerance", tolerance))
    error = (0.3 / steps**2 + 10.0 * tolerance) * (0.9 + 0.2 * number(scene, seed, speed))
    work = 100.0 + 40.0 * math.log2(steps) - 10.0 * math.log10(tolerance)
    force = 100.0 * (1.0 + number(seed, speed))
    return {"name": name, "ticks": 400, "touching": 300, "lagging": 0, "felt_square": error * error * force, "truth_square": force,
            "felt_max_n": error, "contact_square": error * error * force, "contact_truth_square": force, "contact_max_n": error,
            "torque_square": 0.0, "torque_truth_square": 0.0, "pose_square": 1e-9, "pose_max_m": 1e-5, "turn_max_rad": 0.0,
            "path_gap_m": None if "judged=no" in text else 2e-5, "surface_m": 0.0, "work_mean": work, "work_p50": work, "work_p99": 2 * work,
            "work_max": 3 * work, "tests_mean": work / 2, "iterations_mean": 1.0, "sub_steps_mean": 2.0, "work_bins": [[100, 300]],
            "timing": {"mean_us": time.monotonic() % 10.0, "p50_us": 1.0, "p99_us": 2.0, "max_us": 3.0, "bins": [[16, 300]]}}


def strings():
    """As hapticd-oracle strings prints it."""
    for name, modes in (("static", 0), ("8 modes", 8), ("16 modes", 16)):
        print(json.dumps({"measured": "touch", "name": name, "modes": modes, "model_error": 0.5 / (1 + modes), "model_max_n": 0.1,
                          "played_error": 0.5, "played_max_n": 0.2, "timing": {"median_ns": 100.0 + time.monotonic() % 10.0}}))
    print(json.dumps({"measured": "pitch", "frequency_hz": 65.4, "pluck_lambda": 0.1, "deflection_m": 5e-3, "truth_cents": 98.0, "error_cents": -98.0,
                      "error_with_glide_cents": -13.0}))
    for solved, error in (("series", 0.5), ("coupled", 1e-3)):
        print(json.dumps({"measured": "press", "strings": 2, "solved": solved, "error": error, "max_n": 2.0 * error,
                          "timing": {"median_ns": 100.0 + time.monotonic() % 10.0}}))


def main(arguments):
    """The command line of hapticd-oracle, as far as the study uses it."""
    if arguments[0] == "strings":
        return strings()
    if arguments[0] == "explain":  # hapticd-model's
        return sys.exit("nosuch: no such scene" if arguments[1] == "nosuch" else 0)
    options = {}
    for name, value in zip(arguments[1::2], arguments[2::2]):
        options.setdefault(name, []).append(value)
    time.sleep(float(os.environ.get("FAKE_ORACLE_S", "0")))
    if options["--scene"] == ["nosuch"]:
        sys.exit("nosuch: no such scene")
    where = options["--scene"][0], options["--seed"][0], options["--speed"][0]
    for setting in options["--setting"]:
        print(json.dumps(line(*setting.split(":", 1), *where)))
    for name in options["--baseline"]:
        print(json.dumps(line(name, "", *where)))


main(sys.argv[1:])
