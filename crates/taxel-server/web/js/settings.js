// The user's view settings, kept from visit to visit.

import { Orientation } from "./orientation.js";

const KEY = "taxel.view";

const DEFAULTS = {
  layout: "both", difference: false, smooth: false, surface: false, marks: true, cop: true,
  quarters: 0, mirrorX: false, mirrorY: false,
  unit: "N", colours: "inferno", scaleMode: "follow", scaleFixed: 1,
  window: 30, measure: "force", tool: "point",
};

export class Settings {
  constructor() {
    this.values = { ...DEFAULTS, ...read() };
    this.listeners = [];
    this.turn();
  }

  onChange(listener) {
    this.listeners.push(listener);
  }

  set(name, value) {
    if (this.values[name] === value) return;
    this.values[name] = value;
    this.announce(name);
  }

  toggle(name) {
    this.set(name, !this.values[name]);
  }

  setOrientation(orientation) {
    const { quarters, mirrorX, mirrorY } = orientation;
    Object.assign(this.values, { quarters, mirrorX, mirrorY });
    this.turn();
    this.announce("orientation");
  }

  turn() {
    this.orientation = new Orientation(this.values);
  }

  announce(name) {
    try {
      localStorage.setItem(KEY, JSON.stringify({ ...this.values, tool: DEFAULTS.tool }));
    } catch (_) {
      // Without storage the settings last as long as the page.
    }
    for (const listener of this.listeners) listener(name);
  }
}

// Only known settings of the known type: the storage may be from another version.
function read() {
  try {
    const stored = JSON.parse(localStorage.getItem(KEY)) || {};
    return Object.fromEntries(Object.entries(stored).filter(([name, value]) => typeof value === typeof DEFAULTS[name]));
  } catch (_) {
    return {};
  }
}
