// The experiment's side: who takes part, and how far it is. hapticd-lab runs it and keeps its files, so that a page that was closed, or a
// gateway that was restarted, loses nothing: the same participant goes on.
import { button, make, row } from './dom.js';
import { ExperimentScreen } from './experiment_screen.js';
import { isRunning, stageOf } from './experiment_stage.js';
import { isOk } from './session.js';

const REMEMBERED = 'hapticd.participant'; // whose experiment this browser began and did not see the end of

export class ExperimentPanel {
  #session;
  #banners;
  #screen;
  #shown = ''; // what the side says, so that it is not said again
  #closed = null; // the last screen that was closed here
  #fields = { participant: '', seed: 1 };

  constructor(holder, screenHolder, session, banners) {
    this.#session = session;
    this.#banners = banners;
    this.holder = holder;
    this.#fields.participant = this.#remembered();
    this.#screen = new ExperimentScreen(screenHolder, { answer: async (answer) => isOk(await session.experiment({ answer })), end: () => session.experiment({ end: {} }), close: () => this.#close() });
    session.addEventListener('change', () => this.#draw());
    this.#draw();
  }

  /** An experiment runs, on whichever page: scenes come and go. */
  get running() {
    return isRunning(this.#session.experimentScreen);
  }

  /** A screen lies over the picture. */
  get covers() {
    return this.#screen.covers;
  }

  /** Clears a fault and engages, for the banner of who takes part; null on another page. */
  get engage() {
    return this.running && this.#session.experimentScreen.yours ? () => this.#screen.engage() : null;
  }

  #remembered(participant) {
    try {
      if (participant) localStorage.setItem(REMEMBERED, participant);
      if (participant === '') localStorage.removeItem(REMEMBERED);
      return localStorage.getItem(REMEMBERED) ?? '';
    } catch {
      return this.#fields.participant; // a browser that keeps nothing: the name is typed again
    }
  }

  async #begin() {
    const { participant, seed } = this.#fields;
    if (this.#session.recorded) await this.#session.show('');
    // hapticd-lab takes control itself.
    if (this.#session.controls) await this.#session.ask({ release: {} });
    this.#closed = null;
    if (isOk(await this.#session.experiment({ begin: { participant, seed } }))) this.#remembered(participant);
  }

  #close() {
    this.#closed = this.#session.experimentScreen;
    this.#draw();
  }

  #draw() {
    const screen = this.#session.experimentScreen;
    const mine = screen?.yours && screen !== this.#closed;
    if (stageOf(screen) === 'done' && screen.participant === this.#remembered()) this.#remembered('');
    this.#screen.show(mine && (this.running || stageOf(screen) === 'done') ? screen : null);
    this.#fill(screen);
    this.#banners.set('experiment', this.#banner(screen));
  }

  /** The side; what somebody types in meanwhile is left alone as long as nothing else is to be shown. */
  #fill(screen) {
    const shown = [this.running, stageOf(screen), screen?.participant, screen?.kept, screen?.object, this.#session.mayControl].join();
    if (shown === this.#shown) return;
    this.#shown = shown;
    this.holder.replaceChildren(make('h2', {}, 'Which string is stiffer?'), ...(this.running ? this.#status(screen) : this.#start(screen)));
  }

  #banner(screen) {
    const participant = this.#remembered();
    if (!participant || this.running || stageOf(screen) === 'done' || !this.#session.connected) return null;
    const why = stageOf(screen) === 'stopped' && screen.participant === participant ? screen.text : 'All answers are kept.';
    const may = this.#session.mayControl;
    const goOn = () => {
      this.#fields.participant = participant;
      this.#begin();
    };
    return { title: `The experiment of ${participant} has stopped`, text: may ? why : `${why} Open the address that haptic-web prints now, and go on.`, action: may ? ['Go on', goOn] : null };
  }

  #status(screen) {
    const where = `${screen.participant}: ${screen.kept} of ${screen.trials} trials are answered (${stageOf(screen)} ${screen.object}).`;
    return [make('progress', { max: screen.trials || 1, value: screen.kept, style: 'width:100%' }), make('p', { id: 'experiment-status' }, where),
      row(button('End the experiment', () => this.#session.experiment({ end: {} }), { class: 'stop', disabled: !this.#session.mayControl }))];
  }

  #field(name, properties) {
    const field = make('input', { value: this.#fields[name], ...properties });
    field.oninput = () => { this.#fields[name] = name === 'seed' ? Number(field.value) || 0 : field.value.trim(); };
    return field;
  }

  #start(screen) {
    const participant = this.#field('participant', { type: 'text', id: 'experiment-participant', placeholder: 'P1', maxLength: 64, 'aria-label': 'Participant' });
    const seed = this.#field('seed', { type: 'number', id: 'experiment-seed', min: 0, 'aria-label': 'Seed of the order' });
    seed.style.width = '6em';
    participant.style.width = '9em';
    const begin = button('Begin or go on', () => this.#begin(), { id: 'experiment-begin', class: 'go', disabled: !this.#session.mayControl });
    const last = stageOf(screen) === 'stopped' ? [make('p', { class: 'note', id: 'experiment-last' }, `${screen.participant}: ${screen.text}`)] : [];
    return [make('p', { class: 'note' }, 'Psychophysics of the paper, Table 1: one of two strings has T, E or R raised by 30, 40 or 50 %, three pairs of each, 27 in all; a wall and a sphere before, five sliders after them.'),
      row(make('label', { class: 'note' }, 'Participant ', participant), make('label', { class: 'note' }, 'Order ', seed)), row(begin),
      make('p', { class: 'note' }, 'A participant whose experiment was interrupted goes on where it stopped, in the same order.'), ...last,
      make('p', { class: 'note' }, this.#session.mayControl ? '' : 'This page may only look.')];
  }
}
