// Widths and disparities in pixels against rays drawn by hand.
import assert from 'node:assert/strict';
import test from 'node:test';
import { disparityPx, pixelsPerMetre, stringWidthPx } from '../../../../clients/web/page/src/model/projection.js';

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

test('disparity is that of two eyes, zero at the focus, and falls with depth', () => {
  const eyes = { eyesM: 0.03, focusM: 0.9, fovDeg: 90, heightPx: 720 };
  // Right eye's picture of a point straight ahead of the nose: e/2 to the left, e/2 over the depth as a tangent, and the pictures are
  // shifted so that the focus coincides.
  const byHand = (depthM) => 2 * 360 * (0.015 / depthM - 0.015 / 0.9);
  let last = Infinity;
  for (const depthM of [0.3, 0.5, 0.9, 1.4, 3]) {
    const found = disparityPx({ ...eyes, depthM });
    assert.ok(Math.abs(found - byHand(depthM)) < 1e-9);
    assert.ok(found < last);
    last = found;
  }
  assert.equal(disparityPx({ ...eyes, depthM: 0.9 }), 0);
});
