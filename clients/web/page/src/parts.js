// The parts of the page, each by itself: what one of them throws, when it is made or later, is reported and stops none of the others.

export class Parts {
  #failed = new Map(); // what each part threw last

  /** `tell(name, error)` hears of a failure, and not again while the same one repeats. */
  constructor(tell) {
    this.tell = tell;
  }

  /** What `work` gives, or `otherwise` where it throws. */
  run(name, work, otherwise) {
    try {
      return work();
    } catch (error) {
      this.#fail(name, error);
      return otherwise;
    }
  }

  /** As run(), where `work` gives a promise. */
  async load(name, work, otherwise) {
    try {
      return await work();
    } catch (error) {
      this.#fail(name, error);
      return otherwise;
    }
  }

  #fail(name, error) {
    const text = `${error?.stack ?? error}`;
    if (this.#failed.get(name) === text) return;
    this.#failed.set(name, text);
    console.error(`${name}: ${text}`);
    try {
      this.tell(name, error);
    } catch (worse) {
      console.error(worse);
    }
  }
}
