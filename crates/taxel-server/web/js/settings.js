// The user's view settings, kept from visit to visit.

import { Orientation } from "./orientation.js";

const KEY = "taxel.view";

/** @typedef {"both" | "compensated" | "raw"} Layout */
/** @typedef {"point" | "rectangle" | "lasso"} Tool */
/** @typedef {"follow" | "hold" | "fixed"} ScaleMode */
/**
 * @typedef {object} SettingValues
 * @property {Layout} layout
 * @property {boolean} difference
 * @property {boolean} smooth
 * @property {boolean} surface
 * @property {boolean} marks
 * @property {boolean} cop
 * @property {number} quarters
 * @property {boolean} mirrorX
 * @property {boolean} mirrorY
 * @property {string} unit
 * @property {string} colours
 * @property {ScaleMode} scaleMode
 * @property {number} scaleFixed
 * @property {number} window seconds shown in the charts
 * @property {number} fileWindow the same where a file is played; 0: all of it
 * @property {keyof Page.Measures} measure
 * @property {Tool} tool
 * @property {boolean} letters keys of a single letter, digit or sign do something
 */
/** @typedef {"difference" | "smooth" | "surface" | "marks" | "cop" | "letters"} Flag */

/** @type {SettingValues} */
const DEFAULTS = {
  layout: "both", difference: false, smooth: false, surface: false, marks: true, cop: true,
  quarters: 0, mirrorX: false, mirrorY: false,
  unit: "N", colours: "inferno", scaleMode: "follow", scaleFixed: 1,
  window: 30, fileWindow: 0, measure: "force", tool: "point", letters: true,
};

export class Settings {
  constructor() {
    /** @type {SettingValues} */
    this.values = { ...DEFAULTS, ...read() };
    /** @type {((name: keyof SettingValues | "orientation") => void)[]} */
    this.listeners = [];
    this.orientation = new Orientation(this.values);
  }

  /** @param {(name: keyof SettingValues | "orientation") => void} listener */
  onChange(listener) {
    this.listeners.push(listener);
  }

  /**
   * @template {keyof SettingValues} K
   * @param {K} name
   * @param {SettingValues[K]} value
   */
  set(name, value) {
    if (this.values[name] === value) return;
    this.values[name] = value;
    this.announce(name);
  }

  /** @param {Flag} name */
  toggle(name) {
    this.set(name, !this.values[name]);
  }

  /** @param {Orientation} orientation */
  setOrientation(orientation) {
    const { quarters, mirrorX, mirrorY } = orientation;
    Object.assign(this.values, { quarters, mirrorX, mirrorY });
    this.orientation = new Orientation(this.values);
    this.announce("orientation");
  }

  /** @param {keyof SettingValues | "orientation"} name */
  announce(name) {
    try {
      localStorage.setItem(KEY, JSON.stringify({ ...this.values, tool: DEFAULTS.tool }));
    } catch (_) {
      // Without storage the settings last as long as the page.
    }
    for (const listener of this.listeners) listener(name);
  }
}

/**
 * Only known settings of the known type: the storage may be from another version.
 * @returns {Partial<SettingValues>}
 */
function read() {
  try {
    const stored = JSON.parse(localStorage.getItem(KEY) || "{}") || {};
    const known = /** @type {Record<string, unknown>} */ (/** @type {unknown} */ (DEFAULTS));
    return Object.fromEntries(Object.entries(stored).filter(([name, value]) => typeof value === typeof known[name]));
  } catch (_) {
    return {};
  }
}
