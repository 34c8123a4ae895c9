// The band that a sounding string swings in, as rings of a tube along its static axis: over the part that sounds and no farther, as wide at each
// place as its partials reach there together.
import { swingAt } from 'hapticd-stream';
import { add, scale, subtract } from 'hapticd-stream/vector';

const RINGS = 25; // of a string alone: four for each loop of the 6th partial
const LEAST_RINGS = 9;
const RINGS_IN_ALL = 175; // 2800 triangles, little beside what meshes may have without a GPU
const UNSEEN_M = 2e-6;

/** Rings for the band of each of `strings` strings. */
export const ringsOfBand = (strings) => Math.max(LEAST_RINGS, Math.min(RINGS, Math.floor(RINGS_IN_ALL / strings)));

/** The point at `lambda` of an axis whose corners stand at `lambdas`, ascending from 0 to 1. */
function pointAt(axis, lambdas, lambda) {
  let k = 1;
  while (k + 1 < axis.length && lambdas[k] < lambda) ++k;
  const length = lambdas[k] - lambdas[k - 1];
  const t = length > 0 ? (lambda - lambdas[k - 1]) / length : 0;
  return add(axis[k - 1], scale(subtract(axis[k], axis[k - 1]), t));
}

/**
 * Rings of the band of `string`, shaped as `shape` says along `axis`: `count` of [{at, radiusM}], evenly over shape.band. radiusM is R plus the
 * swing, 0 where there is none to be seen.
 */
export function bandRings(string, shape, axis, count) {
  const { from, to, partialsM } = shape.band;
  const bent = axis.length === 3 && string.points.length === 2;
  const lambdas = bent ? [0, shape.lambda, 1] : axis.map((_, k) => k / (axis.length - 1));
  return Array.from({ length: count }, (_, k) => {
    const s = k / (count - 1);
    const swingM = swingAt(partialsM, s);
    return { at: pointAt(axis, lambdas, from + (to - from) * s), radiusM: swingM > UNSEEN_M ? string.radiusM + swingM : 0 };
  });
}
