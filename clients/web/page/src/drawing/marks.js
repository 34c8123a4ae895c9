// What is not a thing but said about things: contacts with their normals and forces, force and torque at the hand, and the depth cue, a
// plumb line from the tool to its nearest string with a ring on the string.
import { scale, subtract } from 'hapticd-stream/vector';
import { triples } from 'hapticd-stream';

export const COLOURS = { contact: '#ffd54a', normal: '#8de28a', force: '#ff6b5e', torque: '#b48cff', limited: '#ffa94d', near: '#4fd1ff' };

const NORMAL_PX = 30;
const METRES_PER_NEWTON = 0.02;
const LONGEST_FORCE_M = 0.2;
const METRES_PER_NEWTON_METRE = 2;
const CUE_FROM_M = 0.08; // farther away no string is meant

/** Points, normals and forces of a ContactPatch as [{point, normal, gapM, forceN}]; empty where its columns disagree. */
export function contactsOf(patch) {
  const count = patch.tool_sphere.length;
  if (patch.p_wc_um.length !== 3 * count || patch.nhat_og_w_e4.length !== 3 * count) return [];
  if (patch.gap_nanometres.length !== count || patch.force_mn.length !== count) return [];
  const points = triples(patch.p_wc_um), normals = triples(patch.nhat_og_w_e4);
  return points.map((point, i) => ({
    point: point.map((value) => value * 1e-6),
    normal: normals[i].map((value) => value * 1e-4),
    gapM: patch.gap_nanometres[i] * 1e-9,
    forceN: patch.force_mn[i] * 1e-3,
  }));
}

/** Arrow for a force: 20 mm per newton, no longer than 20 cm. */
export function forceVector(forceN) {
  const size = Math.hypot(...forceN);
  return size > 0.02 ? scale(forceN, Math.min(METRES_PER_NEWTON, LONGEST_FORCE_M / size)) : [0, 0, 0];
}

/** `pixelM(at)` is what a pixel is worth at a point, m: marks keep their size on the screen. */
export function drawMarks({ arrows, state, nearest, options, pixelM }) {
  arrows.begin();
  if (options.contacts) state.contacts.forEach((patch) => drawPatch(arrows, patch, pixelM));
  if (options.forces) state.tools.forEach((tool) => drawWrench(arrows, tool, pixelM));
  if (options.depth) nearest.forEach((near) => drawCue(arrows, near, pixelM));
}

function drawPatch(arrows, patch, pixelM) {
  const contacts = contactsOf(patch);
  for (const { point, normal, forceN } of contacts) {
    const px = pixelM(point);
    arrows.dot(point, (forceN > 0 ? 4 : 2.5) * px, COLOURS.contact);
    arrows.arrow(point, scale(normal, NORMAL_PX * px), 1.1 * px, COLOURS.normal);
  }
  if (contacts.length && patch.force_w_n.length === 3) {
    arrows.arrow(contacts[0].point, forceVector(patch.force_w_n), 1.8 * pixelM(contacts[0].point), COLOURS.force);
  }
}

function drawWrench(arrows, tool, pixelM) {
  const origin = tool.p_wh_m;
  const px = pixelM(origin);
  const limited = tool.wrench_unlimited_h_w.length === 6;
  arrows.arrow(origin, forceVector(tool.wrench_h_w.slice(0, 3)), 2.6 * px, limited ? COLOURS.limited : COLOURS.force);
  const torque = tool.wrench_h_w.slice(3, 6);
  const size = Math.hypot(...torque);
  if (!(size > 0.002)) return;
  arrows.arrow(origin, scale(torque, Math.min(METRES_PER_NEWTON_METRE, LONGEST_FORCE_M / size)), 2 * px, COLOURS.torque);
  arrows.ring(origin, torque, Math.min(0.05, 0.008 + 0.12 * size), COLOURS.torque);
}

function drawCue(arrows, near, pixelM) {
  if (near.distanceM > CUE_FROM_M) return;
  const px = pixelM(near.onString);
  const away = subtract(near.onTool, near.onString);
  arrows.ring(near.onString, near.along, Math.max(6 * px, 0.0022), COLOURS.near);
  if (near.distanceM > 2 * px) arrows.arrow(near.onTool, scale(away, -1), 0.9 * px, COLOURS.near);
  else arrows.dot(near.onString, 2 * px, COLOURS.near);
}
