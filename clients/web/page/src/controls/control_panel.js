// The Control side: lease, force, scene, quality, gesture, and the panels of recordings and parameters. What this page may not do now is greyed, and the first
// line says why.
import { button, fill, group, make, row } from './dom.js';
import { ParameterPanel } from './parameter_panel.js';
import { RecordingsPanel } from './recordings_panel.js';
import { isOk } from './session.js';

export class ControlPanel {
  #session;
  #parts = {};

  constructor(holder, session) {
    this.#session = session;
    this.parameters = new ParameterPanel(session);
    this.recordings = new RecordingsPanel(session);
    this.note = make('p', { class: 'note', id: 'said', role: 'status' });
    holder.append(this.#lease(), this.#force(), this.#scene(), this.#gesture(), this.recordings.element, this.parameters.element);
    session.addEventListener('change', () => this.refresh());
    session.addEventListener('said', ({ detail }) => this.#say(detail));
    this.refresh();
  }

  #say({ ok, text }) {
    this.note.textContent = text;
    this.note.className = `note ${ok ? 'good' : 'bad'}`;
  }

  #lease() {
    const take = button('Take control', () => this.#toggleLease(), { id: 'lease', class: 'go' });
    const who = make('span', { class: 'grow note', id: 'lease-note' });
    Object.assign(this.#parts, { take, who });
    return group('Control', row(take, who), this.note);
  }

  async #toggleLease() {
    const { controls, lease } = this.#session;
    if (controls) return this.#session.ask({ release: {} });
    if (!lease?.fence) return this.#session.ask({ acquire: { holder: 'web page' } });
    const reason = window.prompt(`${lease.holder || 'Another client'} has control. It and everyone else is told why you take it over:`, '');
    return reason?.trim() ? this.#session.ask({ acquire: { holder: 'web page', take_over: reason.trim() } }) : null;
  }

  #force() {
    const ask = (item) => () => this.#session.ask(item);
    return group('Force', row(
      button('Engage', ask({ engage: {} }), { 'data-lease': '' }),
      button('Disengage', ask({ disengage: {} }), { 'data-lease': '' }),
      button('Clear fault', ask({ clear: {} }), { 'data-lease': '', id: 'clear' }),
      button('Recentre', () => this.#session.ask({ recentre: { tool_id: this.#session.scene?.tools[0]?.id ?? 0 } }), { 'data-lease': '' })));
  }

  #scene() {
    const scenes = make('select', { id: 'scenes', class: 'grow', 'aria-label': 'Scene', 'data-lease': '' });
    const preset = make('select', { id: 'preset', 'aria-label': 'Preset', 'data-lease': '' });
    fill(preset, [['0', 'as the scene says'], ['1', 'paper'], ['2', 'deflecting']], '0');
    const load = button('Load', () => this.#load(scenes.value, Number(preset.value)), { id: 'load', 'data-lease': '' });
    const quality = make('select', { id: 'quality', 'aria-label': 'Quality', 'data-lease': '' });
    fill(quality, [['auto', 'automatic'], ...[0, 1, 2, 3, 4].map((level) => [String(level), `${level}${['fastest', '', '', 'default', 'exact'][level] ? ` · ${['fastest', '', '', 'default', 'exact'][level]}` : ''}`])], '3');
    quality.onchange = () => this.#setQuality(quality.value);
    const inForce = make('span', { class: 'note grow', id: 'quality-note' });
    Object.assign(this.#parts, { scenes, quality, inForce });
    return group('Scene and quality', row(scenes, preset, load), row(make('span', {}, 'Quality'), quality, inForce));
  }

  #load(name, preset) {
    this.#session.ask({ load_scene: preset ? { name, preset } : { name } });
  }

  #setQuality(value) {
    const assignment = value === 'auto' ? { path: 'quality', text: 'auto' } : { path: 'quality', number: Number(value) };
    this.#session.ask({ set_parameter: { assignments: [assignment] } });
  }

  #gesture() {
    const gestures = make('select', { id: 'gestures', class: 'grow', 'aria-label': 'Gesture', 'data-lease': '' });
    const arm = make('select', { id: 'arm', 'aria-label': 'Arm', 'data-lease': '' });
    fill(arm, [['0', 'arm as before'], ['2', 'light arm'], ['3', 'firm arm'], ['1', 'no hand'], ['4', 'adversarial']], '0');
    const repeat = make('input', { type: 'number', min: 0, max: 1000000, value: 1, id: 'repeat', 'aria-label': 'Repetitions, 0 = for ever', title: 'Repetitions, 0 = for ever', 'data-lease': '' });
    repeat.style.width = '5em';
    const play = button('Play', () => this.#session.ask({ play_gesture: { name: gestures.value, arm: Number(arm.value), repeat: Number(repeat.value) } }), { id: 'play-gesture', 'data-lease': '' });
    const end = button('End', () => this.#session.ask({ play_gesture: {} }), { 'data-lease': '', id: 'gesture-end' });
    const progress = make('meter', { min: 0, max: 1, value: 0, id: 'gesture-progress', 'aria-label': 'Progress of the gesture' });
    const name = make('span', { class: 'note grow', id: 'gesture-note' });
    Object.assign(this.#parts, { gestures, progress, gestureName: name });
    return group('Gesture of the simulated hand', row(gestures, arm), row(repeat, make('span', { class: 'note' }, 'times'), play, end), row(name, progress));
  }

  /** Names of scenes, gestures and recordings, asked for anew at each connection and scene. */
  async list() {
    const [scenes, gestures] = await Promise.all([this.#names({ list_scenes: {} }), this.#names({ list_gestures: {} }), this.recordings.list()]);
    fill(this.#parts.scenes, scenes, this.#session.scene?.name);
    fill(this.#parts.gestures, gestures);
    await this.parameters.load();
  }

  /** [[name, text to show], ...] of a listing; empty when it is refused. */
  async #names(item) {
    const result = await this.#session.ask(item, { quiet: true });
    return isOk(result) && result.listing ? result.listing.names.map((name, i) => [name, result.listing.descriptions[i] ? `${name} · ${result.listing.descriptions[i]}` : name]) : [];
  }

  refresh() {
    const { mayControl, controls, lease } = this.#session;
    const { take, who } = this.#parts;
    take.textContent = controls ? 'Give back' : lease?.fence ? 'Take over…' : 'Take control';
    take.disabled = !mayControl;
    who.textContent = leaseText(mayControl, lease);
    document.querySelectorAll('[data-lease]').forEach((element) => { element.disabled = !controls; });
    this.recordings.refresh();
  }

  /** What the newest State says about quality and gesture. */
  show(state) {
    const { inForce, gestureName, progress } = this.#parts;
    const quality = state.quality;
    if (quality) inForce.textContent = `level ${quality.level}${quality.automatic ? ', automatic' : ''} · ${quality.substeps} sub-step${quality.substeps === 1 ? '' : 's'}`;
    const gesture = state.gestures[0];
    gestureName.textContent = gesture ? `${gesture.name}, ${gesture.repeated_count} done` : 'no gesture plays';
    progress.value = gesture?.progress ?? 0;
    this.recordings.show(state);
  }
}

export function leaseText(mayControl, lease) {
  if (!mayControl) return 'This page may only look. To control, open the address that haptic-web prints, token included; the token changes with each start.';
  const why = lease?.reason ? ` Taken over${lease.taken_from ? ` from ${lease.taken_from}` : ''}: ${lease.reason}` : '';
  if (lease?.yours) return `This page controls.${why}`;
  return lease?.fence ? `Held by ${lease.holder || 'another client'}.${why}` : 'Nobody controls.';
}
