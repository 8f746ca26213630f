// The charts below the maps: total force, peak pressure, contact area, and the selection.

import { TimeChart, longestStep } from "./timechart.js";
import { theme } from "./theme.js";
import { fixed, decimalsFor, forceUnit, pressureUnit, loadFactor } from "./units.js";

const MOST_POINTS = 1500;
const SELECTION_POINTS = 500;

export class Charts {
  constructor(app) {
    this.app = app;
    const options = { onClick: (time) => app.playback.goTo(time) };
    const line = () => [{ colour: () => theme.comp, fill: () => `${theme.comp}22` }];
    const plot = (id) => document.querySelector(`#${id} .plot`);
    this.charts = {
      force: new TimeChart(plot("chart-force"), line(), { ...options, nameEvents: true }),
      peak: new TimeChart(plot("chart-peak"), line(), options),
      area: new TimeChart(plot("chart-area"), line(), options),
    };
    this.selection = new TimeChart(plot("chart-selection"), [], options);
    this.hint = document.getElementById("selection-hint");
    this.readouts = {
      force: document.getElementById("readout-force"),
      peak: document.getElementById("readout-peak"),
      area: document.getElementById("readout-area"),
    };
    this.titles = { force: document.querySelector("#chart-force h3"), peak: document.querySelector("#chart-peak h3") };
    this.sizes = { force: 0, peak: 0 };
  }

  // Lines are made anew only when the selection changes.
  takeSelection(selection) {
    this.selection.setLines(selection.items.map((item) => ({ colour: () => item.colour, dash: item.letter === "R" ? [6, 3] : undefined })));
    this.hint.hidden = !selection.empty;
  }

  // What each quantity is shown in: [factor, unit].
  quantities() {
    const { unit, sensor, newtons } = this.app;
    const force = forceUnit(unit);
    const pressure = pressureUnit(unit);
    return {
      force: [force.factor, force.text],
      // peaks of the whole array arrive in kPa, in siemens per taxel without a load law
      peak: newtons ? [pressure.factor, pressure.text] : [unit.factor, unit.text],
      taxelPressure: newtons ? [loadFactor(pressure, sensor.taxel_area_mm2), pressure.text] : [unit.factor, unit.text],
      area: [0.01, "cm²"],
    };
  }

  update() {
    const { app } = this;
    const { series, settings, playback } = app;
    if (!app.shown) return;
    const span = settings.values.window;
    const end = this.endOf(series.lastTime, span, app.paused ? app.shown.host : NaN);
    const pausedAt = app.paused ? app.shown.host : NaN;
    const quantities = this.quantities();
    for (const [name, chart] of Object.entries(this.charts)) {
      extract(series, name === "force" ? "total" : name, end, span, quantities[name][0], chart.data);
      chart.update(end, span, playback.events, pausedAt);
    }
    this.updateSelection(end, span, quantities, pausedAt);
    this.write(quantities);
  }

  // While paused at a frame older than the window, the window moves to it.
  endOf(last, span, pausedAt) {
    return pausedAt < last - span ? pausedAt + span / 2 : last;
  }

  updateSelection(end, span, quantities, pausedAt) {
    const { selection, settings, playback } = this.app;
    const { measure } = settings.values;
    const [factor, unit] = measure === "force" ? quantities.force : measure === "area" ? quantities.area : quantities.taxelPressure;
    document.getElementById("measure-unit").textContent = selection.empty ? "" : unit;
    const { data } = this.selection;
    const step = span / SELECTION_POINTS;
    // A grid that stands still in time: one that moved with the newest frame would make the lines shimmer.
    const last = Math.floor(end / step);
    data[0].length = 0;
    for (let k = SELECTION_POINTS; k >= 0; k -= 1) data[0].push((last - k) * step - end);
    selection.items.forEach((item, i) => {
      const out = data[i + 1];
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
    this.selection.update(end, span, playback.events, pausedAt);
  }

  decimals(name) {
    return decimalsFor(this.charts[name].top / 3);
  }

  write(quantities) {
    const { shown, newtons } = this.app;
    this.titles.force.textContent = newtons ? "Total force" : "Total conductance";
    this.titles.peak.textContent = newtons ? "Peak pressure" : "Peak conductance";
    const values = { force: shown.total, peak: shown.peak, area: shown.area };
    for (const [name, element] of Object.entries(this.readouts)) {
      const [factor, unit] = quantities[name];
      const value = values[name] * factor;
      // Decimals from the size of the chart, not of the value: they would jump as it passes powers of ten.
      element.textContent = `${fixed(value, this.decimals(name))} ${unit}`;
    }
  }
}

// Rows of the series within the window, thinned to the highest of each bucket, with gaps kept as gaps.
function extract(series, name, end, span, factor, data) {
  const [xs, ys] = data;
  xs.length = 0;
  ys.length = 0;
  const { time } = series.columns;
  const values = series.columns[name];
  const from = series.indexFrom(end - span);
  const to = series.indexFrom(end + 1e-6);
  const stride = Math.max(1, Math.ceil((to - from) / MOST_POINTS));
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
