"""What tests of the lab share: traces with chosen columns, and outcomes."""
import dataclasses

import numpy
from hapticd_lab.outcome import Outcome
from hapticd_lab.trace import Trace

WIDTHS = {"force_n": 3, "torque_n_m": 3, "unlimited_force_n": 3, "p_wh_m": 3, "p_wg_m": 3, "q_wh": 4, "q_wg": 4}


def make_trace(count, **columns):
    """A trace of `count` ticks, zero but for the columns given."""
    values = {"tick": numpy.arange(count), "t_s": numpy.arange(count) * 1e-3, "flags": [frozenset()] * count}
    for each in dataclasses.fields(Trace):
        if each.default is dataclasses.MISSING and each.default_factory is dataclasses.MISSING and each.name not in values:
            width = WIDTHS.get(each.name)
            values[each.name] = numpy.zeros((count, width) if width else count)
    values.update(columns)
    return Trace(**values)


def make_outcome(figure_id, claims=(), **more):
    """An outcome without files."""
    return Outcome(figure_id, f"title of {figure_id}", f"what is seen in {figure_id}", list(claims), **more)
