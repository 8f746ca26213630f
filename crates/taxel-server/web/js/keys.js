// The keyboard: one letter a command, as listed by "?".

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

const ARROWS = { ArrowLeft: [-1, 0], ArrowRight: [1, 0], ArrowUp: [0, -1], ArrowDown: [0, 1] };

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

export function actionsOf(app) {
  const { settings, controls, playback } = app;
  return {
    tare: () => controls.tare(),
    record: () => controls.toggleRecording(),
    event: () => controls.askEvent(),
    nextMethod: () => controls.nextMethod(),
    nextUnit: () => controls.nextUnit(),
    layout: (layout) => settings.set("layout", layout),
    difference: () => settings.toggle("difference"),
    smooth: () => settings.toggle("smooth"),
    surface: () => settings.toggle("surface"),
    marks: () => settings.toggle("marks"),
    cop: () => settings.toggle("cop"),
    help: () => document.getElementById("keys-dialog").showModal(),
    pause: () => playback.toggle(),
    isPaused: () => app.paused,
    step: (frames) => playback.step(frames),
    movePicked: (right, down, taxels) => app.movePicked(right, down, taxels),
    pin: () => app.picked && app.pin(app.picked),
    escape: () => app.escape(),
  };
}

export function startKeys(actions) {
  const letters = {
    t: actions.tare, r: actions.record, e: actions.event, m: actions.nextMethod, u: actions.nextUnit,
    1: () => actions.layout("both"), 2: () => actions.layout("compensated"), 3: () => actions.layout("raw"),
    x: actions.difference, s: actions.smooth, d: actions.surface, b: actions.marks, c: actions.cop, "?": actions.help,
  };
  document.addEventListener("keydown", (event) => {
    if (event.ctrlKey || event.metaKey || document.querySelector("dialog[open]")) return;
    const { target } = event;
    if (isTyping(target)) {
      if (event.key === "Escape") target.blur();
      return;
    }
    const arrow = ARROWS[event.key];
    if (arrow) {
      const scrubs = actions.isPaused() && arrow[0] !== 0 && !event.altKey;
      // Sliders and lists keep their own arrow keys; the scrub bar goes by frames.
      if (usesArrows(target) && !(scrubs && target.id === "scrub")) return;
      event.preventDefault();
      if (scrubs) actions.step(arrow[0] * (event.shiftKey ? 10 : 1));
      else actions.movePicked(arrow[0], arrow[1], event.shiftKey ? 8 : 1);
      return;
    }
    if (event.altKey) return;
    if (event.key === " ") {
      // A focused button is pressed by the space bar: that stays so.
      if (isPressable(target)) return;
      event.preventDefault();
      actions.pause();
    } else if (event.key === "Enter") {
      if (isPressable(target)) return;
      event.preventDefault();
      actions.pin();
    } else if (event.key === "Escape") {
      actions.escape();
    } else if (letters[event.key.toLowerCase()] && !event.repeat) {
      if (target.tagName === "SELECT") return;
      event.preventDefault();
      letters[event.key.toLowerCase()]();
    }
  });
}

function isTyping(element) {
  return element.tagName === "TEXTAREA" || (element.tagName === "INPUT" && !["range", "checkbox"].includes(element.type));
}

const usesArrows = (element) => element.tagName === "SELECT" || (element.tagName === "INPUT" && element.type === "range");
const isPressable = (element) => ["BUTTON", "SELECT", "A"].includes(element.tagName) || (element.tagName === "INPUT" && element.type === "checkbox");
