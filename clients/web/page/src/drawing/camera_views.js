// Where the eye is: presets for every scene, computed from its box, and flights from one to the next. Pure, except the flight.
import * as THREE from 'three';
import { add, mix } from 'hapticd-stream/vector';

/**
 * {eye, target} of preset `name`. `box` of the scene, `focus` what is played (the tool), m; `aspect` of the picture; `fovDeg` vertical.
 */
export function viewOf(name, { box, focus, aspect, fovDeg }) {
  const half = Math.tan((fovDeg * Math.PI) / 360);
  const width = Math.max(box.upper[0] - box.lower[0], 0.05);
  const depth = Math.max(box.upper[2] - box.lower[2], 0.05);
  const height = Math.max(box.upper[1] - box.lower[1], 0.02);
  // Far enough that the box fits, by its width or by what is seen of its height.
  const distance = (across, up) => 0.5 * Math.max(across / (half * aspect), up / half);
  if (name === 'top') {
    const away = distance(1.04 * width, 1.15 * depth) + height;
    return { eye: add(box.centre, [0, away, 0.001]), target: box.centre };
  }
  if (name === 'close') {
    const away = Math.min(0.16, 0.6 * box.size);
    return { eye: add(focus, [-1.05 * away, 0.62 * away, 0.3 * away]), target: add(focus, [0.12 * away, 0.05 * away, 0]) };
  }
  const away = distance(1.0 * width, height + 0.8 * depth) + 0.3 * depth;
  const target = add(box.centre, [0, 0.12 * depth, 0]);
  return { eye: add(target, [0.03 * away, 0.6 * away, 0.8 * away]), target };
}

/** Smooth from 0 to 1, at rest at both ends. */
export const eased = (t) => t * t * t * (t * (6 * t - 15) + 10);

const FLIGHT_S = 0.7;

/** Moves `camera` and the target of `controls` to a preset within 0.7 s; a drag ends it. */
export class CameraFlight {
  #from = null;
  #to = null;
  #startS = 0;

  constructor(camera, controls) {
    Object.assign(this, { camera, controls });
    controls.addEventListener('start', () => { this.#to = null; });
  }

  flyTo(view, nowS, { atOnce = false } = {}) {
    this.#from = { eye: this.camera.position.toArray(), target: this.controls.target.toArray() };
    this.#to = view;
    this.#startS = atOnce ? nowS - FLIGHT_S : nowS;
    this.step(nowS);
  }

  get flying() {
    return this.#to !== null;
  }

  step(nowS) {
    if (!this.#to) return;
    const t = Math.min(1, (nowS - this.#startS) / FLIGHT_S);
    this.camera.position.copy(new THREE.Vector3(...mix(this.#from.eye, this.#to.eye, eased(t))));
    this.controls.target.copy(new THREE.Vector3(...mix(this.#from.target, this.#to.target, eased(t))));
    if (t >= 1) this.#to = null;
  }
}
