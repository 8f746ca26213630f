// Values with names, and listeners that hear when some of them change: what the parts of the page have in common.

/**
 * @template {object} T
 */
export class Store {
  /** @type {T} */
  #values;
  /** @type {{ names: ReadonlySet<keyof T>, tell: () => void }[]} */
  #listeners = [];
  /** @type {Set<keyof T>} */
  #changed = new Set();
  #isTelling = false;

  /** @param {T} values */
  constructor(values) {
    this.#values = { ...values };
  }

  /** @returns {Readonly<T>} */
  get now() {
    return this.#values;
  }

  /**
   * Writes some values. Listeners hear of it when all of them are written, each once, and only if one of theirs is
   * another value than before. What a listener writes is told after what it was told itself.
   * @param {Partial<T>} values
   */
  set(values) {
    for (const name of /** @type {(keyof T)[]} */ (Object.keys(values))) {
      const value = /** @type {T[keyof T]} */ (values[name]);
      if (Object.is(this.#values[name], value)) continue;
      this.#values[name] = value;
      this.#changed.add(name);
    }
    this.#tell();
  }

  /**
   * Tells of values that are the same objects as before, with other content.
   * @param {...keyof T} names
   */
  touch(...names) {
    for (const name of names) this.#changed.add(name);
    this.#tell();
  }

  /**
   * @param {(keyof T)[]} names
   * @param {() => void} tell
   * @returns {() => void} ends it
   */
  on(names, tell) {
    const listener = { names: new Set(names), tell };
    this.#listeners.push(listener);
    return () => {
      this.#listeners = this.#listeners.filter((one) => one !== listener);
    };
  }

  #tell() {
    if (this.#isTelling) return;
    this.#isTelling = true;
    try {
      while (this.#changed.size > 0) {
        const changed = this.#changed;
        this.#changed = new Set();
        for (const { names, tell } of [...this.#listeners]) {
          if ([...changed].some((name) => names.has(name))) tell();
        }
      }
    } finally {
      // One that failed must not silence the others for good.
      this.#isTelling = false;
    }
  }
}
