// The one button of a guided task's phase. It stands in the same place in every phase, and does something else in each:
// what was meant for the phase before must not reach it.

import { buttonById, byId, write } from "./dom.js";

/** A second press of a key so soon after a step was none on purpose, ms. */
const ONE_PRESS_MS = 300;

export class PrimaryButton {
  /**
   * @param {(action: string) => void} act
   * @param {number} readMs so long after it became another one it does nothing: nobody has read yet what it would do
   */
  constructor(act, readMs = 0) {
    this.element = buttonById("primary");
    this.readMs = readMs;
    this.key = "";
    /** When it became another one, and when the last step was sent, by the page's clock, ms. */
    this.changedAt = -Infinity;
    this.sentAt = -Infinity;
    this.isWaiting = false;
    this.element.addEventListener("click", (event) => this.refuse(event));
    byId("task").addEventListener("submit", (event) => {
      event.preventDefault();
      if (!this.isWaiting) act(this.element.dataset.action ?? "");
    });
    // A key that is held presses again and again: the next phase has another button in the same place.
    byId("task").addEventListener("keydown", (event) => {
      if (event.repeat && (event.key === "Enter" || event.key === " ")) event.preventDefault();
    });
  }

  get isHidden() {
    return this.element.hidden;
  }

  /** @param {MouseEvent} event */
  refuse(event) {
    const isDouble = event.detail > 1 || (event.detail === 0 && event.timeStamp - this.sentAt < ONE_PRESS_MS);
    const isUnread = event.timeStamp - this.changedAt < this.readMs;
    if (isDouble || isUnread || this.isWaiting) event.preventDefault();
  }

  /** @param {boolean} isWaiting for the server's answer */
  wait(isWaiting) {
    this.isWaiting = isWaiting;
    if (isWaiting) this.sentAt = performance.now();
    this.element.setAttribute("aria-disabled", String(isWaiting));
  }

  /** @param {{ action: string, label: string } | null} button */
  show(button) {
    const key = button ? `${button.action} ${button.label}` : "";
    if (key !== this.key) this.changedAt = performance.now();
    this.key = key;
    this.element.hidden = button === null;
    if (!button) return;
    this.element.dataset.action = button.action;
    write(this.element, button.label);
  }
}
