// The side panel: the picked taxel with its last 30 s, pins and regions, and the frame as a whole.

import { TimeChart } from "./timechart.js";
import { markOf, MARKS } from "./wire.js";
import { slotValue } from "./buffer.js";
import { contactThreshold, measure } from "./selection.js";
import { theme } from "./theme.js";
import { fixed, decimalsFor, significant, siemens, areaText, forceUnit, pressureUnit, loadFactor } from "./units.js";

const CHART_SECONDS = 30;
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
      return;
    }
    const { row, column } = picked;
    const at = row * sensor.columns + column;
    const force = forceUnit(unit);
    const detail = this.detail(row, column);
    byId("taxel-title").textContent = `Taxel row ${row}, column ${column}`;
    const mark = markOf(frame.marks[at]);
    badge.textContent = mark.word;
    badge.dataset.severity = mark.severity;
    byId("taxel-mark-text").textContent = mark.severity ? mark.text : "";

    const decimals = this.loadDecimals(force.factor);
    const error = detail && detail.standard_error_newtons !== null ? detail.standard_error_newtons * force.factor : NaN;
    const load = fixed(frame.compensated[at] * force.factor, decimals);
    byId("taxel-load").textContent = newtons && Number.isFinite(error) ? `${load} ± ${fixed(error, decimals)} ${force.text}` : `${load} ${force.text}`;
    const pressure = pressureUnit(unit);
    const perTaxel = loadFactor(pressure, sensor.taxel_area_mm2);
    byId("taxel-pressure").textContent = newtons ? `${fixed(frame.compensated[at] * perTaxel, this.loadDecimals(perTaxel))} ${pressure.text}` : "–";
    byId("taxel-raw").textContent = `${fixed(frame.raw[at] * force.factor, decimals)} ${force.text}`;
    byId("taxel-crosstalk").textContent = `${fixed((frame.raw[at] - frame.compensated[at]) * force.factor, decimals)} ${force.text}`;
    byId("taxel-siemens").textContent = siemens(newtons ? (detail ? detail.siemens : NaN) : frame.compensated[at]);
    byId("taxel-counts").textContent = `${frame.counts[at]} / ${sensor.max_count}`;
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
    for (let i = buffer.indexAt(end - CHART_SECONDS); i < buffer.length; i += 1) {
      const slot = buffer.at(i);
      if (slot.host > end) break;
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
    const threshold = hasRegions ? contactThreshold(frame.compensated, frame.area / sensor.taxel_area_mm2) : Infinity;
    const numbers = {};
    const decimals = this.loadDecimals(force.factor);
    for (const item of items) {
      if (!this.rows.has(item)) this.rows.set(item, this.makeRow(item));
      const row = this.rows.get(item);
      measure(item.taxels, frame.compensated, threshold, sensor, numbers);
      if (item.letter === "P") {
        row.force.textContent = `${fixed(numbers.force * force.factor, decimals)} ${force.text}`;
        const detail = this.detail(item.row, item.column);
        const raw = frame.raw[item.taxels[0]];
        row.more.textContent = `raw ${fixed(raw * force.factor, decimals)} ${force.text}${detail ? `, ${siemens(detail.siemens)}` : ""}`;
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

const orNull = (value) => (value === value ? value : null);
