// The interactive model: joins the settings with the chart, the table, the points and the address.

import { all, buttonById, byId, inputById, onClick, write } from "../dom.js";
import { startTheme, toggleTheme } from "../theme.js";
import { takeToken } from "../connection.js";
import { fixed, significant } from "../units.js";
import { toast } from "../toast.js";
import { curvesOf } from "./circuit.js";
import { atCeiling, pointsIn, summaryOf } from "./points.js";
import { Settings, mayBeFullScale, mayBeLast } from "./settings.js";
import { Cards } from "./cards.js";
import { Chart } from "./chart.js";
import { PointsPanel } from "./pointspanel.js";
import { curvesText, savePicture, saveTable } from "./save.js";
import { writeTable } from "./table.js";

// Browsers limit how often a page may change its address.
const ADDRESS_AFTER_MS = 300;
const TABLE_AFTER_MS = 120;

class App {
  constructor() {
    this.settings = new Settings();
    /** @type {number | null} the N that was chosen */
    this.at = null;
    /** @type {ReturnType<typeof setTimeout> | undefined} */
    this.addressTimer = undefined;
    /** @type {ReturnType<typeof setTimeout> | undefined} */
    this.tableTimer = undefined;
    /** @type {string | undefined} */
    this.tableKey = undefined;
    this.asked = false;
    this.cards = new Cards(byId("cards"), this.settings);
    this.points = new PointsPanel(this.settings, () => this.ask());
    this.chart = new Chart(byId("chart"), (n) => this.moveTo(n));
    this.settings.onChange((what) => {
      if (what === "list") this.cards.rebuild();
      this.ask();
      this.writeAddressSoon();
    });
    this.readAddress();
    window.addEventListener("hashchange", () => this.readAddress());
    this.startControls();
    this.startKeys();
    this.draw();
  }

  readAddress() {
    // While a change waits to be written, the address is the older one.
    clearTimeout(this.addressTimer);
    if (location.hash.replace(/^#/, "") === this.settings.hash) {
      this.cards.rebuild();
      return;
    }
    const wrong = this.settings.takeHash(location.hash);
    if (wrong.length > 0) toast(`Not understood in the address, so left as on a fresh page: ${wrong.join(", ")}`, "bad");
  }

  writeAddressSoon() {
    clearTimeout(this.addressTimer);
    this.addressTimer = setTimeout(() => {
      const { hash } = this.settings;
      history.replaceState(null, "", `${location.pathname}${location.search}${hash ? `#${hash}` : ""}`);
    }, ADDRESS_AFTER_MS);
  }

  startControls() {
    const { settings } = this;
    for (const button of all("[data-y]")) {
      button.addEventListener("click", () => settings.setView("y", /** @type {Model.Quantity} */ (button.dataset.y)));
    }
    onClick("zero-button", () => settings.setView("fromZero", !settings.view.fromZero));
    onClick("add-button", () => this.cards.focusName(settings.add()));
    onClick("reset-button", () => {
      this.at = null;
      settings.reset();
    });
    const slider = inputById("last-slider");
    slider.addEventListener("input", () => settings.setView("last", Number(slider.value)));
    this.startNumber("last-input", "last", mayBeLast, "a whole number from 1 to 255 is expected");
    this.startNumber("full-input", "fullScaleVolts", mayBeFullScale, "a number above 0 is expected");
    onClick("png-button", async () => {
      this.draw();
      toast(`Saved ${await savePicture(this.chart.plot, settings.list, this.chart.shown.points.length > 0)}`);
    });
    onClick("csv-button", () => {
      toast(`Saved ${saveTable(curvesText(this.curves(), settings.list, settings.view.last))}`);
    });
    const repaint = () => this.draw();
    onClick("theme-button", () => toggleTheme(repaint));
    startTheme(repaint);
  }

  /**
   * @param {string} id
   * @param {"last" | "fullScaleVolts"} name
   * @param {(value: number) => boolean} mayBe
   * @param {string} expected
   */
  startNumber(id, name, mayBe, expected) {
    const input = inputById(id);
    input.addEventListener("input", () => {
      const value = input.value === "" ? NaN : Number(input.value);
      const good = mayBe(value);
      input.setAttribute("aria-invalid", String(!good));
      input.setCustomValidity(good ? "" : expected);
      if (good) this.settings.setView(name, value);
    });
    for (const event of ["change", "blur"]) {
      input.addEventListener(event, () => {
        input.value = String(this.settings.view[name]);
        input.removeAttribute("aria-invalid");
        input.setCustomValidity("");
      });
    }
  }

  // The chart is a slider over N for those who have no pointer.
  startKeys() {
    byId("chart").addEventListener("keydown", (event) => {
      const { last } = this.settings.view;
      /** @type {Record<string, number>} */
      const steps = { ArrowLeft: -1, ArrowDown: -1, ArrowRight: 1, ArrowUp: 1, PageDown: -10, PageUp: 10, Home: -last, End: last };
      const step = steps[event.key];
      if (step === undefined || event.ctrlKey || event.metaKey || event.altKey) return;
      event.preventDefault();
      this.moveTo(this.shownN + step);
    });
  }

  // Without a choice, the last N: there the drop is the largest.
  get shownN() {
    const { last } = this.settings.view;
    return this.at === null ? last : Math.min(this.at, last);
  }

  /** @param {number} n */
  moveTo(n) {
    const { last } = this.settings.view;
    const next = Math.min(last, Math.max(0, Math.round(n)));
    if (next === this.shownN) return;
    this.at = next === last ? null : next;
    this.ask();
  }

  // One drawing a frame of the screen, however fast a slider moves.
  ask() {
    if (this.asked) return;
    this.asked = true;
    requestAnimationFrame(() => {
      this.asked = false;
      this.draw();
    });
  }

  curves() {
    const { list, view } = this.settings;
    return list.map((setting) => ({ name: setting.name, colour: setting.colour, ...curvesOf(setting, view.last, view.fullScaleVolts) }));
  }

  draw() {
    const { view } = this.settings;
    const { measured, offset } = this.points;
    const curves = this.curves();
    const { points, why } = pointsIn(view.y, measured, { unit: view.unit, offset, fullScaleVolts: view.fullScaleVolts });
    const summary = summaryOf(points);
    this.chart.show({ ...view, curves, points, summary, at: this.shownN });
    this.points.write(why, summary.length, points.filter(({ n }) => n > view.last).length, atCeiling(measured, view.unit));
    this.writeControls();
    this.writeLegend(curves);
    this.writeSaturation(curves);
    this.writeTableSoon(curves);
    byId("chart").dataset.points = String(points.filter(({ n }) => n <= view.last).length);
  }

  /**
   * Thousands of cells would make a slider stutter: they wait until it rests. N under the pointer is none of theirs.
   * @param {Model.Curves[]} curves
   */
  writeTableSoon(curves) {
    const { list, view } = this.settings;
    const key = JSON.stringify([list, view.y, view.last, view.fullScaleVolts]);
    if (key === this.tableKey) return;
    const first = this.tableKey === undefined;
    this.tableKey = key;
    clearTimeout(this.tableTimer);
    this.tableTimer = setTimeout(() => writeTable(/** @type {HTMLTableElement} */ (byId("values")), { curves, y: view.y, last: view.last }), first ? 0 : TABLE_AFTER_MS);
  }

  writeControls() {
    const { view, isFull } = this.settings;
    for (const button of all("[data-y]")) button.setAttribute("aria-pressed", String(button.dataset.y === view.y));
    byId("zero-button").setAttribute("aria-pressed", String(view.fromZero));
    const slider = inputById("last-slider");
    for (const [input, value] of /** @type {[HTMLInputElement, number][]} */ ([[inputById("last-input"), view.last], [slider, view.last], [inputById("full-input"), view.fullScaleVolts]])) {
      if (document.activeElement !== input) input.value = String(value);
    }
    slider.style.setProperty("--share", `${(100 * (Number(slider.value) - 1)) / (Number(slider.max) - 1)}%`);
    buttonById("add-button").disabled = isFull;
    for (const button of all(".duplicate")) /** @type {HTMLButtonElement} */ (button).disabled = isFull;
  }

  /** @param {Model.Curves[]} curves */
  writeLegend(curves) {
    const { y, last } = this.settings.view;
    const n = this.shownN;
    byId("at").textContent = `N = ${n}`;
    /** @type {string[]} */
    const words = [];
    byId("legend").replaceChildren(...curves.map(({ name, colour, circuit, paper }) => {
      const values = [circuit, paper].map((curve) => valueText(curve, y, n));
      words.push(`${name || "unnamed"}: circuit ${values[0]}, paper ${values[1]}`);
      const item = document.createElement("li");
      item.dataset.colour = String(colour);
      const title = Object.assign(document.createElement("b"), { textContent: name || "unnamed", title: name });
      const text = document.createElement("span");
      text.className = "num";
      text.append(Object.assign(document.createElement("strong"), { textContent: values[0] }), ` · paper ${values[1]}`);
      const drop = document.createElement("span");
      drop.className = "num";
      if (y !== "drop") drop.append("drop ", Object.assign(document.createElement("strong"), { textContent: dropText(circuit, n) }), ` · paper ${dropText(paper, n)}`);
      item.append(title, text, drop);
      return item;
    }));
    const chart = byId("chart");
    chart.setAttribute("aria-valuemin", "0");
    chart.setAttribute("aria-valuemax", String(last));
    chart.setAttribute("aria-valuenow", String(n));
    chart.setAttribute("aria-valuetext", `N = ${n}. ${words.join("; ")}`);
  }

  /** @param {Model.Curves[]} curves */
  writeSaturation(curves) {
    const parts = [];
    for (const { name, circuit, paper } of curves) {
      const ends = [circuit, paper].map((curve) => curve.saturates.lastIndexOf(true));
      if (Math.max(...ends) < 0) continue;
      const { last } = this.settings.view;
      /** @param {number} end */
      const range = (end) => (end === last ? "at every N" : `up to N = ${end}`);
      if (ends[0] === ends[1]) parts.push(`“${name}” saturates ${range(ends[0])}`);
      else parts.push(`“${name}” saturates ${ends.map((end, i) => (end < 0 ? "" : `${["by the circuit", "by the paper’s equation"][i]} ${range(end)}`)).filter(Boolean).join(", ")}`);
    }
    const words = parts.length > 0 ? `${parts.join("; ")}: |V_out| is beyond the converter’s full scale.` : "";
    write("saturation", words);
  }
}

/**
 * @param {Model.Curve} curve
 * @param {Model.Quantity} y
 * @param {number} n
 */
function valueText(curve, y, n) {
  if (y === "drop") return dropText(curve, n);
  if (curve.saturates[n]) return "saturates";
  return y === "counts" ? fixed(Math.round(curve.counts[n]), 0) : `${fixed(curve.volts[n], 4)} V`;
}

/**
 * @param {Model.Curve} curve
 * @param {number} n
 */
const dropText = (curve, n) => `${significant(curve.drop[n])} %`;

takeToken();
new App();
