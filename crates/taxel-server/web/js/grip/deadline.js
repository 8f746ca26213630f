// How long a phase still lasts, by the page's own clock: the server says it twice a second only, and each time a little late.

/** A deadline that moves by more than this was moved on purpose, s. */
const MOVED_SECS = 1;

export class Deadline {
  key = "";
  /** By the page's clock, ms; NaN: the operator ends the phase. */
  at = NaN;
  /** How long the phase lasts in all, s. */
  lasts = NaN;

  /**
   * What is said late says a deadline that is too late: the earliest holds, and the clock never jumps back.
   * @param {string} key which phase it is of
   * @param {number | null} remaining
   * @param {number | null} lasts
   * @param {number} now ms
   */
  take(key, remaining, lasts, now) {
    const said = remaining === null ? NaN : now + 1000 * remaining;
    const isSame = key === this.key && Math.abs(said - this.at) <= 1000 * MOVED_SECS;
    this.at = isSame ? Math.min(this.at, said) : said;
    this.lasts = lasts ?? remaining ?? NaN;
    this.key = key;
  }

  /**
   * Seconds; NaN where the operator ends the phase.
   * @param {number} now ms
   */
  remaining(now) {
    return Math.max(0, (this.at - now) / 1000);
  }

  /**
   * What is left of it, 0 to 1.
   * @param {number} now ms
   */
  share(now) {
    return Math.min(1, this.remaining(now) / this.lasts);
  }

  /** When the phase began, by the page's clock, ms. */
  get begun() {
    return this.at - 1000 * this.lasts;
  }
}
