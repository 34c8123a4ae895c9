// Switches of the picture: camera, what is drawn, stereo, magnification; and the card with the nearest string. Buttons and keys do the same.
import { STEREO_MODES } from './drawing/stereo.js';

const MOST = 50;
const CARD_M = 0.15; // farther from every string none is the nearest one meant

/** Slider 0..1 -> 1..50, even by factor. */
export const magnification = (slider) => Number((MOST ** Number(slider)).toPrecision(2));

export class ViewControls {
  #form = document.getElementById('looks');
  #card = document.getElementById('nearest');

  constructor(picture, address) {
    this.picture = picture;
    const { magnify, stereo } = this.#form.elements;
    magnify.value = Math.log(address.magnify) / Math.log(MOST);
    stereo.value = STEREO_MODES.includes(address.stereo) ? address.stereo : 'off';
    this.#form.oninput = () => this.#apply();
    document.querySelectorAll('[data-view]').forEach((button) => { button.onclick = () => this.look(button.dataset.view); });
    this.#apply();
  }

  /** Another picture, which is to look as the switches stand. */
  use(picture) {
    this.picture = picture;
    this.#apply();
  }

  #apply() {
    const { contacts, forces, depth, names, magnify, stereo } = this.#form.elements;
    Object.assign(this.picture.options, { contacts: contacts.checked, forces: forces.checked, depth: depth.checked, names: names.checked,
      magnify: magnification(magnify.value) });
    this.#form.querySelector('output').textContent = `${this.picture.options.magnify}×`;
    this.picture.setStereo(stereo.value);
  }

  look(name) {
    this.picture.following = name === 'close';
    this.picture.look(name);
  }

  toggle(name) {
    const box = this.#form.elements[name];
    box.checked = !box.checked;
    this.#apply();
  }

  magnifyNext() {
    const { magnify } = this.#form.elements;
    magnify.value = Number(magnify.value) > 0.01 ? 0 : Math.log(10) / Math.log(MOST);
    this.#apply();
  }

  stereoNext() {
    const { stereo } = this.#form.elements;
    stereo.value = STEREO_MODES[(STEREO_MODES.indexOf(stereo.value) + 1) % STEREO_MODES.length];
    this.#apply();
  }

  /** Keys of the picture, for controls/keyboard. */
  keys() {
    return {
      1: () => this.look('player'), 2: () => this.look('top'), 3: () => this.look('close'),
      f: () => { this.picture.following = !this.picture.following; },
      c: () => this.toggle('contacts'), v: () => this.toggle('forces'), d: () => this.toggle('depth'), n: () => this.toggle('names'),
      m: () => this.magnifyNext(), s: () => this.stereoNext(),
    };
  }

  /** A few times a second: which preset stands, and the nearest string. */
  show() {
    document.querySelectorAll('[data-view]').forEach((button) => button.classList.toggle('chosen', button.dataset.view === this.picture.viewName));
    const near = (this.picture.view?.nearest ?? []).filter((found) => found.distanceM < CARD_M);
    this.#card.hidden = near.length === 0;
    if (near.length) this.#card.innerHTML = near.map((found) => nearestRow(found, near.length > 1)).join('');
  }
}

/** Distances as people read them: 12.3 mm, 0.42 mm, touching. */
export function distanceText(metres) {
  if (metres < 5e-5) return 'touching';
  const mm = metres * 1e3;
  return `${mm < 1 ? mm.toFixed(2) : mm.toFixed(1)} mm`;
}

function nearestRow({ name, distanceM, toolId }, several) {
  const text = distanceText(distanceM);
  const escaped = name.replace(/[<>&"]/g, '');
  return `<div class="${text === 'touching' ? 'touching' : ''}" data-tool="${toolId}" data-distance-m="${distanceM}">${several ? `tool ${toolId}: ` : ''}
    <b>${escaped}</b> ${text}</div>${several ? '' : `<meter min="0" max="0.05" value="${Math.max(0, 0.05 - distanceM)}"></meter>`}`;
}
