"""Numbers out of messages and into them. With numpy columns are arrays, without it lists; the same code reads both.
Units and frames as in proto/hapticd/v1/state.proto: SI, W the world, quaternions w x y z."""
from __future__ import annotations

import math
from typing import Any, Dict, Iterable, List, Mapping, Optional, Sequence

from hapticd.v1 import control_pb2, state_pb2

try:
    import numpy
except ImportError:  # optional
    numpy = None  # type: ignore[assignment]

POSES_IN_BATCH = 14
"""16 are allowed, but would need Chunks."""
LEAST_NORM, MOST_NORM = 0.5, 2.0
"""Of the quaternion of a pose: PROTOCOL.md section 9."""


def as_array(values: Sequence[Any]) -> Any:
    """A numpy array of the values, or a list where numpy is missing. Rows of unequal length stay a list."""
    values = list(values)
    if numpy is None or len({len(row) for row in values if isinstance(row, (list, tuple))}) > 1:
        return values
    return numpy.array(values)


def tool_state(state: state_pb2.State, tool_id: int = 0) -> Optional[state_pb2.ToolState]:
    """The tool of that id, or None: ids are names, not indices."""
    return next((tool for tool in state.tools if tool.tool_id == tool_id), None)


def contacts(patch: state_pb2.ContactPatch) -> Optional[Dict[str, Any]]:
    """A patch in SI: tool_sphere (n), p_wc_m (n x 3), nhat_og_w (n x 3), gap_m (n), force_n (n). None where the patch's columns
    disagree in length: such a patch is to be ignored."""
    count = len(patch.tool_sphere)
    lengths = (len(patch.p_wc_um), len(patch.nhat_og_w_e4), len(patch.gap_nanometres), len(patch.force_mn))
    if lengths != (3 * count, 3 * count, count, count):
        return None
    table = {
        "tool_sphere": list(patch.tool_sphere),
        "p_wc_m": _triples(patch.p_wc_um, 1e-6),
        "nhat_og_w": _triples(patch.nhat_og_w_e4, 1e-4),
        "gap_m": [gap * 1e-9 for gap in patch.gap_nanometres],
        "force_n": [force * 1e-3 for force in patch.force_mn],
    }
    return {name: as_array(column) for name, column in table.items()}


def _triples(numbers: Sequence[int], unit: float) -> List[List[float]]:
    return [[number * unit for number in numbers[i:i + 3]] for i in range(0, len(numbers), 3)]


def _numbers(row: Any, place: int) -> List[float]:
    """The row of poses at that place."""
    try:
        if isinstance(row, (str, bytes, Mapping)):
            raise TypeError
        return [float(number) for number in row]
    except (TypeError, ValueError) as error:
        raise type(error)(f"a pose is a row of 3 or 7 numbers, and row {place} is {repr(row):.80}.") from None


def pose_rows(poses: Iterable[Sequence[float]]) -> List[List[float]]:
    """Poses as rows of 3 numbers (position) or 7 (position, then quaternion w x y z). TypeError for what is no rows of numbers; ValueError for
    another count, for a number that is not finite and for a quaternion of a norm outside [0.5, 2], with the row's number from 0."""
    if isinstance(poses, (str, bytes, Mapping)):
        raise TypeError(f"poses are rows of 3 or 7 numbers, and not a {type(poses).__name__}: give [[x, y, z], ...], a row for each tick.")
    rows = [_numbers(row, place) for place, row in enumerate(poses)]
    for place, row in enumerate(rows):
        if len(row) not in (3, 7):
            raise ValueError(f"a pose is 3 or 7 numbers, and row {place} has {len(row)}")
        if not all(map(math.isfinite, row)):
            raise ValueError(f"a pose is of finite numbers, and row {place} is {row}")
        if len(row) == 7 and not LEAST_NORM <= math.hypot(*row[3:]) <= MOST_NORM:
            raise ValueError(f"the quaternion of a pose has a norm in [{LEAST_NORM}, {MOST_NORM}], and that of row {place} is {row[3:]}")
    return rows


def pose_batches(poses: Iterable[Sequence[float]], tool_id: int, first_tick: Optional[int]) -> List[control_pb2.PoseBatch]:
    """Poses as for `pose_rows`, 14 to a batch. `first_tick` None: right after what is queued."""
    rows = pose_rows(poses)
    batches = []
    for start in range(0, len(rows), POSES_IN_BATCH):
        batch = control_pb2.PoseBatch()
        if first_tick is not None:
            batch.first_tick = first_tick + start
        for row in rows[start:start + POSES_IN_BATCH]:
            sample = batch.poses.add(tool_id=tool_id)
            sample.pose_dh.p_m.extend(row[:3])
            sample.pose_dh.q.extend(row[3:] or (1.0, 0.0, 0.0, 0.0))
        batches.append(batch)
    return batches


def fill_value(assignment: control_pb2.Assignment, value: Any) -> None:
    """Puts a Python value into an Assignment: bool, number, text, or a sequence of numbers."""
    if isinstance(value, str):
        assignment.text = value
    elif isinstance(value, bool) or (numpy is not None and isinstance(value, numpy.bool_)):
        assignment.flag = bool(value)
    elif hasattr(value, "__len__"):
        assignment.numbers.values.extend(float(number) for number in value)
    else:
        assignment.number = float(value)


def read_value(assignment: control_pb2.Assignment) -> Any:
    """The value of an Assignment: bool, float, str, an array of numbers, or None where it is of a kind not known here."""
    kind = assignment.WhichOneof("value")
    if kind is None:
        return None
    return as_array(assignment.numbers.values) if kind == "numbers" else getattr(assignment, kind)
