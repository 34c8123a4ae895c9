// A SceneInfo as the page draws it: shapes with the hashes of their files, strings and lines as chains of corners, the box around all.
import { hex } from './wire.js';
import { add, length, poseOf, scale, subtract, transform } from './vector.js';

const LARGE_M = 5; // spheres above this are walls and floors; they are drawn flat and do not count for the size of the scene
const SAG_PIECES = 5; // as the daemon cuts a slack cable

/** {id, name, description, tools, bodies, lines, strings, box, rateHz, virtual, parameters} */
export function sceneModel(info) {
  const assets = new Map(info.assets.map((asset) => [asset.name, { hash: hex(asset.hash), size: asset.size }]));
  const scene = info.scene;
  const model = {
    id: info.scene_id,
    name: scene.name,
    description: scene.description,
    scene,
    tools: scene.tools.map((tool) => toolModel(tool, assets)),
    bodies: scene.bodies.map((body) => ({ name: body.name, pose: poseOf(body.pose_wb), ...shapeModel(body.shape, assets) })),
    lines: scene.lines.map((line) => ({ name: line.name, points: triples(line.points_w_m), radiusM: line.radius_m })),
    strings: scene.strings.map(stringModel),
    rateHz: info.rate_hz,
    virtual: info.clock === 2,
    parameters: info.parameters,
    serverVersion: info.server_version,
  };
  model.box = boxOf(model);
  return model;
}

function toolModel(tool, assets) {
  return {
    id: tool.tool_id,
    name: tool.name,
    pose: poseOf(tool.pose_wg),
    parts: tool.parts.map((part) => ({ name: part.name, pose: poseOf(part.pose_gp), ...shapeModel(part.shape, assets) })),
  };
}

/** {mesh, tree: {hash, size} | null, spheres: Float64Array of x y z r | null} */
function shapeModel(shape, assets) {
  return {
    mesh: (shape.mesh && assets.get(shape.mesh)) || null,
    tree: (shape.tree && assets.get(shape.tree)) || null,
    spheres: shape.spheres ? spheresOf(shape.spheres) : null,
  };
}

function spheresOf(spheres) {
  const radii = spheres.radius_m;
  return Float64Array.from(triples(spheres.centre_m).flatMap((centre, i) => [...centre, radii.length === 1 ? radii[0] : radii[i]]));
}

export function triples(values) {
  return Array.from({ length: Math.floor(values.length / 3) }, (_, i) => [...values.slice(i * 3, i * 3 + 3)]);
}

function stringModel(string) {
  const a = string.p_wa_m, b = string.p_wb_m;
  return {
    name: string.name,
    points: string.sag_m > 0 ? sagging(a, b, string.sag_m) : [[...a], [...b]],
    radiusM: string.radius_m ?? 3.4e-4,
    frequencyHz: string.frequency_hz ?? 0,
  };
}

/** Corners of a slack cable: a parabola that hangs `sag` below the chord at mid-span. */
export function sagging(a, b, sag) {
  return Array.from({ length: SAG_PIECES + 1 }, (_, i) => {
    const t = i / SAG_PIECES;
    return add(add(a, scale(subtract(b, a), t)), [0, -4 * sag * t * (1 - t), 0]);
  });
}

/** {centre, size, lower, upper} of strings, lines and what is written as spheres; meshes widen it when they arrive. */
function boxOf(model) {
  const points = [
    ...model.strings.flatMap((string) => string.points),
    ...model.lines.flatMap((line) => line.points),
    ...model.tools.map((tool) => tool.pose.p),
    ...model.bodies.flatMap((body) => spherePoints(body)),
  ];
  return boxAround(points.length > 1 ? points : [[-0.1, -0.1, -0.1], [0.1, 0.1, 0.1]]);
}

function spherePoints(body) {
  const spheres = body.spheres ?? [];
  const points = [];
  for (let i = 0; i < spheres.length; i += 4) {
    if (spheres[i + 3] > LARGE_M) continue;
    const centre = transform(body.pose, [spheres[i], spheres[i + 1], spheres[i + 2]]);
    for (const side of [-1, 1]) points.push(centre.map((value) => value + side * spheres[i + 3]));
  }
  return points.length ? points : [body.pose.p].filter(() => !spheres.length);
}

export function boxAround(points) {
  const lower = [0, 1, 2].map((axis) => Math.min(...points.map((point) => point[axis])));
  const upper = [0, 1, 2].map((axis) => Math.max(...points.map((point) => point[axis])));
  return { lower, upper, centre: scale(add(lower, upper), 0.5), size: Math.max(0.05, length(subtract(upper, lower))) };
}

/** Of a wall's sphere: the point of it nearest to `to`, and its normal there. */
export function flatPart(sphere, to) {
  const centre = sphere.slice(0, 3);
  const away = subtract(to, centre);
  const n = scale(away, 1 / (length(away) || 1));
  return { point: add(centre, scale(n, sphere[3])), normal: n };
}

export const isLarge = (radiusM) => radiusM > LARGE_M;
