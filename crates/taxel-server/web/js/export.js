// Saving what is seen: the view as a picture, the selection over time or the shown frame as a table.

import { evened } from "./areas.js";
import { MARGIN } from "./furniture.js";
import { boxesOf, taxelsAt } from "./regions.js";
import { measure, slotThreshold } from "./selection.js";
import { slotValue } from "./buffer.js";
import { loadFactor, forceUnit, pressureUnit, fixed, decimalsFor, clockText } from "./units.js";
import { byId, contextOf } from "./dom.js";
import { theme } from "./theme.js";
import { isTared } from "./wire.js";

const FONT = "system-ui, -apple-system, 'Segoe UI', Roboto, sans-serif";

/**
 * What is saved from.
 * @typedef {object} Source
 * @property {import("./view.js").View} view
 * @property {import("./settings.js").Settings} settings
 * @property {import("./history.js").History} history
 * @property {import("./selection.js").Selection} selection
 * @property {import("./stage.js").Stage} stage
 */
/** @typedef {{ sensor: Wire.SensorFacts, shown: Page.Frame }} Shown */

/**
 * @param {Source} source
 * @returns {Shown}
 */
function shownOf({ view }) {
  const { sensor } = view;
  const { shown } = view.now;
  if (!sensor || !shown) throw new Error("there is no frame");
  return { sensor, shown };
}

/**
 * @param {Shown} shown
 * @param {string} what
 * @param {string} ending
 */
function fileName({ sensor, shown }, what, ending) {
  const stamp = new Date(shown.host * 1000);
  const time = Number.isNaN(stamp.getTime()) ? "" : `_${stamp.toISOString().slice(0, 23).replace(/[:.]/g, "-")}`;
  return `taxel_${sensor.name.replace(/[^\w.-]+/g, "-")}${time}_${what}.${ending}`;
}

/**
 * @param {Blob | null} blob
 * @param {string} name
 */
function save(blob, name) {
  if (!blob) throw new Error("the browser makes no picture of that size");
  const link = document.createElement("a");
  link.href = URL.createObjectURL(blob);
  link.download = name;
  link.click();
  setTimeout(() => URL.revokeObjectURL(link.href), 10000);
  return name;
}

/**
 * The maps as they lie on the stage, with the colour bar, and a heading that says what it is.
 * @param {Source} source
 * @returns {Promise<string>} the name of the file
 */
export function savePicture(source) {
  const { stage, view } = source;
  const both = shownOf(source);
  const { shown, sensor } = both;
  const ratio = stage.ratio;
  const tiles = stage.shownTiles;
  const origin = byId("tiles").getBoundingClientRect();
  const pad = 20, head = 62, caption = 24;
  const boxes = tiles.map((tile) => tile.canvas.getBoundingClientRect());
  const wide = Math.max(...boxes.map((box) => box.right)) - origin.left;
  const high = Math.max(...boxes.map((box) => box.bottom)) - origin.top;
  const barCanvas = stage.bar.canvas;
  const barWide = barCanvas.width / ratio;
  const width = Math.max(520, Math.ceil(wide + barWide + 3 * pad));
  const height = Math.ceil(high + head + 2 * pad);
  const canvas = document.createElement("canvas");
  canvas.width = width * ratio;
  canvas.height = height * ratio;
  const g = contextOf(canvas);
  g.scale(ratio, ratio);
  g.fillStyle = theme.panel;
  g.fillRect(0, 0, width, height);
  g.textBaseline = "alphabetic";
  g.fillStyle = theme.ink;
  g.font = `600 17px ${FONT}`;
  g.fillText(sensor.name, pad, pad + 15);
  const when = new Date(shown.host * 1000);
  const facts = [
    `${when.toLocaleDateString("sv")} ${clockText(shown.host)}`, `frame ${shown.sequence}`,
    `method ${view.method}`, isTared(shown) ? "tared" : "not tared", view.unit.text,
  ];
  const force = forceUnit(view.unit);
  if (view.now.newtons) facts.push(`total ${fixed(shown.total * force.factor, decimalsFor(shown.total * force.factor))} ${force.text}`);
  g.fillStyle = theme.ink2;
  g.font = `13px ${FONT}`;
  g.fillText(facts.join("  ·  "), pad, pad + 37, width - 2 * pad);
  tiles.forEach((tile, i) => {
    const x = pad + boxes[i].left - origin.left;
    const y = pad + head - caption + boxes[i].top - origin.top;
    g.fillStyle = theme.ink;
    g.font = `600 13px ${FONT}`;
    g.fillText(tile.title.textContent || "", x + MARGIN.left, y - 4);
    for (const layer of [tile.inSurface ? tile.surfaceCanvas : null, tile.canvas]) {
      if (layer) g.drawImage(layer, x, y, boxes[i].width, boxes[i].height);
    }
  });
  g.drawImage(barCanvas, pad * 2 + wide, pad + head - caption, barWide, barCanvas.height / ratio);
  const name = fileName(both, "view", "png");
  return new Promise((resolve) => canvas.toBlob((blob) => resolve(blob), "image/png")).then((blob) => save(blob, name));
}

/**
 * Pins and regions over the buffered time; without any, the shown frame as a matrix.
 * @param {Source} source
 * @returns {Promise<string>} the name of the file
 */
export async function saveTable(source) {
  const both = shownOf(source);
  const table = source.selection.empty ? frameTable(source, both) : selectionTable(source, both);
  return save(new Blob([table.text], { type: "text/csv" }), fileName(both, table.what, "csv"));
}

/**
 * The regions as `taxel measure --regions` and a sensor file take them.
 * @param {Source} source
 * @returns {Promise<string>} the name of the file
 */
export async function saveRegions(source) {
  const both = shownOf(source);
  const { columns } = both.sensor;
  const tables = source.selection.regions.flatMap(({ name, taxels, windows }) => {
    if (windows.length === 0) return [regionTable(name, taxels, columns)];
    return windows.map((window) => `${regionTable(name, window.taxels, columns)}frames = [${window.frames.join(", ")}]\n`);
  });
  return save(new Blob([tables.join("\n")], { type: "application/toml" }), fileName(both, "regions", "toml"));
}

/**
 * @param {string} name
 * @param {number[]} taxels
 * @param {number} columns
 */
function regionTable(name, taxels, columns) {
  const boxes = boxesOf(taxels, columns).map((box) => `[${box.join(", ")}]`);
  return `[[region]]\nname = ${JSON.stringify(name)}\nboxes = [${boxes.join(", ")}]\n`;
}

/**
 * @param {Source} source
 * @param {Shown} both
 */
function frameTable({ view, settings }, { sensor, shown }) {
  const { unit } = view;
  const isRaw = settings.values.layout === "raw";
  const loads = isRaw ? shown.raw : shown.compensated;
  const values = evened(loads, sensor, unit, new Float32Array(loads.length));
  const factor = loadFactor(unit, sensor.taxel_area_mm2);
  const lines = [[`row\\column (${unit.key})`, ...Array.from({ length: sensor.columns }, (_, column) => column)].join(",")];
  for (let row = 0; row < sensor.rows; row += 1) {
    /** @type {(string | number)[]} */
    const cells = [row];
    for (let column = 0; column < sensor.columns; column += 1) cells.push(cell(values[row * sensor.columns + column] * factor));
    lines.push(cells.join(","));
  }
  const what = `frame-${shown.sequence}-${isRaw ? "raw" : view.method}-${unit.key.replace("/", "per")}`;
  return { what, text: `${lines.join("\n")}\n` };
}

/**
 * @param {Source} source
 * @param {Shown} both
 */
function selectionTable({ view, history, selection }, { sensor }) {
  const { buffer } = history;
  const { unit } = view;
  const { newtons } = view.now;
  const force = newtons ? forceUnit(unit) : unit;
  const pressure = newtons ? pressureUnit(unit) : unit;
  const perTaxel = loadFactor(pressure, sensor.taxel_area_mm2);
  const head = ["host_time_s", "device_time_s", "sequence"];
  for (const item of selection.items) {
    if (item.letter === "P") {
      const name = `${item.label} row ${item.row} column ${item.column}`;
      head.push(`${name} load (${force.key})`, `${name} raw load (${force.key})`, `${name} counts`);
    } else {
      const name = item.windows.length > 0 ? `${item.name} ${item.shape}` : `${item.name} ${item.shape} ${item.taxels.length} taxels`;
      head.push(...[`force (${force.key})`, `peak (${pressure.key})`, `mean (${pressure.key})`, "area (mm2)"].map((what) => quoted(`${name} ${what}`)));
    }
  }
  const lines = [head.join(",")];
  const values = new Float32Array(buffer.taxels);
  const numbers = { force: 0, peak: 0, mean: 0, area: 0 };
  for (let i = 0; i < buffer.length; i += 1) {
    const slot = buffer.at(i);
    const cells = [slot.host.toFixed(6), Number.isFinite(slot.device) ? slot.device.toFixed(6) : "", slot.sequence];
    if (selection.regions.length > 0 && !(slot.threshold >= 0)) slot.threshold = slotThreshold(slot, sensor);
    for (const item of selection.items) {
      const taxels = taxelsAt(item, slot.sequence);
      for (const taxel of taxels) values[taxel] = slotValue(slot.compensated[taxel], slot.compensatedRange);
      const at = item.taxels[0];
      if (item.letter === "P") {
        cells.push(cell(values[at] * force.factor), cell(slotValue(slot.raw[at], slot.rawRange) * force.factor), slot.counts[at]);
      } else {
        measure(taxels, values, slot.threshold, sensor, numbers);
        cells.push(cell(numbers.force * force.factor), cell(numbers.peak * perTaxel), cell(numbers.mean * perTaxel), cell(numbers.area));
      }
    }
    lines.push(cells.join(","));
  }
  return { what: "selection", text: `${lines.join("\n")}\n` };
}

/**
 * A name may hold commas and quotation marks.
 * @param {string} text
 */
const quoted = (text) => (/[",\n]/.test(text) ? `"${text.replaceAll('"', '""')}"` : text);

/**
 * Six digits are more than the sensor has, and keep the file small.
 * @param {number} value
 */
const cell = (value) => (Number.isFinite(value) ? String(Number(value.toPrecision(6))) : "");
