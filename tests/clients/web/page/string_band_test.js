// The rings of a band against sines written out: where they stand on a bent axis, and how wide they are.
import assert from 'node:assert/strict';
import test from 'node:test';
import { bandRings, ringsOfBand } from '../../../../clients/web/page/src/drawing/string_band.js';

const R = 0.0004;
const string = { radiusM: R, points: [[0, 0, 0], [0.8, 0, 0]] };
const near = (value, wanted) => assert.ok(Math.abs(value - wanted) < 1e-12, `${value} is not ${wanted}`);

test('a string that rings alone with its third partial has three loops between four still places', () => {
  const shape = { lambda: 0.5, band: { from: 0, to: 1, partialsM: [0, 0, 0.002] } };
  const rings = bandRings(string, shape, string.points, 25);
  assert.equal(rings.length, 25);
  rings.forEach(({ at, radiusM }, k) => {
    near(at[0], (0.8 * k) / 24);
    near(radiusM, k % 8 === 0 ? 0 : R + 0.002 * Math.abs(Math.sin((Math.PI * k) / 8)));
  });
});

test('the band of a stopped string lies between the stop and the end, on the bent axis', () => {
  const axis = [[0, 0, 0], [0.2, -0.004, 0.001], [0.8, 0, 0]];
  const shape = { lambda: 0.25, band: { from: 0.25, to: 1, partialsM: [0.003, 0.001] } };
  const rings = bandRings(string, shape, axis, 13);
  rings.forEach(({ at, radiusM }, k) => {
    const s = k / 12;
    near(at[0], 0.2 + 0.6 * s);
    near(at[1], -0.004 * (1 - s));
    near(at[2], 0.001 * (1 - s));
    const swing = 0.003 * Math.sin(Math.PI * s) + 0.001 * Math.abs(Math.sin(2 * Math.PI * s));
    near(radiusM, swing > 1e-9 ? R + swing : 0);
  });
});

test('a band across the finger has its corner there', () => {
  const axis = [[0, 0, 0], [0.4, 0.01, 0], [0.8, 0, 0]];
  const rings = bandRings(string, { lambda: 0.5, band: { from: 0, to: 1, partialsM: [0.001] } }, axis, 9);
  rings.forEach(({ at }, k) => near(at[1], 0.01 * (1 - Math.abs(k / 4 - 1))));
});

test('of a cable in pieces a place is counted by the pieces', () => {
  const cable = { radiusM: R, points: [[0, 0, 0], [0.1, 0, 0], [0.5, 0, 0]] };
  const rings = bandRings(cable, { lambda: 0.5, band: { from: 0, to: 1, partialsM: [0.001] } }, cable.points, 9);
  near(rings[2].at[0], 0.05);
  near(rings[4].at[0], 0.1);
  near(rings[6].at[0], 0.3);
});

test('many strings have fewer rings each, and never too few for a half wave', () => {
  assert.deepEqual([1, 7, 12, 25, 1024].map(ringsOfBand), [25, 25, 14, 9, 9]);
});
