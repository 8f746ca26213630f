// The sliders of a simulated source, as the server lists them.

import { fixed, decimalsFor, significant } from "./units.js";

const SENDS_PER_SECOND = 20;
const POSITIONS = 1000;

export class Sliders {
  constructor(app) {
    this.app = app;
    this.box = document.getElementById("sliders");
    this.controls = new Map();
  }

  reset(list) {
    this.box.textContent = "";
    this.controls.clear();
    document.getElementById("simulation-panel").hidden = list.length === 0;
    for (const slider of list) {
      const isToggle = slider.min === 0 && slider.max === 1 && slider.step === 1;
      this.controls.set(slider.key, isToggle ? this.makeToggle(slider) : this.makeSlider(slider));
    }
  }

  makeToggle(slider) {
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

  makeSlider(slider) {
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

    const control = { held: false, timer: 0 };
    const write = (value) => {
      const text = `${valueText(value, slider)}${slider.unit ? ` ${slider.unit}` : ""}`;
      output.textContent = text;
      input.setAttribute("aria-valuetext", text);
      input.style.setProperty("--share", `${(100 * Number(input.value)) / POSITIONS}%`);
    };
    control.take = (value) => {
      if (control.held || control.timer) return;
      input.value = String(Math.round(POSITIONS * shareOf(value, slider)));
      write(value);
    };
    input.addEventListener("pointerdown", () => { control.held = true; });
    for (const name of ["pointerup", "pointercancel", "blur"]) input.addEventListener(name, () => { control.held = false; });
    input.addEventListener("input", () => {
      const value = valueAt(Number(input.value) / POSITIONS, slider);
      write(value);
      // The last value is always sent: the timer reads it when it fires.
      if (!control.timer) {
        control.timer = setTimeout(() => {
          control.timer = 0;
          this.send(slider.key, valueAt(Number(input.value) / POSITIONS, slider));
        }, 1000 / SENDS_PER_SECOND);
      }
    });
    control.take(slider.value);
    return control;
  }

  send(key, value) {
    this.app.command({ do: "slider", key, value });
  }

  takeState(values) {
    for (const [key, value] of Object.entries(values || {})) {
      const control = this.controls.get(key);
      if (control) control.take(value);
    }
  }
}

function shareOf(value, { min, max, logarithmic }) {
  const share = logarithmic ? Math.log(value / min) / Math.log(max / min) : (value - min) / (max - min);
  return Math.min(1, Math.max(0, share));
}

function valueAt(share, { min, max, step, logarithmic }) {
  const value = logarithmic ? min * (max / min) ** share : min + (max - min) * share;
  const stepped = step > 0 ? min + Math.round((value - min) / step) * step : value;
  return Number(Math.min(max, Math.max(min, stepped)).toPrecision(12));
}

function valueText(value, { step, logarithmic }) {
  return logarithmic || !(step > 0) ? significant(value) : fixed(value, decimalsFor(step, 1));
}
