// What plots are drawn from: the last seconds of several numbers over time, and a histogram of the times of ticks. Rings of fixed size.

export class TimeSeries {
  #times;
  #columns;
  #next = 0;
  #count = 0;

  constructor(columns, capacity) {
    this.#times = new Float64Array(capacity);
    this.#columns = Array.from({ length: columns }, () => new Float64Array(capacity));
  }

  clear() {
    this.#next = this.#count = 0;
  }

  /** Appends one row; a step back in time begins anew. */
  add(timeS, values) {
    if (this.#count > 0 && timeS < this.newestS) this.clear();
    this.#times[this.#next] = timeS;
    this.#columns.forEach((column, i) => { column[this.#next] = values[i]; });
    this.#next = (this.#next + 1) % this.#times.length;
    this.#count = Math.min(this.#count + 1, this.#times.length);
  }

  get newestS() {
    return this.#count ? this.#times[(this.#next + this.#times.length - 1) % this.#times.length] : 0;
  }

  /** [times relative to the newest, column, column, ...] of the last `seconds`, oldest first, as uPlot takes them. */
  window(seconds) {
    const capacity = this.#times.length;
    const newest = this.newestS;
    const rows = [];
    for (let i = 0; i < this.#count; ++i) {
      const at = (this.#next + capacity - this.#count + i) % capacity;
      if (this.#times[at] >= newest - seconds) rows.push(at);
    }
    return [rows.map((at) => this.#times[at] - newest), ...this.#columns.map((column) => rows.map((at) => column[at]))];
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
