"""The report of a study, report.html with everything inside and report.md with links: what each knob and level costs and errs, what is on the front,
and whether the levels keep what is claimed of them."""
from __future__ import annotations

import pathlib
from typing import Dict, List, Sequence

from hapticd_lab import report, tradeoff_instructions, tradeoff_plots, tradeoff_strings
from hapticd_lab.quality_table import Claim, claims_of
from hapticd_lab.tradeoff_instructions import Counts
from hapticd_lab.tradeoff_plan import LEVELS, Plan
from hapticd_lab.tradeoff_table import DISCRIMINATION, Row, knee


def _percent(share: float) -> str:
    return f"{100.0 * share:.3g} %"


def _cells(row: Row) -> List[str]:
    counted = row.knob != "baseline"
    return [row.knob, row.setting + (" *" if row.on_front else ""), _percent(row.error), _percent(row.bound), f"{1e3 * row.largest_n:.3g}",
            f"{1e6 * row.pose_max_m:.3g}", f"{1e6 * row.penetration_m:.2g}", f"{1e6 * row.surface_m:.0f}",
            *([f"{row.work_mean:.0f}", f"{row.work_p99:.0f}", f"{row.work_max:.0f}"] if counted else ["", "", ""]),
            f"{row.times_us['p50']:.1f}", f"{row.times_us['p99']:.1f}", f"{row.times_us['max']:.0f}"]


HEADINGS = ("knob", "setting (* on the front)", "force error", "bound", "largest, mN", "shown pose, um", "penetration, um", "surface, um", "work, mean",
            "p99", "max", "us, median", "p99", "max")


def _knee_of(rows: Sequence[Row]) -> str:
    own = [row for row in rows if row.on_front]
    if not own:
        return "none"
    best = own[knee([row.work_mean for row in own], [row.error for row in own])]
    return f"{best.setting}: {_percent(best.error)} at a work of {best.work_mean:.0f}"


def _instructions(counts: Counts, output: pathlib.Path) -> List[List[str]]:
    if counts:
        tradeoff_instructions.write(counts, output)
    return [[scene, f"{speed:g} m/s", *(f"{each:.0f}" for each in own)] for (scene, speed), own in counts.items()]


def write(plan: Plan, rows: Sequence[Row], counts: Counts, facts: Dict[str, str], output: pathlib.Path) -> None:
    """Plots, report.html and report.md."""
    tradeoff_plots.draw(plan.scenes, rows, output)
    scenes = [{"name": scene, "plot": f"work_precision_{scene}", "knee": _knee_of([row for row in rows if row.scene == scene]),
               "rows": [_cells(row) for row in rows if row.scene == scene and row.knob != "ladder"]} for scene in plan.scenes]
    claims: List[Claim] = claims_of(rows)
    content = {"scenes": scenes, "facts": facts, "headings": HEADINGS, "claims": claims, "plan": plan, "felt": _percent(DISCRIMINATION),
               "strings": tradeoff_strings.write(output), "instructions": _instructions(counts, output), "levels": list(LEVELS),
               "embed": lambda name: report.embedded_plot(output, name)}
    for name, escape in (("html", True), ("md", False)):
        text = report.environment(escape).get_template(f"tradeoff.{name}.j2").render(content)
        (output / f"report.{name}").write_text(text, encoding="utf-8")
