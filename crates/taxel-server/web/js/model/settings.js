// What is compared, and how it is shown: up to four settings. All of it stands in the address, so that it can be shared.

import { TABLE_V } from "./circuit.js";
import { POINT_UNITS } from "./points.js";

export const MAX_SETTINGS = 4;
export const MAX_OTHERS = 255;
const MAX_NAME = 40;

// The ends are those of the sliders; numbers beyond them may be typed. `log`: steps of equal ratio. `zero`: the
// slider's lowest position is 0, and `min` the next one. `least`: what the formulas can bear.
/** @type {Model.Parameter[]} */
export const PARAMETERS = [
  { key: "openLoopGain", symbol: "A", below: "", words: "open-loop gain at the scan rate", unit: "", min: 10, max: 1e7, log: true },
  { key: "feedbackOhms", symbol: "R", below: "k", words: "feedback resistor", unit: "Ω", min: 100, max: 1e5, log: true },
  { key: "otherOhms", symbol: "R", below: "i", words: "each of the N other pressed taxels", unit: "Ω", min: 100, max: 1e6, log: true },
  { key: "taxelOhms", symbol: "R", below: "taxel", words: "the taxel that is read", unit: "Ω", min: 100, max: 1e6, log: true },
  { key: "testVolts", symbol: "V", below: "test", words: "test voltage", unit: "V", min: 0.01, max: 3, log: false, step: 0.01 },
  { key: "switchOhms", symbol: "R", below: "mux", words: "each switch, column and row", unit: "Ω", min: 0.1, max: 1000, log: true, zero: true },
  { key: "sourceOhms", symbol: "R", below: "v", words: "resistor in series with the source", unit: "Ω", min: 1, max: 1e5, log: true, zero: true },
];

const MAX_VALUE = 1e12;

/**
 * @param {Model.Parameter} parameter
 * @param {number} value
 */
export const mayBe = (parameter, value) => Number.isFinite(value) && value <= MAX_VALUE && (parameter.zero ? value >= 0 : value > 0);

/** @type {Model.View} */
const VIEW = { y: "volts", fromZero: true, last: 20, fullScaleVolts: 2.2, unit: "counts", nCounts: "others" };

/**
 * The name in the address, and what may stand there.
 * @type {{ [K in keyof Model.View]: { name: string, read: (text: string) => Model.View[K] | undefined, write?: (value: Model.View[K]) => string } }}
 */
const KEYS = {
  y: { name: "y", read: (text) => oneOf(/** @type {Model.Quantity[]} */ (["volts", "counts", "drop"]), text) },
  fromZero: { name: "zero", read: (text) => (text === "1" ? true : text === "0" ? false : undefined), write: (value) => (value ? "1" : "0") },
  last: { name: "n", read: (text) => (mayBeLast(Number(text)) ? Number(text) : undefined) },
  fullScaleVolts: { name: "full", read: (text) => (mayBeFullScale(Number(text)) ? Number(text) : undefined) },
  unit: { name: "unit", read: (text) => oneOf(POINT_UNITS.map(({ key }) => key), text) },
  nCounts: { name: "counting", read: (text) => oneOf(/** @type {Model.View["nCounts"][]} */ (["others", "pressed"]), text) },
};

/**
 * @template {string} T
 * @param {T[]} list
 * @param {string} text
 */
const oneOf = (list, text) => list.find((item) => item === text);

/** @param {number} value */
export const mayBeLast = (value) => Number.isInteger(value) && value >= 1 && value <= MAX_OTHERS;
/** @param {number} value */
export const mayBeFullScale = (value) => value > 0 && value <= 1000;

/**
 * Table V, which knows no switches, and the same behind switches of 10 Ω: what really makes the drop.
 * @returns {Model.Setting[]}
 */
const start = () => [
  { name: "Table V", colour: 0, ...TABLE_V },
  { name: "Table V, R_mux 10 Ω", colour: 1, ...TABLE_V, switchOhms: 10 },
];

const VIEW_KEYS = /** @type {(keyof Model.View)[]} */ (Object.keys(KEYS));

/**
 * @template {keyof Model.View} K
 * @param {K} key
 * @param {Model.View} view
 */
function written(key, view) {
  const { write } = KEYS[key];
  return write ? write(view[key]) : String(view[key]);
}

/**
 * Whether the text makes sense; then the view has it.
 * @template {keyof Model.View} K
 * @param {K} key
 * @param {string} text
 * @param {Model.View} view
 */
function take(key, text, view) {
  const value = KEYS[key].read(text);
  if (value === undefined) return false;
  view[key] = /** @type {Model.View[K]} */ (value);
  return true;
}

/** @typedef {"list" | "value"} Change settings came or went, or a value is another one */

export class Settings {
  constructor() {
    /** @type {((what: Change) => void)[]} */
    this.listeners = [];
    this.list = start();
    /** @type {Model.View} */
    this.view = { ...VIEW };
  }

  /** @param {(what: Change) => void} listener */
  onChange(listener) {
    this.listeners.push(listener);
  }

  /** @param {Change} what */
  announce(what) {
    for (const listener of this.listeners) listener(what);
  }

  reset() {
    this.list = start();
    this.view = { ...VIEW };
    this.announce("list");
  }

  /**
   * @template {keyof Model.View} K
   * @param {K} name
   * @param {Model.View[K]} value
   */
  setView(name, value) {
    if (this.view[name] === value) return;
    this.view[name] = value;
    this.announce("value");
  }

  /**
   * @param {Model.Setting} setting
   * @param {keyof Model.Numbers} key
   * @param {number} value
   */
  setValue(setting, key, value) {
    setting[key] = value;
    this.announce("value");
  }

  /**
   * @param {Model.Setting} setting
   * @param {string} name
   */
  rename(setting, name) {
    setting.name = name.slice(0, MAX_NAME);
    this.announce("value");
  }

  get isFull() {
    return this.list.length >= MAX_SETTINGS;
  }

  /** @returns {Model.Setting | null} null where there is no room */
  add(like = { name: "Table V", ...TABLE_V }, name = like.name) {
    if (this.isFull) return null;
    const taken = this.list.map(({ colour }) => colour);
    const colour = [0, 1, 2, 3].find((one) => !taken.includes(one)) ?? 0;
    const setting = { ...like, name: this.freeName(name), colour };
    this.list.push(setting);
    this.announce("list");
    return setting;
  }

  /**
   * Two of the same name could not be told apart in a legend or a table.
   * @param {string} name
   */
  freeName(name) {
    const base = name.replace(/ \(\d+\)$/, "").slice(0, MAX_NAME - 4);
    let free = base;
    for (let i = 2; this.list.some((setting) => setting.name === free); i += 1) free = `${base} (${i})`;
    return free;
  }

  /** @param {Model.Setting} setting */
  remove(setting) {
    if (this.list.length === 1) return;
    this.list = this.list.filter((one) => one !== setting);
    this.announce("list");
  }

  // Empty for what a fresh page shows.
  get hash() {
    const text = this.write();
    return text === new Settings().write() ? "" : text;
  }

  write() {
    const parts = new URLSearchParams();
    for (const key of VIEW_KEYS) parts.set(KEYS[key].name, written(key, this.view));
    for (const setting of this.list) {
      parts.append("s", [setting.colour, ...PARAMETERS.map(({ key }) => setting[key]), setting.name].join("~"));
    }
    return parts.toString();
  }

  /**
   * Gives what was not understood, in words; that part is as on a fresh page.
   * @param {string} hash
   */
  takeHash(hash) {
    const parts = new URLSearchParams(hash.replace(/^#/, ""));
    const wrong = [];
    this.view = { ...VIEW };
    for (const key of VIEW_KEYS) {
      const { name } = KEYS[key];
      const text = parts.get(name);
      if (text !== null && !take(key, text, this.view)) wrong.push(`${name}=${text}`);
    }
    /** @type {Model.Setting[]} */
    const list = [];
    for (const text of parts.getAll("s")) {
      const setting = readSetting(text);
      const fits = setting && list.length < MAX_SETTINGS && !list.some(({ colour }) => colour === setting.colour);
      if (fits) list.push(setting);
      else wrong.push(`s=${text}`);
    }
    this.list = list.length > 0 ? list : start();
    this.announce("list");
    return wrong;
  }
}

/**
 * @param {string} text
 * @returns {Model.Setting | null}
 */
function readSetting(text) {
  const [colour, ...cells] = text.split("~");
  const values = cells.slice(0, PARAMETERS.length).map((cell) => (cell === "" ? NaN : Number(cell)));
  const name = cells.slice(PARAMETERS.length).join("~").slice(0, MAX_NAME);
  const good = /^[0-3]$/.test(colour) && values.length === PARAMETERS.length && PARAMETERS.every((parameter, i) => mayBe(parameter, values[i]));
  const numbers = Object.fromEntries(PARAMETERS.map(({ key }, i) => [key, values[i]]));
  return good ? { name, colour: Number(colour), .../** @type {Model.Numbers} */ (/** @type {unknown} */ (numbers)) } : null;
}
