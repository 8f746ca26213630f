// The sliders of a simulated source, as the server lists them.

import { byId } from "./dom.js";
import { fixed, decimalsFor, significant } from "./units.js";

const SENDS_PER_SECOND = 20;
const POSITIONS = 1000;

/** @typedef {{ take: (value: number) => void }} Control */

export class Sliders {
  /**
   * @param {import("./view.js").View} view
   * @param {import("./requests.js").Requests} requests
   */
  constructor(view, requests) {
    this.requests = requests;
    this.box = byId("sliders");
    /** @type {Map<string, Control>} */
    this.controls = new Map();
    view.on(["hello"], () => this.reset(view.now.hello ? view.now.hello.sliders : []));
    view.on(["state"], () => this.takeState(view.now.state ? view.now.state.sliders : {}));
  }

  /** @param {Wire.Slider[]} list */
  reset(list) {
    this.box.textContent = "";
    this.controls.clear();
    byId("simulation-panel").hidden = list.length === 0;
    for (const slider of list) {
      this.controls.set(slider.key, slider.type === "switch" ? this.makeSwitch(slider) : this.makeRange(slider));
    }
  }

  /**
   * @param {Wire.Switch} slider
   * @returns {Control}
   */
  makeSwitch(slider) {
    const label = document.createElement("label");
    label.className = "check";
    const input = document.createElement("input");
    input.type = "checkbox";
    input.id = `slider-${slider.key}`;
    input.setAttribute("role", "switch");
    input.checked = slider.value > 0.5;
    label.append(input, slider.label);
    this.box.append(label);
    input.addEventListener("change", () => this.send(slider.key, input.checked ? 1 : 0));
    return { take: (value) => { input.checked = value > 0.5; } };
  }

  /**
   * @param {Wire.Range} slider
   * @returns {Control}
   */
  makeRange(slider) {
    const row = document.createElement("div");
    row.className = "slider";
    const label = document.createElement("label");
    label.htmlFor = `slider-${slider.key}`;
    label.textContent = slider.label;
    const output = document.createElement("output");
    output.className = "num";
    const input = document.createElement("input");
    input.type = "range";
    input.id = `slider-${slider.key}`;
    input.min = "0";
    input.max = String(POSITIONS);
    input.step = "1";
    row.append(label, output, input);
    this.box.append(row);

    let held = false;
    /** @type {ReturnType<typeof setTimeout> | undefined} */
    let timer;
    /** @param {number} value */
    const write = (value) => {
      const text = `${valueText(value, slider)}${slider.unit ? ` ${slider.unit}` : ""}`;
      output.textContent = text;
      input.setAttribute("aria-valuetext", text);
      input.style.setProperty("--share", `${(100 * Number(input.value)) / POSITIONS}%`);
    };
    /** @param {number} value */
    const take = (value) => {
      if (held || timer) return;
      input.value = String(Math.round(POSITIONS * shareOf(value, slider)));
      write(value);
    };
    input.addEventListener("pointerdown", () => { held = true; });
    for (const name of ["pointerup", "pointercancel", "blur"]) input.addEventListener(name, () => { held = false; });
    input.addEventListener("input", () => {
      const value = valueAt(Number(input.value) / POSITIONS, slider);
      write(value);
      // The last value is always sent: the timer reads it when it fires.
      if (!timer) {
        timer = setTimeout(() => {
          timer = undefined;
          this.send(slider.key, valueAt(Number(input.value) / POSITIONS, slider));
        }, 1000 / SENDS_PER_SECOND);
      }
    });
    take(slider.value);
    return { take };
  }

  /**
   * @param {string} key
   * @param {number} value
   */
  send(key, value) {
    this.requests.send({ do: "slider", key, value });
  }

  /** @param {Record<string, number>} values */
  takeState(values) {
    for (const [key, value] of Object.entries(values)) {
      const control = this.controls.get(key);
      if (control) control.take(value);
    }
  }
}

/**
 * @param {number} value
 * @param {Wire.Range} range
 */
function shareOf(value, { min, max, logarithmic }) {
  const share = logarithmic ? Math.log(value / min) / Math.log(max / min) : (value - min) / (max - min);
  return Math.min(1, Math.max(0, share));
}

/**
 * @param {number} share
 * @param {Wire.Range} range
 */
function valueAt(share, { min, max, step, logarithmic }) {
  const value = logarithmic ? min * (max / min) ** share : min + (max - min) * share;
  const stepped = step > 0 ? min + Math.round((value - min) / step) * step : value;
  return Number(Math.min(max, Math.max(min, stepped)).toPrecision(12));
}

/**
 * @param {number} value
 * @param {Wire.Range} range
 */
function valueText(value, { step, logarithmic }) {
  return logarithmic || !(step > 0) ? significant(value) : fixed(value, decimalsFor(step, 1));
}
