// The panel beside a guided task: what is the same in each of them.

import { byId, made } from "./dom.js";
import { capital } from "./text.js";

export class SidePanel {
  constructor() {
    /** @type {Map<string, string>} what each part shows */
    this.shown = new Map();
  }

  /**
   * States come twice a second: what is the same is left alone, with the selection of whoever copies something.
   * @param {string} part
   * @param {unknown} what
   */
  isNew(part, what) {
    const key = JSON.stringify(what);
    if (this.shown.get(part) === key) return false;
    this.shown.set(part, key);
    return true;
  }

  /** @param {string[]} warnings */
  showWarnings(warnings) {
    if (!this.isNew("warnings", warnings)) return;
    byId("warnings-panel").hidden = warnings.length === 0;
    byId("warnings").replaceChildren(...warnings.map((text) => made("li", capital(text))));
  }

  /** @param {[string, string][]} facts names and what they are */
  showFacts(facts) {
    if (!this.isNew("facts", facts)) return;
    byId("facts").replaceChildren(...facts.map(([name, text]) => pair(name, text)));
  }
}

/**
 * A name and what it is, for a list of such.
 * @param {string} name
 * @param {string} text
 */
export function pair(name, text, className = "") {
  const both = document.createElement("div");
  both.append(made("dt", name), made("dd", text, className));
  return both;
}
