// Pinned taxels and regions: their taxels, and their numbers over time. A pin is a region of one taxel.

import { Series } from "./series.js";
import { SELECTION_COLOURS } from "./colour.js";
import { slotValue } from "./buffer.js";
import { cellArea, evening, taxelArea } from "./areas.js";
import { layoutOf } from "./places.js";
import { nameProblem, outlinesOf, taxelsAt, taxelsOf } from "./regions.js";

export const MAX_PINS = 8;
export const MAX_REGIONS = 24;
/** @type {(keyof Page.Measures)[]} */
const NAMES = ["force", "peak", "mean", "area"];

/** @typedef {{ buffer: import("./buffer.js").FrameBuffer, sensor: Wire.SensorFacts }} Context */

export class Selection {
  constructor() {
    /** @type {(() => void)[]} */
    this.listeners = [];
    /** @type {Page.Pin[]} */
    this.pins = [];
    /** @type {Page.Region[]} */
    this.regions = [];
    this.scratch = { force: 0, peak: 0, mean: 0, area: 0 };
  }

  /** @param {() => void} listener */
  onChange(listener) {
    this.listeners.push(listener);
  }

  announce() {
    for (const listener of this.listeners) listener();
  }

  /** @returns {Page.Item[]} */
  get items() {
    return [...this.pins, ...this.regions];
  }

  get empty() {
    return this.pins.length + this.regions.length === 0;
  }

  clear() {
    this.pins = [];
    this.regions = [];
    this.announce();
  }

  /** Forgets the numbers of before, not the items. */
  forget() {
    for (const item of this.items) item.series.clear();
  }

  /**
   * Pins the taxel, or takes its pin away. Returns what was done.
   * @param {Page.Taxel} taxel
   * @param {Context} context
   */
  togglePin({ row, column }, context) {
    const at = this.pins.findIndex((pin) => pin.row === row && pin.column === column);
    if (at >= 0) {
      this.pins.splice(at, 1);
      this.announce();
      return "removed";
    }
    if (this.pins.length >= MAX_PINS) return "full";
    const facts = makeItem(this.pins, SELECTION_COLOURS, "P", [row * context.sensor.columns + column]);
    this.pins.push(withPast({ letter: "P", row, column, ...facts }, context));
    this.announce();
    return "pinned";
  }

  /**
   * A taxel belongs if its centre is inside.
   * @param {string} shape
   * @param {Page.Corner[]} corners a closed outline
   * @param {Context} context
   */
  addRegion(shape, corners, context) {
    const taxels = inside(corners, context.sensor);
    if (taxels.length === 0) return "empty";
    if (this.regions.length >= MAX_REGIONS) return "full";
    this.pushRegion("", shape, { taxels, outlines: [corners], windows: [] }, context);
    this.announce();
    return "added";
  }

  /**
   * Regions that are known already, of the sensor file or of another. Returns how many there was no room for.
   * @param {Wire.RegionFacts[]} known
   * @param {Context} context
   */
  addKnown(known, context) {
    const { sensor } = context;
    const room = known.slice(0, MAX_REGIONS - this.regions.length);
    /** @param {number[][]} boxes */
    const placeOf = (boxes) => {
      const taxels = taxelsOf(boxes, sensor.columns);
      return { taxels, outlines: outlinesOf(taxels, sensor) };
    };
    for (const { name, boxes, windows } of room) {
      const places = windows.map((window) => ({ frames: window.frames, ...placeOf(window.boxes) }));
      this.pushRegion(name, windows.length > 0 ? "of a file, moving" : "of a file", { ...placeOf(boxes), windows: places }, context);
    }
    if (room.length > 0) this.announce();
    return known.length - room.length;
  }

  /**
   * @param {string} name none: as its label, or as the first that is free
   * @param {string} shape
   * @param {Page.Place & { windows: Page.RegionWindow[] }} place
   * @param {Context} context
   */
  pushRegion(name, shape, { taxels, outlines, windows }, context) {
    // Regions take the colours from the other end, so that a first pin and a first region differ.
    const facts = makeItem(this.regions, [...SELECTION_COLOURS].reverse(), "R", taxels);
    const others = this.regions.map((region) => region.name);
    let own = name || facts.label;
    for (let again = 2; nameProblem(own, others) !== ""; again += 1) own = `${name || facts.label} ${again}`;
    this.regions.push(withPast({ letter: "R", name: own, shape, outlines, windows, ...facts }, context));
  }

  /**
   * Returns why not, in words; empty where it is done.
   * @param {Page.Region} region
   * @param {string} name
   */
  rename(region, name) {
    const others = this.regions.filter((other) => other !== region);
    const problem = nameProblem(name, others.map((other) => other.name));
    if (problem !== "") return problem;
    region.name = name.trim();
    this.announce();
    return "";
  }

  /** @param {Page.Item} item */
  remove(item) {
    this.pins = this.pins.filter((pin) => pin !== item);
    this.regions = this.regions.filter((region) => region !== item);
    this.announce();
  }

  /**
   * @param {Page.Frame} frame
   * @param {Wire.SensorFacts} sensor
   */
  takeFrame(frame, sensor) {
    if (this.empty) return;
    const threshold = contactThreshold(frame.compensated, frame.area, sensor);
    for (const list of [this.pins, this.regions]) {
      for (const item of list) {
        measure(taxelsAt(item, frame.sequence), frame.compensated, threshold, sensor, this.scratch);
        item.series.push(frame.host, this.scratch);
      }
    }
  }
}

/**
 * What an item is called.
 * @param {Page.Item} item
 */
export const titleOf = (item) => (item.letter === "R" ? item.name : item.label);

/**
 * @param {Page.ItemFacts[]} list those of its kind that there are
 * @param {string[]} colours
 * @param {"P" | "R"} letter
 * @param {number[]} taxels
 * @returns {Page.ItemFacts}
 */
function makeItem(list, colours, letter, taxels) {
  const used = new Set(list.map((item) => item.number));
  let number = 1;
  while (used.has(number)) number += 1;
  return { number, label: `${letter}${number}`, colour: colours[(number - 1) % colours.length], taxels, series: new Series(NAMES) };
}

/**
 * Of one set of taxels: sum, highest and mean of the loads, and the area in contact. Mean and peak are loads per taxel,
 * in the unit the loads arrive in; where taxels differ, on one of the widest ring by the same pressure. Of no taxel nothing is known.
 * @param {number[]} taxels
 * @param {Float32Array} values
 * @param {number} threshold
 * @param {Wire.SensorFacts} sensor
 * @param {Page.Measures} into
 */
export function measure(taxels, values, threshold, sensor, into) {
  let force = 0;
  let peak = -Infinity;
  let touched = 0;
  let area = 0;
  for (let i = 0; i < taxels.length; i += 1) {
    const taxel = taxels[i];
    area += taxelArea(sensor, taxel);
    const value = values[taxel];
    if (value !== value) continue;
    force += value;
    const even = value * evening(sensor, taxel);
    if (even > peak) peak = even;
    if (value > threshold) touched += cellArea(sensor, taxel);
  }
  into.force = taxels.length > 0 ? force : NaN;
  into.peak = peak === -Infinity ? NaN : peak;
  into.mean = sensor.has_load_law ? (force / area) * sensor.taxel_area_mm2 : force / taxels.length;
  into.area = taxels.length > 0 ? touched : NaN;
  return into;
}

/**
 * The server says how large the contact is, not from which load on. The load that leaves taxels of as large an area above it is
 * found here, so that the areas of regions add up to the area of the whole.
 * @param {Float32Array} values
 * @param {number} area mm2
 * @param {Wire.SensorFacts} sensor
 */
export function contactThreshold(values, area, sensor) {
  if (!(area > 0)) return Infinity;
  // The narrowest cell is far more than half of this.
  const enough = area + 0.1 * sensor.cell_area_mm2;
  let low = 0;
  let high = 0;
  for (let i = 0; i < values.length; i += 1) if (values[i] > high) high = values[i];
  for (let step = 0; step < 18; step += 1) {
    const middle = (low + high) / 2;
    let above = 0;
    for (let i = 0; i < values.length; i += 1) if (values[i] > middle) above += cellArea(sensor, i);
    if (above > enough) low = middle;
    else high = middle;
  }
  return high;
}

/**
 * A new item with its past, from the buffered frames.
 * @template {Page.Item} T
 * @param {T} item
 * @param {Context} context
 */
function withPast(item, { buffer, sensor }) {
  const values = new Float32Array(buffer.taxels);
  const scratch = { force: 0, peak: 0, mean: 0, area: 0 };
  for (let i = 0; i < buffer.length; i += 1) {
    const slot = buffer.at(i);
    const taxels = taxelsAt(item, slot.sequence);
    for (const taxel of taxels) values[taxel] = slotValue(slot.compensated[taxel], slot.compensatedRange);
    if (!(slot.threshold >= 0)) slot.threshold = slotThreshold(slot, sensor);
    measure(taxels, values, slot.threshold, sensor, scratch);
    item.series.push(slot.host, scratch);
  }
  return item;
}

let unpacked = new Float32Array(0);

/**
 * @param {Page.Slot} slot
 * @param {Wire.SensorFacts} sensor
 */
export function slotThreshold(slot, sensor) {
  if (unpacked.length !== slot.compensated.length) unpacked = new Float32Array(slot.compensated.length);
  for (let i = 0; i < unpacked.length; i += 1) unpacked[i] = slotValue(slot.compensated[i], slot.compensatedRange);
  return contactThreshold(unpacked, slot.area, sensor);
}

/**
 * @param {Page.Corner[]} corners
 * @param {Wire.SensorFacts} sensor
 */
function inside(corners, sensor) {
  const layout = layoutOf(sensor);
  const taxels = [];
  for (let taxel = 0; taxel < sensor.rows * sensor.columns; taxel += 1) {
    if (holds(corners, ...layout.centre(taxel))) taxels.push(taxel);
  }
  return taxels;
}

/**
 * Even-odd rule: how many edges lie to the right of the point.
 * @param {Page.Corner[]} corners
 * @param {number} x
 * @param {number} y
 */
function holds(corners, x, y) {
  let within = false;
  for (let i = 0, j = corners.length - 1; i < corners.length; j = i, i += 1) {
    const [xi, yi] = corners[i];
    const [xj, yj] = corners[j];
    if (yi > y !== yj > y && x < ((xj - xi) * (y - yi)) / (yj - yi) + xi) within = !within;
  }
  return within;
}
