// The keyboard: one letter a command, as listed by "?". Letters, digits and signs can be turned off, for those whose voice
// or hand would press them unawares (WCAG 2.1.4).

/** @typedef {import("./settings.js").Layout} Layout */
/**
 * @typedef {object} Actions
 * @property {() => void} tare
 * @property {() => void} record
 * @property {() => void} event
 * @property {() => void} nextMethod
 * @property {() => void} nextUnit
 * @property {(layout: Layout) => void} layout
 * @property {() => void} difference
 * @property {() => void} smooth
 * @property {() => void} surface
 * @property {() => void} marks
 * @property {() => void} cop
 * @property {() => void} help
 * @property {() => void} pause
 * @property {() => boolean} isPaused
 * @property {(frames: number) => void} step
 * @property {(right: number, down: number, taxels: number) => void} movePicked
 * @property {() => void} pin
 * @property {() => void} escape
 * @property {() => boolean} hasLetters
 * @property {() => void} leaveField
 */

/** @type {[string, string][]} */
const LIST = [
  ["Space", "Pause the view, or back to live"],
  ["← →", "Move the picked taxel; while paused, step through the frames (Shift: by 10)"],
  ["↑ ↓", "Move the picked taxel (Shift: by 8)"],
  ["Alt + arrows", "Move the picked taxel also while paused"],
  ["Enter", "Pin the picked taxel, or take its pin away"],
  ["Esc", "Cancel drawing; clear the picked taxel; then pins and regions"],
  ["t", "Tare"],
  ["r", "Record, or stop"],
  ["e", "Mark an event"],
  ["m", "Next method"],
  ["u", "Next unit"],
  ["1 2 3", "Both maps, compensated only, raw only"],
  ["x", "Difference"],
  ["s", "Smooth"],
  ["d", "3D surface"],
  ["b", "Marks on bad taxels and lines"],
  ["c", "Centre of pressure"],
  ["?", "This list"],
];

/** @type {Record<string, [number, number]>} */
const ARROWS = { ArrowLeft: [-1, 0], ArrowRight: [1, 0], ArrowUp: [0, -1], ArrowDown: [0, 1] };

/** @param {HTMLElement} list */
export function fillKeyList(list) {
  for (const [keys, text] of LIST) {
    const dt = document.createElement("dt");
    for (const key of keys === "Alt + arrows" ? [keys] : keys.split(" ")) {
      const kbd = document.createElement("kbd");
      kbd.textContent = key;
      dt.append(kbd);
    }
    const dd = document.createElement("dd");
    dd.textContent = text;
    list.append(dt, dd);
  }
}

// Whoever last used the pointer has the focus where he clicked, but means the view with the keys; whoever came by Tab means
// the control that has the focus. So nothing has to take the focus away, and Tab goes on from where it is.
class Hand {
  constructor() {
    this.byPointer = false;
    /** @type {EventTarget | null} a list of which the pointer has chosen: it is closed again */
    this.chosen = null;
    document.addEventListener("pointerdown", () => {
      this.byPointer = true;
      this.chosen = null;
    }, true);
    document.addEventListener("keydown", (event) => {
      if (event.key === "Tab") this.byPointer = false;
    }, true);
    document.addEventListener("change", (event) => {
      if (this.byPointer) this.chosen = event.target;
    });
  }

  /** @param {HTMLElement} target */
  lends(target) {
    return this.byPointer && (target.tagName !== "SELECT" || target === this.chosen);
  }
}

/** @param {Actions} actions */
export function startKeys(actions) {
  /** @type {Record<string, () => void>} */
  const letters = {
    t: actions.tare, r: actions.record, e: actions.event, m: actions.nextMethod, u: actions.nextUnit,
    1: () => actions.layout("both"), 2: () => actions.layout("compensated"), 3: () => actions.layout("raw"),
    x: actions.difference, s: actions.smooth, d: actions.surface, b: actions.marks, c: actions.cop, "?": actions.help,
  };
  const hand = new Hand();
  let spaceIsOurs = false;
  document.addEventListener("keyup", (event) => {
    // Some browsers press a button when the space bar is let go.
    if (event.key === " " && spaceIsOurs) event.preventDefault();
    spaceIsOurs = false;
  });
  document.addEventListener("keydown", (event) => {
    const target = event.target instanceof HTMLElement ? event.target : document.body;
    if (event.ctrlKey || event.metaKey || document.querySelector("dialog[open]")) return;
    if (isTyping(target)) {
      if (event.key === "Escape") actions.leaveField();
      return;
    }
    const lends = hand.lends(target);
    if (ARROWS[event.key]) takeArrow(event, target, lends, actions);
    else if (event.altKey) return;
    else if (event.key === "Escape") actions.escape();
    else if (event.key === " " || event.key === "Enter") {
      if (isPressable(target) && !lends) return;
      event.preventDefault();
      spaceIsOurs = event.key === " ";
      if (event.key === " ") actions.pause();
      else actions.pin();
    } else {
      const action = letters[event.key.toLowerCase()];
      if (!action || event.repeat || !actions.hasLetters() || (target.tagName === "SELECT" && !lends)) return;
      event.preventDefault();
      action();
    }
  });
}

/**
 * @param {KeyboardEvent} event
 * @param {HTMLElement} target
 * @param {boolean} lends
 * @param {Actions} actions
 */
function takeArrow(event, target, lends, actions) {
  const [right, down] = ARROWS[event.key];
  const scrubs = actions.isPaused() && right !== 0 && !event.altKey;
  // Sliders and lists keep their own arrow keys; the scrub bar goes by frames.
  if (usesArrows(target) && !lends && !(scrubs && target.id === "scrub")) return;
  event.preventDefault();
  if (scrubs) actions.step(right * (event.shiftKey ? 10 : 1));
  else actions.movePicked(right, down, event.shiftKey ? 8 : 1);
}

/** @param {HTMLElement} element */
function isTyping(element) {
  // A box that was closed a moment ago still has the focus, until the next picture.
  if (element.closest("dialog:not([open])")) return false;
  return element.tagName === "TEXTAREA" || (element instanceof HTMLInputElement && !["range", "checkbox"].includes(element.type));
}

/** @param {HTMLElement} element */
const usesArrows = (element) => element.tagName === "SELECT" || (element instanceof HTMLInputElement && element.type === "range");
/** @param {HTMLElement} element */
const isPressable = (element) => ["BUTTON", "SELECT", "A"].includes(element.tagName) || (element instanceof HTMLInputElement && element.type === "checkbox");
