// A film of a recording: its maker (hapticd-lab) has instant after instant drawn and takes a picture of each. Drawing follows these
// instants and no clock, so that a film is the same on a slow machine. The page shows the picture, force and torque, and a caption then.

export class Film {
  #arrived = null;
  #drawnS = Infinity; // instant that was drawn last

  /** `draw(elapsedS)` draws what is newest, so long after what was drawn before, and writes all texts; `scene()` is the promise of the scene that is being drawn. */
  constructor({ model, session, panels, draw, scene }) {
    Object.assign(this, { model, session, panels, draw, scene, rolling: false });
  }

  /** Waits for a recording and the files of its scene, stops it at its beginning, and puts the page into its form for films; its length, s. */
  async begin(caption = '') {
    while (!this.model.recorded || !this.model.playback || !this.model.scene) await new Promise((resolve) => setTimeout(resolve, 20));
    this.rolling = true;
    document.body.classList.add('film');
    document.getElementById('film-caption').textContent = caption;
    this.panels.seconds = Math.min(Math.max(this.model.playback.duration_s, 1), 10);
    await this.frame(0);
    this.panels.clear();
    return this.model.playback.duration_s;
  }

  /** Draws the instant `positionS` of the recording; resolves as soon as it is on the screen. */
  async frame(positionS) {
    const wantedS = Math.min(Math.max(positionS, 0), this.model.playback.duration_s);
    const arrived = new Promise((resolve) => { this.#arrived = { wantedS, resolve }; });
    this.session.play({ position_s: wantedS, playing: false, rate: 1 });
    await arrived;
    await this.scene();
    // At first, and after a jump back, nothing goes on from what was there.
    const elapsedS = wantedS >= this.#drawnS ? wantedS - this.#drawnS : Infinity;
    this.#drawnS = wantedS;
    document.getElementById('film-time').textContent = `${wantedS.toFixed(2)} s`;
    await new Promise((resolve) => requestAnimationFrame(() => resolve(this.draw(elapsedS))));
    return wantedS;
  }

  /** A PagePlayback came: the State of its position has come before it. */
  heard({ position_s, playing }) {
    // To and fro over the wire a double stays what it is; the end of a recording may be given as one tick less.
    if (!this.#arrived || playing || Math.abs(position_s - this.#arrived.wantedS) > 1e-6) return;
    const { resolve } = this.#arrived;
    this.#arrived = null;
    resolve();
  }
}
