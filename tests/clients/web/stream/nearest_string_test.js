// Nearest string and distance against brute force that shares nothing: every sphere against every string by
// a search.
import assert from 'node:assert/strict';
import test from 'node:test';
import { bentAxis, nearestString } from '../../../../clients/web/stream/src/nearest_string.js';
import { length, subtract, transform } from '../../../../clients/web/stream/src/vector.js';

let seed = 20261;
const random = (low, high) => low + (high - low) * ((seed = (seed * 48271) % 2147483647) / 2147483647);

const strings = Array.from({ length: 7 }, (_, i) => ({
  points: [[0.55, 0.005 + 0.001 * i, 0.02 * (i - 3)], [-0.55, 0.002, 0.014 * (i - 3)]], radiusM: 0.00034 + 0.00006 * i }));
const spheres = Float64Array.from(Array.from({ length: 40 }, () => [random(-0.03, 0.03), random(-0.02, 0.02), random(-0.03, 0.03), random(0.002, 0.006)]).flat());

function randomPose() {
  const q = [random(-1, 1), random(-1, 1), random(-1, 1), random(-1, 1)];
  const size = Math.hypot(...q);
  return { p: [random(-0.6, 0.6), random(0.03, 0.1), random(-0.08, 0.08)], q: q.map((value) => value / size) };
}

/** Distance of `centre` to the piece from `a` to `b`, which is convex along it: by halving what cannot hold the smallest. */
function byHalving(centre, a, b) {
  const distance = (t) => length(subtract(centre, a.map((value, axis) => value + (b[axis] - value) * t)));
  let low = 0, high = 1;
  for (let i = 0; i < 90; ++i) {
    const third = (high - low) / 3;
    if (distance(low + third) < distance(high - third)) high -= third;
    else low += third;
  }
  return Math.min(distance(0), distance(1), distance((low + high) / 2));
}

/** Every sphere, in the world, against every piece of every string. */
function truth(pose, chains) {
  let best = { distanceM: Infinity };
  for (let i = 0; i < spheres.length; i += 4) {
    const centre = transform(pose, [...spheres.subarray(i, i + 3)]);
    chains.forEach(({ points, radiusM }, index) => {
      for (let k = 0; k + 1 < points.length; ++k) {
        const distanceM = byHalving(centre, points[k], points[k + 1]) - spheres[i + 3] - radiusM;
        if (distanceM < best.distanceM) best = { index, distanceM };
      }
    });
  }
  return best;
}

test('string and distance equal an exhaustive search at 20 poses', () => {
  for (let n = 0; n < 20; ++n) {
    const pose = randomPose();
    const found = nearestString(spheres, pose, strings), expected = truth(pose, strings);
    assert.equal(found.index, expected.index);
    assert.ok(Math.abs(found.distanceM - expected.distanceM) < 1e-9, `${found.distanceM} is not ${expected.distanceM}`);
    assert.ok(Math.abs(length(subtract(found.onString, found.onTool)) - Math.abs(found.distanceM)) < 1e-9);
  }
});

test('a bent string is near where it was bent to', () => {
  const bent = { ...strings[3], points: bentAxis(strings[3], { deflection: [0, -0.004, 0.003], lambda: 0.3 }) };
  const pose = { p: [0.22, -0.03, 0.003], q: [1, 0, 0, 0] };
  const found = nearestString(spheres, pose, [bent]);
  assert.ok(Math.abs(found.distanceM - truth(pose, [bent]).distanceM) < 1e-9);
  assert.ok(found.distanceM < nearestString(spheres, pose, [strings[3]]).distanceM - 1e-4);
});

test('a tool inside a string has a negative distance', () => {
  const found = nearestString(Float64Array.of(0, 0, 0, 0.005), { p: [0, 0.003, 0], q: [1, 0, 0, 0] }, [{ points: [[-1, 0, 0], [1, 0, 0]], radiusM: 0.001 }]);
  assert.ok(Math.abs(found.distanceM + 0.003) < 1e-12);
});

test('without strings or without spheres there is no nearest one', () => {
  assert.equal(nearestString(spheres, randomPose(), []), null);
  assert.equal(nearestString(new Float64Array(), randomPose(), strings), null);
});
