// What plots are drawn from: the last seconds of several numbers over time, and a histogram of the times of ticks. Rings of fixed size.

const AROUND = 4; // steps on each side of a gap that show the stream's period there
const LOST_PERIODS = 1.5; // rows farther apart have lost one: instants of ticks, and the pace of a replay, vary by less

/**
 * Where a row is missing: for each of the rows at `places`, whether there is a hole before it. The period of the stream is not known, and it
 * changes: a daemon sends fewer States where the network loses them. So it is read off the neighbours: a step is a hole where it is longer
 * than those before it or than those after it. A lost State is; where the stream slows down, the steps after are as long, and it is none. A
 * place that goes back is another run.
 */
export function holesBefore(places) {
  const steps = places.map((place, i) => (i > 0 ? place - places[i - 1] : Infinity));
  const least = Math.min(...steps.filter((step) => step > 0));
  return steps.map((step, i) => {
    if (i === 0) return false;
    if (!(step > 0)) return step < 0;
    return step > LOST_PERIODS * least && step > LOST_PERIODS * periodAround(steps, i);
  });
}

/** The longer of the shortest steps before and after step `at`; where one side has none, the other's. */
function periodAround(steps, at) {
  const shortest = (from, to) => Math.min(...steps.slice(Math.max(from, 1), to).filter((step) => step > 0));
  const sides = [shortest(at - AROUND, at), shortest(at + 1, at + 1 + AROUND)].filter(Number.isFinite);
  return sides.length ? Math.max(...sides) : Infinity;
}

/**
 * Rows that a line does not show, since holes on both sides leave it less than `leastS` of time: they are dots. `times` and `values` as window()
 * gives them.
 */
export function loneRows(times, values, leastS) {
  const lone = [];
  for (let first = 0; first < values.length; ++first) {
    if (values[first] === null) continue;
    let last = first;
    while (last + 1 < values.length && values[last + 1] !== null) ++last;
    if (last === first || times[last] - times[first] < leastS) for (let i = first; i <= last; ++i) lone.push(i);
    first = last;
  }
  return lone;
}

/** By how much `values` have grown since the first of them; where there is none there is none. */
export function sinceFirst(values) {
  const first = values.find((value) => value !== null) ?? 0;
  return values.map((value) => (value === null ? null : value - first));
}

export class TimeSeries {
  #times;
  #places;
  #columns;
  #next = 0;
  #count = 0;

  constructor(columns, capacity) {
    this.#times = new Float64Array(capacity);
    this.#places = new Float64Array(capacity);
    this.#columns = Array.from({ length: columns }, () => new Float64Array(capacity));
  }

  clear() {
    this.#next = this.#count = 0;
  }

  /** Appends one row; a step back in time starts again. `place` tells missing rows: the number of its tick, exact where instants are not. */
  add(timeS, values, place = timeS) {
    if (this.#count > 0 && timeS < this.newestS) this.clear();
    this.#times[this.#next] = timeS;
    this.#places[this.#next] = place;
    this.#columns.forEach((column, i) => { column[this.#next] = values[i]; });
    this.#next = (this.#next + 1) % this.#times.length;
    this.#count = Math.min(this.#count + 1, this.#times.length);
  }

  get newestS() {
    return this.#count ? this.#times[(this.#next + this.#times.length - 1) % this.#times.length] : 0;
  }

  /**
   * [times relative to the newest, column, column, ...] of the last `seconds`, oldest first, as uPlot takes them. Where rows are missing there is
   * one of null in the middle: what was then is not known, and no line goes across. So is a value that is not a number.
   */
  window(seconds) {
    const capacity = this.#times.length;
    const newest = this.newestS;
    const rows = [];
    for (let i = 0; i < this.#count; ++i) {
      const at = (this.#next + capacity - this.#count + i) % capacity;
      if (this.#times[at] >= newest - seconds) rows.push(at);
    }
    const holes = holesBefore(rows.map((at) => this.#places[at]));
    const spread = (valueOf, holeOf) => rows.flatMap((at, i) => (holes[i] ? [holeOf(rows[i - 1], at), valueOf(at)] : [valueOf(at)]));
    const timeOf = (at) => this.#times[at] - newest;
    return [spread(timeOf, (before, after) => (timeOf(before) + timeOf(after)) / 2),
      ...this.#columns.map((column) => spread((at) => (Number.isFinite(column[at]) ? column[at] : null), () => null))];
  }
}

/** Counts of the last `capacity` values in bins that each are a quarter of an octave wide: ticks last from 1 us to 10 ms. */
export class LogHistogram {
  #recent;
  #seen = 0;

  constructor({ least, most, capacity }) {
    this.least = least;
    this.bins = Math.ceil(Math.log2(most / least) * 4);
    this.counts = new Array(this.bins).fill(0);
    this.#recent = new Int16Array(capacity);
  }

  clear() {
    this.counts.fill(0);
    this.#seen = 0;
  }

  /** Values since the beginning. */
  get seen() {
    return this.#seen;
  }

  binOf(value) {
    const bin = Math.floor(Math.log2(Math.max(value, this.least) / this.least) * 4);
    return Math.min(this.bins - 1, Math.max(0, bin));
  }

  /** Lower edge of a bin. */
  edge(bin) {
    return this.least * 2 ** (bin / 4);
  }

  add(value) {
    const place = this.#seen % this.#recent.length;
    if (this.#seen >= this.#recent.length) --this.counts[this.#recent[place]];
    this.#recent[place] = this.binOf(value);
    ++this.counts[this.#recent[place]];
    ++this.#seen;
  }
}
