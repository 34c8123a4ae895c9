// The drawn scene: bodies, strings, tools and marks of one SceneInfo, moved each frame to the State that is shown. Knows nothing of where
// States come from.
import * as THREE from 'three';
import { bentAxis, boxAround, nearestString, stringShape } from 'hapticd-stream';
import { pixelsPerMetre, stringWidthPx } from '../model/projection.js';
import { add, normalised, scale, subtract } from 'hapticd-stream/vector';
import { Arrows } from './arrows.js';
import { project } from './labels.js';
import { drawMarks } from './marks.js';
import { bandRings } from './string_band.js';
import { makeMaterial, substanceOf } from './materials.js';
import { buildShapes } from './shape_builder.js';
import { StringTubes } from './string_tubes.js';
import { placed, ToolView } from './tool_view.js';

const STRING_COLOUR = '#d9c48c';
const ENVELOPE_COLOUR = '#ffe39a';
const LINE_COLOUR = '#8d959f';
const NAMED_STRINGS = 24; // of more of them only the nearest has its name beside it

export class SceneView {
  constructor(stage, model, { labels, motion }) {
    Object.assign(this, { stage, model, labels, motion });
    this.options = { contacts: true, forces: true, depth: true, names: true, magnify: 1 };
    this.tools = [];
    this.nearest = [];
    this.shapes = model.strings.map((string, i) => stringShape(string, i, undefined, motion, 0));
    this.box = model.box;
    this.#addStrings();
    this.arrows = new Arrows(600);
    stage.things.add(this.arrows.group);
  }

  #addStrings() {
    const { strings, lines } = this.model;
    const { things } = this.stage;
    this.tubes = new StringTubes(strings.map((string) => ({ ...string, colour: STRING_COLOUR })), { stage: this.stage, glow: '#4d4328' });
    this.envelopes = new StringTubes(strings.map((string) => ({ ...string, colour: ENVELOPE_COLOUR })), { envelope: true, stage: this.stage, glow: '#6b5a26' });
    const pipes = lines.map((line) => ({ ...line, colour: /pipe/.test(line.name) ? substanceOf(line.name, 0).colour : LINE_COLOUR }));
    this.pipes = new StringTubes(pipes, { stage: this.stage });
    strings.forEach((string, i) => {
      this.tubes.set(i, string.points, string.radiusM);
      this.envelopes.set(i, string.points, 0);
    });
    pipes.forEach((line, i) => this.pipes.set(i, line.points, line.radiusM));
    for (const tubes of [this.tubes, this.pipes]) tubes.mesh.receiveShadow = true;
    things.add(this.tubes.mesh, this.pipes.mesh, this.envelopes.mesh);
    this.moved = new Set(); // strings that are not drawn straight and still
  }

  /** Fetches meshes and trees; returns what was drawn as what, for people. */
  async load(assets) {
    const { bodies, tools } = this.model;
    const shapes = [...bodies.map((body) => ({ ...body, copies: 1 })),
      ...tools.flatMap((tool) => tool.parts.map((part) => ({ ...part, copies: 2 })))];
    const built = await buildShapes(shapes, assets, { high: this.stage.high, towards: this.model.box });
    bodies.forEach((body, i) => this.#addBody(body, built[i], i));
    let next = bodies.length;
    for (const tool of tools) {
      const view = new ToolView(tool, built.slice(next, next + tool.parts.length), this.stage.high);
      next += tool.parts.length;
      this.stage.things.add(view.solid, view.ghost);
      this.tools.push(view);
    }
    this.stage.fit(this.box);
    return built.map((shape) => shape.drawnAs);
  }

  #addBody(body, shape, index) {
    if (!shape.geometry) return;
    const mesh = placed(new THREE.Mesh(shape.geometry, makeMaterial(substanceOf(body.name, index), this.stage.high)), body.pose);
    mesh.castShadow = shape.drawnAs !== 'flat';
    mesh.receiveShadow = true;
    mesh.name = body.name;
    this.stage.things.add(mesh);
    if (shape.drawnAs === 'flat') return;
    mesh.updateMatrixWorld();
    const box = new THREE.Box3().setFromObject(mesh);
    this.box = boxAround([this.box.lower, this.box.upper, box.min.toArray(), box.max.toArray()]);
  }

  /** Moves everything to `state`, shown at `ns` of the daemon's clock. */
  show(state, ns) {
    this.#showStrings(state, ns);
    for (const view of this.tools) {
      const tool = state.tools.find((candidate) => candidate.tool_id === view.tool.id);
      if (tool) view.show(tool);
    }
    this.nearest = this.#findNearest(state);
    const px = (at) => this.#pixelM(at);
    drawMarks({ arrows: this.arrows, state, nearest: this.nearest, options: this.options, pixelM: px });
  }

  #showStrings(state, ns) {
    const states = new Map(state.strings.map((string) => [string.string_index, string]));
    this.model.strings.forEach((string, i) => {
      const shape = stringShape(string, i, states.get(i), this.motion, ns);
      this.shapes[i] = shape;
      const still = shape.envelopeM === 0 && shape.deflection.every((value) => value === 0);
      if (still && !this.moved.has(i)) return;
      const axis = bentAxis(string, shape);
      this.tubes.set(i, axis, string.radiusM);
      if (shape.band) this.envelopes.setRings(i, axis, bandRings(string, shape, axis, this.envelopes.rings[i]));
      else this.envelopes.set(i, axis, shape.envelopeM > 0 ? shape.radiusM : 0);
      if (still) this.moved.delete(i);
      else this.moved.add(i);
    });
  }

  #findNearest(state) {
    const strings = this.model.strings.map((string, i) => ({ points: bentAxis(string, this.shapes[i]), radiusM: string.radiusM }));
    return this.tools.flatMap((view) => {
      const tool = state.tools.find((candidate) => candidate.tool_id === view.tool.id);
      const found = tool && nearestString(view.spheres, { p: tool.p_wg_m, q: tool.q_wg }, strings);
      if (!found) return [];
      const points = this.model.strings[found.index].points;
      return [{ ...found, toolId: view.tool.id, name: this.model.strings[found.index].name,
        along: normalised(subtract(points.at(-1), points[0]), [1, 0, 0]) }];
    });
  }

  #pixelM(at) {
    const height = this.stage.renderer.domElement.clientHeight || 1;
    const seen = project(at, this.stage.camera, 1, 1);
    return 1 / pixelsPerMetre(seen?.depthM ?? 1, this.stage.camera.fov, height);
  }

  /** Just before a frame is drawn, once the camera stands. */
  prepare() {
    const height = this.stage.renderer.domElement.clientHeight || 1;
    const atOneMetre = 1 / pixelsPerMetre(1, this.stage.camera.fov, height);
    for (const tubes of [this.tubes, this.envelopes, this.pipes]) {
      tubes.prepare(atOneMetre, tubes === this.pipes ? 1 : this.options.magnify);
    }
    this.#nameStrings();
  }

  #nameStrings() {
    const { clientWidth: width, clientHeight: height } = this.stage.renderer.domElement;
    const near = new Set(this.nearest.filter((found) => found.distanceM < 0.05).map((found) => found.index));
    const many = this.model.strings.length > NAMED_STRINGS;
    this.model.strings.forEach((string, i) => {
      const shown = this.options.names && (!many || near.has(i));
      const [a, b] = [string.points[0], string.points.at(-1)];
      // Toward the end where nobody plays, each a little farther along, or names of near strings would cover each other.
      const place = add(b, scale(subtract(a, b), 0.03 + 0.035 * (i % 8)));
      const at = shown ? project(place, this.stage.camera, width, height) : null;
      const sounding = this.shapes[i].envelopeM > 5e-5;
      this.labels.set(`string ${i}`, string.name, at, `string${near.has(i) ? ' near' : ''}${sounding ? ' sounding' : ''}`);
    });
  }

  /** What is drawn of string `index`, for tests and for people who measure: widths in pixels at the place `t` along it. */
  drawnString(index, t = 0.5) {
    const { clientWidth: width, clientHeight: height } = this.stage.renderer.domElement;
    const string = this.model.strings[index];
    const place = add(string.points[0], scale(subtract(string.points.at(-1), string.points[0]), t));
    const at = project(place, this.stage.camera, width, height);
    const shape = this.shapes[index];
    const common = { magnify: this.options.magnify, depthM: at?.depthM ?? 1, fovDeg: this.stage.camera.fov, heightPx: height };
    return { name: string.name, radiusM: shape.radiusM, envelopeM: shape.envelopeM, at, widthPx: stringWidthPx({ radiusM: shape.radiusM, leastPx: this.tubes.leastPx, ...common }) };
  }
}
