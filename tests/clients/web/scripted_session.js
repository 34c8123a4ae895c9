// A session made up for tests of the page: seven strings, a finger of one ball that glides above them, one contact that stays, one string
// that is released again and again. Everything in it is a closed form, so that what is drawn can be judged without the page's own code.
// Used by mock_gateway.js in place of a capture.

export const DURATION_S = 8;
export const STATES_PER_S = 250;
const START_NS = 50e12;
const RELEASE = 2;

export const STRINGS = Array.from({ length: 7 }, (_, i) => ({ name: ['C2', 'D2', 'F2', 'G2', 'A2', 'C3', 'D3'][i],
  p_wa_m: [0.55, 0.01, 0.02 * (i - 3)], p_wb_m: [-0.55, 0.002, 0.014 * (i - 3)], radius_m: 0.0004 }));
export const FINGER_RADIUS_M = 0.005;
/** The string that rings, from second 1 on in every round. */
export const RINGING = { index: 5, releasedS: 1, r_max_m: 0.004, decay_s: 1.5 };
export const CONTACT = { point_um: [120000, 8000, 3000], normal_e4: [0, 10000, 0], force_mn: 2500 };

/** Where the finger is `s` seconds into a round. */
export const fingerAt = (s) => [0.3 * Math.sin((2 * Math.PI * s) / DURATION_S), 0.03, 0.06 * Math.cos((4 * Math.PI * s) / DURATION_S)];

const scene = {
  name: 'scripted',
  description: 'Seven strings, made up',
  tools: [{ tool_id: 0, name: 'finger', parts: [{ name: 'tip', shape: { spheres: { centre_m: [0, 0, 0], radius_m: [FINGER_RADIUS_M] } } }], pose_wg: { p_m: fingerAt(0), q: [1, 0, 0, 0] } }],
  bodies: [],
  lines: [],
  strings: STRINGS,
};

function stateAt(k) {
  const s = k / STATES_PER_S;
  const p = fingerAt(s);
  return { tick: 4 * k, t_ns: START_NS + s * 1e9, loop_state: 4, scene_id: 1,
    tools: [{ tool_id: 0, p_wh_m: [p[0], p[1] - 0.006, p[2]], q_wh: [1, 0, 0, 0], p_wg_m: p, q_wg: [1, 0, 0, 0], wrench_h_w: [0, 2 + Math.sin(s), 0, 0, 0, 0.02], minimum_gap_m: 0.001 }],
    strings: [],
    contacts: [{ tool_id: 0, string_index: 3, force_w_n: [0, 2.5, 0], tool_sphere: [0], p_wc_um: CONTACT.point_um, nhat_og_w_e4: CONTACT.normal_e4, gap_nanometres: [0], force_mn: [CONTACT.force_mn] }],
    timing: { last_ns: 30000 + 100 * (k % 50), p50_ns: 30000, p99_ns: 35000 },
    energy: { tools: [{ tool_id: 0, port_j: 0.001 * Math.sin(s) }], strings_j: 0.001, tanks_j: 0.0005 } };
}

/** PageEvents of one round, as plain objects. */
export function scriptedEvents() {
  const info = { scene_id: 1, scene, hash: new Uint8Array(32), assets: [], parameters: [{ path: 'strings[*].tension_n', unit: 'N', minimum: 0, maximum: 1e6 }], rate_hz: 1000, clock: 1, server_version: 'scripted' };
  const radius = { t_ns: START_NS + RINGING.releasedS * 1e9, string_index: RINGING.index, phase: RELEASE, r_max_m: RINGING.r_max_m, decay_s: RINGING.decay_s, frequency_hz: 130.8 };
  const states = Array.from({ length: DURATION_S * STATES_PER_S }, (_, k) => ({ state: stateAt(k) }));
  return [{ item: { scene_info: info } }, { item: { record_info: { state: 1 } } }, { item: { string_radius: radius } }, ...states];
}
