// A ring that fills while the press stands, with the load in it.

import { byId, write } from "../dom.js";
import { loadText } from "./numbers.js";
import { PRESSING } from "./words.js";

export class Ring {
  constructor() {
    const circle = document.getElementById("ring-left");
    if (!(circle instanceof SVGElement)) throw new Error("the page has no #ring-left");
    this.circle = circle;
    this.element = byId("ring");
  }

  /** @param {Wire.CalibrationSession} session */
  show({ phase, asked, seen, presses }) {
    this.element.hidden = !PRESSING.includes(phase);
    const last = presses.at(-1)?.asked;
    // What was taken is what the ring tells of until it is off, whatever is asked for next.
    const shown = phase === "off" ? last ?? asked : asked ?? last;
    write("ring-load", shown ? loadText(shown.load_g) : "");
    const share = phase === "off" ? 1 : Math.min(1, Math.max(0, seen?.standing ?? 0));
    this.element.setAttribute("aria-valuenow", String(Math.round(100 * share)));
    this.circle.style.strokeDasharray = `${share} 2`;
  }
}
