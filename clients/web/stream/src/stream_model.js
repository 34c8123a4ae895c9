// What has arrived, put where it belongs: scene, States, radii of strings, lease, faults, link. Whoever draws or sounds it reads it; it knows
// nobody.
import { monotonicS } from './connection.js';
import { DaemonClock, shownNs } from './clock.js';
import { sceneModel } from './scene_model.js';
import { StateBuffer } from './state_buffer.js';
import { StringMotion } from './string_motion.js';
import { v1 } from './wire.js';

const TONES_KEPT = 64;

export class StreamModel {
  clock = new DaemonClock();
  states = new StateBuffer();
  motion = new StringMotion();
  tones = []; // not yet shown, oldest first
  welcome = null;
  link = null;
  fault = null;
  playback = null;
  shown = null; // PageShown
  scene = null;
  received = { states: 0 };

  /**
   * `session` keeps lease, recorder and the daemon's scene for who controls, and is told with changed() and lost(); `handlers`: scene(model),
   * state(State), playback(PagePlayback), shown(), none of which has to be there; `pageS` a clock that never goes back, s.
   */
  constructor({ session = { changed() {}, lost() {} }, handlers = {}, pageS = monotonicS } = {}) {
    Object.assign(this, { session, handlers, pageS });
  }

  /** The connection is lost. */
  lost() {
    Object.assign(this, { welcome: null, link: null, shown: null });
    this.#forget();
    this.session.lost();
  }

  /** Nothing that came before goes on. The scene stays until another comes. */
  #forget() {
    Object.assign(this, { playback: null, fault: null, tones: [] });
    this.clock.forget();
    this.states.clear();
    this.motion.clear();
  }

  /** A recording is shown, not the daemon. */
  get recorded() {
    return this.shown?.source === v1.PageSource.PAGE_SOURCE_RECORDING;
  }

  /** Takes a PageEvent. */
  take(event) {
    if (event.state) this.#takeState(event.state);
    else if (event.item) this.#takeItem(event.item);
    else if (event.pong) this.clock.heard(event.pong.sent_s, event.pong.daemon_t_ns, this.pageS());
    else if (event.link) this.#takeLink(event.link);
    else if (event.welcome) this.#takeWelcome(event.welcome);
    else if (event.playback) this.#takePlayback(event.playback);
    else if (event.shown) this.#takeShown(event.shown);
    else if (event.experiment) this.#tell('experimentScreen', event.experiment);
  }

  #takeState(state) {
    ++this.received.states;
    // States of a scene that is not known yet cannot be drawn; its SceneInfo is under way.
    if (!this.scene || state.scene_id !== this.scene.id) return;
    // A recording that was moved back: what was told later has not been told yet.
    if (state.t_ns < this.states.newest?.t_ns) this.motion.soundings.clear();
    this.states.add(state);
    this.motion.soundings.addState(state);
    this.handlers.state?.(state);
  }

  #takeWelcome(welcome) {
    this.welcome = welcome;
    this.shown = { source: welcome.source, recording: '', cut_off: false, daemon_fault: '', tools_only: false };
    this.session.recorded = this.recorded;
    this.session.connected = true;
    this.session.maySteer = welcome.steer;
    this.#tell('mayControl', welcome.control);
  }

  #takeLink(link) {
    const Live = v1.PageLinkState.PAGE_LINK_STATE_LIVE;
    if (link.state !== Live && this.link?.state === Live && !this.recorded) {
      // Another run of the daemon has another clock, and its ticks start again.
      this.clock.forget();
      this.states.clear();
      this.motion.clear();
    }
    this.link = link;
  }

  #takePlayback(playback) {
    this.playback = playback;
    this.handlers.playback?.(playback);
  }

  #takeShown(shown) {
    const other = this.shown?.source !== shown.source || this.shown.recording !== shown.recording;
    this.shown = shown;
    this.#tell('recorded', this.recorded);
    if (other) {
      this.#forget();
      this.scene = null;
    }
    this.handlers.shown?.();
  }

  #takeItem(item) {
    if (item.scene_info) this.#takeScene(item.scene_info);
    else if (item.string_radius) this.motion.add(item.string_radius);
    else if (item.string_sounding) this.motion.soundings.add(item.string_sounding);
    else if (item.tone) this.tones = [...this.tones, item.tone].slice(-TONES_KEPT);
    else if (item.fault) this.fault = item.fault.latched ? item.fault : null;
    else if (item.lease_info) this.#tell('lease', item.lease_info);
    else if (item.record_info) this.#tell('recorder', item.record_info);
  }

  #tell(name, value) {
    this.session[name] = value;
    this.session.changed();
  }

  #takeScene(info) {
    this.scene = sceneModel(info);
    this.states.clear();
    this.motion.clear();
    this.tones = [];
    // What the panels change is the daemon's scene.
    if (!this.recorded) this.#tell('scene', this.scene);
    this.handlers.scene?.(this.scene);
  }

  /** Time of the daemon goes on as ours does: neither virtual nor a recording that pauses or runs at another pace. */
  get steady() {
    if (this.scene?.virtual) return false;
    return !this.recorded;
  }

  /** Instant of the daemon that is shown now, ns; null without any State. */
  shownNs() {
    const newest = this.states.newest;
    if (!newest) return null;
    const delayS = this.welcome?.presentation_delay_s ?? 0.008;
    return shownNs({ clock: this.clock, pageS: this.pageS(), delayS, newestNs: newest.t_ns, steady: this.steady });
  }

  /** Tones whose instant has come at `ns`; each is given out once. */
  dueTones(ns) {
    const due = this.tones.filter((tone) => tone.t_ns <= ns);
    if (due.length) this.tones = this.tones.filter((tone) => tone.t_ns > ns);
    return due;
  }
}
