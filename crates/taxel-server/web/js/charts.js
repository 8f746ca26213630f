// The charts below the maps: total force, peak pressure, contact area, and the selection.

import { SELECTION_COLOURS } from "./colour.js";
import { TimeChart, longestStep } from "./timechart.js";
import { faint, theme } from "./theme.js";
import { byId, inside, write } from "./dom.js";
import { titleOf } from "./selection.js";
import { fixed, decimalsFor, plusMinus, forceUnit, pressureUnit, loadFactor } from "./units.js";

const MAX_POINTS = 1500;
const SELECTION_POINTS = 500;

const DESCRIBE_EVERY_MS = 1000;
const DASHES = [[6, 3], [2, 3], [10, 3, 2, 3]];
/** @type {("force" | "peak" | "area")[]} */
const CHARTS = ["force", "peak", "area"];

/** @typedef {Record<"force" | "peak" | "area" | "taxelPressure", [factor: number, unit: string]>} Quantities */

export class Charts {
  /**
   * @param {object} parts
   * @param {import("./view.js").View} parts.view
   * @param {import("./settings.js").Settings} parts.settings
   * @param {import("./history.js").History} parts.history
   * @param {import("./selection.js").Selection} parts.selection
   * @param {import("./figures.js").Figures} parts.figures
   * @param {(time: number) => void} parts.goTo shows the frame of that time
   * @param {(secs: number) => void} parts.seek plays the file from there
   */
  constructor({ view, settings, history, selection, figures, goTo, seek }) {
    this.view = view;
    this.settings = settings;
    this.history = history;
    this.items = selection;
    this.figures = figures;
    /** @param {number} time */
    const onClick = (time) => (this.wholeCurve() ? seek(Math.max(0, time)) : goTo(time));
    const options = { onClick };
    const line = () => [{ colour: () => theme.comp, fill: () => faint(theme.comp, 0.13) }];
    /** @param {string} id */
    const plot = (id) => inside(byId(id), ".plot");
    this.charts = {
      force: new TimeChart(plot("chart-force"), line(), { ...options, nameEvents: true }),
      peak: new TimeChart(plot("chart-peak"), line(), options),
      area: new TimeChart(plot("chart-area"), line(), options),
    };
    this.selection = new TimeChart(plot("chart-selection"), [], { onClick: goTo });
    this.hint = byId("selection-hint");
    /** @param {string} id */
    const readout = (id) => ({ whole: byId(id), value: inside(byId(id), ".value"), error: inside(byId(id), ".error"), unit: inside(byId(id), ".unit") });
    this.readouts = { force: readout("readout-force"), peak: readout("readout-peak"), area: readout("readout-area") };
    this.titles = { force: inside(byId("chart-force"), "h2"), peak: inside(byId("chart-peak"), "h2") };
    this.describedAt = -Infinity;
    selection.onChange(() => this.takeSelection(selection));
  }

  /**
   * Lines are made anew only when the selection changes.
   * @param {import("./selection.js").Selection} selection
   */
  takeSelection(selection) {
    this.selection.setLines(selection.items.map((item) => ({ colour: () => item.colour, dash: dashOf(item) })));
    this.hint.hidden = !selection.empty;
    this.update();
  }

  /**
   * What each quantity is shown in: [factor, unit].
   * @returns {Quantities}
   */
  quantities() {
    const { unit, sensor } = this.view;
    const { newtons } = this.view.now;
    const area = sensor ? sensor.taxel_area_mm2 : NaN;
    const force = forceUnit(unit);
    const pressure = pressureUnit(unit);
    return {
      force: [force.factor, force.text],
      // peaks of the whole array arrive in kPa, in siemens per taxel without a load law
      peak: newtons ? [pressure.factor, pressure.text] : [unit.factor, unit.text],
      taxelPressure: newtons ? [loadFactor(pressure, area), pressure.text] : [unit.factor, unit.text],
      area: [0.01, "cm²"],
    };
  }

  update() {
    const { shown, paused } = this.view.now;
    const { series, events } = this.history;
    if (!shown) return;
    const { window, fileWindow } = this.settings.values;
    const span = (this.view.isFile && fileWindow) || window;
    const pausedAt = paused ? shown.host : NaN;
    const end = this.endOf(series.lastTime, span, pausedAt);
    const quantities = this.quantities();
    const whole = this.wholeCurve();
    if (whole) this.drawWhole(whole, quantities);
    else for (const name of CHARTS) {
      const chart = this.charts[name];
      chart.whole = null;
      extract(series, name === "force" ? "total" : name, end, span, quantities[name][0], chart.data);
      chart.update(end, span, events, pausedAt);
    }
    this.updateSelection(end, span, quantities, pausedAt);
    this.write(shown, quantities);
    this.describe(quantities);
  }

  /**
   * All of the file that is played, where that is to be shown and is known: by the method that is chosen.
   * @returns {Wire.Curve | null}
   */
  wholeCurve() {
    const { curve } = this.history;
    const shown = this.view.isFile && this.settings.values.fileWindow === 0 && this.view.now.newtons;
    return shown && curve && curve.method === this.view.method && curve.secs.length > 1 ? curve : null;
  }

  /**
   * The whole file, with the place where it is.
   * @param {Wire.Curve} curve
   * @param {Quantities} quantities
   */
  drawWhole(curve, quantities) {
    const { state } = this.view.now;
    const at = state && state.player ? state.player.position_secs : NaN;
    const span = Math.max(curve.secs[curve.secs.length - 1], state && state.player ? state.player.duration_secs : 0);
    const columns = { force: curve.total_newtons, peak: curve.peak_kilopascals, area: curve.contact_area_mm2 };
    for (const name of CHARTS) {
      const chart = this.charts[name];
      const factor = quantities[name][0];
      const drawn = chart.whole;
      const isSame = drawn && drawn.curve === curve && drawn.factor === factor && drawn.span === span;
      // A frame is no reason to draw all of a recording again: the place in it is told twice a second.
      if (isSame && drawn.at === at && drawn.theme === theme.version) continue;
      if (!isSame) {
        chart.data[0] = curve.secs.map((secs) => secs - span);
        chart.data[1] = columns[name].map((value) => (value === null ? null : value * factor));
      }
      chart.whole = { curve, factor, span, at, theme: theme.version };
      chart.update(span, span, [], at, true);
    }
  }

  /**
   * The charts in words; now and then, since nobody reads as fast as frames come.
   * @param {Quantities} quantities
   */
  describe(quantities) {
    const now = performance.now();
    if (now - this.describedAt < DESCRIBE_EVERY_MS) return;
    this.describedAt = now;
    const names = { force: this.titles.force.textContent || "", peak: this.titles.peak.textContent || "", area: "Contact area" };
    for (const name of CHARTS) this.charts[name].describe(names[name], [quantities[name][1]]);
    const { items } = this.items;
    const { measure } = this.settings.values;
    const unit = this.measured(quantities)[1];
    this.selection.describe(`Selection, ${measure}`, items.map(() => unit), items.map(titleOf));
  }

  /**
   * What the chart of the selection is in.
   * @param {Quantities} quantities
   */
  measured(quantities) {
    const { measure } = this.settings.values;
    return measure === "force" ? quantities.force : measure === "area" ? quantities.area : quantities.taxelPressure;
  }

  /**
   * While paused at a frame older than the window, the window moves to it.
   * @param {number} last
   * @param {number} span
   * @param {number} pausedAt
   */
  endOf(last, span, pausedAt) {
    return pausedAt < last - span ? pausedAt + span / 2 : last;
  }

  /**
   * @param {number} end
   * @param {number} span
   * @param {Quantities} quantities
   * @param {number} pausedAt
   */
  updateSelection(end, span, quantities, pausedAt) {
    const selection = this.items;
    const { measure } = this.settings.values;
    const [factor, unit] = this.measured(quantities);
    write("measure-unit", selection.empty ? "" : unit);
    const [xs, ...columns] = this.selection.data;
    const step = span / SELECTION_POINTS;
    // A grid that stands still in time: one that moved with the newest frame would make the lines shimmer.
    const last = Math.floor(end / step);
    xs.length = 0;
    for (let k = SELECTION_POINTS; k >= 0; k -= 1) xs.push((last - k) * step - end);
    selection.items.forEach((item, i) => {
      const out = columns[i];
      out.length = 0;
      const { time } = item.series.columns;
      const values = item.series.columns[measure];
      const longest = longestStep((i) => time[i], item.series.indexFrom(end - span), item.series.end);
      let at = item.series.indexFrom(end - span - longest);
      for (let k = SELECTION_POINTS; k >= 0; k -= 1) {
        const instant = (last - k) * step;
        while (at + 1 < item.series.end && time[at + 1] <= instant) at += 1;
        const known = at < item.series.end && time[at] <= instant && instant - time[at] < longest;
        out.push(known ? values[at] * factor : null);
      }
    });
    this.selection.update(end, span, this.history.events, pausedAt);
  }

  /** @param {keyof Charts["charts"]} name */
  decimals(name) {
    return decimalsFor(this.charts[name].top / 3);
  }

  /**
   * @param {Page.Frame} shown
   * @param {Quantities} quantities
   */
  write(shown, quantities) {
    const { newtons } = this.view.now;
    const other = this.view.exported ? "reading" : "conductance";
    this.titles.force.textContent = newtons ? "Total force" : `Total ${other}`;
    this.titles.peak.textContent = newtons ? "Peak pressure" : `Peak ${other}`;
    const values = { force: shown.total, peak: shown.peak, area: shown.area };
    for (const name of CHARTS) {
      const [factor, unit] = quantities[name];
      const value = values[name] * factor;
      // Decimals from the size of the chart, not of the value: they would jump as it passes powers of ten.
      const decimals = this.decimals(name);
      const { half, words } = this.figures.of(name, shown);
      const readout = this.readouts[name];
      readout.value.textContent = fixed(value, decimals);
      readout.error.textContent = half === null ? "" : plusMinus(half * factor, decimals);
      readout.unit.textContent = ` ${unit}`;
      // A title that is written anew goes away under the pointer.
      if (readout.whole.title !== words) readout.whole.title = words;
    }
  }
}

/**
 * Pins are whole lines, regions dashed; those that take a colour for the second or third time in dashes of their own.
 * @param {Page.Item} item
 */
function dashOf(item) {
  return item.letter === "R" ? DASHES[Math.floor((item.number - 1) / SELECTION_COLOURS.length) % DASHES.length] : undefined;
}

/**
 * Rows of the series within the window, thinned to the highest of each bucket, with gaps kept as gaps.
 * @template {string} N
 * @param {import("./series.js").Series<N>} series
 * @param {N} name
 * @param {number} end
 * @param {number} span
 * @param {number} factor
 * @param {import("./timechart.js").Data} data
 */
function extract(series, name, end, span, factor, data) {
  const [xs, ys] = data;
  xs.length = 0;
  ys.length = 0;
  const { time } = series.columns;
  const values = series.columns[name];
  const from = series.indexFrom(end - span);
  const to = series.indexFrom(end + 1e-6);
  const stride = Math.max(1, Math.ceil((to - from) / MAX_POINTS));
  const longest = longestStep((i) => time[i], from, to) * stride;
  // Buckets at fixed places in the series, for the same reason as the grid above.
  let at = stride > 1 ? from - (from % stride) : from;
  if (at < series.start) at = from;
  for (; at < to; at += stride) {
    let highest = -Infinity;
    const stop = Math.min(at + stride, to);
    for (let i = at; i < stop; i += 1) if (values[i] > highest) highest = values[i];
    if (xs.length > 0 && time[at] - end - xs[xs.length - 1] > longest) {
      xs.push(time[at] - end - 1e-3);
      ys.push(null);
    }
    xs.push(time[at] - end);
    ys.push(highest === -Infinity ? null : highest * factor);
  }
}
