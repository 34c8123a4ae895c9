// A recording that is shown: its name, slider, pause, speed, and the way back to the daemon for those who may. While the slider is held it
// belongs to the hand.
import { shownText } from './connection_panel.js';

export class PlaybackBar {
  #bar = document.getElementById('playback');
  #time = document.getElementById('playback-time');
  #run = document.getElementById('playback-run');
  #rate = document.getElementById('playback-rate');
  #text = document.getElementById('playback-text');
  #name = document.getElementById('playback-name');
  #live = document.getElementById('playback-live');
  #last = { position_s: 0, duration_s: 0, playing: false, rate: 1 };
  #held = false;

  constructor(session) {
    const send = (change) => session.play({ ...this.#last, ...change });
    this.#time.oninput = () => {
      this.#held = true;
      send({ position_s: this.#chosenS(), playing: false });
    };
    this.#time.onchange = () => {
      this.#held = false;
      send({ position_s: this.#chosenS() });
    };
    this.toggle = () => send({ playing: !this.#last.playing });
    this.#run.onclick = this.toggle;
    this.#live.onclick = () => session.show('');
    this.#rate.onchange = () => send({ rate: Number(this.#rate.value) });
  }

  get shown() {
    return !this.#bar.hidden;
  }

  get position() {
    return this.#last;
  }

  #chosenS() {
    return (Number(this.#time.value) / 1000) * this.#last.duration_s;
  }

  /** Tells what is shown (PageShown), and what this page may do with it. */
  tell(shown, { mayControl, maySteer }) {
    this.#name.textContent = shownText(shown);
    this.#live.hidden = !mayControl;
    for (const part of [this.#time, this.#run, this.#rate]) part.disabled = !maySteer;
  }

  /** A PagePlayback arrived; null hides the bar. */
  show(playback) {
    this.#bar.hidden = !playback;
    if (!playback) return;
    this.#last = { position_s: playback.position_s, duration_s: playback.duration_s, playing: playback.playing, rate: playback.rate || 1 };
    this.#run.textContent = playback.playing ? '⏸' : '▶';
    if (!this.#held) this.#time.value = playback.duration_s > 0 ? (1000 * playback.position_s) / playback.duration_s : 0;
    this.#text.textContent = `${playback.position_s.toFixed(1)} / ${playback.duration_s.toFixed(1)} s`;
  }
}
