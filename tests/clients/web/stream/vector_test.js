// Rotations and interpolation against closed forms.
import assert from 'node:assert/strict';
import test from 'node:test';
import { multiply, rotate, slerp, transform, transformBack } from '../../../../clients/web/stream/src/vector.js';

const about = (axis, angle) => [Math.cos(angle / 2), ...axis.map((value) => value * Math.sin(angle / 2))];
const near = (a, b, tolerance = 1e-12) => a.forEach((value, i) => assert.ok(Math.abs(value - b[i]) <= tolerance, `${a} is not ${b}`));

test('a quarter turn about y takes z to x and x to -z', () => {
  const q = about([0, 1, 0], Math.PI / 2);
  near(rotate(q, [0, 0, 1]), [1, 0, 0]);
  near(rotate(q, [1, 0, 0]), [0, 0, -1]);
});

test('the product of two rotations is the second one first', () => {
  const a = about([1, 0, 0], 0.7), b = about([0, 0, 1], -1.3), v = [0.3, -2, 5];
  near(rotate(multiply(a, b), v), rotate(a, rotate(b, v)));
});

test('what a pose brings to the world it brings back', () => {
  const pose = { p: [1, -2, 3], q: about([0.6, 0, 0.8], 2.1) };
  near(transformBack(pose, transform(pose, [0.1, 0.2, 0.3])), [0.1, 0.2, 0.3]);
});

test('interpolated orientations turn at constant speed about the same axis', () => {
  const axis = [0, 0.6, 0.8];
  for (const t of [0, 0.2, 0.5, 0.9, 1]) near(slerp(about(axis, 0.3), about(axis, 1.5), t), about(axis, 0.3 + 1.2 * t));
});

test('the shorter way is taken although q and -q mean the same', () => {
  const axis = [1, 0, 0];
  const middle = slerp(about(axis, 0.1), about(axis, 0.5).map((value) => -value), 0.5);
  near(rotate(middle, [0, 1, 0]), rotate(about(axis, 0.3), [0, 1, 0]));
});

test('two orientations that are almost one do not divide by nothing', () => {
  near(slerp([1, 0, 0, 0], about([0, 1, 0], 1e-9), 0.5), about([0, 1, 0], 0.5e-9), 1e-15);
});
