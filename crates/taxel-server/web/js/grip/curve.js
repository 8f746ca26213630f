// Force against time of one hold, with the largest so far: what the chart draws.

/** Seconds without a frame over which no line is drawn. */
const GAP_SECS = 0.4;
/** By more than this the two clocks do not belong together: a file was wound on, or the device's time is wrong. */
const ASTRAY_SECS = 1;
/** As many points as a chart can show apart, many times over. */
export const MOST_POINTS = 12000;

export class Curve {
  /** @type {number[]} seconds since the hold began */
  times = [];
  /** @type {(number | null)[]} newtons; null: nothing is known */
  forces = [];
  /** @type {(number | null)[]} */
  largest = [];
  max = NaN;
  /** The host's clock at the beginning of the hold, s. */
  zero = NaN;

  get isEmpty() {
    return this.times.length === 0;
  }

  clear() {
    this.times.length = 0;
    this.forces.length = 0;
    this.largest.length = 0;
    this.max = NaN;
    this.zero = NaN;
  }

  /**
   * Frames arrive in bursts but carry the time at which they were taken: that of the first one is set against the page's
   * clock, and those of all others against the first.
   * @param {number} host s
   * @param {number} sinceBegun seconds by the page's clock
   */
  timeOf(host, sinceBegun) {
    const isAstray = !(Math.abs(host - this.zero - sinceBegun) <= ASTRAY_SECS);
    if (isAstray) this.zero = host - sinceBegun;
    return Number.isFinite(host) ? host - this.zero : sinceBegun;
  }

  /**
   * @param {number} time seconds since the hold began
   * @param {number} newtons NaN: unknown
   */
  push(time, newtons) {
    const { times } = this;
    const last = times.length > 0 ? times[times.length - 1] : time;
    // A chart's times must grow.
    if (time < last || time < 0) return;
    if (time - last > GAP_SECS) this.add((time + last) / 2, NaN);
    if (Number.isFinite(newtons)) this.max = this.max >= newtons ? this.max : newtons;
    this.add(time, newtons);
    if (times.length > MOST_POINTS) this.thin();
  }

  /**
   * @param {number} time
   * @param {number} newtons
   */
  add(time, newtons) {
    this.times.push(time);
    this.forces.push(Number.isFinite(newtons) ? newtons : null);
    this.largest.push(Number.isFinite(this.max) ? this.max : null);
  }

  /** Of each two points the one with the larger force stays: the largest force must not get lost. */
  thin() {
    const { times, forces, largest } = this;
    let to = 0;
    for (let i = 0; i + 1 < times.length; i += 2) {
      const keep = (forces[i + 1] ?? -Infinity) >= (forces[i] ?? -Infinity) ? i + 1 : i;
      times[to] = times[keep];
      forces[to] = forces[keep];
      largest[to] = largest[i + 1];
      to += 1;
    }
    for (const column of [times, forces, largest]) column.length = to;
  }
}
