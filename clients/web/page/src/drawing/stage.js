// The room: renderer, light with shadow, the table things stand on, and what a frame costs. Everything is in metres, y up.
import * as THREE from 'three';
import { RoomEnvironment } from 'three/addons/environments/RoomEnvironment.js';

const BACKGROUND = '#1d2026';

/** No GPU: pixels cost as much as everything else together, so edges stay rough, the shadow is coarser and the lit part of the table smaller. */
export function rendersInSoftware() {
  const gl = document.createElement('canvas').getContext('webgl2');
  const names = gl?.getExtension('WEBGL_debug_renderer_info');
  const name = names ? gl.getParameter(names.UNMASKED_RENDERER_WEBGL) : '';
  gl?.getExtension('WEBGL_lose_context')?.loseContext();
  return /llvmpipe|softpipe|swiftshader|software/i.test(name);
}

export class Stage {
  /** `high`: a GPU is there, so full light and fine shadows. */
  constructor(canvas, { high }) {
    this.high = high;
    this.thrifty = !high && rendersInSoftware();
    this.renderer = new THREE.WebGLRenderer({ canvas, antialias: !this.thrifty, powerPreference: 'high-performance' });
    this.renderer.setPixelRatio(high ? Math.min(window.devicePixelRatio, 2) : 1);
    this.renderer.shadowMap.enabled = true;
    this.renderer.shadowMap.type = THREE.PCFShadowMap;
    this.renderer.toneMapping = THREE.ACESFilmicToneMapping;
    this.renderer.toneMappingExposure = 1.15;
    this.scene = new THREE.Scene();
    this.scene.background = new THREE.Color(BACKGROUND);
    this.camera = new THREE.PerspectiveCamera(38, 16 / 9, 0.01, 50);
    this.things = new THREE.Group(); // what changes with the scene
    this.scene.add(this.things);
    this.#addLight();
    this.#addTable();
    if (high) this.#addReflections();
  }

  #addLight() {
    this.scene.add(new THREE.HemisphereLight('#dfe8ff', '#4a3a2e', this.high ? 0.5 : 1.15));
    this.sun = new THREE.DirectionalLight('#fff1dc', this.high ? 1.9 : 2.7);
    this.sun.castShadow = true;
    this.sun.shadow.mapSize.setScalar(this.high ? 4096 : this.thrifty ? 1024 : 2048);
    this.sun.shadow.bias = -0.0004;
    this.sun.shadow.normalBias = 0.0006;
    this.sun.shadow.radius = 3;
    const rim = new THREE.DirectionalLight('#8fb2ff', 0.7);
    rim.position.set(-0.8, 0.5, -1.2);
    this.scene.add(this.sun, this.sun.target, rim);
  }

  /** What polished things mirror: a room with windows. */
  #addReflections() {
    const maker = new THREE.PMREMGenerator(this.renderer);
    this.scene.environment = maker.fromScene(new RoomEnvironment(), 0.04).texture;
    this.scene.environmentIntensity = 0.2;
    maker.dispose();
  }

  /** After the browser had taken the drawing away: what was drawn into a texture is drawn again. */
  restore() {
    if (this.high) this.#addReflections();
  }

  #addTable() {
    const shade = document.createElement('canvas');
    shade.width = shade.height = 256;
    const context = shade.getContext('2d');
    const fade = context.createRadialGradient(128, 128, 10, 128, 128, 128);
    fade.addColorStop(0, '#626a78ff');
    fade.addColorStop(0.55, '#4a515dc0');
    fade.addColorStop(1, '#30353e00');
    context.fillStyle = fade;
    context.fillRect(0, 0, 256, 256);
    const texture = new THREE.CanvasTexture(shade);
    texture.colorSpace = THREE.SRGBColorSpace;
    this.table = new THREE.Mesh(new THREE.CircleGeometry(1, 64), new THREE.MeshLambertMaterial({ map: texture, transparent: true, depthWrite: false }));
    this.table.rotation.x = -Math.PI / 2;
    this.table.receiveShadow = true;
    this.table.renderOrder = -1; // below all that is see-through
    this.scene.add(this.table);
  }

  /** Puts light and table to the size of a scene: `box` of model/scene_model. */
  fit(box) {
    const centre = new THREE.Vector3(...box.centre);
    const size = box.size;
    this.sun.position.copy(centre).add(new THREE.Vector3(-0.34, 1, 0.34).multiplyScalar(size));
    this.sun.target.position.copy(centre);
    const camera = this.sun.shadow.camera;
    const half = 0.56 * size;
    Object.assign(camera, { left: -half, right: half, top: half, bottom: -half, near: 0.1 * size, far: 2.4 * size });
    camera.updateProjectionMatrix();
    this.table.position.set(centre.x, box.lower[1] - 0.002 * size, centre.z);
    this.table.scale.setScalar((this.thrifty ? 0.8 : 1.5) * size);
    this.camera.near = Math.max(0.002, size * 0.008);
    this.camera.far = size * 12;
    this.camera.updateProjectionMatrix();
  }

  /** Takes everything of the last scene out and gives its memory back. */
  clear() {
    this.things.traverse((thing) => {
      thing.geometry?.dispose();
      [].concat(thing.material ?? []).forEach((material) => material.dispose());
      thing.dispose?.();
    });
    this.things.clear();
  }

  /** Follows the size of the canvas; true where it changed. */
  resize() {
    const { clientWidth: width, clientHeight: height } = this.renderer.domElement;
    const size = this.renderer.getSize(new THREE.Vector2());
    if (width === 0 || height === 0 || (size.x === width && size.y === height)) return false;
    this.renderer.setSize(width, height, false);
    this.camera.aspect = width / height;
    this.camera.updateProjectionMatrix();
    return true;
  }

  /** Before a frame: without a GPU the shadow follows at half the pace. */
  prepare(frame) {
    const { shadowMap } = this.renderer;
    shadowMap.autoUpdate = !this.thrifty;
    if (this.thrifty && frame % 2 === 0) shadowMap.needsUpdate = true;
  }

  /** Triangles of the last frame, shadows included. */
  get triangles() {
    return this.renderer.info.render.triangles;
  }
}
