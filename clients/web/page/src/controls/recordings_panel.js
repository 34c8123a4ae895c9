// Recordings: what the recorder does, what there is, and replay. The gateway shows a recording to all pages in place of the daemon, whose
// session goes on; to compute one again is a separate program.
import { v1 } from 'hapticd-stream';
import { button, fill, group, make, row } from './dom.js';
import { isOk } from './session.js';

export class RecordingsPanel {
  #session;
  #parts = {};
  #written = null;
  #mayControl = false;

  constructor(session) {
    this.#session = session;
    const start = button('● Record', () => this.#toggleRecord(), { id: 'record', 'data-lease': '' });
    const dump = button('Keep last 60 s', () => session.ask({ record: { mode: v1.RecordMode.RECORD_MODE_DUMP } }), { id: 'dump', 'data-lease': '' });
    const recorded = make('p', { class: 'note', id: 'recorder-note' });
    const recordings = make('select', { id: 'recordings', class: 'grow', 'aria-label': 'Recording', onchange: () => this.refresh() });
    const replay = button('▶ Replay', () => session.show(recordings.value), { id: 'replay', title: 'Show it here, to all pages, with a slider' });
    const end = button('End replay', () => session.ask({ replay: {} }), { id: 'replay-end', 'data-lease': '' });
    const how = make('p', { class: 'note', id: 'replay-how' });
    Object.assign(this.#parts, { start, recorded, recordings, replay, end, how });
    this.element = group('Recordings', row(start, dump), recorded, row(recordings, replay, end), how);
  }

  #toggleRecord() {
    const on = this.#session.recorder?.state === v1.RecordState.RECORD_STATE_RECORDING;
    this.#session.ask({ record: { mode: on ? v1.RecordMode.RECORD_MODE_STOP : v1.RecordMode.RECORD_MODE_START } });
  }

  /** Asks daemon and gateway for what there is, and chooses `wanted`, or what was chosen. */
  async list(wanted) {
    const [daemon, gateway] = await Promise.all([this.#session.ask({ list_recordings: {} }, { quiet: true }), this.#session.listRecordings()]);
    fill(this.#parts.recordings, recordingChoices(namesOf(daemon), namesOf(gateway)), wanted);
    this.refresh();
  }

  refresh() {
    const { mayControl, recorder } = this.#session;
    const { start, recorded, recordings, replay, how } = this.#parts;
    const State = v1.RecordState;
    start.textContent = recorder?.state === State.RECORD_STATE_RECORDING ? '■ End recording' : '● Record';
    recorded.textContent = recorderText(recorder);
    replay.disabled = !mayControl || !recordings.value;
    const file = recordings.value;
    if (how.dataset.file !== file) how.replaceChildren(...(file ? ['To compute it again and compare each bit: ', make('code', {}, `hapticctl replay ${file}`), '.'] : []));
    how.dataset.file = file;
    const written = recorder?.state === State.RECORD_STATE_WRITTEN ? recorder.file : null;
    // Also where no daemon is whose scene would be the occasion to ask.
    const comes = mayControl && ((written && written !== this.#written) || !this.#mayControl);
    this.#written = written;
    this.#mayControl = mayControl;
    if (comes) this.list(written ?? undefined);
  }

  /** What the newest State of the daemon says. */
  show(state) {
    this.#parts.end.hidden = !state.replay;
  }
}

const namesOf = (result) => (isOk(result) && result.listing ? result.listing.names : []);

/** [[name, text], ...]: what the gateway can show, and then what lies with the daemon alone. */
export function recordingChoices(daemon, gateway) {
  const here = new Set(gateway);
  return [...gateway.map((name) => [name, name]), ...daemon.filter((name) => !here.has(name)).map((name) => [name, `${name} · on the daemon’s machine`])];
}

export function recorderText(recorder) {
  const State = v1.RecordState;
  if (!recorder || recorder.state === State.RECORD_STATE_IDLE) return 'Only the last 60 s are kept.';
  const size = `${recorder.ticks} ticks, ${(recorder.bytes / 1e6).toFixed(1)} MB`;
  if (recorder.state === State.RECORD_STATE_FAILED) return `Failed: ${recorder.message}`;
  return `${recorder.state === State.RECORD_STATE_RECORDING ? 'Writing' : 'Written'} ${recorder.file}: ${size}${recorder.lost_ticks ? `, ${recorder.lost_ticks} ticks lost` : ''}`;
}
