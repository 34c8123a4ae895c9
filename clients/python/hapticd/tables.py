"""Columns of numbers with their units, of States and of events: for numpy, xarray, pandas and files. Each column is a numpy array, or a list
where numpy is missing. Frames as in proto/hapticd/v1/state.proto and event.proto; units are SI."""
from __future__ import annotations

import csv
import difflib
import math
import operator
import os
from typing import TYPE_CHECKING, Any, Dict, Iterable, Iterator, List, Mapping, NamedTuple, Sequence, Tuple, Union

from google.protobuf.descriptor import FieldDescriptor

from hapticd.conversation import Event
from hapticd.v1 import event_pb2, state_pb2
from hapticd.values import as_array

if TYPE_CHECKING:
    import numpy
    import pandas
    import xarray

XYZ = ("x", "y", "z")
WXYZ = ("w", "x", "y", "z")
WRENCH = ("fx", "fy", "fz", "tx", "ty", "tz")
EVENT_KINDS = ("tone", "contact", "string_radius", "string_sounding", "fault")
"""Events that have an instant."""


class Kind(NamedTuple):
    """What a column holds: its unit, "" for text, and the names of the components where a row has several. `component_units`: those of the
    components, where they differ."""

    unit: str
    components: Tuple[str, ...] = ()
    component_units: Tuple[str, ...] = ()


STATE_COLUMNS = {
    "tick": Kind("1"), "t_s": Kind("s"), "minimum_gap_m": Kind("m"), "p_wh_m": Kind("m", XYZ), "q_wh": Kind("1", WXYZ), "p_wg_m": Kind("m", XYZ),
    "q_wg": Kind("1", WXYZ), "wrench_h_w": Kind("N, N m", WRENCH, ("N", "N", "N", "N m", "N m", "N m")),
}
# By the end of a field's name, the longest first.
UNITS = (("_m_per_s", "m/s"), ("_cents", "cents"), ("_hz", "Hz"), ("_m", "m"), ("_s", "s"), ("_n", "N"))


class Table(Mapping[str, Any]):
    """Columns by name, each with a row per State or event: table["t_s"]. `units` has the unit of each, "1" for pure numbers, "" for text."""

    def __init__(self, columns: Mapping[str, Sequence[Any]], kinds: Mapping[str, Kind]) -> None:
        lengths = {len(column) for column in columns.values()}
        if len(lengths) > 1:
            raise ValueError(f"the columns of a table have as many rows as each other, and not {sorted(lengths)}")
        self.rows = lengths.pop() if lengths else 0
        self.units = {name: kinds[name].unit for name in columns}
        self._kinds = dict(kinds)
        self._columns = {name: as_array(column) for name, column in columns.items()}

    def __getitem__(self, name: str) -> Any:
        return self._columns[name]

    def __iter__(self) -> Iterator[str]:
        return iter(self._columns)

    def __len__(self) -> int:
        return len(self._columns)

    def __repr__(self) -> str:
        names = ", ".join(f"{name} [{unit}]" if unit else name for name, unit in self.units.items())
        return f"<Table of {self.rows} rows: {names}>"

    def to_numpy(self) -> "numpy.ndarray[Any, Any]":
        """One structured array with a field for each column. ModuleNotFoundError without numpy."""
        numpy = _module("numpy")
        columns = {name: numpy.asarray(self._filled(name)) for name in self}
        made = numpy.empty(self.rows, [(name, column.dtype, column.shape[1:]) for name, column in columns.items()])
        for name, column in columns.items():
            made[name] = column
        return made

    def to_csv(self, path: Union[str, "os.PathLike[str]"]) -> None:
        """Writes a file with a line of names and units, such as "p_wh_m_x [m]", and a line for each row. Numbers are written so that
        reading them gives the same bits. What is there is replaced."""
        flat = self._flat()
        with open(path, "w", newline="", encoding="utf-8") as file:
            writer = csv.writer(file, lineterminator="\n")
            writer.writerow([f"{name} [{unit}]" if unit else name for name, (unit, _) in flat.items()])
            writer.writerows(zip(*(column for _, column in flat.values())))

    def to_pandas(self) -> "pandas.DataFrame":
        """A DataFrame with a column for each number; its attrs["units"] has their units. ModuleNotFoundError without pandas."""
        flat = self._flat()
        made = _module("pandas").DataFrame({name: column for name, (_, column) in flat.items()})
        made.attrs["units"] = {name: unit for name, (unit, _) in flat.items()}
        return made

    def to_xarray(self) -> "xarray.Dataset":
        """A Dataset along t_s, each variable with its unit in attrs["units"]. ModuleNotFoundError without xarray."""
        xarray = _module("xarray")
        variables, coordinates = {}, {}
        for name in self:
            components = self._kinds[name].components
            along = ("t_s", f"{name}_component") if components else ("t_s",)
            variables[name] = xarray.Variable(along, self._filled(name), {"units": self.units[name]})
            if components:
                coordinates[along[1]] = list(components)
        return xarray.Dataset(variables, coordinates).set_coords("t_s")

    def _filled(self, name: str) -> Any:
        """The column; without rows it still has its width."""
        width = len(self._kinds[name].components)
        return _module("numpy").zeros((0, width)) if width and not self.rows else self._columns[name]

    def _flat(self) -> Dict[str, Tuple[str, List[Any]]]:
        """A column for each number: unit and values, which are Python's own."""
        flat: Dict[str, Tuple[str, List[Any]]] = {}
        for name, column in self._columns.items():
            kind = self._kinds[name]
            values = column.tolist() if hasattr(column, "tolist") else list(column)
            if not kind.components:
                flat[name] = (kind.unit, values)
            for place, component in enumerate(kind.components):
                unit = kind.component_units[place] if kind.component_units else kind.unit
                flat[f"{name}_{component}"] = (unit, [row[place] for row in values])
        return flat


def table(states: Iterable[state_pb2.State], tool_id: int = 0) -> Table:
    """The States of a tool, a row for each State that has it: tick, t_s, p_wh_m (n x 3) and q_wh (n x 4, w x y z) of the haptic tool, p_wg_m and
    q_wg of the graphic tool, wrench_h_w (n x 6, force then torque, N and N m), minimum_gap_m. ValueError where tool_id is no number."""
    tools = [(state, tool) for state in states for tool in state.tools]
    try:
        wanted = operator.index(tool_id)
    except TypeError:
        there_are = ", ".join(str(number) for number in sorted({tool.tool_id for _, tool in tools})) or "none in these States"
        near = difflib.get_close_matches(str(tool_id), EVENT_KINDS, 1)
        hint = f" Did you mean event_table({near[0]!r})?" if near else ""
        raise ValueError(f"{tool_id!r} is no tool_id: tools are numbers, and there are {there_are}.{hint}") from None
    rows = [(state, tool) for state, tool in tools if tool.tool_id == wanted]
    columns: Dict[str, List[Any]] = {"tick": [state.tick for state, _ in rows], "t_s": [state.t_ns * 1e-9 for state, _ in rows]}
    for name, kind in STATE_COLUMNS.items():
        if name not in columns:
            columns[name] = [_number_or_row(tool, name, kind) for _, tool in rows]
    return Table({name: columns[name] for name in STATE_COLUMNS}, STATE_COLUMNS)


def event_table(events: Iterable[Event], kind: str = "tone") -> Table:
    """The events of one kind, "tone", "contact", "string_radius", "string_sounding" or "fault", a row for each: t_s, and the fields of event.proto by name. Numbers
    that an event does not have are -1, as the string_index of a contact with a body; `phase` and `cause` are names. Tone.partials, of
    which each tone has its own number, is left out."""
    if kind not in EVENT_KINDS:
        near = difflib.get_close_matches(str(kind), EVENT_KINDS, 1)
        raise ValueError(f"{kind!r} is none of {', '.join(EVENT_KINDS)}.{f' Did you mean {near[0]}?' if near else ''}")
    bodies = [event.body for event in events if event.kind == kind]
    message = event_pb2.DESCRIPTOR.message_types_by_name["".join(word.capitalize() for word in kind.split("_"))]
    columns: Dict[str, List[Any]] = {"t_s": [body.t_ns * 1e-9 for body in bodies]}
    kinds = {"t_s": Kind("s")}
    for each in message.fields:
        if each.name in ("t_ns", "partials"):
            continue
        columns[each.name] = [_value(body, each) for body in bodies]
        kinds[each.name] = _kind(each)
    return Table(columns, kinds)


def _number_or_row(message: Any, name: str, kind: Kind) -> Any:
    """A row of another length than it must have is one of NaN."""
    value = getattr(message, name)
    if not kind.components:
        return value
    return list(value) if len(value) == len(kind.components) else [math.nan] * len(kind.components)


def _value(body: Any, field: FieldDescriptor) -> Any:
    if _is_repeated(field):
        return _number_or_row(body, field.name, _kind(field))
    if field.has_presence and not body.HasField(field.name):
        return -1
    value = getattr(body, field.name)
    if field.enum_type is None:
        return value
    names = field.enum_type.values_by_number
    prefix = field.enum_type.values_by_number[0].name.removesuffix("UNSPECIFIED")
    return names[value].name.removeprefix(prefix) if value in names else str(value)


def _kind(field: FieldDescriptor) -> Kind:
    if field.enum_type is not None or field.type == FieldDescriptor.TYPE_STRING:
        return Kind("")
    unit = next((unit for end, unit in UNITS if field.name.endswith(end)), "1")
    return Kind(unit, XYZ if _is_repeated(field) else ())


def _is_repeated(field: FieldDescriptor) -> bool:
    """protobuf 7 has no `label`, and Debian's 4.21 no `is_repeated`."""
    return field.is_repeated if hasattr(field, "is_repeated") else field.label == FieldDescriptor.LABEL_REPEATED


def _module(name: str) -> Any:
    """A module that not everyone has; where it is missing the error says how to get it."""
    try:
        return __import__(name)
    except ModuleNotFoundError:
        raise ModuleNotFoundError(f"{name} is not installed; Debian has it as python3-{name}", name=name) from None
