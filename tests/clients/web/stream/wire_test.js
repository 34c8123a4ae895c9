// The page's readers and writers against bytes that protoc made.
import assert from 'node:assert/strict';
import test from 'node:test';
import { hex, nameOf, v1 } from '../../../../clients/web/stream/src/wire.js';
import { bytesOf, exampleOf, names, typeOf } from './examples.js';

test('every example is written as it was read', () => {
  for (const name of names) assert.equal(hex(typeOf(name).encode(exampleOf(name)).finish()), hex(bytesOf(name)), name);
});

test('a welcome says what the page may do and how late it shows', () => {
  const { sequence, welcome } = exampleOf('page_welcome');
  assert.deepEqual([sequence, welcome.version, welcome.control, welcome.steer, welcome.source, welcome.presentation_delay_s], [1, '0.1.0', true, true, 1, 0.008]);
  assert.equal(welcome.scene_hash.length, 32);
});

test('a link says what is wrong in words and numbers', () => {
  const { link } = exampleOf('page_link');
  assert.deepEqual([link.state, link.message, link.clock_offset_s, link.loss, link.dropped_states],
    [v1.PageLinkState.PAGE_LINK_STATE_SILENT, 'nothing has come from 10.0.0.2:47800 for 3 s', -1234.5, 0.2, 17]);
  assert.equal(nameOf(v1.PageLinkState, 'PAGE_LINK_STATE_', link.state), 'silent');
});

test('instants are plain numbers, exact to 2^53', () => {
  assert.equal(exampleOf('page_pong').pong.daemon_t_ns, 123456789012);
  assert.equal(exampleOf('contact_event').state.t_ns, 2 ** 53 - 1);
});

test('a tone and a refusal arrive whole', () => {
  const { tone } = exampleOf('page_item').item;
  assert.deepEqual([tone.t_ns, tone.string_index, tone.frequency_hz, tone.decay_s], [19345678, 3, 98, 0.5]);
  const { result } = exampleOf('page_result');
  assert.deepEqual([result.item_id, nameOf(v1.ResultCode, 'RESULT_CODE_', result.code), result.message], [3, 'not permitted', 'this page only looks']);
});

test('what the page sends is what protoc would write', () => {
  const call = { set_parameter: { assignments: [{ path: 'strings[3].tension_n', number: 45 }] } };
  assert.equal(hex(v1.PageRequest.encode({ id: 3, call }).finish()), hex(bytesOf('page_call')));
  assert.equal(hex(v1.PageRequest.encode({ id: 4, playback: { position_s: 30, rate: 1 } }).finish()), hex(bytesOf('page_seek')));
  assert.equal(hex(v1.PageRequest.encode({ id: 5, ping: { sent_s: 8.125 } }).finish()), hex(bytesOf('page_ping')));
  assert.equal(hex(v1.PageRequest.encode({ id: 6, show: { recording: '20260102T030405.mcap' } }).finish()), hex(bytesOf('page_show')));
  assert.equal(hex(v1.PageRequest.encode({ id: 7, list_recordings: {} }).finish()), hex(bytesOf('page_list_recordings')));
  assert.equal(hex(v1.PageRequest.encode({ id: 8, experiment: { begin: { participant: 'P1', seed: 7, repetitions: 3 } } }).finish()), hex(bytesOf('page_experiment_begin')));
  assert.equal(hex(v1.PageRequest.encode({ id: 9, experiment: { answer: { number: 12, reply: 6, score: 85 } } }).finish()), hex(bytesOf('page_experiment_answer')));
  assert.equal(hex(v1.PageRequest.encode({ id: 10, experiment: { end: {} } }).finish()), hex(bytesOf('page_experiment_end')));
});

test('signed columns of contacts keep their signs and their size', () => {
  const [patch] = exampleOf('contact_event').state.contacts;
  assert.deepEqual(patch.tool_sphere, [17, -3]);
  assert.deepEqual(patch.p_wc_um, [-250000, 500001, 0, 1000000000000, -1, 2]);
  assert.deepEqual(patch.gap_nanometres, [-12, 40]);
  assert.ok(Object.hasOwn(patch, 'string_index') && patch.string_index === 0 && !Object.hasOwn(patch, 'body_index'));
});

test('a hash is two lower-case digits a byte', () => {
  assert.equal(hex(Uint8Array.of(0, 1, 10, 255)), '00010aff');
});
