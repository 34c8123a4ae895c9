"""Words and tables of tests/results/one_string.md."""
import math
import os
import platform
import re
import subprocess
import textwrap

import numpy as np
from playing import ROOT

PAGE = ROOT / "tests/results/one_string.md"
FOLDER = PAGE.with_suffix("")
SOUND = FOLDER / "phrase.wav"
WIDTH = 140  # of prose, columns
# What the page is held against: dB, cents, ms, uJ.
LOUDNESS_DB, TOLD_CENTS, HEARD_CENTS, HARMONIC_DB, HEARD_DB, LAP_UJ, WON_UJ = 0.1, 5.0, 8.0, 3.0, 6.0, 5.0, 50.0
SILENT_DB = -40.0  # below what it was a string counts as silent
PART_WORDS = {2: "1/2", 3: "1/3", 4: "1/4", 5: "1/5"}


def decibels(a, b):
    return 20 * math.log10(a / b)


def table(heads, rows):
    """Markdown; numbers to the right of the first column."""
    return ["| " + " | ".join(heads) + " |", "|---|" + "---:|" * (len(heads) - 1), *("| " + " | ".join(map(str, row)) + " |" for row in rows), ""]


def picture(name, words):
    return [f"![{words}](one_string/{name}.png)", ""]


def machine(program):
    """CPU, kernel, the compiler that the program names, and the commit."""
    cpu = re.search(r"model name\s*: (.*)", open("/proc/cpuinfo", encoding="utf-8").read())
    comment = subprocess.run(["readelf", "-p", ".comment", program], capture_output=True, text=True, check=False).stdout
    compilers = sorted(set(re.findall(r"(GCC: .*|.*clang version .*)", comment)))
    commit = subprocess.run(["git", "-C", str(ROOT), "log", "-1", "--format=%h", "--", "core", "server", "clients/audio", "proto"],
                            capture_output=True, text=True, check=False)
    return (f"{cpu[1] if cpu else 'unknown processor'} x {os.cpu_count()}, Linux {platform.release()}. {'; '.join(compilers) or 'unknown compiler'}. "
            f"Beside commit {commit.stdout.strip() or 'unknown'}.")


def head(figures):
    return ["# One string, from the pluck to the ear", "",
            "Written by `tests/one_string/one_string --bin build/dev/bin`, with its pictures and sound.", figures["machine"],
            "The whole daemon plays in virtual time, and haptic-audio computes the sound (`--render --synth`), so no figure depends on the load of the",
            "machine. The string has 1.1 m and 30 N, and is a wave because nothing else is said: the default. *Told* is what events say,",
            "`StringSounding` carried on as its comment says; *heard* is measured in the sound, by a program that knows nothing of strings.", ""]


def loudness(found):
    rows = found["rows"]
    known = [decibels(row["mode_mm"], row["truth_mm"]) for row in rows if row["truth_mm"] and row["mode_mm"]]
    lines = ["## Loudness", "",
             "A finger of 1 kN/m plucks straight across, 3 mm above the axis. Swing of the fundamental at its belly in mm, by amplitude and",
             "partials of the `Tone`; its amplitude itself, which is that of a fundamental with the energy of all partials; and the fundamental by the",
             "[truth](string_truth.md), finite differences, where it has the speed.", ""]
    speeds = sorted({row["speed"] for row in rows})
    cells = []
    for hz, place in dict.fromkeys((row["hz"], row["place"]) for row in rows):
        of = {row["speed"]: row for row in rows if (row["hz"], row["place"]) == (hz, place)}
        cells.append([f"{hz:g} Hz at {place:g}"] + [f"{of[speed]['mode_mm']:.2f}" if of[speed]["mode_mm"] is not None else "none" for speed in speeds])
        cells.append(["Tone"] + [f"{of[speed]['tone_mm']:.2f}" if of[speed]["tone_mm"] is not None else "none" for speed in speeds])
        cells.append(["truth"] + [f"{of[speed]['truth_mm']:.2f}" if of[speed]["truth_mm"] else "" for speed in speeds])
    lines += table(["m/s"] + [f"{speed:g}" for speed in speeds], cells)
    late = [row["late_ms"] for row in rows if row["late_ms"] is not None]
    lines += [f"{len(known)} of the {len(rows)} plucks have a truth: worst {max(known, key=abs):+.2f} dB, rms {np.sqrt(np.mean(np.square(known))):.3f} dB. "
              f"Plucks without exactly one tone: {sum(row['tones'] != 1 for row in rows)}.",
              f"`StringSounding` has the fundamental wrong by more than 1 dB after the Tone in {sum(each > 0 for each in late)} plucks, for up to "
              f"{max(late):g} ms.", ""]
    return lines + picture("loudness", "Swing of the fundamental against the speed of the finger")


def pitch(found):
    lines = ["## Glide and vibrato", "",
             "A finger of 15 mm stops the string in the air at 0.4 of its length, 5 mm down, another plucks beyond it. Then the stop glides 80 mm in 0.6 s,",
             "or rocks 6 mm to each side five times a second. Cents off the pitch of the part, f / (1 - place); of a string that stretches, f under its raised",
             "tension. Looked at in every tick from 33 ms after the tone; heard in every tenth.", ""]
    rows = []
    for name, of in found.items():
        for stretch, each in of.items():
            rows.append([f"{name}, E A {stretch} N", *(f"{each[key]:+.2f}" if key.endswith("mean") else f"{each[key]:.2f}" for key in
                                                      ("worst", "mean", "about", "heard_worst", "heard_mean", "heard_about")),
                         f"{each['messages'] / each['seconds']:.0f}"])
    lines += table(["", "told worst", "mean", "rms about it", "heard worst", "mean", "rms about it", "messages per s"], rows)
    return lines + picture("glide", "Pitch of a glide, told and heard") + picture("vibrato", "Pitch of a vibrato, told and heard")


def attacks(found):
    wrong = [each for each in found if each["wrong_ms"] > 0]
    cents = sorted({round(each["cents"]) for each in wrong})
    return ["### The first instants of a stopped tone", "",
            f"{len(found)} stops at 0.3, 0.4 and 0.6 of the length that come down with 0.05 to 0.6 m/s. The `Tone` is within "
            f"{max(abs(each['tone_cents']) for each in found):.1f} cents of the part beyond the stop. `StringSounding`",
            f"names another part than the one that was plucked after {len(wrong)} of them, for up to {max((e['wrong_ms'] for e in wrong), default=0):g} ms: "
            f"{', '.join(f'{each:+d}' for each in cents)} cents." if wrong else "`StringSounding` agrees with it from the beginning.", ""]


def harmonics(found):
    lines = ["## Harmonics", "",
             "A skin of 1 mm touches a node, with 8 and 25 mN, the string is plucked at 0.93, the skin lifted 0.12 s after. The loudest partial that is",
             "none of the harmonic's, dB below its first, 0.1 s after the lift: [truth](string_truth.md), told, heard.", ""]
    rows = []
    for force in sorted({each["force"] for each in found}):
        rows.append([f"{1e3 * force:g} mN"] + [f"{e['truth_db']:.1f}, {e['told_db']:.1f}, {e['heard_db']:+.1f}" for e in found if e["force"] == force])
    lines += table(["touched at"] + list(PART_WORDS.values()), rows)
    missed = sum(each["heard_db"] > each["told_db"] + 6 for each in found)
    lines += [f"In {missed} of {len(found)} the sound has more than 6 dB more of other partials than was told. haptic-audio follows the pitch and the loudness of "
              "`StringSounding`, not its partials:", "a harmonic is heard where the lift gives a `Tone` of its own.", ""] if missed else []
    return lines + picture("harmonics", "Spectra of harmonics, told and heard")


def touched(found):
    rows = []
    for each in found:
        rows.append([f"{'soft skin' if each['skin'] else 'firm finger'} at {each['place']:g}", f"{each['energy_db']:.1f}",
                     f"{each['told_db']:.1f}" if each["told_db"] > -100.0 else "silent",
                     f"{each['heard_db']:+.1f}", "" if each["late_ms"] is None else f"{each['late_ms']:.0f}"])
    return ["## A finger on a ringing string", "",
            "### What is heard", "",
            "An open string of 130.8 Hz rings; a finger comes down and stays, 1 mm deep, firm (1 kN/m) or with a skin of 25 N/m. From before to 0.19 s after:", "",
            *table(["", "energy dB", "loudness told dB", "heard dB", "told late by ms"], rows),
            "*Late*: from when the string has lost three quarters of its energy until half the amplitude is told.", ""]


def felt(found):
    rows = []
    for each in found:
        rows.append([f"{each['depth_mm']:g}", f"{1e3 * each['rest_n']:.0f}", f"{1e3 * each['mean_n']:.0f}", f"{1e3 * each['largest_n']:.0f}",
                     *(f"{value:.0f}" for value in each["rms_mn"]), f"{100 * each['of_force']:.0f} %", f"{100 * each['share']:.0f} %"])
    return ["### What is felt", "",
            "A finger of 1 kN/m plucks a string of 65.4 Hz at 1 m/s and comes down on it 0.35 s after, with 0.2 m/s, and stays. F_y in mN; *vibration* is what it has",
            "beyond the same way on a string that does not sound.", "",
            *table(["mm deep", "at rest", "mean of the end", "largest", "vibration rms 0-20 ms", "0-100", "100-300", "500-600", "of the force in 100 ms",
                    "of all vibration in 100 ms"], rows),
            f"The least force of all: {1e3 * min(each['least_n'] for each in found):.1f} mN; a string never pulls. The last column is of the squares, over 0.6 s.", "",
            *picture("felt", "Force on a finger that touches a ringing string")]


def laps(found):
    rows = []
    for each in found:
        rows.append([f"{each['laps']} x at {each['place']:g}, {each['way_mm']:+.0f} mm, {each['depth_mm']:g} mm deep, {each['speed_mm']:g} mm/s",
                     f"{each['work_uj']:+.2f}", f"{each['law_uj']:+.2f}", f"{each['beyond_uj']:+.1f}", f"{each['left_uj']:.2f}"])
    return ["## Laps", "",
            "A finger presses, glides along the string, lifts and returns above it, without friction. Work of the hand in uJ, by the trapezoid of the force",
            "before and after each tick: less than nothing is the hand's gain. *Beyond the law*: what a force that is held until the next tick gives the",
            "hand more than on the string that does not sound; of a silent string that is to be 50 uJ at most, however often it laps (tests/core/simulation/wave_passivity_test.cpp).", "",
            *table(["laps", "work uJ", "of the law alone", "won beyond the law", "left in the string"], rows)]


def ringing(found):
    rows = [[each["n"], f"{found['partials_mm'][each['n'] - 1]:.3f}", f"{each['due_s']:.3f}", f"{each['told_s']:.3f}", f"{each['heard_s']:.3f}"]
            for each in found["decays"] if found["partials_mm"][each["n"] - 1] > 1e-3]
    return ["## Decay", "",
            f"A silk string as the lowest of the Guqin, plucked at 0.23 with 1 m/s. Decay times to 1/e; {found['messages']} `StringSounding` in 2.5 s.", "",
            *table(["partial", "told mm", "of the scene s", "told s", "heard s"], rows),
            *picture("ringing", "Sound of a plucked string, and how its partials decay"),
            "Below: before the finger lets go, the string as States have it, two straight pieces under the static law; after it, the twelve partials that are",
            "told, with their phases.", "",
            *picture("shape", "Shape of the string before and after the finger lets go")]


def phrase(found):
    return ["## A phrase", "",
            f"[phrase.wav](one_string/phrase.wav), {found['seconds']:.1f} s: an open C3, touched while it rings and plucked as a harmonic, lifted, stopped, plucked, a glide,",
            f"plucked anew, a vibrato, lifted, pressed down behind a fret and plucked. {found['tones']} tones and {found['messages']} `StringSounding`. "
            f"Of {found['looked']} instants at which the sound has a pitch, "
            f"{100 * found['within_10_cents']:.0f} % are within 10 cents of what was told.", "",
            *picture("phrase", "Pitch of the phrase, told and heard")]


def cost(found, reference):
    rows = [[what, f"{count:.0f}", f"{count / found[reference]:.2f}"] for what, count in found.items()]
    return ["## Cost", "",
            "Instructions of a tick of the daemon's loop by callgrind, all of it, mean of 200 ticks. The fingers press 2 mm and go up and down by 0.5 mm. E A is 2 kN but",
            "for the string that does not stretch.", "",
            *table(["", "instructions", f"of {reference}"], rows)]


def known_db(row):
    """Of the plucks that have one tone."""
    return [each for each in row["off_db"] if each is not None]


def quality_row(row, usual):
    """Of the table of knobs."""
    off, cents = known_db(row), row["stopped_cents"]
    return [f"{row['modes']}/{row['substeps']}", f"{max(off, key=abs):+.2f}", f"{np.sqrt(np.mean(np.square(off))):.3f}", len(row["off_db"]) - len(off),
            f"{max(cents, key=abs):+.1f}", f"{np.mean(cents):+.1f}", f"{row['instructions']:.0f}", f"{row['instructions'] / usual['instructions']:.2f}"]


def half_the_cost(rows, usual):
    """What the most exact of the knobs gives that cost about half as much, in a sentence."""
    cheap = [row for row in rows if row["instructions"] <= 0.55 * usual["instructions"]]
    if not cheap:
        return "None of them costs half as much."
    best = min(cheap, key=lambda row: max(map(abs, known_db(row))))
    off, before = (max(map(abs, known_db(row))) for row in (best, usual))
    flat, flat_before = (max(map(abs, row["stopped_cents"])) for row in (best, usual))
    return (f"For {best['instructions'] / usual['instructions']:.2f} of its cost `wave {{ modes: {best['modes']} substeps: {best['substeps']} }}` is off by up to "
            f"{off:.2f} dB instead of {before:.2f}, and stopped by up to {flat:.1f} cents instead of {flat_before:.1f}.")


def quality(found, usual_knobs):
    usual = next(row for row in found["knobs"] if (row["modes"], row["substeps"]) == usual_knobs)
    rows = [[row["what"], ", ".join(f"{each:+.1f}" for each in row["stopped_cents"]), ", ".join(f"{each:+.1f}" for each in row["rise_cents"]),
             f"{row['instructions']:.0f}"] for row in found["tension"]]
    return ["## Quality", "",
            "`wave` has two knobs, modes and sub-steps of a millisecond. Level of the fundamental of 30 of the plucks above beside the truth, dB, worst and rms, and",
            "how many of them have not exactly one tone; pitch of a string of 65.4 Hz stopped at 0.3, 0.4 and 0.6, by how the force on the finger that stops it",
            "swings from 0.3 s after its tone on, in cents off the closed form of a string between its ends and a spring of 20 kN/m, worst and mean; instructions of",
            "a tick with one finger on a string of E A 2 kN, and as a share of the default's. The truth is printed to 1 um, up to 0.03 dB of the softest pluck.", "",
            *table(["modes/sub-steps", "worst dB", "rms dB", "not one tone", "stopped worst cents", "mean", "instructions", "of the default's"],
                   [quality_row(row, usual) for row in found["knobs"]]),
            f"{usual['modes']}/{usual['substeps']} is the default. {half_the_cost(found['knobs'], usual)}", "",
            "The tension of a string follows how it is bent if it has an axial stiffness E A, and its mean swing if the scene has `pitch_glide`. At the three places:",
            "cents off the closed form with the tension that the string then has, and how much that raises its pitch, which a string without E A lacks.", "",
            *table(["", "stopped, cents", "raised by, cents", "instructions"], rows)]


def failures(figures):
    """What does not hold of what a player may expect."""
    found = []

    def hold(holds, words):
        if not holds:
            found.append(words)
    known = [abs(decibels(row["mode_mm"], row["truth_mm"])) for row in figures["loudness"]["rows"] if row["truth_mm"]]
    hold(max(known) <= LOUDNESS_DB, f"a pluck is {max(known):.2f} dB off the truth")
    ways = [each for of in figures["pitch"].values() for each in of.values()]
    hold(max(each["worst"] for each in ways) <= TOLD_CENTS, "a pitch told is more than 5 cents off")
    hold(max(each["heard_worst"] for each in ways) <= HEARD_CENTS, "a pitch heard is more than 8 cents off")
    wrong = sum(each["wrong_ms"] > 0 for each in figures["attacks"])
    hold(not wrong, f"{wrong} of {len(figures['attacks'])} stopped tones are first told as the part that was not plucked")
    tones = figures["harmonics"]
    hold(all(e["told_db"] <= max(-20.0, e["truth_db"] + HARMONIC_DB) for e in tones), "a harmonic that is told has partials that the truth has not")
    missed = sum(e["heard_db"] > e["told_db"] + HEARD_DB for e in tones)
    hold(not missed, f"{missed} of {len(tones)} harmonics are not heard as they are told")
    loud = [e["heard_db"] - max(e["told_db"], SILENT_DB) for e in figures["touched"]]
    hold(max(map(abs, loud)) <= HEARD_DB, f"a string that a finger damps is heard up to {max(loud):.0f} dB louder than told")
    slow = [e for e in figures["laps"] if e["laps"] == 1 and e["speed_mm"] <= 50]
    gain = min(e["work_uj"] for e in slow)
    hold(max(abs(e["work_uj"]) for e in slow) <= LAP_UJ, f"a slow lap gives the hand {-gain:.1f} uJ, not 5 at most")
    won = max(e["beyond_uj"] for e in figures["laps"])
    hold(won <= WON_UJ, f"{max(e['laps'] for e in figures['laps'])} laps over a silent string give the hand {won:.0f} uJ beyond its law, not 50 at most")
    hold(min(e["least_n"] for e in figures["felt"]) >= 0, "a string pulls the finger")
    return found


def wrapped(lines):
    """Paragraphs broken anew; headings, tables and pictures as they are."""
    paragraph, kept = [], []
    for line in [*lines, ""]:
        if line and not line.startswith(("#", "|", "![", "- ")):
            paragraph.append(line)
            continue
        if paragraph:
            kept += textwrap.wrap(" ".join(paragraph), WIDTH, break_long_words=False, break_on_hyphens=False)
            paragraph = []
        kept.append(line)
    return kept


def write(figures, reference, usual_knobs):
    """The page. `reference`: what costs are compared with; `usual_knobs`: the default."""
    lines = head(figures)
    wrong = failures(figures)
    lines += ["Not held:", "", *(f"- {each}" for each in wrong), ""] if wrong else ["Held.", ""]
    for part in (loudness, pitch, attacks, harmonics, touched, felt, laps, ringing, phrase):
        lines += part(figures[part.__name__])
    lines += cost(figures["cost"], reference) + quality(figures["quality"], usual_knobs)
    PAGE.write_text("\n".join(wrapped(lines)).rstrip() + "\n", encoding="utf-8")
