// The upper end of the common colour scale, in the unit the loads arrive in. It moves between round
// numbers only, so that the ticks of the colour bar stand still.

import { niceCeil } from "./units.js";

const RISE_SECONDS = 0.15;
const FALL_SECONDS = 4;
// The scale shrinks only when the loads have fallen well below it, or it would flicker between two steps.
const SHRINK_BELOW = 0.6;
// Without a load the scale must not blow up the noise.
const MIN_SHARE_OF_PEAK = 0.02;

export class Scale {
  followed = 0;
  peak = 0;
  lastTime = NaN;
  top = 1;

  reset() {
    this.followed = 0;
    this.peak = 0;
    this.lastTime = NaN;
    this.top = 1;
  }

  restartPeak() {
    this.peak = this.followed;
  }

  /** @param {number} highest */
  makeRoom(highest) {
    if (highest > this.top) this.top = niceCeil(highest);
  }

  /**
   * @param {number} highest the highest load shown
   * @param {number} time seconds
   * @param {import("./settings.js").ScaleMode} mode
   * @param {number} fixed the user's upper end
   */
  update(highest, time, mode, fixed) {
    const seconds = time >= this.lastTime ? Math.min(time - this.lastTime, 1) : NaN;
    this.lastTime = time;
    if (highest >= 0) {
      const lag = highest > this.followed ? RISE_SECONDS : FALL_SECONDS;
      // The first frame, and one after a jump in time, sets the level at once.
      const share = seconds >= 0 ? 1 - Math.exp(-seconds / lag) : 1;
      this.followed += (highest - this.followed) * share;
      this.peak = Math.max(this.peak, highest);
    }
    if (mode === "fixed") {
      this.top = fixed;
      return;
    }
    const wanted = mode === "hold" ? this.peak : Math.max(this.followed, MIN_SHARE_OF_PEAK * this.peak);
    if (!(wanted > 0)) return;
    const fits = wanted <= this.top * 1.0001 && wanted > SHRINK_BELOW * this.top;
    if (!fits) this.top = niceCeil(wanted * (mode === "hold" ? 1 : 1.05));
  }
}
