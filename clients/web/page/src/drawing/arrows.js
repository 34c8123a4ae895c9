// Many arrows, rings and dots in a few draw calls: contacts, forces, torques. Set again each frame; what is not set is not drawn.
import * as THREE from 'three';

const UP = new THREE.Vector3(0, 1, 0);
const Z = new THREE.Vector3(0, 0, 1);

/** Instances of one geometry that are filled from the front each frame. */
class Swarm {
  constructor(geometry, capacity, { onTop = false } = {}) {
    const material = new THREE.MeshBasicMaterial({ toneMapped: false, depthTest: !onTop, transparent: onTop });
    this.mesh = new THREE.InstancedMesh(geometry, material, capacity);
    this.mesh.setColorAt(0, new THREE.Color()); // so that the attribute exists before the shader is made
    this.mesh.frustumCulled = false;
    this.mesh.renderOrder = onTop ? 5 : 1;
    this.capacity = capacity;
    this.begin();
  }

  begin() {
    this.mesh.count = 0;
  }

  put(matrix, colour) {
    if (this.mesh.count >= this.capacity) return;
    const index = this.mesh.count++;
    this.mesh.setMatrixAt(index, matrix);
    this.mesh.setColorAt(index, colour);
    this.mesh.instanceMatrix.needsUpdate = this.mesh.instanceColor.needsUpdate = true;
  }
}

export class Arrows {
  #shafts;
  #heads;
  #dots;
  #rings;

  constructor(capacity) {
    this.#shafts = new Swarm(new THREE.CylinderGeometry(1, 1, 1, 8, 1, true).translate(0, 0.5, 0), capacity, { onTop: true });
    this.#heads = new Swarm(new THREE.ConeGeometry(1, 1, 12).translate(0, 0.5, 0), capacity, { onTop: true });
    this.#dots = new Swarm(new THREE.IcosahedronGeometry(1, 1), capacity, { onTop: true });
    this.#rings = new Swarm(new THREE.TorusGeometry(1, 0.05, 6, 24, 1.6 * Math.PI), 32, { onTop: true });
    this.group = new THREE.Group();
    this.group.add(...[this.#shafts, this.#heads, this.#dots, this.#rings].map((swarm) => swarm.mesh));
  }

  begin() {
    for (const swarm of [this.#shafts, this.#heads, this.#dots, this.#rings]) swarm.begin();
  }

  /** From `origin` along `vector` (arrays, m); `width` of the shaft, m. Shorter than its head it is a smaller arrow. */
  arrow(origin, vector, width, colour) {
    const direction = new THREE.Vector3(...vector);
    const size = direction.length();
    if (!(size > 1e-9)) return;
    const head = Math.min(5 * width, 0.5 * size);
    const thick = Math.min(width, 0.12 * size);
    const turn = new THREE.Quaternion().setFromUnitVectors(UP, direction.divideScalar(size));
    const at = new THREE.Vector3(...origin);
    const tone = new THREE.Color(colour);
    this.#shafts.put(new THREE.Matrix4().compose(at, turn, new THREE.Vector3(thick, size - head, thick)), tone);
    const tip = at.clone().addScaledVector(direction, size - head);
    this.#heads.put(new THREE.Matrix4().compose(tip, turn, new THREE.Vector3(2.6 * thick, head, 2.6 * thick)), tone);
  }

  dot(at, radius, colour) {
    const matrix = new THREE.Matrix4().compose(new THREE.Vector3(...at), new THREE.Quaternion(), new THREE.Vector3(radius, radius, radius));
    this.#dots.put(matrix, new THREE.Color(colour));
  }

  /** An open ring about `axis`: a torque, or where a string is nearest. */
  ring(at, axis, radius, colour) {
    const direction = new THREE.Vector3(...axis);
    if (!(direction.lengthSq() > 1e-18)) return;
    const turn = new THREE.Quaternion().setFromUnitVectors(Z, direction.normalize());
    this.#rings.put(new THREE.Matrix4().compose(new THREE.Vector3(...at), turn, new THREE.Vector3(radius, radius, radius)), new THREE.Color(colour));
  }
}
