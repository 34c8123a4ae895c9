// One picture for each eye: side by side for a viewer or for looking parallel, or red and cyan for glasses of paper. The eyes look at the
// point the camera turns around, so what is nearer stands before the screen.
import * as THREE from 'three';

export const STEREO_MODES = ['off', 'side', 'anaglyph'];
/** Distance of the eyes over the distance looked at: a thirtieth is comfortable for what fills the screen. */
const EYES_OVER_FOCUS = 1 / 30;

/** Eyes for something at `focusM`: {eyesM, focusM}. */
export const eyesFor = (focusM) => ({ eyesM: focusM * EYES_OVER_FOCUS, focusM });

export class StereoPainter {
  mode = 'off';
  #eyes = new THREE.StereoCamera();

  /** Draws `scene` as `camera` sees it, focused at `focusM`. */
  draw(renderer, scene, camera, focusM) {
    if (this.mode === 'off') {
      renderer.render(scene, camera);
      return;
    }
    const size = renderer.getSize(new THREE.Vector2());
    const { eyesM } = eyesFor(focusM);
    camera.focus = focusM;
    this.#eyes.eyeSep = eyesM;
    this.#eyes.aspect = this.mode === 'side' ? 0.5 : 1;
    camera.updateMatrixWorld();
    this.#eyes.update(camera);
    if (this.mode === 'side') this.#sideBySide(renderer, scene, size);
    else this.#anaglyph(renderer, scene);
  }

  #sideBySide(renderer, scene, size) {
    renderer.setScissorTest(true);
    [this.#eyes.cameraL, this.#eyes.cameraR].forEach((eye, i) => {
      const box = [(i * size.x) / 2, 0, size.x / 2, size.y];
      renderer.setScissor(...box);
      renderer.setViewport(...box);
      renderer.render(scene, eye);
    });
    renderer.setScissorTest(false);
    renderer.setViewport(0, 0, size.x, size.y);
  }

  #anaglyph(renderer, scene) {
    const gl = renderer.getContext();
    renderer.autoClear = false;
    renderer.clear();
    gl.colorMask(true, false, false, true);
    renderer.render(scene, this.#eyes.cameraL);
    renderer.clearDepth();
    gl.colorMask(false, true, true, true);
    renderer.render(scene, this.#eyes.cameraR);
    gl.colorMask(true, true, true, true);
    renderer.autoClear = true;
  }
}
