"""The experiment of Table 1: familiarisation with a wall and a sphere, then 27 trials. In each, two strings called A and B are felt one after the
other, one of which has its T, E or R raised by 30, 40 or 50 %; the answer is which was stiffer, or that they were equal.

Take part by --live, at the device of a running hapticd, asked in this terminal, or in the viewer (haptic-web, Experiment); or let a simulated
observer, --observer weber:SEED, press both strings through the protocol in lockstep. Every answer is on the disk before the next trial begins: what was interrupted goes
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
from typing import Any, Dict, List, Optional

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
    who.add_argument("--page", action="store_true", help="a person, asked in a page of haptic-web, which starts this itself; goes on with what is in DIR")
    parser.add_argument("--resume", action="store_true", help="go on with what was interrupted in DIR; its settings are taken from there")
    parser.add_argument("--seed", type=int, default=1, metavar="N", help="of the order of the trials, 0 or more (default: 1)")
    parser.add_argument("--repetitions", type=int, default=REPETITIONS, metavar="N", help="of every comparison (default: %(default)s)")
    parser.add_argument("--participant", default="", metavar="NAME", help="how the files call the participant")
    parser.add_argument("--sigma", type=float, help=f"noise of a simulated observer's ln force (default: {WeberObserver.sigma})")
    parser.add_argument("--criterion", type=float, help=f"difference of ln force it reports (default: {WeberObserver.criterion})")
    parser.add_argument("--address", metavar="HOST:PORT", help="the hapticd of --live and --page (default: 127.0.0.1:47800)")
    parser.add_argument("--key", type=pathlib.Path, metavar="FILE", help="control key of a hapticd of --live and --page that has keys")
    parser.add_argument("--scene", metavar="NAME", help="what --live and --page are played on (default: single_string)")


def _refuse_idle(options: argparse.Namespace, person: bool) -> None:
    """What does nothing for who takes part is refused, and what was not asked for gets its default."""
    whose, idle = ("a simulated observer", ("sigma", "criterion")) if person else ("--live and --page", ("address", "key", "scene"))
    for name in idle:
        if getattr(options, name) is not None:
            raise Refused(f"--{name} is for {whose}: leave it out" + ("" if person else ", or add --live"))
    defaults = {"sigma": WeberObserver.sigma, "criterion": WeberObserver.criterion, "address": "127.0.0.1:47800", "scene": "single_string"}
    for name, value in defaults.items():
        if getattr(options, name) is None:
            setattr(options, name, value)


def observer_seed(text: str) -> int:
    """SEED of weber:SEED."""
    kind, _, seed = text.partition(":")
    if kind != "weber" or not seed.isdecimal():
        raise Refused(f"--observer {text}: it is weber:SEED, SEED a whole number such as 1")
    return int(seed)


def _settings(options: argparse.Namespace) -> Dict[str, Any]:
    """The experiment's settings: as asked for, or of the folder it is resumed in."""
    path = options.output / "experiment.json"
    if options.resume or (options.page and path.exists()):
        if not path.exists():
            raise Refused(f"{options.output} has no experiment to resume: leave --resume out")
        try:
            found = json.loads(path.read_text(encoding="utf-8"))
            settings = {name: found[name] for name in SETTINGS}
        except (ValueError, KeyError, TypeError) as error:
            raise Refused(f"{path}: {error!r}; restore the file, or start again in another folder") from error
        if options.page and settings["observer"] != "person":
            raise Refused(f"{options.output} is of a simulated observer: choose another name")
        _refuse_idle(options, settings["observer"] == "person")
        return settings
    if path.exists() or (options.output / "trials.csv").exists():
        raise Refused(f"{options.output} has an experiment already: go on with it by --resume, or name another folder")
    observer = "person" if options.live or options.page else options.observer or "weber:1"
    if observer != "person":
        observer_seed(observer)
    _refuse_idle(options, observer == "person")
    if options.seed < 0 or not 1 <= options.repetitions <= 1000:
        raise Refused("--seed must be 0 or more, --repetitions 1 to 1000")
    if not (options.sigma > 0.0 and options.criterion >= 0.0):
        raise Refused("--sigma must be above 0, --criterion 0 or more")
    return {"seed": options.seed, "repetitions": options.repetitions, "participant": options.participant, "observer": observer,
            "sigma": options.sigma, "criterion": options.criterion, "scene": options.scene}


def _keep(settings: Dict[str, Any], output: pathlib.Path) -> None:
    """Makes the folder; the settings are whole or not there."""
    (output / "ticks").mkdir(parents=True, exist_ok=True)
    part = output / "experiment.part"
    part.write_text(json.dumps(settings, indent=1) + "\n", encoding="utf-8")
    part.replace(output / "experiment.json")
    (output / "codebook.md").write_text(CODEBOOK, encoding="utf-8")


def _key(path: Optional[pathlib.Path]) -> Optional[pathlib.Path]:
    """The key file, if it is one."""
    from hapticd import key  # it needs the client; help does not
    if path is not None:
        try:
            key.taken(path)
        except ValueError as error:
            raise Refused(f"--key {error}") from error
    return path


def _participant(settings: Dict[str, Any], options: argparse.Namespace, screen: Any) -> Any:
    from hapticd_lab import participant  # it needs the client; help does not
    if settings["observer"] == "person":
        return participant.Person(options.address, settings["scene"], screen, _key(options.key))
    return participant.SimulatedParticipant(WeberObserver(settings["sigma"], settings["criterion"]), observer_seed(settings["observer"]))


def _run_trials(person: Any, screen: Any, log: TrialLog, planned: List[Any], ticks: pathlib.Path) -> None:
    from hapticd_lab import participant, stimulus
    if len(log.rows) < len(planned):
        person.instruct(len(planned), len(log.rows))
    for scene in participant.familiarisation_left([path.stem for path in ticks.glob("*.csv")]):
        stimulus.write(person.familiarise(scene), ticks / f"{scene}.csv")
    for trial in planned[len(log.rows):]:
        answered = person.compare(trial)
        for label, trace in answered.ticks.items():  # before the answer: a trial with an answer has its ticks
            stimulus.write(trace, ticks / f"{trial.trial:03}_{label}.csv")
        log.add(trial, answered.answer, answered.peaks_n, answered.log_ratio, answered.answered)
        screen.kept(trial.trial, len(planned))


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


def _screen(options: argparse.Namespace) -> Any:
    from hapticd_lab import page_screen, terminal_screen
    return page_screen.PageScreen(options.participant) if options.page else terminal_screen.TerminalScreen()


class Run:
    """One run of the command, from its settings to its summary; `log` tells what is kept when it ends early."""

    def __init__(self, options: argparse.Namespace) -> None:
        self._options, self._planned, self._log, self._screen = options, [], None, _screen(options)

    def _kept(self) -> str:
        if self._log is None:
            return ""
        onward = "" if self._options.page else f". Go on with --output {self._options.output} --resume"
        return f"; {len(self._log.rows)} of {len(self._planned)} trials are kept{onward}"

    def _finish(self) -> None:
        options, settings = self._options, _settings(self._options)
        self._planned = plan(settings["seed"], settings["repetitions"])
        with _participant(settings, options, self._screen) as person:
            _keep(settings, options.output)
            self._log = TrialLog(options.output / "trials.csv", self._planned)
            _run_trials(person, self._screen, self._log, self._planned, options.output / "ticks")
            if person.asks_people:
                _ask_scores(person, options.output / "questionnaire.csv")
        text = summary_text(settings, self._log)
        (options.output / "summary.md").write_text(text, encoding="utf-8")
        self._screen.done(text, str(options.output.resolve()))

    def run(self) -> int:
        """Exit code of the command."""
        import hapticd
        from hapticd_lab import participant, terminal_screen
        try:
            self._finish()
            return 0
        except (Refused, BadTrials, participant.Unplayable, hapticd.RequestError, OSError) as refused:
            self._screen.stopped(f"{str(refused).rstrip('.')}{self._kept()}")
            return 1
        except participant.LostControl as lost:
            self._screen.stopped(f"{lost}, so what was felt last does not count{self._kept()}")
            return 1
        except (terminal_screen.Interrupted, KeyboardInterrupt):
            self._screen.stopped(f"interrupted{self._kept()}")
            return INTERRUPTED


def run(options: argparse.Namespace) -> int:
    """The command; its exit code."""
    return Run(options).run()
