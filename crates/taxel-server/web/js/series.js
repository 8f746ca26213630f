// Numbers over time, one row a frame. The columns stay contiguous, so that a chart can take a
// subarray: they are twice as long as needed, and move back to the start when the end is reached.

const CAPACITY = 24000;

/** @template {string} N */
export class Series {
  /** @param {N[]} names */
  constructor(names) {
    this.names = names;
    const columns = ["time", ...names].map((name) => [name, new Float64Array(2 * CAPACITY)]);
    this.columns = /** @type {Record<N | "time", Float64Array>} */ (Object.fromEntries(columns));
    this.start = 0;
    this.end = 0;
  }

  get length() {
    return this.end - this.start;
  }

  get lastTime() {
    return this.end > this.start ? this.columns.time[this.end - 1] : NaN;
  }

  clear() {
    this.start = 0;
    this.end = 0;
  }

  /**
   * @param {number} time
   * @param {Record<N, number>} values
   */
  push(time, values) {
    if (this.end === 2 * CAPACITY) {
      for (const column of /** @type {Float64Array[]} */ (Object.values(this.columns))) column.copyWithin(0, CAPACITY);
      this.start = 0;
      this.end = CAPACITY;
    }
    this.columns.time[this.end] = time;
    for (let i = 0; i < this.names.length; i += 1) this.columns[this.names[i]][this.end] = values[this.names[i]];
    this.end += 1;
    if (this.end - this.start > CAPACITY) this.start += 1;
  }

  /**
   * The index of the first row at or after this time.
   * @param {number} time
   */
  indexFrom(time) {
    const times = this.columns.time;
    let low = this.start;
    let high = this.end;
    while (low < high) {
      const middle = (low + high) >> 1;
      if (times[middle] < time) low = middle + 1;
      else high = middle;
    }
    return low;
  }
}
