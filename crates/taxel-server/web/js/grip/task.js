// The task of the phase: what to do, the one button for it, and what the last trial came to.

import { byId, inputById, made, write } from "../dom.js";
import { PrimaryButton } from "../primary.js";
import { pair } from "../sidepanel.js";
import { capital } from "../text.js";
import { fixed } from "../units.js";
import { bothForces, wrongWithPerson } from "./numbers.js";
import { wordsOf } from "./words.js";

/** @type {Wire.GripPhase[]} */
const WITH_FORCE = ["zero", "ready", "countdown", "hold"];
/** @type {Wire.GripPhase[]} */
const WITH_WAITING = ["measuring", "finishing"];

export class Task {
  /** @param {(action: string) => void} act */
  constructor(act) {
    this.act = act;
    this.primary = new PrimaryButton(act);
    for (const id of ["repeat", "zero-again", "zero-anyway"]) {
      byId(id).addEventListener("click", () => act(byId(id).dataset.action ?? ""));
    }
    inputById("person").addEventListener("input", () => this.showWrong(""));
  }

  /** @param {Wire.GripSession} grip */
  show(grip) {
    const { phase, protocol } = grip;
    const { title, text, primary } = wordsOf(grip);
    write("phase-title", title);
    write("phase-text", text);
    write("posture", protocol.posture);
    byId("posture").hidden = protocol.posture === "" || !["ready", "countdown"].includes(phase);
    byId("fields").hidden = phase !== "setup";
    byId("force").hidden = !WITH_FORCE.includes(phase);
    byId("waiting").hidden = !WITH_WAITING.includes(phase);
    byId("finish").hidden = ["setup", "finishing", "done"].includes(phase);
    byId("repeat").hidden = phase !== "review";
    byId("zero-again").hidden = phase !== "ready";
    this.primary.show(primary);
    this.primary.element.classList.toggle("calm", primary?.action === "cancel" || primary?.action === "skip-rest");
    write("key-hint", primary?.action === "cancel" ? "or Esc" : "");
    this.showFigures(grip);
  }

  /** @param {Wire.GripSession} grip */
  showFigures({ phase, measured }) {
    byId("figures").hidden = phase !== "review" || !measured;
    if (!measured) return;
    /** @param {number | null} value @param {string} unit */
    const one = (value, unit) => (value === null ? "–" : `${fixed(value, 1)} ${unit}`);
    /** @type {[string, string][]} */
    const figures = [
      ["Largest force", bothForces(measured.max_newtons)],
      ["Plateau, mean", measured.plateau_newtons === null ? "none found" : bothForces(measured.plateau_newtons)],
      ["Variation (CV)", one(measured.variation_percent, "%")],
      ["Time to peak", one(measured.time_to_peak_secs, "s")],
      ["Total normal force", `${fixed(measured.total_newtons, 0)} N`],
    ];
    byId("figures-list").replaceChildren(...figures.map(([name, value]) => pair(name, value, "num")));
    byId("doubts").replaceChildren(...measured.doubts.map((text) => made("li", capital(text))));
  }

  get focusTarget() {
    if (!byId("fields").hidden) return inputById("person");
    if (!this.primary.isHidden) return this.primary.element;
    const link = byId("files").querySelector("a");
    return link && !byId("results").hidden ? link : byId("phase-title");
  }

  /** The button of the phase has the focus, so that Enter and Space press it; not while somebody types or answers. */
  takeFocus() {
    const { activeElement } = document;
    if (document.querySelector("dialog[open]")) return;
    const isTyping = activeElement instanceof HTMLInputElement && activeElement.checkVisibility();
    if (isTyping) return;
    this.focusTarget.focus({ preventScroll: true });
    if (byId("task").getBoundingClientRect().top < 0) window.scrollTo(0, 0);
  }

  /**
   * Why something did not work.
   * @param {string} text
   * @param {boolean} offerAnyway
   */
  say(text, offerAnyway = false) {
    write("message", text);
    byId("zero-anyway").hidden = !offerAnyway;
  }

  /** @param {string} text */
  showWrong(text) {
    write("person-error", text);
    const input = inputById("person");
    if (text) input.setAttribute("aria-invalid", "true");
    else input.removeAttribute("aria-invalid");
  }

  /** Who begins; null where the id is not as it must be, which is then said. */
  person() {
    const input = inputById("person");
    const person = input.value.trim();
    const wrong = wrongWithPerson(person);
    this.showWrong(wrong);
    if (wrong) {
      input.focus();
      return null;
    }
    return { person, note: inputById("note").value.trim() };
  }
}
