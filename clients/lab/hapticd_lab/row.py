"""What every figure with contact goes through: the same motion in the paper's model, in the reference, beyond the paper, and by simulated hands;
and the claims that are made of each of them."""
from __future__ import annotations

from dataclasses import dataclass
from typing import List, Optional, Tuple

import numpy
from scipy import optimize

from hapticd.v1 import device_profile_pb2
from hapticd_lab import smoothness, stability
from hapticd_lab.figure import NUMBER, OURS, Claim, Figure, at_least, at_most, is_so
from hapticd_lab.judgement import Judgement
from hapticd_lab.lab import Lab, as_reference, beyond
from hapticd_lab.player import Hand, Setup
from hapticd_lab.trace import Trace

PAPER = "paper"
BEYOND = "yielding strings, friction, modes"
ARMS = ("LIGHT", "FIRM")
DELAYS_S = (0.0, 0.001, 0.002)
DEEPEST_M = 1e-6
REFERENCE_N = 0.02
TICK_US = 1000.0


@dataclass
class Row:
    """A motion as it was played. `slips`: rows and objects at which an object is lost, by the oracle."""

    scene: str
    gesture: str
    poses: numpy.ndarray
    paper: Trace
    judged: Judgement
    slips: List[Tuple[int, str]]
    beyond: Optional[Trace] = None

    @property
    def slip_rows(self) -> List[int]:
        return [row for row, _ in self.slips]


def play_row(lab: Lab, figure: Figure, scene: str, gesture: str, hands: bool = True, every_tick: bool = True) -> Row:
    """Plays the gesture and adds to the figure what is asked of all rows. `hands`: simulated hands play it too; `every_tick`: every one is
    claimed to take less than 1 ms, not most."""
    poses = lab.poses(gesture, scene)
    setup = Setup(scene, "PAPER")
    paper = lab.play(setup, poses, "paper", timed=True)
    judged = lab.judge("paper", paper)
    row = Row(scene, gesture, poses, paper, judged, judged.losses())
    figure.runs[PAPER] = paper
    add_contact_claims(figure, row)
    add_smoothness_claims(figure, row, lab.play(Setup(scene, "PAPER", as_reference), poses))
    add_cost_claims(figure, paper, every_tick)
    if paper.strings:
        row.beyond = lab.play(beyond(scene), poses, "beyond", timed=True)
        figure.runs[BEYOND] = row.beyond
        figure.claims.append(at_most("Beyond the paper's model too, the tool's path never enters anything",
                                     lab.judge("beyond", row.beyond).penetration_m * 1e6, DEEPEST_M * 1e6, "um", source=OURS))
    if hands:
        add_hand_claims(lab, figure, row)
    return row


def add_contact_claims(figure: Figure, row: Row) -> None:
    """Nothing is entered, on the whole path; who was touched when."""
    figure.claims.append(at_most("The tool's path never enters anything (exhaustive search along the whole committed path)",
                                 row.judged.penetration_m * 1e6, DEEPEST_M * 1e6, "um", "the law of the project; the paper says: no penetration"))
    table = [["object", "ticks that bear force", "from, s", "to, s", "largest force, N", "most regions", "largest force of a region, N"]]
    for name, force in row.paper.object_force_n.items():
        rows = numpy.flatnonzero(row.paper.touched(name))
        if len(rows):
            table.append([name, str(len(rows)), f"{row.paper.t_s[rows[0]]:.3f}", f"{row.paper.t_s[rows[-1]]:.3f}",
                          f"{numpy.linalg.norm(force, axis=1).max():.3f}", f"{int(row.paper.regions[name].max())}",
                          f"{row.paper.region_force_n[name].max():.3f}"])
    figure.tables["Contacts, in the paper's model"] = table
    if row.slips:
        figure.tables["Ticks in which an object is lost"] = [["time, s", "object", "change of force, N"]] + [
            [f"{row.paper.t_s[at]:.3f}", name, f"{numpy.linalg.norm(row.paper.force_n[at] - row.paper.force_n[at - 1]):.3f}"]
            for at, name in row.slips if at < len(row.paper)]


def add_smoothness_claims(figure: Figure, row: Row, reference: Trace) -> None:
    """Change per tick against its bound, and error against the reference, outside slips."""
    for what, measured in (("Force", smoothness.force_changes(row.paper, row.slip_rows)),
                           ("Torque", smoothness.torque_changes(row.paper, row.slip_rows))):
        at = measured.worst_row
        figure.claims.append(at_most(f"{what} is smooth: its largest change in a tick, over what the hand's motion explains",
                                     measured.worst, 1.0, "", f"at {row.paper.t_s[at]:.3f} s; slips left out"))
    error = smoothness.reference_error_n(row.paper, reference, row.slip_rows)
    at = int(error.argmax())
    beyond_bound = int(numpy.sum(error > REFERENCE_N))
    others = float(numpy.delete(error, at).max(initial=0.0))
    figure.claims.append(at_most("Error of the force against the reference of 400 sub-steps", float(error.max()) * 1e3, REFERENCE_N * 1e3, "mN",
                                 f"at {row.paper.t_s[at]:.3f} s; {beyond_bound} ticks beyond, the others at most {others * 1e3:.3g} mN; rms "
                                 f"{1e3 * float(numpy.sqrt(numpy.mean(error ** 2))):.3g} mN", OURS))


def predicted_cost_us(trace: Trace) -> numpy.ndarray:
    """n, what the work of each tick takes at the pace of this run: time = a + b sphere tests + c sub-steps, fitted to the thread's CPU time
    of all ticks but the slowest of a hundred, which a busy machine held up."""
    timed = numpy.isfinite(trace.cpu_us)
    if timed.sum() < 10:
        return numpy.full(len(trace), numpy.nan)
    work = numpy.column_stack((numpy.ones(len(trace)), trace.sphere_tests, trace.substeps)).astype(float)
    usual = timed & (trace.cpu_us <= numpy.nanpercentile(trace.cpu_us, 99))
    weights, _ = optimize.nnls(work[usual], trace.cpu_us[usual])
    return work @ weights


def add_cost_claims(figure: Figure, trace: Trace, every_tick: bool = True) -> None:
    """Time of a tick. What a busy machine makes of it is told; judged is the work. `every_tick`: else the paper claims it of most ticks."""
    cost = trace.cpu_us[numpy.isfinite(trace.cpu_us)]
    work = predicted_cost_us(trace)
    p50, p99, most = numpy.percentile(cost, (50, 99, 100)) if len(cost) else (numpy.nan,) * 3
    note = (f"heaviest tick: {trace.sphere_tests.max():.0f} sphere tests, {trace.substeps.max():.0f} sub-steps; on this machine's clock p50 "
            f"{p50:.1f}, p99 {p99:.1f}, max {most:.1f} us, {100.0 * numpy.mean(cost < TICK_US) if len(cost) else numpy.nan:.2f} % of ticks below 1 ms")
    if not every_tick:
        figure.claims.append(at_least("Most ticks take less than 1 ms, by their work at the pace of this run: share", 100.0 * float(numpy.mean(work < TICK_US)),
                                      95.0, "%", note))
    else:
        figure.claims.append(at_most("Every tick takes less than 1 ms: the heaviest one's work at the pace of this run", float(work.max()), TICK_US, "us",
                                     note, NUMBER))


def delayed_profile(lab: Lab, delay_s: float) -> str:
    """The simulated device with a delay, as a file."""
    def change(profile: device_profile_pb2.DeviceProfile) -> None:
        profile.delay_s.value[:] = [delay_s]
        profile.delay_s.source = "set by hapticd-lab"
    return lab.profile(f"delay_{delay_s * 1e3:.0f}_ms", change)


def string_energy_j(trace: Trace) -> float:
    """E0 of all tones."""
    total = 0.0
    for event in trace.events:
        if event.kind == "tone":
            string = trace.strings[event.body.string_index]
            length = float(numpy.linalg.norm(numpy.subtract(string.p_wb_m, string.p_wa_m)))
            total += stability.modal_energy_j(string.tension_n, event.body.amplitude_m, length)
    return total


def add_hand_claims(lab: Lab, figure: Figure, row: Row) -> None:
    """The same gesture by simulated hands on a simulated device."""
    texture = stability.measure(row.paper, 0.0).sliding_n
    table = [["arm", "delay, ms", "stiffness granted", "lasting vibration at rest, mN", "sliding, mN", "energy to the hand, mJ", "allowed, mJ",
              "energy taken out in, ticks", "largest force, N"]]
    all_found = []
    played = lab.some([(arm, delay_s) for arm in ARMS for delay_s in DELAYS_S])
    for arm, delay_s in played:
        trace = lab.play_hand(Setup(row.scene, "PAPER"), lab.gesture(row.gesture), Hand(arm, delayed_profile(lab, delay_s)))
        found = stability.measure(trace, string_energy_j(trace))
        all_found.append(found)
        table.append([arm.lower(), f"{delay_s * 1e3:.0f}", f"{trace.stiffness_scale.min():.2f}", f"{found.resting_n * 1e3:.2f}",
                      f"{found.sliding_n * 1e3:.2f}", f"{found.energy_j * 1e3:.3f}", f"{found.allowed_j * 1e3:.3f}", str(found.limited),
                      f"{numpy.linalg.norm(trace.force_n, axis=1).max():.2f}"])
        if arm == "LIGHT" and delay_s == 0.0:
            figure.runs["by a simulated hand"] = trace
    figure.tables["By simulated hands on a simulated device"] = table
    hands = "; ".join(f"{arm.lower()} arm, delay of {delay_s * 1e3:.0f} ms" for arm, delay_s in played)
    figure.claims.append(at_most("By a hand, stable: lasting vibration of the contact force between 20 and 400 Hz while the hand rests",
                                 max(found.resting_n for found in all_found) * 1e3, stability.MOST_N * 1e3, "mN", hands))
    figure.claims.append(at_most("The same while it slides, where surfaces of spheres have a texture", max(found.sliding_n for found in all_found) * 1e3,
                                 stability.MOST_N * 1e3, "mN",
                                 f"{texture * 1e3:.1f} mN when the same way is gone by a scripted device: a loop that rings would add to it"))
    figure.claims.append(at_most("By a hand, the scene gives it no more than it may: energy over what is allowed",
                                 max(found.energy_j / found.allowed_j for found in all_found), 1.0, "",
                                 "4 mJ of the safety stage, and what the strings rang with", OURS))
    figure.claims.append(at_most("By a hand, the safety stage never has to take energy out", sum(found.limited for found in all_found), 0, "ticks",
                                 source=OURS))


def touched_together(trace: Trace, *names: str) -> numpy.ndarray:
    """n, True where all of these bear force at once."""
    return numpy.logical_and.reduce([trace.touched(name) for name in names])


def together_claim(trace: Trace, *names: str, ticks: int = 100) -> Claim:
    """All of these are touched at once, for at least so many ticks."""
    return at_least(f"{', '.join(names)} are touched at once", float(touched_together(trace, *names).sum()), ticks, "ticks")


def only_claim(trace: Trace, *names: str) -> Claim:
    """These are touched, and nothing else."""
    touched = sorted(name for name in trace.object_force_n if trace.touched(name).any())
    return is_so(f"Touched is {', '.join(names)} and nothing else", touched == sorted(names), ", ".join(touched) or "nothing", ", ".join(names))
