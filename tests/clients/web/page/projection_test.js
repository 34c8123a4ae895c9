// Widths in pixels against rays drawn by hand.
import assert from 'node:assert/strict';
import test from 'node:test';
import { pixelsPerMetre, stringWidthPx } from '../../../../clients/web/page/src/model/projection.js';

test('at the distance where the view is as high as the picture in millimetres, a pixel is a millimetre', () => {
  const fovDeg = 90; // at 0.36 m one sees 0.72 m of height
  assert.ok(Math.abs(pixelsPerMetre(0.36, fovDeg, 720) - 1000) < 1e-9);
});

test('a string is as wide as its magnified diameter', () => {
  const common = { depthM: 0.36, fovDeg: 90, heightPx: 720, leastPx: 1 };
  assert.ok(Math.abs(stringWidthPx({ radiusM: 0.003, magnify: 1, ...common }) - 6) < 1e-9);
  assert.ok(Math.abs(stringWidthPx({ radiusM: 0.003, magnify: 10, ...common }) - 60) < 1e-9);
});

test('a far string is never thinner than what can be seen', () => {
  assert.equal(stringWidthPx({ radiusM: 0.00034, magnify: 1, depthM: 30, fovDeg: 38, heightPx: 720, leastPx: 1.4 }), 1.4);
});
