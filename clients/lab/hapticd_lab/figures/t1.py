"""T1: whether people feel that T, E or R was raised. What the equations predict, what is rendered, what a simulated observer answers, and what the
paper's own numbers say when its analyses are done again from its table."""
from __future__ import annotations

import math
from typing import Dict, List, Tuple

import numpy

from hapticd_lab import anova, plots
from hapticd_lab.figure import NUMBER, OURS, WORDS, Claim, Figure, Spec, at_least, at_most, is_so
from hapticd_lab.lab import Lab
from hapticd_lab.observer import FELT_DEPTH_M, FELT_PLACE, WeberObserver
from hapticd_lab.published import ANOVAS, INCREMENTS, PARTICIPANTS, REPETITIONS, TABLE_1
from hapticd_lab.stimulus import Bench, peak_n, press_path
from hapticd_lab.string_law import PARAMETERS, StringValues, change
from hapticd_lab.trace import Trace

PRESSED_DEPTH_M, PRESSED_PLACE = 0.005, 0.5
PREDICTED = {"T": (27.4, 36.5, 45.7), "E": (2.6, 3.5, 4.3), "R": (6.0, 8.3, 10.8)}
"""Change of force, %, at that press, as it was computed before anything was measured."""
PREDICTED_RATES = {"T": (49.0, 55.0, 61.0), "E": (34.0, 36.0, 37.0), "R": (41.0, 45.0, 50.0)}
ROUNDED = 0.0501
RATE_ROUNDED = 1.0
"""Points; they were given as whole numbers."""
ANSWERS = PARTICIPANTS * REPETITIONS
ANSWER_ROUNDED = 0.25
"""Points: the printed means are averages of rates that were rounded themselves."""
CLOSED_FORM = 1e-4
SEED = 1
GROUPS = 2000
SIGNIFICANT = 0.05
SMALL_E_PA = tuple(float(value) for value in numpy.geomspace(1e9, 1.9e11, 8))
LEVELS = tuple(f"{100.0 * increment:.0f} %" for increment in INCREMENTS)
REFERENCE = StringValues()

Changes = Dict[str, Tuple[float, ...]]


def measure(bench: Bench, depth_m: float, place: float) -> Tuple[float, Changes, Changes, Dict[str, Trace]]:
    """(force of the reference, changes of force at the same deflection, changes when the hand goes the same way, traces of these) through the
    protocol."""
    same_way = press_path(REFERENCE, depth_m, place)
    traces = {"reference": bench.present(REFERENCE, same_way)}
    reference = peak_n(traces["reference"])
    deflected, led = {}, {}
    for parameter in PARAMETERS:
        strings = [REFERENCE.raised(parameter, increment) for increment in INCREMENTS]
        deflected[parameter] = tuple(peak_n(bench.present(string, press_path(string, depth_m, place))) / reference - 1.0 for string in strings)
        for string, level in zip(strings, LEVELS):
            traces[f"{parameter} + {level}"] = bench.present(string, same_way)
        led[parameter] = tuple(peak_n(traces[f"{parameter} + {level}"]) / reference - 1.0 for level in LEVELS)
    return reference, deflected, led, traces


def _force_claims(figure: Figure, reference_n: float, deflected: Changes, led: Changes) -> None:
    for parameter in PARAMETERS:
        worst = max(abs(100.0 * value - predicted) for value, predicted in zip(deflected[parameter], PREDICTED[parameter]))
        figure.claims.append(at_most(f"Raised {parameter}: change of the rendered force against the one predicted, largest difference", worst, ROUNDED,
                                     "points", f"{_percents(deflected[parameter])} at +30/40/50 %, predicted {PREDICTED[parameter]}", OURS))
    exact = max(abs((1.0 + value) / (1.0 + change(REFERENCE, parameter, increment, PRESSED_DEPTH_M, PRESSED_PLACE)) - 1.0)
                for parameter in PARAMETERS for value, increment in zip(deflected[parameter], INCREMENTS))
    figure.claims.append(at_most("Ratios of rendered forces against Eq. 10-12: largest error", exact, CLOSED_FORM, "", source=OURS))
    figure.tables["Change of the force at 5 mm in the middle, through the protocol"] = [["raised", *LEVELS, "the hand goes the same way", "", ""]] + [
        [parameter, *(f"{100.0 * value:.2f} %" for value in deflected[parameter] + led[parameter])] for parameter in PARAMETERS]
    figure.notes.append(f"The reference gives {reference_n:.4f} N. A thicker string is met sooner: when the hand goes the same way it is pressed deeper by what "
                        "R grew, and R is felt more than at the same deflection.")


def _percents(values: Tuple[float, ...]) -> str:
    return "/".join(f"{100.0 * value:.2f}" for value in values)


def _switch_claims(bench: Bench, figure: Figure, traces: Dict[str, Trace]) -> None:
    """All strings of a trial come by the same path, delay and ramp."""
    touched = {name: int(numpy.flatnonzero(numpy.linalg.norm(trace.force_n, axis=1) > 0.0)[0]) for name, trace in traces.items()}
    begins = {touched[name] for name in traces if not name.startswith("R")}
    before = max(float(numpy.linalg.norm(trace.force_n[:min(touched.values())], axis=1).max()) for trace in traces.values())
    lengths = {len(trace) for trace in traces.values()}
    figure.claims.append(is_so("Every string of a trial comes by the same path, delay and ramp", len(begins) == 1 and len(lengths) == 1 and before == 0.0,
                               f"touched {sorted(begins)} ms after the change for T and E, force before it {before:g} N, {sorted(lengths)} ticks",
                               "one instant, no force, one duration", "R is met sooner by what it grew; that is the string, not the way it comes", OURS))
    same_way = press_path(REFERENCE, PRESSED_DEPTH_M, PRESSED_PLACE)
    apart = 0.0
    for parameter in ("T", "E"):
        raised, field = REFERENCE.raised(parameter, INCREMENTS[-1]), PARAMETERS[parameter]
        bench.bring(REFERENCE)
        bench.session.set(f"strings[0].{field}", getattr(raised, field))
        apart = max(apart, abs(peak_n(bench.follow(same_way)) / peak_n(traces[f"{parameter} + {LEVELS[-1]}"]) - 1.0))
    figure.claims.append(at_most("T and E set while it runs give the force that a change of scene gives: largest difference", apart, 1e-6, "",
                                 "R is no live parameter, so all of them change by the scene", OURS))


def _rates(changes: Changes) -> Dict[str, Tuple[float, ...]]:
    observer = WeberObserver()
    return {parameter: tuple(100.0 * float(observer.rate_correct(math.log1p(value))) for value in values) for parameter, values in changes.items()}


def _rate_claims(figure: Figure, rates: Dict[str, Tuple[float, ...]]) -> None:
    off = max(abs(rate - known) for name in rates for rate, known in zip(rates[name], PREDICTED_RATES[name]))
    figure.claims.append(at_most("Rates of the simulated observer against those computed before: largest difference", off, RATE_ROUNDED, "points", source=OURS))
    for parameter in PARAMETERS:
        shown = "/".join(f"{rate:.1f}" for rate in rates[parameter])
        figure.claims.append(is_so(f"The rate rises with the increment: {parameter}", bool(numpy.all(numpy.diff(rates[parameter]) > 0.0)), f"{shown} %",
                                   "rising", f"the paper: {TABLE_1[parameter].means}"))
    for level, name in enumerate(LEVELS):
        figure.claims.append(is_so(f"T is told best at + {name}", rates["T"][level] == max(rates[each][level] for each in rates),
                                   ", ".join(f"{each} {rates[each][level]:.1f}" for each in rates), "T first", source=NUMBER))
    figure.claims.append(at_most("E is flat: its rate at + 50 % over that at + 30 %", rates["E"][2] - rates["E"][0],
                                 TABLE_1["E"].means[2] - TABLE_1["E"].means[0], "points", "the paper's own rises by so much", NUMBER))
    for level in (0, 1):
        ours, theirs = (rates["E"][level] - rates["R"][level], TABLE_1["E"].means[level] - TABLE_1["R"].means[level])
        error = math.sqrt((TABLE_1["E"].deviations[level] ** 2 + TABLE_1["R"].deviations[level] ** 2) / PARTICIPANTS)
        figure.claims.append(at_least(f"E is told better than R at + {LEVELS[level]}: rate of E over that of R", ours, 0.0, "points",
                                      f"the paper: {theirs:.1f} points, standard error {error:.0f}. Eq. 10-12 make R, which enters squared, change the force "
                                      "more than E at every deflection, so no observer of them can answer so; the paper's difference is within its noise", NUMBER))
    table, worst = [["raised", *(f"+ {level}" for level in LEVELS), *(f"paper, + {level}" for level in LEVELS)]], 0.0
    for name, published in TABLE_1.items():
        table.append([name, *(f"{rate:.1f}" for rate in rates[name]),
                      *(f"{mean} \N{PLUS-MINUS SIGN} {deviation}" for mean, deviation in zip(published.means, published.deviations))])
        worst = max(worst, *(abs(rate - mean) / (deviation / math.sqrt(PARTICIPANTS))
                             for rate, mean, deviation in zip(rates[name], published.means, published.deviations)))
    figure.tables["Rate of correct identification, %: simulated observer, and the paper's seven people"] = table
    figure.claims.append(at_most("All nine rates agree with the paper's: largest difference in standard errors of its seven people", worst, 2.0, "",
                                 "the observer was fixed beforehand and is not tuned to the table", NUMBER))


def _printed_anova_claims(figure: Figure) -> None:
    table = [["raised", "levels", "printed", "recomputed from the printed table"]]
    for name, printed in ANOVAS.items():
        again = anova.from_summary([TABLE_1[name].means[i] for i in printed.levels], [TABLE_1[name].deviations[i] for i in printed.levels], PARTICIPANTS)
        table.append([name, ", ".join(LEVELS[i] for i in printed.levels), f"F{printed.degrees} = {printed.f}, p = {printed.p}",
                      f"F({again.between}, {again.within}) = {again.f:.3f}, p = {again.p:.3f}"])
        figure.claims.append(at_most(f"The paper's analysis for {name} follows from its table: F recomputed over F printed, distance from 1",
                                     abs(again.f / printed.f - 1.0), 0.05, "", f"F({again.between}, {again.within}) = {again.f:.3f}, p = {again.p:.3f}; printed "
                                     f"{printed.f}, p = {printed.p}", NUMBER))
    figure.tables["Analyses of variance, one-way, seven people"] = table
    means = numpy.array([mean for rates in TABLE_1.values() for mean in rates.means])
    whole = numpy.round(means * ANSWERS / 100.0) * 100.0 / ANSWERS
    figure.claims.append(at_most(f"The printed rates are those of {ANSWERS} answers each, seven people and three repetitions: largest distance from a whole number",
                                 float(numpy.abs(means - whole).max()), ANSWER_ROUNDED, "points", source=NUMBER))


def answers(rates: Tuple[float, ...], random: numpy.random.Generator) -> numpy.ndarray:
    """levels x people, rate of correct answers of simulated people, %."""
    share = numpy.asarray(rates)[:, None] / 100.0
    return 100.0 * random.binomial(REPETITIONS, share, (len(rates), PARTICIPANTS)) / REPETITIONS


def _simulated_group_claims(figure: Figure, rates: Dict[str, Tuple[float, ...]]) -> None:
    random = numpy.random.default_rng(SEED)
    table = [["raised", "simulated group", "printed", f"groups of {GROUPS} with p < {SIGNIFICANT}"]]
    shares = {}
    for name, printed in ANOVAS.items():
        levels = list(printed.levels)
        groups = [anova.of_groups(answers(rates[name], random)[levels]) for _ in range(GROUPS)]
        shares[name] = sum(each.p < SIGNIFICANT for each in groups) / GROUPS
        table.append([name, f"F({groups[0].between}, {groups[0].within}) = {groups[0].f:.3f}, p = {groups[0].p:.3f}",
                      f"F{printed.degrees} = {printed.f}, p = {printed.p}", f"{100.0 * shares[name]:.1f} %"])
    figure.tables["Seven simulated people, their analysis, and how often such a group is significant"] = table
    figure.claims.append(at_most("No significant difference for E: share of simulated groups that find one", 100.0 * shares["E"], 10.0, "%", source=NUMBER))
    for name in ("T", "R"):
        figure.claims.append(at_least(f"Significant difference for {name}: share of simulated groups that find one", 100.0 * shares[name], 50.0, "%",
                                      "seven people with three answers each are too few for differences of this size: most groups of the simulated "
                                      "observer would find none", NUMBER))


def _small_e(bench: Bench, figure: Figure) -> List[float]:
    found = []
    for youngs_modulus_pa in SMALL_E_PA:
        string = StringValues(youngs_modulus_pa=youngs_modulus_pa)
        pair = [peak_n(bench.present(each, press_path(each, PRESSED_DEPTH_M, PRESSED_PLACE))) for each in (string, string.raised("E", INCREMENTS[-1]))]
        found.append(100.0 * (pair[1] / pair[0] - 1.0))
    figure.claims.append(at_least("A smaller E makes its raise felt more, as the paper proposes for later: change at 1e9 Pa over that at 1.9e11 Pa, + 50 %",
                                  found[0] / found[-1], 1.0, "", "the other way round: the smaller E, the smaller its share in the force of Eq. 10, which T then "
                                  f"bears alone ({found[0]:.3f} % against {found[-1]:.2f} %). A deeper press would show E: its share grows with the deflection "
                                  "squared", WORDS))
    figure.tables["Change of the force at + 50 % of E"] = [["E, Pa", "change, %"]] + [[f"{e:.3g}", f"{value:.4f}"] for e, value in zip(SMALL_E_PA, found)]
    return found


def _draw(lab: Lab, figure: Figure, rates: Dict[str, Tuple[float, ...]], small_e: List[float]) -> None:
    percent = [100.0 * increment for increment in INCREMENTS]
    curves = []
    for name, color in zip(PARAMETERS, ("#d1352b", "#1b8a3a", "#1f5fbf")):
        curves += [plots.Line(f"{name}, simulated observer", percent, rates[name], "o-", color), plots.Line(f"{name}, paper", percent, TABLE_1[name].means, "s:", color)]
    plots.lines("T1: who tells the raised string", [
        plots.Panel("increment, %", "correct, %", curves),
        plots.Panel("E, Pa", "change of force at + 50 % of E, %", [plots.Line("through the protocol", SMALL_E_PA, small_e, "o-")], log_x=True, log_y=True),
    ]).save(lab.folder / "rates")
    figure.pictures["rates.svg"] = "Rates of correct identification; and how little a raised E is felt as E falls"


def make(lab: Lab, figure: Figure) -> None:
    """Table 1."""
    with Bench() as bench:
        reference_n, deflected, led, traces = measure(bench, PRESSED_DEPTH_M, PRESSED_PLACE)
        _force_claims(figure, reference_n, deflected, led)
        _switch_claims(bench, figure, traces)
        _, felt, _, _ = measure(bench, FELT_DEPTH_M, FELT_PLACE)
        small_e = _small_e(bench, figure)
    rates = _rates(felt)
    _rate_claims(figure, rates)
    _printed_anova_claims(figure)
    _simulated_group_claims(figure, rates)
    _draw(lab, figure, rates, small_e)
    figure.runs = {name: traces[name] for name in ("reference", *(f"{parameter} + {LEVELS[-1]}" for parameter in PARAMETERS))}
    observer = WeberObserver()
    figure.notes.append(f"The simulated observer feels the logarithm of the ratio of peak forces at {1e3 * FELT_DEPTH_M:g} mm, lambda {FELT_PLACE:g}, with noise of "
                        f"{observer.sigma:g}, and calls strings equal within {observer.criterion:g}: three answers, as the rates below one half suggest. "
                        "Rates are its closed form on forces measured through the protocol; the groups are drawn from them, seeded.")


SPECS = [Spec("T1", "Telling raised T, E and R", "rates of correct identification of T, E and R raised by 30, 40 and 50 %, and their analyses of variance", make, 10.0)]
