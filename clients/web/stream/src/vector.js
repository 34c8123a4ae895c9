// Vectors are arrays x y z, quaternions arrays w x y z, as on the wire. Small and plain: what is computed here is tested, what is drawn
// with it is three.js'.

export const add = (a, b) => [a[0] + b[0], a[1] + b[1], a[2] + b[2]];
export const subtract = (a, b) => [a[0] - b[0], a[1] - b[1], a[2] - b[2]];
export const scale = (a, s) => [a[0] * s, a[1] * s, a[2] * s];
export const dot = (a, b) => a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
export const cross = (a, b) => [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]];
export const length = (a) => Math.hypot(a[0], a[1], a[2]);
export const mix = (a, b, t) => a.map((value, i) => value + (b[i] - value) * t);

/** Unit vector along `a`, or `otherwise` where it has no direction. */
export function normalised(a, otherwise = [0, 1, 0]) {
  const size = length(a);
  return size > 1e-12 ? scale(a, 1 / size) : otherwise;
}

/** A unit vector at right angles to the unit vector `a`. */
export function perpendicular(a) {
  const other = Math.abs(a[1]) < 0.9 ? [0, 1, 0] : [1, 0, 0];
  return normalised(cross(a, other));
}

/** R(q) v. */
export function rotate(q, v) {
  const u = [q[1], q[2], q[3]];
  const t = scale(cross(u, v), 2);
  return add(add(v, scale(t, q[0])), cross(u, t));
}

export const conjugate = (q) => [q[0], -q[1], -q[2], -q[3]];

/** Rotation b, then a. */
export function multiply(a, b) {
  return [
    a[0] * b[0] - a[1] * b[1] - a[2] * b[2] - a[3] * b[3],
    a[0] * b[1] + a[1] * b[0] + a[2] * b[3] - a[3] * b[2],
    a[0] * b[2] - a[1] * b[3] + a[2] * b[0] + a[3] * b[1],
    a[0] * b[3] + a[1] * b[2] - a[2] * b[1] + a[3] * b[0],
  ];
}

/** From a to b at constant angular speed, the shorter way; q and -q mean the same. */
export function slerp(a, b, t) {
  let cosine = a[0] * b[0] + a[1] * b[1] + a[2] * b[2] + a[3] * b[3];
  const sign = cosine < 0 ? -1 : 1;
  cosine = Math.min(1, Math.abs(cosine));
  const angle = Math.acos(cosine);
  // Below a milliradian the straight way differs from the arc by 1e-10.
  if (angle < 1e-3) return unit(mix(a, b.map((value) => value * sign), t));
  const from = Math.sin((1 - t) * angle) / Math.sin(angle);
  const to = (sign * Math.sin(t * angle)) / Math.sin(angle);
  return a.map((value, i) => from * value + to * b[i]);
}

function unit(q) {
  const size = Math.hypot(...q) || 1;
  return q.map((value) => value / size);
}

/** A pose {p, q} of pose.proto's Pose, absent = identity. */
export function poseOf(pose) {
  return {
    p: pose?.p_m?.length === 3 ? pose.p_m : [0, 0, 0],
    q: pose?.q?.length === 4 ? unit(pose.q) : [1, 0, 0, 0],
  };
}

/** X_AB p_B = p_A. */
export const transform = (pose, p) => add(pose.p, rotate(pose.q, p));
/** X_AB^-1 p_A = p_B. */
export const transformBack = (pose, p) => rotate(conjugate(pose.q), subtract(p, pose.p));
