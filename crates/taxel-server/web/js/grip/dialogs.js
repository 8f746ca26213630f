// A question: why a trial is repeated.

import { byId, dialogById, inputById, made, onClick, openDialog, write } from "../dom.js";
import { capital } from "../text.js";
import { REASONS } from "./words.js";

const OTHER = "other";

export class RepeatDialog {
  /** @param {(reason: string) => void} repeat */
  constructor(repeat) {
    this.dialog = dialogById("repeat-reasons");
    this.repeat = repeat;
    byId("reasons").replaceChildren(...REASONS.map((reason) => choice(reason, capital(reason))), choice(OTHER, "Other:"));
    byId("reasons").addEventListener("change", () => this.showOther(true));
    onClick("repeat-cancel", () => this.dialog.close());
    byId("repeat-form").addEventListener("submit", (event) => {
      event.preventDefault();
      this.send();
    });
  }

  get chosen() {
    const input = this.dialog.querySelector("input[name=reason]:checked");
    return input instanceof HTMLInputElement ? input.value : "";
  }

  open() {
    for (const input of this.dialog.querySelectorAll("input")) {
      if (input.type === "radio") input.checked = false;
      else input.value = "";
    }
    write("reason-error", "");
    this.showOther(false);
    openDialog(this.dialog);
  }

  close() {
    if (this.dialog.open) this.dialog.close();
  }

  /** @param {boolean} focus */
  showOther(focus) {
    const text = inputById("reason-text");
    text.hidden = this.chosen !== OTHER;
    write("reason-error", "");
    // Whoever walks through the choices with the arrow keys must be able to walk on: only the pointer moves to the text.
    if (focus && !text.hidden && !document.activeElement?.matches(":focus-visible")) text.focus();
  }

  send() {
    const { chosen } = this;
    const text = inputById("reason-text").value.trim();
    if (chosen === "" || (chosen === OTHER && text === "")) {
      write("reason-error", chosen === "" ? "Choose a reason." : "Say which reason it is.");
      (chosen === "" ? this.dialog.querySelector("input") : inputById("reason-text"))?.focus();
      return;
    }
    this.dialog.close();
    this.repeat(chosen === OTHER ? text : chosen);
  }
}

/**
 * @param {string} value
 * @param {string} text
 */
function choice(value, text) {
  const label = document.createElement("label");
  const input = document.createElement("input");
  input.type = "radio";
  input.name = "reason";
  input.value = value;
  label.append(input, made("span", text));
  return label;
}
