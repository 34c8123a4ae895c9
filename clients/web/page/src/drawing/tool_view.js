// One tool: solid where contact lets it be (graphic), glass where the hand is (haptic). The glass fades in as the two part; where they are
// one it would only dim the solid.
import * as THREE from 'three';
import { length, subtract, transform } from 'hapticd-stream/vector';
import { makeGhostMaterial, makeMaterial, substanceOf } from './materials.js';

const PARTED_M = 0.001; // distance at which the glass is fully there
const GHOST_OPACITY = 0.38;

export class ToolView {
  /** `shapes`: of each part, from buildShapes. */
  constructor(tool, shapes, high) {
    this.tool = tool;
    this.ghostMaterial = makeGhostMaterial();
    this.solid = new THREE.Group();
    this.ghost = new THREE.Group();
    this.spheres = touchingSpheres(tool, shapes);
    tool.parts.forEach((part, i) => {
      if (!shapes[i].geometry) return;
      const substance = substanceOf(`${part.name} ${tool.name}`, i);
      const solid = placed(new THREE.Mesh(shapes[i].geometry, makeMaterial(substance, high)), part.pose);
      solid.castShadow = solid.receiveShadow = true;
      this.solid.add(solid);
      const ghost = placed(new THREE.Mesh(shapes[i].geometry, this.ghostMaterial), part.pose);
      ghost.renderOrder = 3;
      this.ghost.add(ghost);
    });
    pose(this.solid, tool.pose.p, tool.pose.q);
    this.ghost.visible = false; // until a State says where the hand is
  }

  /** `state`: its ToolState, interpolated. */
  show(state) {
    pose(this.solid, state.p_wg_m, state.q_wg);
    pose(this.ghost, state.p_wh_m, state.q_wh);
    this.apartM = length(subtract(state.p_wh_m, state.p_wg_m));
    this.ghostMaterial.opacity = GHOST_OPACITY * Math.min(1, this.apartM / PARTED_M);
    this.ghost.visible = this.ghostMaterial.opacity > 0.01;
  }
}

/** Spheres of all parts in the tool's frame, flat x y z r. */
function touchingSpheres(tool, shapes) {
  const all = [];
  tool.parts.forEach((part, i) => {
    const spheres = shapes[i].spheres ?? [];
    for (let k = 0; k < spheres.length; k += 4) {
      all.push(...transform(part.pose, [spheres[k], spheres[k + 1], spheres[k + 2]]), spheres[k + 3]);
    }
  });
  return Float64Array.from(all);
}

export function placed(mesh, at) {
  pose(mesh, at.p, at.q);
  return mesh;
}

function pose(thing, p, q) {
  thing.position.set(p[0], p[1], p[2]);
  thing.quaternion.set(q[1], q[2], q[3], q[0]);
}
