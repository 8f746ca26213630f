// The side panel: the picked taxel with its last 30 s, pins and regions, and the frame as a whole.

import { taxelArea } from "./areas.js";
import { layoutOf } from "./places.js";
import { TimeChart, longestStep } from "./timechart.js";
import { slotValue } from "./buffer.js";
import { DETAILS_VALID_MS } from "./figures.js";
import { MAX_NAME, taxelsAt } from "./regions.js";
import { contactThreshold, measure } from "./selection.js";
import { byId, inside, onClick, write } from "./dom.js";
import { theme } from "./theme.js";
import { fixed, decimalsFor, plusMinus, significant, siemens, areaText, forceUnit, pressureUnit, loadFactor } from "./units.js";

const CHART_SECONDS = 30;
const DESCRIBE_EVERY_MS = 1000;

export class Panel {
  /**
   * @param {object} parts
   * @param {import("./view.js").View} parts.view
   * @param {import("./history.js").History} parts.history
   * @param {import("./selection.js").Selection} parts.selection
   * @param {import("./scale.js").Scale} parts.scale
   * @param {() => number} parts.forceDecimals
   * @param {(time: number) => void} parts.goTo shows the frame of that time
   */
  constructor({ view, history, selection, scale, forceDecimals, goTo }) {
    this.view = view;
    this.history = history;
    this.selection = selection;
    this.scale = scale;
    this.forceDecimals = forceDecimals;
    this.chart = new TimeChart(byId("taxel-chart"), [
      { colour: () => theme.raw, dash: [4, 3] },
      { colour: () => theme.comp },
    ], { onClick: goTo });
    /** @type {Map<string, Wire.TaxelDetails>} */
    this.details = new Map();
    this.detailsAt = 0;
    this.describedAt = -Infinity;
    /** The load of the picked taxel as it is shown. */
    this.load = "";
    /** @type {Map<Page.Item, { element: HTMLElement, force: HTMLElement, more: HTMLElement, what: string }>} */
    this.rows = new Map();
    onClick("clear-selection", () => {
      selection.clear();
      // The button goes away with what it cleared.
      byId("selection-panel").focus();
    });
    view.on(["picked"], () => this.update());
    selection.onChange(() => this.update());
  }

  /** @param {Wire.Details} details */
  takeDetails(details) {
    this.details.clear();
    for (const taxel of details.taxels) this.details.set(`${taxel.row} ${taxel.column}`, taxel);
    this.detailsAt = performance.now();
  }

  /**
   * @param {number} row
   * @param {number} column
   */
  detail(row, column) {
    if (this.view.now.paused || performance.now() - this.detailsAt > DETAILS_VALID_MS) return null;
    return this.details.get(`${row} ${column}`) || null;
  }

  update() {
    const { shown } = this.view.now;
    const { sensor } = this.view;
    if (!shown || !sensor) return;
    this.updateTaxel(shown, sensor);
    this.updateSelection(shown, sensor);
    this.updateFrame(shown);
  }

  /**
   * Of a taxel's load: from the size of the scale, or the digits would jump with the value.
   * @param {number} factor
   * @param {Wire.SensorFacts} sensor
   */
  loadDecimals(factor, sensor) {
    return decimalsFor((this.scale.top / loadFactor(this.view.unit, sensor.taxel_area_mm2)) * factor, 4);
  }

  /**
   * @param {Page.Frame} frame
   * @param {Wire.SensorFacts} sensor
   */
  updateTaxel(frame, sensor) {
    const { unit } = this.view;
    const { picked, newtons, marks } = this.view.now;
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
    const mark = marks.of(one.mark);
    badge.textContent = mark.word;
    badge.dataset.severity = String(mark.severity);
    byId("taxel-mark-text").textContent = mark.severity ? mark.text : "";

    const decimals = this.loadDecimals(force.factor, sensor);
    const load = fixed(one.load * force.factor, decimals);
    const half = one.half_width_95_newtons;
    const error = newtons && half !== null ? plusMinus(half * force.factor, decimals) : "";
    const only = error && one.noise_only ? " (noise only)" : "";
    this.load = `${load}${error} ${force.text}${only}`;
    byId("taxel-load").textContent = this.load;
    const pressure = pressureUnit(unit);
    const perTaxel = loadFactor(pressure, taxelArea(sensor, at));
    byId("taxel-pressure").textContent = newtons ? `${fixed(one.load * perTaxel, this.loadDecimals(perTaxel, sensor))} ${pressure.text}` : "–";
    byId("taxel-raw").textContent = `${fixed(one.raw * force.factor, decimals)} ${force.text}`;
    byId("taxel-crosstalk").textContent = `${fixed((one.raw - one.load) * force.factor, decimals)} ${force.text}`;
    // Of numbers of another program nobody knows what conducted.
    const conductance = newtons ? one.siemens ?? NaN : one.load;
    byId("taxel-siemens").textContent = this.view.exported ? "–" : siemens(conductance);
    byId("taxel-counts").textContent = `${one.counts} / ${sensor.max_count}`;
    this.drawTaxel(frame, at, force);
  }

  /**
   * The buffer holds the past of every taxel, so a taxel just pointed at has its 30 s at once.
   * @param {Page.Frame} shown
   * @param {number} at
   * @param {Page.Unit} unit
   */
  drawTaxel(shown, at, unit) {
    const { paused } = this.view.now;
    const { buffer, events } = this.history;
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
    this.chart.update(end, CHART_SECONDS, events, paused ? shown.host : NaN);
    this.describeTaxel(unit);
  }

  /** @param {Page.Unit} unit */
  describeTaxel(unit) {
    const now = performance.now();
    if (now - this.describedAt < DESCRIBE_EVERY_MS) return;
    this.describedAt = now;
    this.chart.describe("Load of the taxel", [unit.text, unit.text], ["raw", "compensated"]);
  }

  /**
   * @param {Page.Frame} frame
   * @param {Wire.SensorFacts} sensor
   */
  updateSelection(frame, sensor) {
    const { selection } = this;
    const { unit } = this.view;
    const { newtons } = this.view.now;
    const items = selection.items;
    byId("selection-empty").hidden = items.length > 0;
    byId("clear-selection").hidden = items.length === 0;
    byId("save-regions").hidden = !items.some((item) => item.letter === "R");
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
    const threshold = hasRegions ? contactThreshold(frame.compensated, frame.area, sensor) : Infinity;
    const numbers = { force: 0, peak: 0, mean: 0, area: 0 };
    const decimals = this.loadDecimals(force.factor, sensor);
    for (const item of items) {
      const row = this.rows.get(item) || this.makeRow(item);
      this.rows.set(item, row);
      const taxels = taxelsAt(item, frame.sequence);
      measure(taxels, frame.compensated, threshold, sensor, numbers);
      if (taxels.length === 0) {
        row.force.textContent = "–";
        row.more.textContent = `${row.what}: nowhere in this frame`;
      } else if (item.letter === "P") {
        row.force.textContent = `${fixed(numbers.force * force.factor, decimals)} ${force.text}`;
        const raw = frame.raw[item.taxels[0]];
        row.more.textContent = `raw ${fixed(raw * force.factor, decimals)} ${force.text}`;
      } else {
        row.force.textContent = `${fixed(numbers.force * force.factor, this.forceDecimals())} ${force.text}`;
        row.more.textContent = `${row.what}, peak ${significant(numbers.peak * factor)}, mean ${significant(numbers.mean * factor)} ${pressure.text}, ${areaText(numbers.area)}`;
      }
    }
  }

  /** @param {Page.Item} item */
  makeRow(item) {
    const element = document.createElement("li");
    element.innerHTML = '<i class="swatch" aria-hidden="true"></i><span class="name"></span><span class="force num"></span><button type="button" class="remove">×</button><span class="problem" role="alert" hidden></span><span class="more num"></span>';
    const swatch = inside(element, ".swatch");
    swatch.style.background = item.colour;
    swatch.textContent = item.label;
    const what = item.letter === "P" ? `row ${item.row}, col ${item.column}` : whatOf(item);
    const remove = inside(element, ".remove");
    const nameRemove = () => remove.setAttribute("aria-label", `Remove ${item.label}, ${item.letter === "P" || item.name === item.label ? what : item.name}`);
    nameRemove();
    remove.addEventListener("click", () => this.remove(item));
    if (item.letter === "P") inside(element, ".name").textContent = what;
    else inside(element, ".name").replaceWith(this.nameField(item, inside(element, ".problem"), nameRemove));
    byId("selection-list").append(element);
    return { element, force: inside(element, ".force"), more: inside(element, ".more"), what };
  }

  /**
   * Where a region gets its name: taken when the field is left or Enter is pressed, given back by Escape.
   * @param {Page.Region} region
   * @param {HTMLElement} problem where it is said why a name is refused
   * @param {() => void} onRenamed
   */
  nameField(region, problem, onRenamed) {
    const field = document.createElement("input");
    field.type = "text";
    field.className = "name";
    field.maxLength = MAX_NAME;
    field.value = region.name;
    field.spellcheck = false;
    field.autocomplete = "off";
    field.setAttribute("aria-label", `Name of region ${region.label}`);
    problem.id = `region-problem-${region.number}`;
    /** @param {string} words */
    const refuse = (words) => {
      problem.hidden = words === "";
      write(problem, words === "" ? "" : `${words} It is still “${region.name}”.`);
      if (words === "") field.removeAttribute("aria-describedby");
      else field.setAttribute("aria-describedby", problem.id);
      field.setAttribute("aria-invalid", String(words !== ""));
    };
    field.addEventListener("change", () => {
      const words = this.selection.rename(region, field.value);
      refuse(words);
      if (words !== "") return;
      field.value = region.name;
      onRenamed();
      write("announce", `${region.label} is called ${region.name}`);
    });
    field.addEventListener("keydown", (event) => {
      if (event.key !== "Escape") return;
      field.value = region.name;
      refuse("");
    });
    return field;
  }

  /**
   * Whoever has the focus in the list keeps a place there.
   * @param {Page.Item} item
   */
  remove(item) {
    const at = this.selection.items.indexOf(item);
    this.selection.remove(item);
    const next = this.selection.items[Math.min(at, this.selection.items.length - 1)];
    const row = next && this.rows.get(next);
    (row ? inside(row.element, ".remove") : byId("selection-panel")).focus();
  }

  /** @param {Page.Frame} frame */
  updateFrame(frame) {
    const { badLines, marks } = this.view.now;
    byId("frame-sequence").textContent = `no. ${frame.sequence}`;
    const centred = Number.isFinite(frame.copRow) && Number.isFinite(frame.copColumn);
    const { sensor } = this.view;
    const [down, across] = sensor && layoutOf(sensor).owners ? sensor.pitch_mm : [0, 0];
    byId("frame-cop").textContent = centred && down > 0 ? `x ${fixed(frame.copColumn * across, 0)}, y ${fixed(frame.copRow * down, 0)} mm` : centred ? `row ${fixed(frame.copRow, 1)}, col ${fixed(frame.copColumn, 1)}` : "none";
    byId("frame-outliers").textContent = `${fixed(frame.outliers * 100, 1)} %`;
    const counts = new Array(256).fill(0);
    let marked = 0;
    let taxels = 0;
    for (let i = 0; i < frame.marks.length; i += 1) {
      if (frame.marks[i] === marks.absent) continue;
      taxels += 1;
      if (frame.marks[i] === 0) continue;
      marked += 1;
      counts[frame.marks[i]] += 1;
    }
    // Saturated readings and those below the floor are bounds, but readings; interpolated ones are none. Never rounded up to all.
    const bounds = (counts[marks.saturated] || 0) + (counts[marks.belowFloor] || 0);
    const measured = 1 - (marked - bounds) / Math.max(1, taxels);
    byId("frame-measured").textContent = `${fixed(Math.floor(measured * 1000) / 10, 1)} %`;
    byId("frame-marked").textContent = `${marked} of ${taxels}`;
    byId("frame-mark-text").textContent = counts.flatMap((count, code) => (code > 0 && count > 0 ? [`${count} ${marks.of(code).word}`] : [])).join(", ");
    const known = [listed("row", badLines.rows), listed("col", badLines.columns)];
    const suspects = [listed("row", badLines.suspect_rows), listed("col", badLines.suspect_columns)];
    byId("frame-lines").textContent = [...known, ...suspects.map((lines) => lines && `${lines} may be dead`)].filter(Boolean).join("; ") || "none";
  }
}

/**
 * @param {string} word
 * @param {number[]} numbers
 */
function listed(word, numbers) {
  if (numbers.length === 0) return "";
  const shown = numbers.slice(0, 4).join(", ");
  return `${word} ${shown}${numbers.length > 4 ? ` +${numbers.length - 4}` : ""}`;
}

/**
 * What a frame itself says of a taxel, in the words of a detail.
 * @param {Page.Frame} frame
 * @param {number} at
 */
function ofFrame(frame, at) {
  return {
    sequence: frame.sequence, load: frame.compensated[at], raw: frame.raw[at], counts: frame.counts[at],
    mark: frame.marks[at], siemens: NaN, half_width_95_newtons: null,
    noise_only: false,
  };
}

/** @param {number} value */
const orNull = (value) => (value === value ? value : null);

/**
 * How a region came about; one that moves has more taxels in one frame than in another.
 * @param {Page.Region} region
 */
const whatOf = ({ shape, windows, taxels }) => (windows.length > 0 ? shape : `${shape}, ${taxels.length} taxels`);
