// What else than the one button is to be done with a press: another one, another load, the last one back.

import { buttonById, byId, onClick, selectById } from "../dom.js";
import { loadText } from "./numbers.js";
import { PRESSING, counting, taxelOf } from "./words.js";

export class Controls {
  /** @param {(step: Wire.CalibrationStep) => void} act */
  constructor(act) {
    this.act = act;
    this.load = selectById("load");
    this.asked = "";
    this.loads = "";
    for (const [id, is] of /** @type {["skip" | "undo", "skip" | "undo"][]} */ ([["skip", "skip"], ["undo", "undo"]])) {
      byId(id).addEventListener("click", (event) => {
        // The second click of a double one was meant for the press that is gone.
        if (event.detail < 2 && buttonById(id).getAttribute("aria-disabled") !== "true") act({ is });
      });
    }
    this.load.addEventListener("change", () => act({ is: "load", load_g: Number(this.load.value) }));
  }

  /** @param {Wire.CalibrationSession} session */
  show(session) {
    const { phase, asked, presses } = session;
    const isPressing = PRESSING.includes(phase) || phase === "others";
    const canChoose = ["press", "elsewhere", "others"].includes(phase);
    byId("skip").hidden = !isPressing;
    byId("undo").hidden = !isPressing;
    // One that has the focus keeps it while it has nothing to do for a moment.
    able("skip", canChoose && asked !== null);
    able("undo", counting(presses) > 0 && phase !== "taking");
    byId("load-field").hidden = !isPressing || session.loads_g.length < 2 || (asked !== null && taxelOf(asked) === null);
    this.load.disabled = !canChoose || asked === null;
    this.showLoads(session);
  }

  /** @param {Wire.CalibrationSession} session */
  showLoads({ loads_g, asked }) {
    const loads = loads_g.join();
    if (loads !== this.loads) {
      this.loads = loads;
      this.load.replaceChildren(...loads_g.map((grams) => new Option(loadText(grams), String(grams))));
    }
    // Whoever walks through the loads with the arrow keys is ahead of what the server says.
    const key = JSON.stringify(asked);
    if (key === this.asked) return;
    this.asked = key;
    this.showAsked(asked);
  }

  /** @param {Wire.AskedPress | null} asked */
  showAsked(asked) {
    if (asked) this.load.value = String(asked.load_g);
  }
}

/**
 * @param {string} id
 * @param {boolean} isAble
 */
function able(id, isAble) {
  byId(id).setAttribute("aria-disabled", String(!isAble));
}
