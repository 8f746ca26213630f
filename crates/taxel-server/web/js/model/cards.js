// A card a setting: its name, and a slider with a number beside it for each parameter.

import { byId, inputById } from "../dom.js";
import { PARAMETERS, mayBe } from "./settings.js";

const STEPS_PER_DECADE = 100;
const DIGITS = 3;

/**
 * @template {keyof HTMLElementTagNameMap} K
 * @param {K} name
 * @param {Partial<HTMLElementTagNameMap[K]>} properties
 * @param {...(Node | string)} children
 * @returns {HTMLElementTagNameMap[K]}
 */
const make = (name, properties = {}, ...children) => {
  const element = Object.assign(document.createElement(name), properties);
  element.append(...children);
  return element;
};

/**
 * Positions of a slider, 0 … last, and the value at each.
 * @param {Model.Parameter} parameter
 * @returns {{ last: number, valueAt: (position: number) => number, positionOf: (value: number) => number }}
 */
function scaleOf({ min, max, log, zero, step = 1 }) {
  if (!log) {
    const last = Math.round((max - min) / step);
    return { last, valueAt: (position) => Number((min + position * step).toPrecision(12)), positionOf: (value) => (value - min) / step };
  }
  const first = zero ? 1 : 0;
  return {
    last: first + Math.round(Math.log10(max / min) * STEPS_PER_DECADE),
    valueAt: (position) => (position < first ? 0 : Number((min * 10 ** ((position - first) / STEPS_PER_DECADE)).toPrecision(DIGITS))),
    positionOf: (value) => (value <= 0 ? 0 : Math.max(first, first + Math.log10(value / min) * STEPS_PER_DECADE)),
  };
}

export class Cards {
  /**
   * @param {HTMLElement} box
   * @param {import("./settings.js").Settings} settings
   */
  constructor(box, settings) {
    this.box = box;
    this.settings = settings;
  }

  rebuild() {
    const alone = this.settings.list.length === 1;
    this.box.replaceChildren(...this.settings.list.map((setting, i) => this.card(setting, i, alone)));
  }

  /** @param {Model.Setting | null} setting */
  focusName(setting) {
    if (!setting) return;
    const name = inputById(`name-${this.settings.list.indexOf(setting)}`);
    name.focus();
    name.select();
  }

  /**
   * @param {Model.Setting} setting
   * @param {number} i
   * @param {boolean} alone
   */
  card(setting, i, alone) {
    const { settings } = this;
    const name = make("input", { type: "text", className: "name", id: `name-${i}`, value: setting.name, maxLength: 40, autocomplete: "off", spellcheck: false });
    name.setAttribute("aria-label", "Name of the setting");
    name.title = "Name of the setting";
    name.addEventListener("input", () => settings.rename(setting, name.value));
    const copy = make("button", { type: "button", className: "small duplicate", textContent: "Duplicate", disabled: settings.isFull });
    copy.addEventListener("click", () => this.focusName(settings.add(setting, setting.name)));
    const remove = make("button", { type: "button", className: "remove", textContent: "×", title: "Remove this setting", disabled: alone });
    remove.setAttribute("aria-label", `Remove ${setting.name}`);
    remove.addEventListener("click", () => {
      settings.remove(setting);
      byId("add-button").focus();
    });
    const card = make("article", { className: "setting" }, make("header", {}, name, copy, remove));
    card.dataset.colour = String(setting.colour);
    for (const parameter of PARAMETERS) card.append(this.row(setting, i, parameter));
    return card;
  }

  /**
   * @param {Model.Setting} setting
   * @param {number} i
   * @param {Model.Parameter} parameter
   */
  row(setting, i, parameter) {
    const { key, symbol, below, words, unit } = parameter;
    const id = `${key}-${i}`;
    const plain = below ? `${symbol}_${below}` : symbol;
    const label = make("label", { htmlFor: id, title: `${plain}: ${words}${unit ? ` (${unit})` : ""}` }, make("span", { className: "symbol" }, symbol, make("sub", { textContent: below })), make("span", { className: "words", textContent: words }));
    const scale = scaleOf(parameter);
    const slider = make("input", { type: "range", id: `${id}-slider`, min: "0", max: String(scale.last), step: "1" });
    slider.setAttribute("aria-label", `${plain}, ${words}`);
    const number = make("input", { type: "number", id, step: "any", min: "0", inputMode: "decimal", autocomplete: "off" });

    const writeSlider = () => {
      const position = Math.min(scale.last, Math.max(0, Math.round(scale.positionOf(setting[key]))));
      // A slider that is being moved stays where it is.
      if (document.activeElement !== slider) slider.value = String(position);
      slider.style.setProperty("--share", `${(100 * Number(slider.value)) / scale.last}%`);
      slider.setAttribute("aria-valuetext", `${setting[key]} ${unit}`.trim());
    };
    const writeNumber = () => {
      number.value = String(setting[key]);
      number.removeAttribute("aria-invalid");
      number.title = "";
    };
    slider.addEventListener("input", () => {
      this.settings.setValue(setting, key, scale.valueAt(Number(slider.value)));
      writeSlider();
      writeNumber();
    });
    number.addEventListener("input", () => {
      const value = number.value === "" ? NaN : Number(number.value);
      const good = mayBe(parameter, value);
      number.setAttribute("aria-invalid", String(!good));
      number.title = good ? "" : `a number ${parameter.zero ? "of 0 or more" : "above 0"} is expected`;
      if (!good) return;
      this.settings.setValue(setting, key, value);
      writeSlider();
    });
    // What could not be used gives way to what is drawn.
    number.addEventListener("change", writeNumber);
    number.addEventListener("blur", writeNumber);
    writeSlider();
    writeNumber();
    return make("div", { className: "parameter" }, label, slider, number, make("span", { className: "unit", textContent: unit }));
  }
}
