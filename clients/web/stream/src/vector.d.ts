// Types of vector.js. Vectors are arrays x y z, quaternions arrays w x y z.
export type Vector = ArrayLike<number> & readonly number[];
export type Quaternion = ArrayLike<number> & readonly number[];
/** X_AB: where B is in A. */
export interface Pose {
  p: Vector;
  q: Quaternion;
}
export const add: (a: Vector, b: Vector) => number[];
export const subtract: (a: Vector, b: Vector) => number[];
export const scale: (a: Vector, s: number) => number[];
export const dot: (a: Vector, b: Vector) => number;
export const cross: (a: Vector, b: Vector) => number[];
export const length: (a: Vector) => number;
export const mix: (a: Vector, b: Vector, t: number) => number[];
/** Unit vector along `a`, or `otherwise` where it has no direction. */
export function normalised(a: Vector, otherwise?: Vector): Vector;
/** A unit vector at right angles to the unit vector `a`. */
export function perpendicular(a: Vector): Vector;
/** R(q) v. */
export function rotate(q: Quaternion, v: Vector): number[];
export const conjugate: (q: Quaternion) => number[];
/** Rotation b, then a. */
export function multiply(a: Quaternion, b: Quaternion): number[];
/** From a to b at constant angular speed, the shorter way. */
export function slerp(a: Quaternion, b: Quaternion, t: number): number[];
/** A pose of pose.proto's Pose; absent = identity. */
export function poseOf(pose?: { p_m?: readonly number[]; q?: readonly number[] } | null): Pose;
/** X_AB p_B = p_A. */
export const transform: (pose: Pose, p: Vector) => number[];
/** X_AB^-1 p_A = p_B. */
export const transformBack: (pose: Pose, p: Vector) => number[];
