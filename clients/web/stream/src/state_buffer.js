// The last States by their instant, and what lies between two of them: positions on the straight way, orientations on the arc, contacts
// of the earlier one. A tick whose tools fill several datagrams is put together again.
import { mix, slerp } from './vector.js';

const KEEP_NS = 0.5e9; // longer than any presentation delay

export class StateBuffer {
  #states = [];

  get newest() {
    return this.#states.at(-1) ?? null;
  }

  clear() {
    this.#states = [];
  }

  /** Takes a State. They come in order; one from before the newest is a recording that was moved, or another run of the daemon. */
  add(state) {
    const newest = this.newest;
    if (newest && state.scene_id !== newest.scene_id) this.clear();
    else if (newest && state.t_ns === newest.t_ns && state.part_count > 0) return mergePart(newest, state);
    else if (newest && state.t_ns <= newest.t_ns) this.clear();
    this.#states.push(state);
    while (this.#states[0].t_ns < state.t_ns - KEEP_NS) this.#states.shift();
  }

  /** The tick at `ns`, between the States around it; before the oldest it is the oldest, after the newest the newest. */
  at(ns) {
    const states = this.#states;
    if (states.length === 0) return null;
    let after = states.length;
    while (after > 0 && states[after - 1].t_ns > ns) --after;
    if (after === 0) return states[0];
    if (after === states.length) return states[after - 1];
    return between(states[after - 1], states[after], ns);
  }
}

function mergePart(whole, part) {
  const known = new Set(whole.tools.map((tool) => tool.tool_id));
  whole.tools.push(...part.tools.filter((tool) => !known.has(tool.tool_id)));
  whole.contacts.push(...part.contacts);
}

function between(a, b, ns) {
  const t = (ns - a.t_ns) / (b.t_ns - a.t_ns);
  const tools = a.tools.map((tool) => {
    const next = b.tools.find((other) => other.tool_id === tool.tool_id);
    return next ? toolBetween(tool, next, t) : tool;
  });
  const strings = a.strings.map((string) => {
    const next = b.strings.find((other) => other.string_index === string.string_index);
    return next && next.phase === string.phase ? stringBetween(string, next, t) : string;
  });
  return changed(a, { t_ns: ns, tools, strings });
}

/** A copy of `message` with some fields changed; fields at their default, such as tool_id 0, stand in its prototype and stay there. */
function changed(message, fields) {
  return Object.assign(Object.create(Object.getPrototypeOf(message)), message, fields);
}

function toolBetween(a, b, t) {
  return changed(a, {
    p_wh_m: mix(a.p_wh_m, b.p_wh_m, t),
    p_wg_m: mix(a.p_wg_m, b.p_wg_m, t),
    q_wh: slerp(a.q_wh, b.q_wh, t),
    q_wg: slerp(a.q_wg, b.q_wg, t),
    wrench_h_w: mix(a.wrench_h_w, b.wrench_h_w, t),
  });
}

function stringBetween(a, b, t) {
  const deflection = a.deflection_w_m.length === 3 && b.deflection_w_m.length === 3
    ? mix(a.deflection_w_m, b.deflection_w_m, t) : a.deflection_w_m;
  const radius = a.radius_m + (b.radius_m - a.radius_m) * t;
  return changed(a, { deflection_w_m: deflection, lambda: a.lambda + (b.lambda - a.lambda) * t, radius_m: radius });
}
