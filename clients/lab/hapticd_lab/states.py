"""From the States of a session to the columns of a Trace."""
from __future__ import annotations

from typing import Any, Dict, List, Sequence

import numpy

from hapticd import values
from hapticd.v1 import state_pb2
from hapticd_lab.trace import Trace

REGION_M = 0.005
"""Contacts that bear force belong to one region when a chain of them has no gap beyond this."""


def build_trace(scene_info: Any, states: Sequence[state_pb2.State], events: List[Any], tool_id: int = 0) -> Trace:
    """The tool's session, a row for each State."""
    count = len(states)
    trace = Trace(
        tick=numpy.array([state.tick for state in states]), t_s=numpy.array([state.t_ns for state in states]) * 1e-9,
        force_n=numpy.zeros((count, 3)), torque_n_m=numpy.zeros((count, 3)), unlimited_force_n=numpy.zeros((count, 3)),
        cpu_us=numpy.array([state.timing.last_ns for state in states]) * 1e-3, p_wh_m=numpy.zeros((count, 3)), q_wh=numpy.zeros((count, 4)),
        p_wg_m=numpy.zeros((count, 3)), q_wg=numpy.zeros((count, 4)), gap_m=numpy.zeros(count),
        substeps=numpy.array([state.quality.substeps for state in states]),
        sphere_tests=numpy.array([state.quality.sphere_tests for state in states]), port_j=numpy.zeros(count),
        stiffness_scale=numpy.ones(count), flags=[frozenset()] * count, events=[event for event in events if _within(event, states)])
    trace.began_s = float(trace.t_s[0]) if count else 0.0
    coupling = next(tool.coupling for tool in scene_info.scene.tools if tool.tool_id == tool_id)
    trace.kt_n_per_m, trace.length_m = coupling.kt_n_per_m, coupling.length_m
    trace.strings = list(scene_info.scene.strings)
    trace.contact_stiffness_n_per_m = max((string.contact_stiffness_n_per_m for string in trace.strings), default=0.0)
    trace.t_s -= trace.began_s
    names = {kind: [each.name for each in getattr(scene_info.scene, kind)] for kind in ("strings", "bodies", "lines")}
    for row, state in enumerate(states):
        _take_tool(trace, row, state, tool_id)
        _take_strings(trace, row, state, names)
        for patch in state.contacts:
            if patch.tool_id == tool_id:
                _take_patch(trace, row, patch, names)
    return trace


def _within(event: Any, states: Sequence[state_pb2.State]) -> bool:
    t_ns = getattr(event.body, "t_ns", None)
    return t_ns is not None and bool(states) and states[0].t_ns <= t_ns <= states[-1].t_ns


def _take_tool(trace: Trace, row: int, state: state_pb2.State, tool_id: int) -> None:
    tool = values.tool_state(state, tool_id)
    if tool is None:
        return
    trace.force_n[row] = tool.wrench_h_w[:3]
    trace.torque_n_m[row] = tool.wrench_h_w[3:]
    trace.unlimited_force_n[row] = (tool.wrench_unlimited_h_w or tool.wrench_h_w)[:3]
    trace.p_wh_m[row], trace.q_wh[row] = tool.p_wh_m, tool.q_wh
    trace.p_wg_m[row], trace.q_wg[row] = tool.p_wg_m, tool.q_wg
    trace.gap_m[row] = tool.minimum_gap_m
    trace.flags[row] = frozenset(state_pb2.ToolFlag.Name(flag)[len("TOOL_FLAG_"):] for flag in tool.flags)
    trace.port_j[row] = next((each.port_j for each in state.energy.tools if each.tool_id == tool_id), 0.0)
    trace.stiffness_scale[row] = next((each.scale for each in state.stiffness if each.tool_id == tool_id), 1.0)


def _column(columns: Dict[str, numpy.ndarray], name: str, shape: Sequence[int]) -> numpy.ndarray:
    return columns.setdefault(name, numpy.zeros(shape))


def _take_strings(trace: Trace, row: int, state: state_pb2.State, names: Dict[str, List[str]]) -> None:
    for string in state.strings:
        name = names["strings"][string.string_index]
        _column(trace.deflection_m, name, (len(trace), 3))[row] = string.deflection_w_m or (0.0, 0.0, 0.0)
        _column(trace.radius_m, name, (len(trace),))[row] = string.radius_m
        _column(trace.string_phase, name, (len(trace),))[row] = string.phase


def _take_patch(trace: Trace, row: int, patch: state_pb2.ContactPatch, names: Dict[str, List[str]]) -> None:
    kind = patch.WhichOneof("object")
    name = names[{"string_index": "strings", "body_index": "bodies", "line_index": "lines"}[kind]][getattr(patch, kind)]
    _column(trace.object_force_n, name, (len(trace), 3))[row] += patch.force_w_n
    force = numpy.asarray(patch.force_mn, float) * 1e-3
    points = numpy.asarray(patch.p_wc_um, float).reshape(-1, 3) * 1e-6
    found = regions(points[force > 0.0])
    _column(trace.regions, name, (len(trace),))[row] = len(found)
    if found:
        _column(trace.contact_m, name, (len(trace), 3))[row] = points[force > 0.0].mean(axis=0)
        strongest = max(float(force[force > 0.0][members].sum()) for members in found)
        _column(trace.region_force_n, name, (len(trace),))[row] = strongest


def regions(points: numpy.ndarray, apart_m: float = REGION_M) -> List[List[int]]:
    """Separate regions among points (n x 3), each as the points' numbers: single linkage, a new region where no point is within `apart_m`
    of another's."""
    left, found = list(range(len(points))), []
    while left:
        members, chain = [], [left.pop()]
        while chain:
            at = chain.pop()
            members.append(at)
            near = [k for k in left if numpy.linalg.norm(points[k] - points[at]) <= apart_m]
            left = [k for k in left if k not in near]
            chain += near
        found.append(members)
    return found
