// The task of the phase: what to do, the buttons for it, and whether it is enough by now.

import { byId, made, write } from "../dom.js";
import { showFiles } from "../filelinks.js";
import { PrimaryButton } from "../primary.js";
import { Controls } from "./controls.js";
import { errorText, lastError } from "./numbers.js";
import { Ring } from "./ring.js";
import { canFinish, filesOf, sentence, verdictText, wordsOf } from "./words.js";

/** Phases come by themselves here, while somebody aims at a button, ms. */
const READ_MS = 400;
/** What was taken off is seen by itself, within some seconds. Where it is not, somebody can say so. */
const OFF_MS = 6000;
/** @type {import("./words.js").Button} */
const IS_OFF = { action: "ready", label: "It is off" };

export class Task {
  /**
   * @param {(step: Wire.CalibrationStep) => void} act
   * @param {() => string} token
   */
  constructor(act, token) {
    this.token = token;
    this.primary = new PrimaryButton((action) => {
      if (action === "ready" || action === "here") act({ is: action });
    }, READ_MS);
    this.controls = new Controls(act);
    this.ring = new Ring();
    this.files = "";
    this.offSince = Infinity;
  }

  /** @param {Wire.CalibrationSession} session */
  show(session) {
    const { phase, is_enough } = session;
    const { title, text, more, primary } = wordsOf(session);
    write("phase-title", title);
    write("phase-text", text);
    write("phase-more", more);
    byId("phase-more").hidden = more === "";
    byId("waiting").hidden = phase !== "reading" && phase !== "finishing";
    this.offSince = phase === "off" ? Math.min(this.offSince, performance.now()) : Infinity;
    const isLong = performance.now() - this.offSince > OFF_MS;
    this.primary.show(isLong ? IS_OFF : primary);
    this.primary.element.classList.toggle("calm", isLong);
    this.controls.show(session);
    this.ring.show(session);
    byId("verdict").hidden = ["finishing", "done"].includes(phase);
    byId("verdict").classList.toggle("enough", is_enough && canFinish(session));
    write("verdict-text", verdictText(session));
    byId("finish").hidden = !canFinish(session);
    byId("finish").classList.toggle("primary", is_enough);
    write("finish", is_enough ? "Finish" : "Finish…");
    this.showResults(session);
  }

  /** @param {Wire.CalibrationSession} session */
  showResults({ phase, files, progress, doubts }) {
    byId("results").hidden = phase !== "done";
    byId("doubts-box").hidden = doubts.length === 0;
    const last = lastError(progress);
    write("final-error", last ? errorText(last) : "not known");
    const key = JSON.stringify([files, doubts]);
    if (phase !== "done" || key === this.files) return;
    this.files = key;
    byId("doubts").replaceChildren(...doubts.map((text) => made("li", sentence(text))));
    showFiles(filesOf(files), this.token());
  }

  get focusTarget() {
    if (!this.primary.isHidden) return this.primary.element;
    const link = byId("files").querySelector("a");
    return link && !byId("results").hidden ? link : byId("phase-title");
  }

  /**
   * The button of the phase has the focus, so that Enter and Space press it. Phases come by themselves: whoever is at
   * another button keeps it.
   */
  takeFocus() {
    const { activeElement } = document;
    if (document.querySelector("dialog[open]")) return;
    const isFree = !activeElement || activeElement === document.body || [byId("phase-title"), this.primary.element].some((one) => one === activeElement);
    if (!isFree && activeElement.checkVisibility()) return;
    this.focusTarget.focus({ preventScroll: true });
    if (byId("task").getBoundingClientRect().top < 0) window.scrollTo(0, 0);
  }

  /** @param {string} text why something did not work */
  say(text) {
    write("message", text);
  }
}
