// Names beside things, as text of the page above the picture: sharp at any size, read by screen readers, found by tests.
import * as THREE from 'three';

const point = new THREE.Vector3();

/** Pixel of a world point in a picture of `width` x `height`, or null behind the eye: {x, y, depthM}. */
export function project(at, camera, width, height) {
  point.set(...at).applyMatrix4(camera.matrixWorldInverse);
  const depthM = -point.z;
  if (depthM <= camera.near) return null;
  point.applyMatrix4(camera.projectionMatrix);
  return { x: ((point.x + 1) / 2) * width, y: ((1 - point.y) / 2) * height, depthM };
}

export class Labels {
  #layer;
  #labels = new Map();

  constructor(layer) {
    this.#layer = layer;
  }

  clear() {
    this.#layer.replaceChildren();
    this.#labels.clear();
  }

  /** Puts the label `id` with `text` at pixel `at`, or hides it where `at` is null. `kind` is a class of the style sheet. */
  set(id, text, at, kind = '') {
    const label = this.#labels.get(id) ?? this.#make(id);
    const shown = at !== null;
    if (label.hidden === shown) label.hidden = !shown;
    if (!shown) return;
    if (label.textContent !== text) label.textContent = text;
    const name = `label ${kind}`;
    if (label.className !== name) label.className = name;
    label.style.transform = `translate(${at.x.toFixed(1)}px, ${at.y.toFixed(1)}px)`;
  }

  #make(id) {
    const label = document.createElement('span');
    label.dataset.id = id;
    this.#layer.append(label);
    this.#labels.set(id, label);
    return label;
  }
}
