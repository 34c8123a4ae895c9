// Which string is nearest to a tool, and how far: gap between the spheres that the daemon itself touches with and the strings' capsules,
// bent ones included. Strings are brought into the tool's frame, which is one transform per string instead of one per sphere.
import { add, dot, length, scale, subtract, transform, transformBack } from './vector.js';

/** Point of the segment a b nearest to p, and the distance: {point, t, distance}. */
export function nearestOnSegment(a, b, p) {
  const ab = subtract(b, a);
  const square = dot(ab, ab);
  const t = square > 0 ? Math.min(1, Math.max(0, dot(subtract(p, a), ab) / square)) : 0;
  const point = add(a, scale(ab, t));
  return { point, t, distance: length(subtract(p, point)) };
}

/** Corners of a string's axis with its present bend. */
export function bentAxis(string, shape) {
  const along = string.points;
  if (!shape || length(shape.deflection) === 0 || along.length !== 2) return along;
  const [a, b] = along;
  const at = add(add(a, scale(subtract(b, a), shape.lambda)), shape.deflection);
  return [a, at, b];
}

/**
 * Nearest of `strings` ([{points, radiusM}], world frame) to a tool: `spheres` is x y z r of each sphere in its frame G, flat, `pose` X_WG.
 * {index, distanceM (negative = inside), onString, onTool (world points on the surfaces)}, or null without spheres or strings. Flat loops:
 * this runs once a frame over a thousand spheres.
 */
export function nearestString(spheres, pose, strings) {
  let best = null;
  for (let index = 0; index < strings.length; ++index) {
    const corners = strings[index].points.map((point) => transformBack(pose, point));
    for (let k = 0; k + 1 < corners.length; ++k) {
      const found = nearestSphere(spheres, corners[k], corners[k + 1]);
      if (found.sphere < 0) continue;
      const distanceM = found.distance - strings[index].radiusM;
      if (!best || distanceM < best.distanceM) best = { index, distanceM, sphere: found.sphere, a: corners[k], b: corners[k + 1] };
    }
  }
  return best && surfacePoints(best, spheres, pose, strings[best.index].radiusM);
}

/** Sphere whose surface is nearest to the segment a b: {sphere, distance of the surface to the axis}. */
function nearestSphere(spheres, a, b) {
  const [ax, ay, az] = a;
  const ux = b[0] - ax, uy = b[1] - ay, uz = b[2] - az;
  const square = ux * ux + uy * uy + uz * uz;
  let sphere = -1, distance = Infinity;
  for (let i = 0; i < spheres.length; i += 4) {
    const px = spheres[i] - ax, py = spheres[i + 1] - ay, pz = spheres[i + 2] - az;
    const t = square > 0 ? Math.min(1, Math.max(0, (px * ux + py * uy + pz * uz) / square)) : 0;
    const dx = px - t * ux, dy = py - t * uy, dz = pz - t * uz;
    const gap = Math.sqrt(dx * dx + dy * dy + dz * dz) - spheres[i + 3];
    if (gap < distance) {
      distance = gap;
      sphere = i;
    }
  }
  return { sphere, distance };
}

function surfacePoints(best, spheres, pose, radiusM) {
  const centre = [...spheres.slice(best.sphere, best.sphere + 3)];
  const { point } = nearestOnSegment(best.a, best.b, centre);
  const away = subtract(centre, point);
  const size = length(away);
  const n = size > 0 ? scale(away, 1 / size) : [0, 1, 0];
  return {
    index: best.index,
    distanceM: best.distanceM,
    onString: transform(pose, add(point, scale(n, radiusM))),
    onTool: transform(pose, subtract(centre, scale(n, spheres[best.sphere + 3]))),
  };
}
