// Pinned taxels and regions: their taxels, and their numbers over time. A pin is a region of one taxel.

import { Series } from "./series.js";
import { SELECTION_COLOURS } from "./colour.js";
import { slotValue } from "./buffer.js";

export const MOST_PINS = 8;
export const MOST_REGIONS = 8;
const NAMES = ["force", "peak", "mean", "area"];

export class Selection {
  constructor(onChange) {
    this.onChange = onChange;
    this.pins = [];
    this.regions = [];
    this.scratch = { force: 0, peak: 0, mean: 0, area: 0 };
  }

  get items() {
    return [...this.pins, ...this.regions];
  }

  get empty() {
    return this.pins.length + this.regions.length === 0;
  }

  clear() {
    this.pins = [];
    this.regions = [];
    this.onChange();
  }

  // Pins the taxel, or takes its pin away. Returns what was done.
  togglePin(row, column, context) {
    const at = this.pins.findIndex((pin) => pin.row === row && pin.column === column);
    if (at >= 0) {
      this.pins.splice(at, 1);
      this.onChange();
      return "removed";
    }
    if (this.pins.length >= MOST_PINS) return "full";
    const pin = this.make(this.pins, "P", [row * context.sensor.columns + column], context);
    pin.row = row;
    pin.column = column;
    this.onChange();
    return "pinned";
  }

  // `corners` is a closed outline of [column, row] in taxels; a taxel belongs if its centre is inside.
  addRegion(shape, corners, context) {
    const { rows, columns } = context.sensor;
    const taxels = inside(corners, rows, columns);
    if (taxels.length === 0) return "empty";
    if (this.regions.length >= MOST_REGIONS) return "full";
    const region = this.make(this.regions, "R", taxels, context);
    region.shape = shape;
    region.corners = corners;
    this.onChange();
    return "added";
  }

  remove(item) {
    this.pins = this.pins.filter((pin) => pin !== item);
    this.regions = this.regions.filter((region) => region !== item);
    this.onChange();
  }

  make(list, letter, taxels, { buffer, sensor }) {
    const used = new Set(list.map((item) => item.number));
    let number = 1;
    while (used.has(number)) number += 1;
    // Regions take the colours from the other end, so that a first pin and a first region differ.
    const colours = letter === "P" ? SELECTION_COLOURS : [...SELECTION_COLOURS].reverse();
    const item = { letter, number, label: `${letter}${number}`, colour: colours[(number - 1) % colours.length], taxels, series: new Series(NAMES) };
    fill(item, buffer, sensor);
    list.push(item);
    return item;
  }

  takeFrame(frame, sensor) {
    if (this.empty) return;
    const threshold = contactThreshold(frame.compensated, frame.area / cellArea(sensor));
    for (const list of [this.pins, this.regions]) {
      for (const item of list) {
        measure(item.taxels, frame.compensated, threshold, sensor, this.scratch);
        item.series.push(frame.host, this.scratch);
      }
    }
  }
}

// The area that a taxel stands for, as the server counts contact: its cell, mm2.
export const cellArea = (sensor) => sensor.pitch_mm[0] * sensor.pitch_mm[1];

// Of one set of taxels: sum, highest and mean of the loads, and the area in contact. Mean and peak are
// loads per taxel, in the unit the loads arrive in.
export function measure(taxels, values, threshold, sensor, into) {
  let force = 0;
  let peak = -Infinity;
  let touched = 0;
  for (let i = 0; i < taxels.length; i += 1) {
    const value = values[taxels[i]];
    if (value !== value) continue;
    force += value;
    if (value > peak) peak = value;
    if (value > threshold) touched += 1;
  }
  into.force = force;
  into.peak = peak === -Infinity ? NaN : peak;
  into.mean = force / taxels.length;
  into.area = touched * cellArea(sensor);
  return into;
}

// The server says how large the contact is, not from which load on. The load that leaves as many taxels
// above it is found here, so that the areas of regions add up to the area of the whole.
export function contactThreshold(values, count) {
  if (!(count > 0)) return Infinity;
  let low = 0;
  let high = 0;
  for (let i = 0; i < values.length; i += 1) if (values[i] > high) high = values[i];
  for (let step = 0; step < 18; step += 1) {
    const middle = (low + high) / 2;
    let above = 0;
    for (let i = 0; i < values.length; i += 1) if (values[i] > middle) above += 1;
    if (above > count + 0.5) low = middle;
    else high = middle;
  }
  return high;
}

// The past of a new item, from the buffered frames.
function fill(item, buffer, sensor) {
  const values = new Float32Array(buffer.taxels);
  const scratch = {};
  for (let i = 0; i < buffer.length; i += 1) {
    const slot = buffer.at(i);
    for (const taxel of item.taxels) values[taxel] = slotValue(slot.compensated[taxel], slot.compensatedRange);
    if (!(slot.threshold >= 0)) slot.threshold = slotThreshold(slot, sensor);
    measure(item.taxels, values, slot.threshold, sensor, scratch);
    item.series.push(slot.host, scratch);
  }
}

let unpacked = new Float32Array(0);

export function slotThreshold(slot, sensor) {
  if (unpacked.length !== slot.compensated.length) unpacked = new Float32Array(slot.compensated.length);
  for (let i = 0; i < unpacked.length; i += 1) unpacked[i] = slotValue(slot.compensated[i], slot.compensatedRange);
  return contactThreshold(unpacked, slot.area / cellArea(sensor));
}

function inside(corners, rows, columns) {
  const taxels = [];
  for (let row = 0; row < rows; row += 1) {
    for (let column = 0; column < columns; column += 1) {
      if (holds(corners, column + 0.5, row + 0.5)) taxels.push(row * columns + column);
    }
  }
  return taxels;
}

// Even-odd rule: how many edges lie to the right of the point.
function holds(corners, x, y) {
  let within = false;
  for (let i = 0, j = corners.length - 1; i < corners.length; j = i, i += 1) {
    const [xi, yi] = corners[i];
    const [xj, yj] = corners[j];
    if (yi > y !== yj > y && x < ((xj - xi) * (y - yi)) / (yj - yi) + xi) within = !within;
  }
  return within;
}
