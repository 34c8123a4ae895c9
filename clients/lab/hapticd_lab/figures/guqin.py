"""F1, F8 and F15 to F18: the hand at the Guqin."""
from __future__ import annotations

from typing import Any, List

import numpy
from scipy import signal

from hapticd.v1 import gesture_pb2
from hapticd_lab import plots, smoothness
from hapticd_lab.figure import NUMBER, Figure, Spec, at_least, at_most, is_so
from hapticd_lab.lab import Lab
from hapticd_lab.player import Setup
from hapticd_lab.row import DEEPEST_M, Row, only_claim, play_row, together_claim
from hapticd_lab.string_law import values_of
from hapticd_lab.trace import Trace

SCENE = "guqin"
BODY = "guqin_body"
PLAYED = "G2"
RIPPLE = 0.02
TAP_SPEEDS = (0.1, 0.2, 0.4, 0.6, 0.8, 1.0, 1.204, 3.0, 10.0, 30.0, 100.0)
PAPER_FASTEST = 1.204


def tones(trace: Trace) -> List[Any]:
    """Tone events, in order."""
    return [event.body for event in trace.events if event.kind == "tone"]


def _names(trace: Trace) -> List[str]:
    return [trace.strings[tone.string_index].name for tone in tones(trace)]


def _tone_table(figure: Figure, trace: Trace) -> None:
    figure.tables["Tones, in the paper's model"] = [["time, s", "string", "frequency, Hz", "amplitude, mm", "level", "hitting speed, m/s"]] + [
        [f"{tone.t_ns * 1e-9 - trace.began_s:.3f}", trace.strings[tone.string_index].name, f"{tone.frequency_hz:.1f}",
         f"{tone.amplitude_m * 1e3:.2f}", f"{tone.level:.3f}", f"{tone.normal_speed_m_per_s:.2f}"] for tone in tones(trace)]


def _order_claim(figure: Figure, trace: Trace, *names: str) -> None:
    found = _names(trace)
    figure.claims.append(is_so("The strings sound in the order they are left", found == list(names), " ".join(found) or "none", " ".join(names)))
    _tone_table(figure, trace)


def f1(lab: Lab, figure: Figure) -> None:
    """The scene, and the paper's numbers in it."""
    strings = lab.play(Setup(SCENE), lab.poses("press", SCENE)[:10]).strings
    slenderness = [float(numpy.linalg.norm(numpy.subtract(string.p_wb_m, string.p_wa_m))) / string.radius_m for string in strings]
    figure.claims.append(is_so("It has seven strings", len(strings) == 7, str(len(strings)), "7", source=NUMBER))
    figure.claims.append(at_least("Each is longer than 1000 times its radius: smallest ratio", min(slenderness), 1000.0, "", source=NUMBER))
    reference = all(string.tension_n == 30.0 for string in strings)
    figure.claims.append(is_so("Tension is the reference value", reference, "yes" if reference else "no", "30 N", source=NUMBER))
    reference = all(not string.HasField("axial_stiffness_n") and string.youngs_modulus_pa == 1.9e11 for string in strings)
    figure.claims.append(is_so("Modulus is the reference value", reference, "yes" if reference else "no, E A is given", "1.9e11 N/m^2", source=NUMBER))
    figure.claims.append(at_most("The thinnest has the reference radius: difference", abs(min(string.radius_m for string in strings) - 3.4e-4) * 1e6, 0.01, "um",
                                 source=NUMBER))
    figure.tables["Strings"] = [["string", "length, m", "radius, mm", "length over radius", "tuning, Hz", "E A, N"]] + [
        [string.name, f"{ratio * string.radius_m:.4f}", f"{string.radius_m * 1e3:.4f}", f"{ratio:.0f}", f"{string.frequency_hz:.1f}",
         f"{values_of(string).axial_stiffness_n:.0f}"]
        for string, ratio in zip(strings, slenderness)]


def f8(lab: Lab, figure: Figure) -> None:
    """Body and two strings at once, left in turn."""
    row = play_row(lab, figure, SCENE, "hybrid_contact")
    figure.claims.append(together_claim(row.paper, BODY, "G2", "A2"))
    last = {name: int(numpy.flatnonzero(row.paper.touched(name))[-1]) for name in (BODY, "G2", "A2") if row.paper.touched(name).any()}
    left = sorted(last, key=last.get)
    figure.claims.append(is_so("Each is left by itself: never two in the same tick", len(last) == 3 and len(set(last.values())) == 3,
                               ", ".join(f"{name} at {row.paper.t_s[last[name]]:.3f} s" for name in left), "three instants"))
    _tone_table(figure, row.paper)


def _ripple_claim(figure: Figure, trace: Trace, name: str) -> None:
    rows = smoothness.longest_touch(trace, name)
    figure.claims.append(at_most("The force is smooth while it slides: rms above 30 Hz over the mean", 100.0 * smoothness.ripple(trace, rows),
                                 100.0 * RIPPLE, "%"))


def f15a(lab: Lab, figure: Figure) -> None:
    """On the body."""
    row = play_row(lab, figure, SCENE, "slide_on_body")
    figure.claims.append(only_claim(row.paper, BODY))
    _ripple_claim(figure, row.paper, BODY)
    figure.claims.append(is_so("No string sounds", not tones(row.paper), str(len(tones(row.paper))), "none"))


def f15b(lab: Lab, figure: Figure) -> None:
    """Pressing."""
    row = play_row(lab, figure, SCENE, "press")
    figure.claims.append(only_claim(row.paper, PLAYED))
    force = row.paper.force_n
    most = int(numpy.argmax(numpy.linalg.norm(force, axis=1)))
    figure.claims.append(at_least("The force is largest in +y: its y component over its amount where it is largest",
                                  float(force[most, 1] / numpy.linalg.norm(force[most])), 0.99, ""))
    deepest = int(numpy.argmin(row.paper.p_wh_m[:, 1]))
    figure.claims.append(at_least("It is largest where the finger is deepest: force there over the largest",
                                  float(force[deepest, 1] / force[:, 1].max()), 0.999, ""))


def f15c(lab: Lab, figure: Figure) -> None:
    """Lifting from beneath."""
    row = play_row(lab, figure, SCENE, "lift_from_beneath")
    figure.claims.append(only_claim(row.paper, PLAYED))
    touched = row.paper.touched(PLAYED)
    figure.claims.append(at_most("The force of the string is downward all the time: its largest y component",
                                 float(row.paper.force_n[touched, 1].max(initial=-numpy.inf)), 0.0, "N"))
    figure.claims.append(at_most("The largest force in y is downward", float(row.paper.force_n[:, 1].min()), -0.5, "N"))


def _ends_at_rest(trace: Trace) -> float:
    """Largest force after the last contact."""
    touched = numpy.flatnonzero(numpy.any([trace.touched(name) for name in trace.object_force_n], axis=0))
    after = trace.force_n[touched[-1] + 2:] if len(touched) else trace.force_n
    return float(numpy.linalg.norm(after, axis=1).max(initial=0.0))


def f15d(lab: Lab, figure: Figure) -> None:
    """Across several strings."""
    row = play_row(lab, figure, SCENE, "sweep")
    trace = row.paper
    all_strings = [string.name for string in trace.strings]
    figure.claims.append(only_claim(trace, *all_strings))
    _order_claim(figure, trace, *all_strings, *all_strings)
    ringing = numpy.zeros(len(trace), bool)
    for name, phase in trace.string_phase.items():
        ringing |= (phase == 3) & ~trace.touched(name)
    figure.claims.append(at_least("Strings vibrate on after the contact", float(ringing.sum()), 500, "ticks"))
    vibration = numpy.linalg.norm(trace.unlimited_force_n - sum(trace.object_force_n.values()), axis=1)
    second = trace.t_s > trace.t_s[numpy.flatnonzero(trace.touched(all_strings[-1]))[0]] + 0.05
    figure.claims.append(at_least("Strings that still vibrate are felt when they are touched again: largest vibration force of the second stroke",
                                  float(vibration[second].max(initial=0.0)), 0.02, "N"))
    figure.claims.append(at_most("It converges: no force after the last contact", _ends_at_rest(trace), 0.0, "N"))


def f15e(lab: Lab, figure: Figure) -> None:
    """Along one string."""
    row = play_row(lab, figure, SCENE, "slide_along")
    figure.claims.append(only_claim(row.paper, PLAYED))
    rows = smoothness.longest_touch(row.paper, PLAYED, 0)
    touched = row.paper.touched(PLAYED)
    figure.claims.append(is_so("Contact is kept all the way", int(touched.sum()) == rows.stop - rows.start,
                               f"{rows.stop - rows.start} of {int(touched.sum())} ticks in one piece", "one piece"))
    _ripple_claim(figure, row.paper, PLAYED)


def f16(lab: Lab, figure: Figure) -> None:
    """Extreme presses."""
    row = play_row(lab, figure, SCENE, "extreme_presses", every_tick=False)
    deepest = float(numpy.linalg.norm(row.paper.p_wh_m - row.paper.p_wg_m, axis=1).max())
    figure.claims.append(at_least("The hand is led far past what it presses: largest way between hand and tool", deepest * 1e3, 10.0, "mm"))
    figure.notes.append("So deep the bounds of the other figures are left. Beside its end the string of Eq. 10 to 12 is stiffer than the coupling, so the "
                        "force changes by more than the coupling times the motion. The pad slips on within its contact, and where it snaps on over a string "
                        "the reference may do so a tick earlier. What a string bent by 15 mm gives back to a light hand in ticks of 1 ms is more than was put "
                        "in, which the safety stage takes out.")


def _vibration(trace: Trace, name: str) -> numpy.ndarray:
    """n x 3, what the force has beyond the repulsion of all objects: F_v."""
    return trace.unlimited_force_n - sum(trace.object_force_n.values())


def f17(lab: Lab, figure: Figure) -> None:
    """At rest, then vibrating."""
    row = play_row(lab, figure, SCENE, "static_then_vibrating")
    trace = row.paper
    tone = tones(trace)[0]
    released = int(numpy.searchsorted(trace.t_s, tone.t_ns * 1e-9 - trace.began_s))
    press = slice(0, int(numpy.argmax(trace.force_n[:released, 1])))
    dips = numpy.diff(trace.force_n[press, 1]).min(initial=0.0)
    figure.claims.append(at_least("Pressed at rest, the force rises without a dip: smallest change per tick", float(dips) * 1e3, -1.0, "mN"))
    drop = trace.force_n[released - 12:released + 3, 1]
    figure.claims.append(at_most("Left suddenly, it drops at once: time from nine tenths to one tenth",
                                 1e3 * float(numpy.sum((drop < 0.9 * drop.max()) & (drop > 0.1 * drop.max()))) * 1e-3, 10.0, "ms"))
    again = numpy.flatnonzero(trace.touched(PLAYED) & (numpy.arange(len(trace)) > released + 20))
    wave = _vibration(trace, PLAYED)[again[0]:again[-1] + 1, 1]
    _spectrum_claims(lab, figure, wave, tone)
    figure.claims.append(at_most("Once the vibration has decayed the force is smooth: rms of the last half second above 30 Hz, over the mean",
                                 100.0 * smoothness.ripple(trace, slice(again[-1] - 900, again[-1] - 400)), 2.0, "%"))
    figure.claims.append(at_least("The vibration is on F_y and F_z, as the string is touched from above: share of F_y and F_z",
                                  _share_across(trace, again), 0.999, ""))
    figure.notes.append("A tick each millisecond samples a vibration of 98 Hz ten times a period: on the curve it looks like the teeth of a saw.")


def _share_across(trace: Trace, again: numpy.ndarray) -> float:
    wave = _vibration(trace, PLAYED)[again]
    return float(numpy.sqrt(numpy.sum(wave[:, 1:] ** 2) / numpy.sum(wave ** 2)))


def _spectrum_claims(lab: Lab, figure: Figure, wave: numpy.ndarray, tone: Any) -> None:
    spectrum = numpy.abs(numpy.fft.rfft(wave * numpy.hanning(len(wave)), 8 * len(wave)))
    frequencies = numpy.fft.rfftfreq(8 * len(wave), 1e-3)
    peak = float(frequencies[spectrum[frequencies > 20].argmax() + int(numpy.sum(frequencies <= 20))])
    figure.claims.append(at_most("The vibration on the force is at the string's frequency: difference", abs(peak / tone.frequency_hz - 1.0) * 100.0,
                                 1.0, "%", f"{peak:.2f} Hz, the string's is {tone.frequency_hz:.2f} Hz"))
    envelope = numpy.abs(signal.hilbert(wave))
    fit = slice(100, 1100)
    times = numpy.arange(len(wave)) * 1e-3
    slope = numpy.polyfit(times[fit], numpy.log(numpy.maximum(envelope[fit], 1e-12)), 1)[0]
    figure.claims.append(at_most("It decays with T_d: difference of the time constant", abs(-1.0 / slope / tone.decay_s - 1.0) * 100.0, 5.0, "%",
                                 f"{-1.0 / slope:.4f} s, T_d is {tone.decay_s:.4f} s", NUMBER))
    plots.lines("F17: what the force has beyond the repulsion, touching the vibrating string", [
        plots.Panel("time since the touch, s", "F_v in y, N", [plots.Line("F_v", times[:600], wave[:600], "-")]),
        plots.Panel("frequency, Hz", "amplitude", [plots.Line("spectrum", frequencies[frequencies < 300], spectrum[frequencies < 300], "-")],
                    marks={"the string's frequency": tone.frequency_hz})]).save(lab.folder / "vibration")
    figure.pictures["vibration.svg"] = "F_v in the first 0.6 s of the touch, and its spectrum"


def at_speed(lab: Lab, name: str, speed: float) -> gesture_pb2.Gesture:
    """A gesture of which every stroke that has a speed has this one, m/s."""
    gesture = lab.gesture(name)
    for waypoint in gesture.tracks[0].waypoints:
        if waypoint.HasField("speed_m_per_s"):
            waypoint.speed_m_per_s = speed
    return gesture


def f18(lab: Lab, figure: Figure) -> None:
    """Taps, faster and faster."""
    play_row(lab, figure, SCENE, "tap")
    table = [["speed, m/s", "path in anything, um", "largest change over its bound", "largest force, N", "first touch at, s", "tones"]]
    worst = 0.0
    for speed in TAP_SPEEDS:
        poses = lab.poses(at_speed(lab, "tap", speed), SCENE)
        name = f"tap at {speed:g} m/s"
        trace = lab.play(Setup(SCENE), poses, "tap", timed=speed == PAPER_FASTEST)
        judged = lab.judge("tap", trace)
        tap = Row(SCENE, "tap", poses, trace, judged, judged.losses())
        change = smoothness.force_changes(trace, tap.slip_rows)
        worst = max(worst, judged.penetration_m)
        touched = numpy.flatnonzero(trace.touched(PLAYED))
        table.append([f"{speed:g}", f"{judged.penetration_m * 1e6:.3f}", f"{change.worst:.2f}",
                      f"{numpy.linalg.norm(trace.force_n, axis=1).max():.2f}", f"{trace.t_s[touched[0]]:.3f}" if len(touched) else "never",
                      " ".join(_names(trace))])
        if speed == PAPER_FASTEST:
            figure.runs[name] = trace
        figure.claims.append(at_most(f"The force is smooth in a {name}: largest change over what the motion explains", change.worst, 1.0, ""))
        figure.claims.append(at_least(f"The string is touched in a {name}", float(len(touched)), 50, "ticks"))
    figure.tables["Taps by speed, in the paper's model"] = table
    figure.claims.append(at_most("No pop-through from 0.1 to 100 m/s: deepest path in anything", worst * 1e6, DEEPEST_M * 1e6, "um",
                                 "the paper goes up to 1.204 m/s", NUMBER))


SPECS = [
    Spec("F1", "A seven-string instrument and a hand", "a Guqin: a body of complex shape, seven strings more than 1000 times as long as thick, a hand", f1, 2.0),
    Spec("F8", "Hybrid contact", "the hand touches body and strings at once and leaves each in turn", f8, 60.0),
    Spec("F15a", "On the body", "the index finger slides on the body, strings untouched: smooth force", f15a, 40.0),
    Spec("F15b", "Pressing a string", "continuous; the force is largest in +y", f15b, 30.0),
    Spec("F15c", "Lifting a string", "the finger beneath a string lifts it: continuous; the force in y is negative", f15c, 40.0),
    Spec("F15d", "Across the strings", "strings vibrate on; a decaying vibration on the force; it converges; tones start", f15d, 30.0),
    Spec("F15e", "Along a string", "contact is kept; the force is continuous again", f15e, 40.0),
    Spec("F16", "Extremes", "no pop-through", f16, 40.0),
    Spec("F17", "At rest and vibrating", "smooth rise, abrupt drop; a saw-tooth on F_y and F_z that decays", f17, 50.0),
    Spec("F18", "Taps up to 1204 mm/s", "continuous; no pop-through; every tick below 1 ms", f18, 40.0),
]
