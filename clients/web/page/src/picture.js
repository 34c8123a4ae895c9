// The picture: canvas, camera, stereo, and the view of the scene that plays. Draws a frame whenever the browser asks for one, as long as
// something may have moved. A browser may take the drawing away and give it again: in between nothing is drawn, and it goes on.
import { OrbitControls } from 'three/addons/controls/OrbitControls.js';
import { CameraFlight, viewOf } from './drawing/camera_views.js';
import { Labels, project } from './drawing/labels.js';
import { SceneView } from './drawing/scene_view.js';
import { Stage } from './drawing/stage.js';
import { StereoPainter } from './drawing/stereo.js';
import { AssetStore } from './model/asset_store.js';

export class Picture {
  view = null;
  drawnAs = [];
  viewName = 'player';
  following = false;
  followShare = 0.06; // of the way to the tool that camera and target go with each frame: slow enough to look calm
  frames = 0;
  triangles = 0;

  /** `lost(isLost)` hears that the browser takes the drawing away, or gives it again. Throws where there is no WebGL 2. */
  constructor(canvas, labelLayer, { high, motion, nowS, lost = () => {} }) {
    Object.assign(this, { canvas, motion, nowS, isLost: false });
    this.stage = new Stage(canvas, { high });
    this.labels = new Labels(labelLayer);
    this.assets = new AssetStore();
    this.painter = new StereoPainter();
    this.controls = new OrbitControls(this.stage.camera, canvas);
    Object.assign(this.controls, { enableDamping: true, dampingFactor: 0.12, minDistance: 0.03, zoomSpeed: 0.8 });
    this.controls.addEventListener('start', () => { this.viewName = ''; });
    this.flight = new CameraFlight(this.stage.camera, this.controls);
    // three.js asks for it back, and sends everything again.
    canvas.addEventListener('webglcontextlost', () => lost(this.isLost = true));
    canvas.addEventListener('webglcontextrestored', () => {
      this.stage.restore();
      lost(this.isLost = false);
    });
    this.options = { contacts: true, forces: true, depth: true, names: true, magnify: 1 };
  }

  /** Draws `model` from now on; meshes follow as they arrive. */
  async setScene(model) {
    const sameName = this.view?.model.name === model.name;
    this.stage.clear();
    this.labels.clear();
    const view = new SceneView(this.stage, model, { labels: this.labels, motion: this.motion });
    view.options = this.options;
    this.view = view;
    this.stage.fit(view.box);
    this.assets.missing = 0;
    if (!sameName) this.look(this.viewName || 'player', { atOnce: true }); // strings are there at once, meshes soon
    const drawnAs = await view.load(this.assets);
    if (this.view !== view) return; // the next scene came meanwhile
    this.drawnAs = drawnAs;
    this.following = this.viewName === 'close';
    if (!sameName) this.look(this.viewName || 'player', { atOnce: true });
  }

  /** Flies to a camera preset. */
  look(name, { atOnce = false } = {}) {
    this.viewName = name;
    this.stage.resize();
    if (!this.view) return;
    const { camera } = this.stage;
    const aspect = this.painter.mode === 'side' ? camera.aspect / 2 : camera.aspect;
    this.flight.flyTo(viewOf(name, { box: this.view.box, focus: this.focus(), aspect, fovDeg: camera.fov }), this.nowS(), { atOnce });
  }

  /** A picture for each eye, or one; names and rings beside things would be wrong for one of the two halves. */
  setStereo(mode) {
    if (this.painter.mode === mode) return;
    this.painter.mode = mode;
    this.canvas.parentElement.classList.toggle('side', mode === 'side');
    if (this.viewName) this.look(this.viewName, { atOnce: true });
  }

  /** What is played: where the first tool comes nearest to a string, else the tool itself. */
  focus() {
    const nearest = this.view?.nearest[0];
    if (nearest && nearest.distanceM < 0.1) return nearest.onString;
    return this.view?.tools[0]?.solid.position.toArray() ?? this.view?.box.centre ?? [0, 0, 0];
  }

  /** One frame: `state` at `ns` of the daemon's clock, or null to keep what is there. */
  draw(state, ns) {
    if (this.stage.resize() && this.viewName && this.view) this.look(this.viewName, { atOnce: true });
    if (this.view && state) this.view.show(state, ns);
    if (this.isLost) return;
    this.flight.step(this.nowS());
    if (this.following && !this.flight.flying) this.#follow();
    this.controls.update();
    const { camera, renderer, scene } = this.stage;
    camera.updateMatrixWorld();
    this.view?.prepare();
    this.stage.prepare(this.frames);
    this.painter.draw(renderer, scene, camera, camera.position.distanceTo(this.controls.target));
    this.triangles = this.stage.triangles;
    ++this.frames;
  }

  /** Camera and target go along with the tool. */
  #follow() {
    const { target } = this.controls;
    const focus = this.focus();
    const step = ['x', 'y', 'z'].map((axis, i) => this.followShare * (focus[i] - target[axis]));
    target.set(target.x + step[0], target.y + step[1], target.z + step[2]);
    const eye = this.stage.camera.position;
    eye.set(eye.x + step[0], eye.y + step[1], eye.z + step[2]);
  }

  /** Pixel of a world point, {x, y, depthM} or null. */
  project(at) {
    return project(at, this.stage.camera, this.canvas.clientWidth, this.canvas.clientHeight);
  }
}
