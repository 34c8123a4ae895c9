"""The experiment of Table 1: familiarisation with a wall and a sphere, then 27 trials. In each, two strings called A and B are felt one after the
other, one of which has its T, E or R raised by 30, 40 or 50 %; the answer is which was stiffer, or that they were equal.

Take part by --live, at the device of a running hapticd, asked in this terminal; or let a simulated observer, --observer weber:SEED,
press both strings through the protocol in lockstep. Every answer is on the disk before the next trial begins: what was interrupted goes
on with --resume and loses no trial.

DIR gets trials.csv, codebook.md, ticks/ with every tick of every trial, summary.md, and of people questionnaire.csv.

Exit code: 0 all trials are answered; 1 refused, and why is said; 130 interrupted, --resume goes on."""
from __future__ import annotations

import argparse
import csv
import json
import math
import os
import pathlib
import sys
from typing import Any, Dict, List

from hapticd_lab import threshold_fit
from hapticd_lab.observer import WeberObserver
from hapticd_lab.published import REPETITIONS, TABLE_1, TABLE_2
from hapticd_lab.trials import CODEBOOK, BadTrials, TrialLog, judged, plan, rates

SUMMARY = "run the experiment of Table 1, with a person or a simulated observer"
SETTINGS = ("seed", "repetitions", "participant", "observer", "sigma", "criterion", "scene")
INTERRUPTED = 130
METRICS = dict(zip(TABLE_2, ("thin, not to be entered, of small diameter", "sliding along it is not rough", "force and deformation when it is pressed",
                             "the diameter is the same all along", "felt when it is touched while it vibrates")))


class Refused(ValueError):
    """The command cannot be obeyed; the text says why and what helps."""


def describe(parser: argparse.ArgumentParser) -> None:
    """Its options."""
    parser.add_argument("--output", type=pathlib.Path, metavar="DIR", required=True, help="where everything goes, a folder for each participant")
    who = parser.add_mutually_exclusive_group()
    who.add_argument("--observer", metavar="weber:SEED", help="a simulated observer (default: weber:1)")
    who.add_argument("--live", action="store_true", help="a person, asked in this terminal")
    parser.add_argument("--resume", action="store_true", help="go on with what was interrupted in DIR; its settings are taken from there")
    parser.add_argument("--seed", type=int, default=1, metavar="N", help="of the order of the trials, 0 or more (default: 1)")
    parser.add_argument("--repetitions", type=int, default=REPETITIONS, metavar="N", help="of every comparison (default: %(default)s)")
    parser.add_argument("--participant", default="", metavar="NAME", help="how the files call the participant")
    parser.add_argument("--sigma", type=float, default=WeberObserver.sigma, help="noise of a simulated observer's ln force (default: %(default)s)")
    parser.add_argument("--criterion", type=float, default=WeberObserver.criterion, help="difference of ln force it reports (default: %(default)s)")
    parser.add_argument("--address", default="127.0.0.1:47800", metavar="HOST:PORT", help="the hapticd of --live (default: %(default)s)")
    parser.add_argument("--scene", default="single_string", metavar="NAME", help="what --live is played on (default: %(default)s)")


def observer_seed(text: str) -> int:
    """SEED of weber:SEED."""
    kind, _, seed = text.partition(":")
    if kind != "weber" or not seed.isdecimal():
        raise Refused(f"--observer {text}: it is weber:SEED, SEED a whole number such as 1")
    return int(seed)


def _settings(options: argparse.Namespace) -> Dict[str, Any]:
    """The experiment's settings: as asked for, or of the folder it is resumed in."""
    path = options.output / "experiment.json"
    if options.resume:
        if not path.exists():
            raise Refused(f"{options.output} has no experiment to resume: leave --resume out")
        try:
            found = json.loads(path.read_text(encoding="utf-8"))
            return {name: found[name] for name in SETTINGS}
        except (ValueError, KeyError, TypeError) as error:
            raise Refused(f"{path}: {error!r}; restore the file, or begin anew in another folder") from error
    if path.exists() or (options.output / "trials.csv").exists():
        raise Refused(f"{options.output} has an experiment already: go on with it by --resume, or name another folder")
    observer = "person" if options.live else options.observer or "weber:1"
    if observer != "person":
        observer_seed(observer)
    if options.seed < 0 or not 1 <= options.repetitions <= 1000:
        raise Refused("--seed wants 0 or more, --repetitions 1 to 1000")
    if not (options.sigma > 0.0 and options.criterion >= 0.0):
        raise Refused("--sigma wants more than 0, --criterion 0 or more")
    return {"seed": options.seed, "repetitions": options.repetitions, "participant": options.participant, "observer": observer,
            "sigma": options.sigma, "criterion": options.criterion, "scene": options.scene}


def _keep(settings: Dict[str, Any], output: pathlib.Path) -> None:
    """Makes the folder; the settings are whole or not there."""
    (output / "ticks").mkdir(parents=True, exist_ok=True)
    part = output / "experiment.part"
    part.write_text(json.dumps(settings, indent=1) + "\n", encoding="utf-8")
    part.replace(output / "experiment.json")
    (output / "codebook.md").write_text(CODEBOOK, encoding="utf-8")


def _participant(settings: Dict[str, Any], options: argparse.Namespace) -> Any:
    from hapticd_lab import participant  # it needs the client; help does not
    if settings["observer"] == "person":
        return participant.Person(options.address, settings["scene"])
    return participant.SimulatedParticipant(WeberObserver(settings["sigma"], settings["criterion"]), observer_seed(settings["observer"]))


def _run_trials(person: Any, log: TrialLog, planned: List[Any], ticks: pathlib.Path) -> None:
    from hapticd_lab import participant, stimulus
    for scene in participant.familiarisation_left([path.stem for path in ticks.glob("*.csv")]):
        stimulus.write(person.familiarise(scene), ticks / f"{scene}.csv")
    for trial in planned[len(log.rows):]:
        answered = person.compare(trial)
        for label, trace in answered.ticks.items():  # before the answer: a trial with an answer has its ticks
            stimulus.write(trace, ticks / f"{trial.trial:03}_{label}.csv")
        log.add(trial, answered.answer, answered.peaks_n, answered.log_ratio, answered.answered)
        print(f"trial {trial.trial} of {len(planned)} is kept", flush=True)


def _ask_scores(person: Any, path: pathlib.Path) -> None:
    """What is left of the questionnaire, line by line on the disk."""
    done = set()
    if path.exists():
        text = path.read_text(encoding="utf-8")
        text = text[:text.rfind("\n") + 1]
        path.write_text(text, encoding="utf-8")
        done = {row["metric"] for row in csv.DictReader(text.splitlines())}
    with open(path, "a", newline="", encoding="utf-8") as file:
        rows = csv.writer(file, lineterminator="\n")
        if file.tell() == 0:
            rows.writerow(("metric", "score"))
        for metric, explanation in METRICS.items():
            if metric not in done:
                rows.writerow((metric, person.score(metric, explanation)))
            file.flush()
            os.fsync(file.fileno())


def _bounds(low: float, high: float) -> str:
    return f"{'not bounded' if low == 0.0 else f'{low:.3f}'} to {'not bounded' if math.isinf(high) else f'{high:.3f}'}"


def summary_text(settings: Dict[str, Any], log: TrialLog) -> str:
    """The result of one participant beside the paper's seven, Markdown."""
    found = rates(log.rows)
    lines = [f"# Experiment of Table 1: {settings['participant'] or settings['observer']}", "", f"{len(log.rows)} trials, seed {settings['seed']}.", "",
             "| raised | +30 % | +40 % | +50 % | paper's seven people |", "|---|---|---|---|---|"]
    for parameter, one in found.items():
        printed = TABLE_1[parameter]
        paper = ", ".join(f"{mean} \N{PLUS-MINUS SIGN} {deviation}" for mean, deviation in zip(printed.means, printed.deviations))
        lines.append(f"| {parameter} | {' | '.join(f'{rate:.1f} %' for rate in one)} | {paper} |")
    threshold = threshold_fit.fit([row.log_ratio for row in log.rows], [judged(row) for row in log.rows])
    lines += ["", "Of the three-answer Weber model fitted to all answers, with intervals of 95 %:", "",
              f"- criterion {threshold.criterion.value:.3f} ({_bounds(threshold.criterion.low, threshold.criterion.high)}) of ln force: the difference told in half of the trials",
              f"- noise {threshold.sigma.value:.3f} ({_bounds(threshold.sigma.low, threshold.sigma.high)}) of ln force"]
    if settings["observer"] != "person":
        lines.append(f"- the simulated observer has criterion {settings['criterion']:g}, noise {settings['sigma']:g}")
    return "\n".join([*lines, "", "trials.csv has the answers, codebook.md says what its columns mean.", ""])


def run(options: argparse.Namespace) -> int:
    """The command; its exit code."""
    import hapticd
    from hapticd_lab import participant
    log, planned = None, []
    try:
        settings = _settings(options)
        planned = plan(settings["seed"], settings["repetitions"])
        with _participant(settings, options) as person:
            _keep(settings, options.output)
            log = TrialLog(options.output / "trials.csv", planned)
            _run_trials(person, log, planned, options.output / "ticks")
            if person.asks_people:
                _ask_scores(person, options.output / "questionnaire.csv")
    except (Refused, BadTrials, participant.Unplayable, hapticd.RequestError) as refused:
        print(f"hapticd-lab experiment: {refused}", file=sys.stderr)
        return 1
    except (participant.Interrupted, KeyboardInterrupt):
        kept = f"; {len(log.rows)} of {len(planned)} trials are kept. Go on with --output {options.output} --resume" if log else ""
        print(f"\nhapticd-lab experiment: interrupted{kept}", file=sys.stderr)
        return INTERRUPTED
    text = summary_text(settings, log)
    (options.output / "summary.md").write_text(text, encoding="utf-8")
    print(text)
    return 0
