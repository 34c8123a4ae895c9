// States between States: straight motion is met exactly, parts become one tick, scenes do not mix.
import assert from 'node:assert/strict';
import test from 'node:test';
import { v1 } from '../../../../clients/web/stream/src/wire.js';
import { StateBuffer } from '../../../../clients/web/stream/src/state_buffer.js';

const MS = 1e6;
const turn = (angle) => [Math.cos(angle / 2), 0, Math.sin(angle / 2), 0];

/** A tool that moves at 0.3 m/s along x and turns at 2 rad/s about y. */
function stateAt(ms, more = {}) {
  const s = ms / 1000;
  const tool = { tool_id: 0, p_wh_m: [0.3 * s, 1, 2], q_wh: turn(2 * s), p_wg_m: [0.3 * s, 0, 0], q_wg: turn(2 * s), wrench_h_w: [s, 0, 0, 0, 0, 0], flags: [] };
  return { t_ns: 5e12 + ms * MS, scene_id: 1, tools: [tool], strings: [], contacts: [], part_count: 0, ...more };
}

test('between two States positions lie on the straight way and orientations on the arc', () => {
  const buffer = new StateBuffer();
  for (const ms of [0, 4, 8, 12]) buffer.add(stateAt(ms));
  for (const ms of [1, 3.5, 6, 11.9]) {
    const tool = buffer.at(5e12 + ms * MS).tools[0];
    assert.ok(Math.abs(tool.p_wg_m[0] - 0.0003 * ms) < 1e-12);
    turn(0.002 * ms).forEach((value, i) => assert.ok(Math.abs(tool.q_wh[i] - value) < 1e-9));
    assert.ok(Math.abs(tool.wrench_h_w[0] - ms / 1000) < 1e-12);
  }
});

test('fields at their default, which are not on the wire, are still there between two States', () => {
  const buffer = new StateBuffer();
  for (const t_ns of [1000, 2000]) {
    const tool = { tool_id: 0, p_wh_m: [0, 0, 0], q_wh: [1, 0, 0, 0], p_wg_m: [0, 0, 0], q_wg: [1, 0, 0, 0] };
    const string = { string_index: 0, phase: 2, radius_m: 0.001 };
    buffer.add(v1.State.decode(v1.State.encode({ t_ns, scene_id: 1, tools: [tool], strings: [string] }).finish()));
  }
  const state = buffer.at(1500);
  assert.deepEqual([state.tools[0].tool_id, state.tools[0].minimum_gap_m, state.strings[0].string_index, state.cause], [0, 0, 0, 0]);
});

test('before the oldest and after the newest nothing is invented', () => {
  const buffer = new StateBuffer();
  assert.equal(buffer.at(0), null);
  [0, 4].forEach((ms) => buffer.add(stateAt(ms)));
  assert.equal(buffer.at(0).t_ns, 5e12);
  assert.equal(buffer.at(9e12).t_ns, 5e12 + 4 * MS);
});

test('a State from before begins anew, as a recording that was moved back does', () => {
  const buffer = new StateBuffer();
  [0, 4, 8].forEach((ms) => buffer.add(stateAt(ms)));
  buffer.add(stateAt(6));
  assert.equal(buffer.at(9e12).t_ns, 5e12 + 6 * MS);
  assert.equal(buffer.at(0).t_ns, 5e12 + 6 * MS);
});

test('tools of one tick in two datagrams are together, each once', () => {
  const buffer = new StateBuffer();
  const other = { ...stateAt(4).tools[0], tool_id: 7 };
  buffer.add(stateAt(4, { part_count: 2 }));
  buffer.add(stateAt(4, { part_count: 2, part_index: 1, tools: [other] }));
  buffer.add(stateAt(4, { part_count: 2, part_index: 1, tools: [other] }));
  assert.deepEqual(buffer.newest.tools.map((tool) => tool.tool_id), [0, 7]);
});

test('a new scene begins with an empty buffer', () => {
  const buffer = new StateBuffer();
  [0, 4].forEach((ms) => buffer.add(stateAt(ms)));
  buffer.add(stateAt(8, { scene_id: 2 }));
  assert.equal(buffer.at(0).scene_id, 2);
});
