// A ring that empties, with the seconds in it: for those who do not hear the beeps.

import { byId, write } from "../dom.js";
import { clock, countOf } from "./numbers.js";

const still = matchMedia("(prefers-reduced-motion: reduce)");

export class Ring {
  constructor() {
    const circle = document.getElementById("ring-left");
    if (!(circle instanceof SVGElement)) throw new Error("the page has no #ring-left");
    this.circle = circle;
    this.share = NaN;
  }

  /**
   * @param {import("./deadline.js").Deadline} deadline
   * @param {number} now ms
   */
  draw(deadline, now) {
    const remaining = deadline.remaining(now);
    byId("ring").hidden = !Number.isFinite(remaining);
    if (!Number.isFinite(remaining)) return;
    const count = countOf(remaining);
    write("ring-count", clock(count));
    byId("ring-count").classList.toggle("long", count >= 60);
    // Where nothing is to move, the ring takes a step with each second.
    const share = still.matches ? Math.min(1, count / deadline.lasts) : deadline.share(now);
    if (Math.abs(share - this.share) < 5e-4) return;
    this.share = share;
    this.circle.style.strokeDasharray = `${share} 2`;
  }
}
