// What a perspective camera does with lengths: how wide a string is in pixels.

/** Pixels that a metre across the line of sight takes at `depthM` from the camera, `heightPx` the height of the picture. */
export function pixelsPerMetre(depthM, fovDeg, heightPx) {
  return heightPx / (2 * depthM * Math.tan((fovDeg * Math.PI) / 360));
}

/** Width at which a string is drawn: its magnified radius, but never thinner than `leastPx`, or far strings would flicker. */
export function stringWidthPx({ radiusM, magnify, depthM, fovDeg, heightPx, leastPx }) {
  return Math.max(2 * radiusM * magnify * pixelsPerMetre(depthM, fovDeg, heightPx), leastPx);
}
