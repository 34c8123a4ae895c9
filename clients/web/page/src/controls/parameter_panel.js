// Live parameters: one group at a time (a string, a tool, the scene), each with a slider and a number; a search over all of them.
import { fill, group, make, row } from './dom.js';
import { parameterRows, shortNumber, sliderScale } from './parameter_paths.js';
import { isOk } from './session.js';

const MOST_ROWS = 40;

export class ParameterPanel {
  #session;
  #rows = [];

  constructor(session) {
    this.#session = session;
    this.groups = make('select', { id: 'parameter-group', class: 'grow', 'aria-label': 'Parameters of', onchange: () => this.#draw() });
    this.search = make('input', { type: 'search', id: 'parameter-search', placeholder: 'search', 'aria-label': 'Search parameters', oninput: () => this.#draw() });
    this.search.style.width = '8em';
    this.list = make('div', { id: 'parameters' });
    this.element = group('Parameters', row(this.groups, this.search), this.list);
  }

  /** Values in force, from the daemon. */
  async load() {
    const result = await this.#session.ask({ get_parameters: {} }, { quiet: true });
    const scene = this.#session.scene;
    this.#rows = isOk(result) && result.parameters && scene ? parameterRows(scene.parameters, result.parameters.values, scene) : [];
    const names = [...new Set(this.#rows.map((parameter) => parameter.group))];
    fill(this.groups, names.map((name) => [name, name]), names.includes(this.groups.value) ? this.groups.value : names.find((name) => name.startsWith('string')) ?? names[0]);
    this.#draw();
  }

  #draw() {
    const words = this.search.value.toLowerCase();
    const shown = words ? this.#rows.filter((parameter) => parameter.path.includes(words) || `${parameter.group} ${parameter.label}`.toLowerCase().includes(words))
      : this.#rows.filter((parameter) => parameter.group === this.groups.value);
    const rows = shown.slice(0, MOST_ROWS).map((parameter) => this.#row(parameter, Boolean(words)));
    this.list.replaceChildren(...(rows.length ? rows : [make('p', { class: 'note' }, 'none')]));
  }

  #row(parameter, withGroup) {
    const scale = sliderScale(parameter);
    const label = `${withGroup ? `${parameter.group} ` : ''}${parameter.label}${parameter.unit ? `, ${parameter.unit}` : ''}`;
    const disabled = !this.#session.controls;
    const number = make('input', { type: 'number', step: 'any', value: shortNumber(parameter.value), disabled, 'aria-label': label, 'data-lease': '', 'data-path': parameter.path });
    const slider = make('input', { type: 'range', min: 0, max: 1, step: 0.001, value: scale.toSlider(parameter.value), disabled, 'aria-label': label, 'data-lease': '' });
    slider.oninput = () => { number.value = shortNumber(scale.toValue(Number(slider.value))); };
    slider.onchange = () => this.#set(parameter, Number(number.value), number, slider, scale);
    number.onchange = () => this.#set(parameter, Number(number.value), number, slider, scale);
    return make('div', { class: 'parameter' }, make('span', { title: parameter.path }, label), number, slider);
  }

  async #set(parameter, value, number, slider, scale) {
    const result = await this.#session.ask({ set_parameter: { assignments: [{ path: parameter.path, number: value }] } });
    if (isOk(result)) parameter.value = value;
    number.value = shortNumber(parameter.value); // a refused one goes back to what is in force
    slider.value = scale.toSlider(parameter.value);
  }
}
