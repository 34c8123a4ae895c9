"""What is played for the page and its pictures, and what comes of it: each measure gives plain numbers. Truths are closed forms, which stand
here, and the grid's figures in tests/results/string_truth.md."""
import math
import re

import hearing
import numpy as np
from playing import LENGTH_M, ROOT, STRING_M, TENSION_N, TICK_NS, Hand, String, line, place_of, reckoned_hz, together, x_of

TIP_M, STOP_TIP_M = 0.005, 0.015
REACH_M, STOP_REACH_M = TIP_M + STRING_M, STOP_TIP_M + STRING_M
KT = 1000.0
SPEEDS = (0.3, 0.35, 0.4, 0.45, 0.5, 0.6, 0.7, 0.8, 0.9, 1.0, 1.2, 1.5, 2.0, 2.5, 3.0)
PLUCKED = ((65.4, 0.1), (65.4, 0.25), (65.4, 0.5), (146.8, 0.1), (146.8, 0.25), (146.8, 0.5))
STOP_AT, PLUCK_AT, STOP_DEPTH_M = 0.4, 0.9, 0.005
STRETCHES_N = (0.0, 3000.0)  # none, and twisted silk as the lowest string of the Guqin
HARMONICS, TOUCHES_N = (2, 3, 4, 5), (8e-3, 25e-3)


def partials_at(told, t_ns):
    """Amplitudes of the partials of a message, m, at a later instant."""
    since = 1e-9 * (t_ns - told.t_ns)
    return np.array([a * math.exp(-since / d) for a, d in zip(told.partials_m, told.decays_s)])


def pluck_rows(share, speed, height=3e-3):
    """Straight across the string as string_truth.md does it, and away."""
    start = (x_of(share), height, -12e-3)
    rows = [start] + [(start[0], height, start[2] + 1e-3 * speed * (k + 1)) for k in range(math.ceil(72 / speed))]
    return rows + [rows[-1]] * 30


def true_levels():
    """{(Hz, place, m/s): mode 1, mm} of string_truth.md."""
    text = (ROOT / "tests/results/string_truth.md").read_text(encoding="utf-8")
    speeds = [float(each) for each in re.search(r"^\| m/s \|(.*)\|$", text, re.MULTILINE)[1].split("|")]
    rows = re.findall(r"^\| ([\d.]+) Hz at ([\d.]+) \|(.*)\|$", text, re.MULTILINE)
    return {(float(hz), float(share), speed): float(level) for hz, share, levels in rows for speed, level in zip(speeds, levels.split("|"))}


def first_mode(tone):
    """Amplitude of mode 1, m: that of the Tone is of a fundamental with the energy of all partials."""
    shares = np.array(tone.partials)
    return tone.amplitude_m * shares[0] / math.sqrt(np.sum((np.arange(1, len(shares) + 1) * shares) ** 2))


def late_ms(take, tone):
    """For how long after the Tone StringSounding has its first partial wrong by more than 1 dB, ms."""
    wrong = 0
    for us in range(0, 100000, 500):
        told = [each for each in take.told if each.t_ns <= tone.t_ns + us * 1000]
        if told and abs(20 * math.log10(max(told[-1].partials_m, default=1e-9) / first_mode(tone))) > 1:
            wrong += 1
    return 0.5 * wrong


def loudness(stage):
    """Of single plucks: what the Tone says, mm."""
    truth, rows = true_levels(), []
    for hz, share in PLUCKED:
        for speed in SPEEDS:
            take = stage.play([Hand(pluck_rows(share, speed))], [String(hz=hz)], sections=("TOOLS",))
            tone = take.tones[0] if len(take.tones) == 1 else None
            rows.append({"hz": hz, "place": share, "speed": speed, "tones": len(take.tones), "tone_mm": 1e3 * tone.amplitude_m if tone else None,
                         "mode_mm": 1e3 * first_mode(tone) if tone else None, "truth_mm": truth.get((hz, share, speed)),
                         "late_ms": late_ms(take, tone) if tone else None})
    return {"rows": rows}


def held_tension(share, stretch_n, depth=STOP_DEPTH_M):
    """Of a string that a spring of KT presses `depth` below where it rests, N."""
    curve = 1 / (share * LENGTH_M) + 1 / ((1 - share) * LENGTH_M)
    low, high = 0.0, depth
    for _ in range(60):
        bent = 0.5 * (low + high)
        tension = TENSION_N + stretch_n / LENGTH_M * 0.5 * bent * bent * curve
        low, high = (bent, high) if bent + tension * bent * curve / KT < depth else (low, bent)
    return tension


def held_hz(hz, share, stretch_n, depth=STOP_DEPTH_M):
    """Of the part from a stop at `share` to B, with the tension that it then has."""
    return hz / (1 - share) * math.sqrt(held_tension(share, stretch_n, depth) / TENSION_N)


def stopped(places, share=STOP_AT, speed=0.16):
    """Hands that stop the string at `share`, pluck it beyond, and then have the stop at `places`, one a tick; the tick of the first place."""
    low = STOP_REACH_M - STOP_DEPTH_M
    stop = line((x_of(share), STOP_REACH_M + 0.015, 0.0), (x_of(share), low, 0.0), speed) + [(x_of(share), low, 0.0)] * 200
    level = REACH_M - 2.5e-3 - 0.8 * STOP_DEPTH_M * (1 - PLUCK_AT) / (1 - share)
    pluck = [(x_of(PLUCK_AT), 0.02, -0.03)] * len(stop) + line((x_of(PLUCK_AT), level, -0.03), (x_of(PLUCK_AT), level, 0.03), 0.8)
    stop, pluck = together(stop, pluck)
    first = len(stop)
    stop += [(x_of(each), low, 0.0) for each in places]
    stop, pluck = together(stop, pluck + [(x_of(PLUCK_AT), 0.03, 0.03)])
    return [Hand(stop, radius=STOP_TIP_M), Hand(pluck)], first


def ways():
    """{name: places of the stop along the string, one a tick}"""
    def glide(way):
        return [STOP_AT + way / LENGTH_M * min(1.0, max(0, k - 100) / 600) for k in range(1000)]
    return {"glide up": glide(0.08), "glide down": glide(-0.08),
            "vibrato": [STOP_AT + 0.006 / LENGTH_M * math.sin(2e-3 * math.pi * 5 * k) for k in range(1400)]}


def follow(stage, places, stretch_n):
    """How a stop that moves is told and heard."""
    hands, first = stopped(places)
    take = stage.play(hands, [String(decay_s=2.0, loss_n2=0.002, stretch_n=stretch_n)], sections=("TOOLS",), record=True)
    sound = stage.render(take)
    tone = take.tones[0]
    told = [each for each in take.told if each.t_ns >= tone.t_ns]
    due = np.array([held_hz(65.4, share, stretch_n) for share in places])
    instants = [(first + k) * TICK_NS for k in range(len(places))]
    reckoned = np.array([reckoned_hz(told, t) for t in instants])
    looked = range(60, len(places) - 60, 10)
    heard = [hearing.hz_near(sound, 48000, 1e-9 * (instants[k] - take.begin_ns), due[k]) for k in looked]
    off, off_heard = hearing.cents(reckoned, due), hearing.cents(np.array(heard), due[list(looked)])
    return {"due": due.tolist(), "told": reckoned.tolist(), "heard": heard, "heard_ms": list(looked), "messages": len(told),
            "seconds": 1e-3 * len(places),
            "worst": float(np.max(np.abs(off))), "mean": float(np.mean(off)), "about": float(np.std(off)),
            "heard_worst": float(np.max(np.abs(off_heard))), "heard_mean": float(np.mean(off_heard)), "heard_about": float(np.std(off_heard))}


def pitch(stage):
    return {name: {f"{stretch:g}": follow(stage, places, stretch) for stretch in STRETCHES_N} for name, places in ways().items()}


def attacks(stage):
    """How long after its Tone a stopped string is told at another pitch than its part has, for stops that come down at several speeds."""
    found = []
    for speed in (0.05, 0.1, 0.13, 0.16, 0.2, 0.3, 0.4, 0.6):
        for share in (0.3, 0.4, 0.6):
            hands, _ = stopped([share] * 200, share, speed)
            take = stage.play(hands, [String(decay_s=2.0, loss_n2=0.002)], sections=("TOOLS",))
            tone, due = take.tones[0], 65.4 / (1 - share)
            instants = [tone.t_ns + us * 1000 for us in range(0, 100000, 250)]
            off = [float(hearing.cents(reckoned_hz(take.told, t), due)) for t in instants if take.told[0].t_ns <= t]
            wrong = [each for each in off if abs(each) > 50]
            found.append({"speed_mm": 1e3 * speed, "place": share, "wrong_ms": 0.25 * len(wrong), "cents": max(wrong, key=abs, default=0.0),
                          "tone_cents": float(hearing.cents(tone.frequency_hz, due))})
    return found


def harmonic_hands(part, force_n, seconds):
    """A skin of 1 mm at 1 / part, a pluck at 0.93 with 1 m/s, the lift with 30 mm/s 120 ms after; the tick of the lift."""
    lift = 40 + 8 + 120
    ticks = lift + round(1e3 * seconds)
    x = x_of(1 / part)
    touch = [(x, REACH_M - 1e-3 + 0.05e-3 * max(0, 40 - k) + 30e-6 * max(0, k - lift), 0.0) for k in range(ticks)]
    pluck = [(x_of(0.93), 3e-3, -8e-3 + 1e-3 * max(0, k - 40)) for k in range(ticks)]
    return [Hand(touch, skin=(1e3 * force_n, 0.2)), Hand(pluck)], lift


def loudest_other(levels, part):
    """The loudest partial that is none of the harmonic's, dB below its first, and which it is."""
    n = np.arange(1, len(levels) + 1)
    other = n % part != 0
    which = int(n[other][np.argmax(levels[other])])
    return 20 * math.log10(levels[which - 1] / levels[part - 1]), which


def true_harmonics():
    """{(N, part): dB} of string_truth.md."""
    text = (ROOT / "tests/results/string_truth.md").read_text(encoding="utf-8")
    rows = re.findall(r"^\| (\d+) \| 880 \|(.*)\|$", text[text.index("touch mN"):], re.MULTILINE)
    return {(1e-3 * float(force), part): float(cells.split("|")[2 * i + 1]) for force, cells in rows for i, part in enumerate(HARMONICS)}


def harmonics(stage):
    """What is told and heard 0.1 s after a light finger was lifted."""
    truth, found = true_harmonics(), []
    for force in TOUCHES_N:
        for part in HARMONICS:
            hands, lift = harmonic_hands(part, force, 1.0)
            take = stage.play(hands, [String(decay_s=0.5, loss_n2=0.002)], sections=("TOOLS",), record=True)
            sound = stage.render(take)
            t_ns = (lift + 100) * TICK_NS
            at_s = 1e-9 * (t_ns - take.begin_ns)
            told = partials_at([each for each in take.told if each.t_ns <= t_ns][-1], t_ns)
            # Heard is the force at the bridge, in which partial n weighs n times as much as in the string's motion.
            heard = np.array([hearing.level(sound, 48000, at_s, 65.4 * n, 0.5) / n for n in range(1, 25)])
            hz, db = hearing.spectrum(sound, 48000, at_s, at_s + 0.5, 800)
            told_db, told_which = loudest_other(told, part)
            heard_db, heard_which = loudest_other(heard, part)
            found.append({"part": part, "force": force, "truth_db": truth[force, part], "told_db": told_db, "told_which": told_which,
                          "heard_db": heard_db, "heard_which": heard_which, "told": told.tolist(),
                          "heard_hz": float(hearing.hz_near(sound, 48000, at_s + 0.25, 65.4 * part, 0.4, 0.02)),
                          "tones": len(take.tones), "hz": hz[::2].tolist(), "db": db[::2].tolist()})
    return found


def work(forces, states):
    """Of the hand, J, by the trapezoid of the force before and after each tick."""
    moved = np.diff([state.tools[0].p_wh_m for state in states], axis=0)
    return float(-np.sum(0.5 * (forces[1:] + forces[:-1]) * moved))


def beyond(one, other):
    """What a hand wins of a force that is held until the next tick beyond what it wins of another, J."""
    moved = np.diff([state.tools[0].p_wh_m for state in one.states], axis=0)
    return float(np.sum((one.forces() - other.forces())[:-1] * moved))


LAPS = (  # place, way along the string m, depth m, speed m/s, laps
    (0.3, 0.08, 5e-3, 0.02, 1), (0.3, 0.08, 5e-3, 0.05, 1), (0.3, 0.08, 5e-3, 0.2, 1), (0.3, 0.08, 10e-3, 0.05, 1), (0.4, -0.08, 5e-3, 0.05, 1),
    (0.3, 0.0, 5e-3, 0.05, 30), (0.4, -0.08, 5e-3, 0.05, 30), (0.3, 0.08, 5e-3, 0.05, 30), (0.3, 0.08, 10e-3, 0.1, 30))


def laps(stage):
    """Press, glide, lift, return: the same on a string that sounds and on one that keeps to its static law."""
    found = []
    for share, way, depth, speed, count in LAPS:
        above, low = STOP_REACH_M + 2e-3, STOP_REACH_M - depth
        a, b = (x_of(share), above, 0.0), (x_of(share), low, 0.0)
        c, d = (x_of(share) + way, low, 0.0), (x_of(share) + way, above, 0.0)
        lap = line(a, b, speed) + (line(b, c, speed) if way else []) + line(c, d, speed) + (line(d, a, 0.5) if way else [])
        rows = [a] * 5 + lap * count + [a] * 20
        sounds, law = (stage.play([Hand(rows, radius=STOP_TIP_M)], [String(decay_s=0.5, loss_n2=0.002, silent=silent)], sections=("TOOLS", "ENERGY"))
                       for silent in (False, True))
        found.append({"place": share, "way_mm": 1e3 * way, "depth_mm": 1e3 * depth, "speed_mm": 1e3 * speed, "laps": count,
                      "work_uj": 1e6 * work(sounds.forces(), sounds.states), "law_uj": 1e6 * work(law.forces(), law.states),
                      "beyond_uj": 1e6 * beyond(sounds, law), "left_uj": 1e6 * sounds.states[-1].energy.strings_j,
                      "largest_n": float(sounds.forces()[:, 1].max()), "tones": len(sounds.tones)})
    return found


DEPTHS_M = (0.1e-3, 0.3e-3, 1e-3, 3e-3)


def felt(stage):
    """A finger comes down on a string that it has plucked 0.35 s before, with 0.2 m/s, and stays: the force beside that of the same string at
    rest."""
    found = []
    for depth in DEPTHS_M:
        x, over = x_of(0.4), REACH_M + 0.01
        rows = [(x_of(0.25), 3e-3, -12e-3)]
        for goal, speed in (((x_of(0.25), 3e-3, 0.06), 1.0), ((x_of(0.25), 0.03, 0.06), 1.0), ((x, 0.03, 0.0), 5.0)):
            rows += line(rows[-1], goal, speed)
        rows += [rows[-1]] * 300
        rows += line(rows[-1], (x, over, 0.0), 1.0)
        begin = len(rows)
        rows += line(rows[-1], (x, REACH_M - depth, 0.0), 0.2)
        rows += [rows[-1]] * 600
        force, rest = (stage.play([Hand(rows)], [String(decay_s=1.0, loss_n2=0.002, silent=silent)], sections=("TOOLS",)).forces()[:, 1]
                       for silent in (False, True))
        first = begin + int(np.nonzero(force[begin:] > 0)[0][0])
        swing = force[first:first + 600] - rest[first:first + 600]

        def rms(values):
            return float(np.sqrt(np.mean(values ** 2)))
        found.append({"depth_mm": 1e3 * depth, "rest_n": float(rest[-1]), "mean_n": float(np.mean(force[-200:])), "largest_n": float(force[begin:].max()),
                      "rms_mn": [1e3 * rms(swing[a:b]) for a, b in ((0, 20), (0, 100), (100, 300), (500, 600))],
                      "share": float(np.sum(swing[:100] ** 2) / np.sum(swing ** 2)), "of_force": rms(swing[:100]) / rms(force[first:first + 100]),
                      "least_n": float(force[begin:].min()), "force": force[first - 20:first + 300].tolist(), "rest": rest[first - 20:first + 300].tolist()})
    return found


TOUCHED = ((0.5, (25.0, 0.2)), (0.3, (25.0, 0.2)), (0.5, ()), (0.3, ()))  # place, skin


def touched(stage):
    """A finger comes down on an open string that rings, with 0.1 m/s, 1 mm, and stays: loudness before and after, told and heard, dB."""
    found = []
    for share, skin in TOUCHED:
        x, pluck = x_of(share), pluck_rows(0.9, 0.8)
        touch = [(x, REACH_M + 0.01, 0.0)] * 500
        touch += line(touch[-1], (x, REACH_M - 1e-3, 0.0), 0.1)
        touch, pluck = together(touch, pluck + [pluck[-1]] * 1200)
        take = stage.play([Hand(touch, skin=skin), Hand(pluck)], [String(hz=130.8, decay_s=1.33, loss_n2=0.015, stretch_n=750.0)],
                          sections=("TOOLS", "ENERGY"), record=True)
        sound = stage.render(take)

        def told(ms):
            past = [each for each in take.told if each.t_ns <= ms * TICK_NS]
            partials = partials_at(past[-1], ms * TICK_NS)
            return float(np.linalg.norm(np.arange(1, len(partials) + 1) * partials))

        def heard(ms):
            at = round((1e-3 * ms - 1e-9 * take.begin_ns) * 48000)
            return float(np.linalg.norm(sound[at:at + 2880]))

        energy = np.array([state.energy.strings_j for state in take.states])
        after = 800
        quiet = 590 + int(np.argmax(energy[590:900] < 0.25 * energy[590]))
        late = next((k for k in range(590, 900) if told(k) < 0.5 * told(590)), 900) - quiet if skin else None
        found.append({"place": share, "skin": bool(skin), "energy_db": float(10 * np.log10(energy[after] / energy[590])),
                      "told_db": 20 * math.log10(max(told(after) / told(580), 1e-5)), "heard_db": 20 * math.log10(heard(after) / heard(530)), "late_ms": late})
    return found


SILK = {"hz": 65.4, "decay_s": 1.48, "loss_n2": 0.0075, "stretch_n": 3000.0}


def ringing(stage):
    """A pluck that rings out: levels and decays of its first partials, told and heard."""
    rows = pluck_rows(0.23, 1.0)
    string = String(**SILK)
    take = stage.play([Hand(rows + [rows[-1]] * 2500)], [string], sections=("TOOLS",), record=True)
    sound = stage.render(take)
    onset = 1e-9 * (take.tones[0].t_ns - take.begin_ns)
    first = take.told[0]
    times = np.arange(0.05, 2.0, 0.05)
    hz = 65.4 * np.arange(1, 7)
    heard = np.array([[hearing.level(sound, 48000, onset + t, each, 0.1) for each in hz] for t in times])
    decays = []
    for k in range(6):
        level = np.log(heard[:, k])
        kept = (times < 0.8) & (heard[:, k] > 1e-3 * heard.max())
        decays.append({"n": k + 1, "due_s": 1 / (1 / string.decay_s + (k + 1) ** 2 * string.loss_n2), "told_s": float(first.decays_s[k]),
                       "heard_s": float(-1 / np.polyfit(times[kept], level[kept], 1)[0])})
    return {"decays": decays, "partials_mm": [1e3 * each for each in first.partials_m], "messages": len(take.told), "times": times.tolist(),
            "heard": heard.T.tolist(), "sound": hearing.outline(sound[:round((onset + 2.4) * 48000)], 48000, -onset, 0.02)}


def shape(stage):
    """The string while a finger plucks it at 0.25, from the States, and after it has let go, from the first StringSounding."""
    take = stage.play([Hand(pluck_rows(0.25, 1.0))], [String(decay_s=1.0, loss_n2=0.002)], sections=("TOOLS", "STRINGS"))
    tone, first = take.tones[0], take.told[0]
    held = []
    for state in take.states:
        if state.strings and state.t_ns <= tone.t_ns:
            string = state.strings[0]
            held.append({"ms": 1e-6 * (state.t_ns - tone.t_ns), "place": place_of(string),
                         "y": string.deflection_w_m[1], "z": string.deflection_w_m[2]} if string.deflection_w_m else None)
    return {"held": [each for each in held if each], "place": place_of(tone), "tone_mm": 1e3 * tone.amplitude_m, "told_ms": 1e-6 * (first.t_ns - tone.t_ns),
            "partials_mm": [1e3 * each for each in first.partials_m], "phases": list(first.phases_rad), "hz": first.frequency_hz,
            "decays_s": list(first.decays_s)}
