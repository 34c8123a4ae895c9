// What a perspective camera does with lengths: how wide a string is in pixels, and how far apart the two eyes see a point.

/** Pixels that a metre across the line of sight takes at `depthM` from the camera, `heightPx` the height of the picture. */
export function pixelsPerMetre(depthM, fovDeg, heightPx) {
  return heightPx / (2 * depthM * Math.tan((fovDeg * Math.PI) / 360));
}

/** Width at which a string is drawn: its magnified radius, but never thinner than `leastPx`, or far strings would flicker. */
export function stringWidthPx({ radiusM, magnify, depthM, fovDeg, heightPx, leastPx }) {
  return Math.max(2 * radiusM * magnify * pixelsPerMetre(depthM, fovDeg, heightPx), leastPx);
}

/**
 * Shift of a point between the pictures of the right and the left eye, pixels, positive = before the screen: zero at the distance looked
 * at, and falling with depth.
 */
export function disparityPx({ eyesM, focusM, depthM, fovDeg, heightPx }) {
  return eyesM * (pixelsPerMetre(depthM, fovDeg, heightPx) - pixelsPerMetre(focusM, fovDeg, heightPx));
}
