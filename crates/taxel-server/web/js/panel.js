// The side panel: the picked taxel with its last 30 s, pins and regions, and the frame as a whole.

import { TimeChart, longestStep } from "./timechart.js";
import { markOf, MARKS } from "./wire.js";
import { slotValue } from "./buffer.js";
import { cellArea, contactThreshold, measure } from "./selection.js";
import { theme } from "./theme.js";
import { fixed, decimalsFor, significant, siemens, areaText, forceUnit, pressureUnit, loadFactor } from "./units.js";

const CHART_SECONDS = 30;
const SATURATED = MARKS.findIndex((mark) => mark.word === "saturated");
const DETAILS_VALID_MS = 2500;

const byId = (id) => document.getElementById(id);

export class Panel {
  constructor(app) {
    this.app = app;
    this.chart = new TimeChart(byId("taxel-chart"), [
      { colour: () => theme.raw, dash: [4, 3] },
      { colour: () => theme.comp },
    ], { onClick: (time) => app.playback.goTo(time) });
    this.details = new Map();
    this.detailsAt = 0;
    this.rows = new Map();
    byId("clear-selection").addEventListener("click", () => app.selection.clear());
  }

  takeDetails(details) {
    this.details.clear();
    for (const taxel of details.taxels) this.details.set(`${taxel.row} ${taxel.column}`, taxel);
    this.detailsAt = performance.now();
  }

  detail(row, column) {
    if (this.app.paused || performance.now() - this.detailsAt > DETAILS_VALID_MS) return null;
    return this.details.get(`${row} ${column}`) || null;
  }

  update() {
    const { app } = this;
    if (!app.shown) return;
    this.updateTaxel(app.shown);
    this.updateSelection(app.shown);
    this.updateFrame(app.shown);
  }

  // Of a taxel's load: from the size of the scale, or the digits would jump with the value.
  loadDecimals(factor) {
    const { stage, unit, sensor } = this.app;
    return decimalsFor((stage.scale.top / loadFactor(unit, sensor.taxel_area_mm2)) * factor, 4);
  }

  updateTaxel(frame) {
    const { app } = this;
    const { picked, unit, sensor, newtons } = app;
    byId("taxel-empty").hidden = picked !== null;
    byId("taxel-body").hidden = picked === null;
    const badge = byId("taxel-mark");
    badge.hidden = picked === null;
    if (!picked) {
      byId("taxel-title").textContent = "Taxel";
      byId("taxel-sequence").textContent = "";
      return;
    }
    const { row, column } = picked;
    const at = row * sensor.columns + column;
    const force = forceUnit(unit);
    // All numbers are of one frame: of the one whose details came last, or of the one shown, of which less is known.
    const one = this.detail(row, column) || ofFrame(frame, at);
    byId("taxel-title").textContent = `Row ${row}, column ${column}`;
    byId("taxel-sequence").textContent = `frame ${one.sequence}`;
    const mark = markOf(one.mark);
    badge.textContent = mark.word;
    badge.dataset.severity = mark.severity;
    byId("taxel-mark-text").textContent = mark.severity ? mark.text : "";

    const decimals = this.loadDecimals(force.factor);
    const load = fixed(one.load * force.factor, decimals);
    const error = newtons ? uncertainty(one, force.factor, decimals) : "";
    byId("taxel-load").textContent = `${load}${error} ${force.text}`;
    const pressure = pressureUnit(unit);
    const perTaxel = loadFactor(pressure, sensor.taxel_area_mm2);
    byId("taxel-pressure").textContent = newtons ? `${fixed(one.load * perTaxel, this.loadDecimals(perTaxel))} ${pressure.text}` : "–";
    byId("taxel-raw").textContent = `${fixed(one.raw * force.factor, decimals)} ${force.text}`;
    byId("taxel-crosstalk").textContent = `${fixed((one.raw - one.load) * force.factor, decimals)} ${force.text}`;
    byId("taxel-siemens").textContent = siemens(newtons ? one.siemens : one.load);
    byId("taxel-counts").textContent = `${one.counts} / ${sensor.max_count}`;
    this.drawTaxel(at, force);
  }

  // The buffer holds the past of every taxel, so a taxel just pointed at has its 30 s at once.
  drawTaxel(at, unit) {
    const { buffer, shown, paused, playback } = this.app;
    const [xs, raw, compensated] = this.chart.data;
    for (const column of this.chart.data) column.length = 0;
    if (buffer.length === 0) return;
    const last = buffer.at(buffer.length - 1).host;
    const end = paused && shown.host < last - CHART_SECONDS ? shown.host + CHART_SECONDS / 2 : last;
    const first = buffer.indexAt(end - CHART_SECONDS);
    const longest = longestStep((i) => buffer.at(i).host, first, buffer.length);
    for (let i = first; i < buffer.length; i += 1) {
      const slot = buffer.at(i);
      if (slot.host > end) break;
      // No line where frames are missing.
      if (xs.length > 0 && slot.host - end - xs[xs.length - 1] > longest) {
        xs.push(slot.host - end - 1e-3);
        raw.push(null);
        compensated.push(null);
      }
      xs.push(slot.host - end);
      raw.push(orNull(slotValue(slot.raw[at], slot.rawRange) * unit.factor));
      compensated.push(orNull(slotValue(slot.compensated[at], slot.compensatedRange) * unit.factor));
    }
    byId("taxel-chart-unit").textContent = `${unit.text}, last ${CHART_SECONDS} s`;
    this.chart.update(end, CHART_SECONDS, playback.events, paused ? shown.host : NaN);
  }

  updateSelection(frame) {
    const { app } = this;
    const { selection, sensor, unit, newtons } = app;
    const items = selection.items;
    byId("selection-empty").hidden = items.length > 0;
    byId("clear-selection").hidden = items.length === 0;
    for (const [item, row] of this.rows) {
      if (!items.includes(item)) {
        row.element.remove();
        this.rows.delete(item);
      }
    }
    const force = forceUnit(unit);
    const pressure = newtons ? pressureUnit(unit) : unit;
    const factor = loadFactor(pressure, sensor.taxel_area_mm2);
    const hasRegions = selection.regions.length > 0;
    const threshold = hasRegions ? contactThreshold(frame.compensated, frame.area / cellArea(sensor)) : Infinity;
    const numbers = {};
    const decimals = this.loadDecimals(force.factor);
    for (const item of items) {
      if (!this.rows.has(item)) this.rows.set(item, this.makeRow(item));
      const row = this.rows.get(item);
      measure(item.taxels, frame.compensated, threshold, sensor, numbers);
      if (item.letter === "P") {
        row.force.textContent = `${fixed(numbers.force * force.factor, decimals)} ${force.text}`;
        const raw = frame.raw[item.taxels[0]];
        row.more.textContent = `raw ${fixed(raw * force.factor, decimals)} ${force.text}`;
      } else {
        row.force.textContent = `${fixed(numbers.force * force.factor, app.charts.decimals("force"))} ${force.text}`;
        row.more.textContent = `peak ${significant(numbers.peak * factor)}, mean ${significant(numbers.mean * factor)} ${pressure.text}, ${areaText(numbers.area)}`;
      }
    }
  }

  makeRow(item) {
    const element = document.createElement("li");
    const name = item.letter === "P" ? `row ${item.row}, col ${item.column}` : `${item.shape}, ${item.taxels.length} taxels`;
    element.innerHTML = '<i class="swatch" aria-hidden="true"></i><span class="name"></span><span class="force num"></span><button type="button" class="remove">×</button><span class="more num"></span>';
    element.querySelector(".swatch").style.background = item.colour;
    element.querySelector(".swatch").textContent = item.label;
    element.querySelector(".name").textContent = name;
    const remove = element.querySelector(".remove");
    remove.setAttribute("aria-label", `Remove ${item.label}, ${name}`);
    remove.addEventListener("click", () => this.app.selection.remove(item));
    byId("selection-list").append(element);
    return { element, force: element.querySelector(".force"), more: element.querySelector(".more") };
  }

  updateFrame(frame) {
    const { badLines } = this.app;
    byId("frame-sequence").textContent = `no. ${frame.sequence}`;
    const centred = Number.isFinite(frame.copRow) && Number.isFinite(frame.copColumn);
    byId("frame-cop").textContent = centred ? `row ${fixed(frame.copRow, 1)}, col ${fixed(frame.copColumn, 1)}` : "none";
    byId("frame-outliers").textContent = `${fixed(frame.outliers * 100, 1)} %`;
    const counts = new Array(MARKS.length).fill(0);
    let marked = 0;
    for (let i = 0; i < frame.marks.length; i += 1) {
      if (frame.marks[i] === 0) continue;
      marked += 1;
      counts[frame.marks[i]] += 1;
    }
    // Saturated readings are lower bounds, but readings; interpolated ones are none. Never rounded up to all.
    const measured = 1 - (marked - counts[SATURATED]) / frame.marks.length;
    byId("frame-measured").textContent = `${fixed(Math.floor(measured * 1000) / 10, 1)} %`;
    byId("frame-marked").textContent = `${marked} of ${frame.marks.length}`;
    byId("frame-mark-text").textContent = counts.flatMap((count, code) => (code > 0 && count > 0 ? [`${count} ${markOf(code).word}`] : [])).join(", ");
    const lines = badLines.rows.length + badLines.columns.length;
    byId("frame-lines").textContent = lines === 0 ? "none" : [listed("row", badLines.rows), listed("col", badLines.columns)].filter(Boolean).join("; ");
  }
}

function listed(word, numbers) {
  if (numbers.length === 0) return "";
  const shown = numbers.slice(0, 4).join(", ");
  return `${word} ${shown}${numbers.length > 4 ? ` +${numbers.length - 4}` : ""}`;
}

// What a frame itself says of a taxel, in the words of a detail.
function ofFrame(frame, at) {
  return {
    sequence: frame.sequence, load: frame.compensated[at], raw: frame.raw[at], counts: frame.counts[at],
    mark: frame.marks[at], siemens: NaN, standard_error_newtons: null,
  };
}

// Only where it means something: the server gives none for taxels that are not measured or not resolved.
function uncertainty(one, factor, decimals) {
  if (one.standard_error_newtons === null) return "";
  const error = one.standard_error_newtons * factor;
  if (!Number.isFinite(error)) return "";
  const least = 10 ** -decimals;
  return error < least / 2 ? ` ± <${fixed(least, decimals)}` : ` ± ${fixed(error, decimals)}`;
}

const orNull = (value) => (value === value ? value : null);
