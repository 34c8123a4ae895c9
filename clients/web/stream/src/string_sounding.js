// What a string sounds like at an instant, by the events StringSounding and by the States that repeat them for who came later: the newest
// message by its number, carried on as it says until the next. From it the band that the string swings in, over the part that sounds.
const GLIDE_S = 0.1; // a pitch glides on for so long after it was told
const KEEP = 16; // messages of a string, since an instant is shown a little after it was told

/** Whether number `a` comes after `b`; they count through 32 bits. */
const isAfter = (a, b) => ((a - b) | 0) > 0;

export class StringSoundings {
  #told = new Map(); // string index -> its messages, by number

  clear() {
    this.#told.clear();
  }

  /** Takes a StringSounding, from an event or a State; one that is there already changes nothing. */
  add(sounding) {
    const told = this.#told.get(sounding.string_index) ?? [];
    if (told.some((each) => each.number === sounding.number)) return;
    told.push(sounding);
    told.sort((a, b) => (isAfter(a.number, b.number) ? 1 : -1));
    this.#told.set(sounding.string_index, told.slice(-KEEP));
  }

  /** Takes what a State repeats. */
  addState(state) {
    for (const string of state.strings) if (string.sounding) this.add(string.sounding);
  }

  /** The newest message about string `index` that was true by `ns`; null where there is none. */
  at(index, ns) {
    return this.#told.get(index)?.findLast((sounding) => sounding.t_ns <= ns) ?? null;
  }
}

/** Pitch, Hz, and amplitude of each partial, m, at `ns`, if nobody has told anything since: {frequencyHz, partialsM}. */
export function soundingAt(sounding, ns) {
  const sinceS = Math.max(0, (ns - sounding.t_ns) * 1e-9);
  const cents = sounding.cents_per_s * Math.min(sinceS, GLIDE_S);
  return {
    frequencyHz: sounding.frequency_hz * 2 ** (cents / 1200),
    partialsM: sounding.partials_m.map((partial, k) => partial * Math.exp(-sinceS / sounding.decays_s[k])),
  };
}

/**
 * How far the partials reach together at `s` in [0, 1] of the part that sounds, m: the sum of |A_n sin(n pi s)|, since partials whose pitches are
 * not quite harmonic are all at their turning points at one time or another.
 */
export function swingAt(partialsM, s) {
  return partialsM.reduce((sum, partial, k) => sum + Math.abs(partial * Math.sin((k + 1) * Math.PI * s)), 0);
}
