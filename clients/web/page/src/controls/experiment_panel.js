// The screen of the paper's Table 1: pairs of strings, of which one is stiffer. Each half is brought by a change of scene, whatever differs;
// 27 trials; the rates beside the published ones, and all answers as CSV.
import { textOf } from '../model/text_format.js';
import { button, make, row } from './dom.js';
import { INCREMENTS, makePlan, PARAMETERS, PUBLISHED, resultCsv, tally, trialScene } from './experiment_plan.js';
import { isOk } from './session.js';

const SCENE = 'single_string';

export class ExperimentPanel {
  #session;
  #plan = [];
  #answers = [];
  #seed = 1;
  #scene = null;
  #half = 0;

  constructor(holder, session) {
    this.#session = session;
    this.holder = holder;
    session.addEventListener('change', () => this.#draw());
    this.#draw();
  }

  get running() {
    return this.#scene !== null && this.#answers.length < this.#plan.length;
  }

  async #begin(seed) {
    // Its scenes are the daemon's.
    if (this.#session.recorded) await this.#session.show('');
    const loaded = await this.#session.ask({ load_scene: { name: SCENE, preset: 1 } });
    if (!isOk(loaded)) return;
    const scene = await this.#sceneNamed(SCENE);
    if (!scene) return;
    this.#seed = seed;
    this.#plan = makePlan(seed);
    this.#answers = [];
    this.#scene = scene;
    await this.#present(0);
  }

  /** SceneInfo follows the Result of LoadScene. */
  async #sceneNamed(name) {
    for (let tries = 0; tries < 100; ++tries) {
      if (this.#session.scene?.name === name) return this.#session.scene.scene;
      await new Promise((resolve) => setTimeout(resolve, 50));
    }
    return null;
  }

  async #present(half) {
    this.#half = half;
    const trial = this.#plan[this.#answers.length];
    await this.#session.ask({ load_scene: { text: textOf(trialScene(this.#scene, trial, half)), preset: 1 } });
    this.#draw();
  }

  async #answer(answer) {
    this.#answers.push(answer);
    if (this.running) await this.#present(0);
    else this.#draw();
  }

  #end() {
    this.#scene = null;
    this.#session.ask({ load_scene: { name: SCENE } });
    this.#draw();
  }

  #draw() {
    if (this.running) this.holder.replaceChildren(...this.#trial());
    else this.holder.replaceChildren(...this.#start(), ...this.#results());
  }

  #start() {
    const seed = make('input', { type: 'number', value: this.#seed, min: 1, id: 'experiment-seed', 'aria-label': 'Seed of the order' });
    seed.style.width = '7em';
    const begin = button('Begin', () => this.#begin(Number(seed.value) || 1), { id: 'experiment-begin', class: 'go', disabled: !this.#session.controls });
    return [make('h2', {}, 'Which string is stiffer?'),
      make('p', { class: 'note' }, 'Psychophysics of the paper, Table 1: tension T, Young’s modulus E or radius R raised by 30, 40 or 50 %, three pairs of each, 27 in all. Press the string, compare, answer. The reference is T = 30 N, E = 190 GPa, R = 0.34 mm.'),
      row(make('label', { class: 'note' }, 'Order ', seed), begin),
      make('p', { class: 'note' }, this.#session.controls ? '' : 'Take control first.')];
  }

  #trial() {
    const answered = this.#answers.length;
    const half = (n, text) => button(text, () => this.#present(n), { 'aria-pressed': String(this.#half === n), 'data-half': n });
    const answer = (value, text) => button(text, () => this.#answer(value), { 'data-answer': value });
    return [make('h2', {}, `Trial ${answered + 1} of ${this.#plan.length}`),
      make('progress', { max: this.#plan.length, value: answered, style: 'width:100%' }),
      make('p', { class: 'note' }, 'Feel both as often as you like:'), row(half(0, 'First string'), half(1, 'Second string')),
      make('p', { class: 'note' }, 'Which was stiffer?'), row(answer('first', 'The first'), answer('same', 'No difference'), answer('second', 'The second')),
      row(button('End', () => this.#end(), { class: 'stop' }))];
  }

  #results() {
    const table = tally(this.#plan, this.#answers);
    const rate = ({ asked, correct }) => (asked ? `${((100 * correct) / asked).toFixed(0)} %` : '–');
    const rows = PARAMETERS.map((name) => make('tr', {}, make('td', {}, name),
      ...INCREMENTS.map((_, i) => make('td', {}, `${rate(table[name][i])} (${PUBLISHED[name][i]})`))));
    const head = make('tr', {}, make('th', {}, ''), ...INCREMENTS.map((increment) => make('th', {}, `+${increment * 100} %`)));
    const parts = [make('h3', {}, 'Correct answers (published)'), make('table', { id: 'experiment-table' }, head, ...rows)];
    if (this.#answers.length) parts.push(row(make('a', { href: this.#csv(), download: `table1_${this.#seed}.csv` }, 'Answers as CSV')));
    return parts;
  }

  #csv() {
    return `data:text/csv,${encodeURIComponent(resultCsv(this.#seed, this.#plan, this.#answers))}`;
  }
}
