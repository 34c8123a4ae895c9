// The drawn radius R + r(t) of a string against the decay written out.
import assert from 'node:assert/strict';
import test from 'node:test';
import { StringMotion, stringShape } from '../../../../clients/web/stream/src/string_motion.js';

const PRESS = 1, RELEASE = 2, DAMP = 3;
const PRESSED = 2, RINGING = 3;
const string = { radiusM: 0.00034, points: [[0, 0, 0], [1, 0, 0]] };
const release = { string_index: 2, phase: RELEASE, t_ns: 7e12, r_max_m: 0.003, decay_s: 0.5, delta_m: 0, frequency_hz: 98 };

test('a released string has R + r_max exp(-t/T_d) at ten instants', () => {
  const motion = new StringMotion();
  motion.add(release);
  for (let i = 0; i < 10; ++i) {
    const t = 0.13 * i;
    const shape = stringShape(string, 2, undefined, motion, 7e12 + t * 1e9);
    assert.ok(Math.abs(shape.radiusM - (0.00034 + 0.003 * Math.exp(-t / 0.5))) < 1e-12);
  }
});

test('before its instant an event is not seen, although it has arrived', () => {
  const motion = new StringMotion();
  motion.add(release);
  assert.equal(stringShape(string, 2, undefined, motion, 7e12 - 1).radiusM, 0.00034);
});

test('other strings stay as they are', () => {
  const motion = new StringMotion();
  motion.add(release);
  assert.equal(stringShape(string, 3, undefined, motion, 7e12 + 1e6).radiusM, 0.00034);
});

test('a finger on a ringing string makes it decay faster from then on', () => {
  const motion = new StringMotion();
  motion.add(release);
  const left = 0.003 * Math.exp(-0.2 / 0.5);
  motion.add({ ...release, phase: DAMP, t_ns: 7.2e12, r_max_m: left, decay_s: 0.03 });
  const at = (s) => stringShape(string, 2, { string_index: 2, phase: RINGING, deflection_w_m: [], lambda: 0.1, radius_m: 0.002 }, motion, 7e12 + s * 1e9).envelopeM;
  assert.ok(Math.abs(at(0.1) - 0.003 * Math.exp(-0.1 / 0.5)) < 1e-12);
  assert.ok(Math.abs(at(200.03) - left * Math.exp(-(200.03 - 200) / 0.03)) < 1e-12);
});

test('a held string is drawn as States say: R + deflection, bent where the finger is', () => {
  const motion = new StringMotion();
  motion.add({ ...release, phase: PRESS, t_ns: 6.9e12 });
  const state = { string_index: 2, phase: PRESSED, deflection_w_m: [0, -0.002, 0], lambda: 0.25, radius_m: 0.00234 };
  const shape = stringShape(string, 2, state, motion, 6.95e12);
  assert.ok(Math.abs(shape.envelopeM - 0.002) < 1e-12);
  assert.deepEqual([shape.deflection, shape.lambda], [[0, -0.002, 0], 0.25]);
});

test('who joins while a string rings draws it from States', () => {
  const state = { string_index: 2, phase: RINGING, deflection_w_m: [], lambda: 0.1, radius_m: 0.00134 };
  assert.ok(Math.abs(stringShape(string, 2, state, new StringMotion(), 7e12).envelopeM - 0.001) < 1e-12);
});

test('what has decayed below what is seen is at rest', () => {
  const motion = new StringMotion();
  motion.add(release);
  assert.equal(stringShape(string, 2, undefined, motion, 7e12 + 20e9).envelopeM, 0);
});
