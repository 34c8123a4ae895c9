// The screens of the experiment, over everything but Stop and banners: what hapticd-lab asks (ExperimentScreen), with large buttons, keys and
// sliders. While strings are compared nothing of them is drawn: thickness and arrows would give the answer.
import { v1 } from 'hapticd-stream';
import { button, make, row } from './dom.js';
import { CHOICE_KEYS, stageOf } from './experiment_stage.js';
import { summaryElements } from './summary.js';

const Reply = v1.ExperimentReply;
const SURE_MS = 4000; // the second press that ends comes within this time
const FAMILIAR = { wall: 'Here is a wall.', sphere: 'Here is a sphere.' };

export class ExperimentScreen {
  #holder;
  #actions;
  #shown = null;
  #answered = false;

  /** `actions`: answer({number, reply, score}) -> promise of success, end(), close(). */
  constructor(holder, actions) {
    this.#holder = holder;
    this.#actions = actions;
    window.addEventListener('keydown', (event) => this.#key(event), { capture: true });
  }

  /** Draws a screen of this page, or (with null) nothing. */
  show(screen) {
    if (screen?.number === this.#shown?.number && screen?.stage === this.#shown?.stage && screen?.participant === this.#shown?.participant) return;
    this.#shown = screen;
    this.#answered = false;
    this.#holder.hidden = !screen;
    document.body.classList.toggle('experiment', Boolean(screen));
    this.#holder.dataset.stage = stageOf(screen);
    this.#holder.replaceChildren(...(screen ? [make('div', { class: 'card' }, ...this.#parts(screen))] : []));
    this.#holder.querySelector('[data-focus]')?.focus();
  }

  /** Nothing of the scene is seen, so that nothing has to be drawn. */
  get covers() {
    return !this.#holder.hidden && this.#holder.dataset.stage !== 'familiarise';
  }

  /** Clears a fault and engages, where something can be touched. */
  engage() {
    this.#answer('ENGAGE');
  }

  async #answer(reply, score = 0) {
    if (this.#answered || !this.#shown) return;
    this.#answered = true; // whatever comes twice is one answer
    const buttons = [...this.#holder.querySelectorAll('button')];
    buttons.forEach((each) => { each.disabled = true; });
    if (await this.#actions.answer({ number: this.#shown.number, reply: Reply[`EXPERIMENT_REPLY_${reply}`], score })) return;
    this.#answered = false;
    buttons.forEach((each) => { each.disabled = false; });
  }

  #key(event) {
    if (this.#holder.hidden || event.key === 'Escape') return; // Stop stops
    // Keys of the picture do nothing here, and a key that is held goes on once.
    event.stopPropagation();
    if (event.repeat && event.target.type !== 'range') event.preventDefault();
    if (event.repeat || event.ctrlKey || event.metaKey || event.altKey) return;
    const stage = stageOf(this.#shown);
    if (stage === 'compare' && CHOICE_KEYS[event.key.toLowerCase()]) this.#answer(CHOICE_KEYS[event.key.toLowerCase()]);
    if (stage === 'rate' && event.key === 'Enter' && event.target.type === 'range') this.#holder.querySelector('.go').click();
  }

  #parts(screen) {
    const stage = stageOf(screen);
    if (stage === 'done') return this.#done(screen);
    const parts = { instruct: () => this.#instruct(screen), familiarise: () => this.#familiarise(screen), touch: () => this.#touch(screen),
      compare: () => this.#compare(), rate: () => this.#rate(screen) }[stage]();
    const progress = make('progress', { max: screen.trials || 1, value: screen.kept, 'aria-label': `${screen.kept} of ${screen.trials} trials are answered` });
    const trial = ['touch', 'compare'].includes(stage) ? `Trial ${screen.kept + 1} of ${screen.trials}` : '';
    return [row(progress, make('span', { class: 'note', id: 'trial-number' }, trial), this.#end()), ...parts,
      ...(screen.notice ? [make('p', { class: 'note bad', role: 'alert' }, screen.notice)] : [])];
  }

  #next(text) {
    return button(text, () => this.#answer('NEXT'), { class: 'go large', 'data-reply': 'NEXT', 'data-focus': '' });
  }

  #noForce() {
    return button('No force? Engage', () => this.#answer('ENGAGE'), { 'data-reply': 'ENGAGE', title: 'Clears a fault and engages; move the device clear of everything first' });
  }

  #instruct(screen) {
    const onward = screen.kept ? [make('p', { id: 'trial-onward' }, `${screen.kept} trials are answered already; it goes on with trial ${Math.min(screen.kept + 1, screen.trials)}.`)] : [];
    return [make('h2', {}, 'Which string is stiffer?'), make('p', {}, screen.text), ...onward, row(this.#next(screen.kept ? 'Go on' : 'Begin'))];
  }

  #familiarise(screen) {
    return [make('h2', {}, 'Get used to the device'),
      make('p', {}, `${FAMILIAR[screen.object] ?? `Here is: ${screen.object}.`} Touch it, press it, slide on it, as long as you like.`), row(this.#next('Continue'), this.#noForce())];
  }

  #touch(screen) {
    return [make('h2', { class: 'string' }, `String ${screen.object}`), make('p', {}, 'Press it, as often as you like. Then continue.'), row(this.#next('Continue'), this.#noForce())];
  }

  #compare() {
    const choice = (reply, text, key) => {
      const made = button(text, () => this.#answer(reply), { class: 'large choice', 'data-reply': reply });
      made.append(make('kbd', {}, key));
      return made;
    };
    // No answer has the focus: Enter would give one that was not chosen.
    return [make('h2', { tabIndex: -1, 'data-focus': '' }, 'Which one was stiffer?'), row(choice('FIRST', 'String A', 'A'), choice('EQUAL', 'Equal', 'E'), choice('SECOND', 'String B', 'B')),
      row(button('Feel both once more (R)', () => this.#answer('AGAIN'), { 'data-reply': 'AGAIN' }))];
  }

  #rate(screen) {
    const said = make('output', {}, '–');
    const keep = button('Keep', () => this.#answer('SCORE', Number(slider.value)), { class: 'go large', 'data-reply': 'SCORE', disabled: true });
    const slider = make('input', { type: 'range', min: 0, max: 100, step: 1, value: 50, 'aria-label': screen.object, 'data-focus': '' });
    // Its first position is not an answer.
    slider.oninput = slider.onpointerup = slider.onkeyup = () => {
      said.textContent = slider.value;
      keep.disabled = this.#answered;
    };
    return [make('h2', {}, screen.object), make('p', {}, `How much is it like a real string: ${screen.text}?`),
      row(make('span', { class: 'note' }, '0'), slider, make('span', { class: 'note' }, '100')), row(make('span', { class: 'note' }, '100 is like a real string'), said, keep)];
  }

  #end() {
    const end = button('End here', () => {
      if (end.dataset.sure) return this.#actions.end();
      end.dataset.sure = 'yes';
      end.textContent = 'Really end? All answers are kept';
      setTimeout(() => {
        delete end.dataset.sure;
        end.textContent = 'End here';
      }, SURE_MS);
      return undefined;
    }, { class: 'end' });
    return end;
  }

  #done(screen) {
    return [make('h2', {}, 'Thank you!'), make('p', {}, 'All questions are answered.'),
      make('p', { class: 'note' }, `The files of ${screen.participant} are in `, make('code', { id: 'trial-folder' }, screen.folder), ' on the machine of haptic-web; codebook.md there says what they hold.'),
      make('details', {}, make('summary', {}, 'Result'), ...summaryElements(screen.text)), row(button('Close', () => this.#actions.close(), { class: 'go', id: 'trial-close', 'data-focus': '' }))];
  }
}
