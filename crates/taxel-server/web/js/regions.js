// Named parts of the array: their names, their taxels as boxes, and where a map draws them.

import { layoutOf } from "./places.js";

export const MAX_NAME = 60;
/** Columns of a table of `taxel measure` that are there without any region. */
const TAKEN = ["total", "total_error", "grip", "grip_error", "resultant", "reference"];

/**
 * A name as the columns of a table begin with it: small letters, _ between words.
 * @param {string} name
 */
export const keyOf = (name) => name.trim().toLowerCase().replace(/[^\p{Alphabetic}\p{N}]/gu, "_");

/**
 * Why a region cannot be called so; empty where it can.
 * @param {string} name
 * @param {string[]} others what the other regions are called
 */
export function nameProblem(name, others) {
  const key = keyOf(name);
  if (key === "") return "A region needs a name.";
  if ([...name].length > MAX_NAME || /\p{Cc}/u.test(name)) return `A name has at most ${MAX_NAME} letters, and nothing but letters.`;
  const same = others.find((other) => keyOf(other) === key);
  if (same !== undefined) return `Another region is called “${same}”: capitals and signs make no difference.`;
  const beside = others.find((other) => keyOf(other) === `${key}_error` || `${keyOf(other)}_error` === key);
  if (beside !== undefined) return `Beside “${beside}” a table would have the same column for both.`;
  if (TAKEN.includes(key)) return `“${name.trim()}” is what taxel measure calls a force of its own.`;
  return "";
}

/**
 * The boxes (first row, last row, first column, last column) that hold these taxels and no others.
 * @param {number[]} taxels row · columns + column each
 * @param {number} columns
 */
export function boxesOf(taxels, columns) {
  /** @type {number[][]} */
  const boxes = [];
  let row = -1;
  let run = [0, 0];
  const end = () => {
    if (row < 0) return;
    const above = boxes.find((box) => box[1] === row - 1 && box[2] === run[0] && box[3] === run[1]);
    if (above) above[1] = row;
    else boxes.push([row, row, ...run]);
  };
  for (const taxel of [...taxels].sort((a, b) => a - b)) {
    const at = [Math.floor(taxel / columns), taxel % columns];
    if (at[0] === row && at[1] === run[1] + 1) {
      run[1] += 1;
      continue;
    }
    end();
    row = at[0];
    run = [at[1], at[1]];
  }
  end();
  return boxes;
}

/**
 * The taxels of boxes.
 * @param {number[][]} boxes
 * @param {number} columns
 */
export function taxelsOf(boxes, columns) {
  const taxels = [];
  for (const [top, bottom, left, right] of boxes) {
    for (let row = top; row <= bottom; row += 1) {
      for (let column = left; column <= right; column += 1) taxels.push(row * columns + column);
    }
  }
  return taxels;
}

/** Of a region in frames that it is not said of. @type {Page.Place} */
const NOWHERE = { taxels: [], outlines: [] };

/**
 * Where a region lies in a frame.
 * @param {Page.Region} region
 * @param {number} sequence the frame's place in its recording
 * @returns {Page.Place}
 */
export function placeAt(region, sequence) {
  if (region.windows.length === 0) return region;
  return region.windows.find(({ frames: [first, last] }) => first <= sequence && sequence <= last) ?? NOWHERE;
}

/**
 * The taxels of a pin or region in a frame.
 * @param {Page.Item} item
 * @param {number} sequence
 */
export const taxelsAt = (item, sequence) => (item.letter === "R" ? placeAt(item, sequence).taxels : item.taxels);

/**
 * The closed lines around taxels, in cells of their map; where taxels lie at places of their own, a square around each.
 * @param {number[]} taxels
 * @param {Wire.SensorFacts} sensor
 * @returns {Page.Corner[][]}
 */
export function outlinesOf(taxels, sensor) {
  const layout = layoutOf(sensor);
  if (layout.owners) return taxels.map((taxel) => squareAround(layout.centre(taxel)));
  const { columns } = sensor;
  const within = new Set(taxels);
  /** Of each corner, the corners that an edge leads to with the taxels on its right. @type {Map<string, Page.Corner[]>} */
  const edges = new Map();
  /**
   * @param {Page.Corner} from
   * @param {Page.Corner} to
   */
  const add = (from, to) => edges.set(String(from), [...(edges.get(String(from)) || []), to]);
  for (const taxel of taxels) {
    const column = taxel % columns;
    const row = Math.floor(taxel / columns);
    if (!within.has(taxel - columns)) add([column, row], [column + 1, row]);
    if (column + 1 === columns || !within.has(taxel + 1)) add([column + 1, row], [column + 1, row + 1]);
    if (!within.has(taxel + columns)) add([column + 1, row + 1], [column, row + 1]);
    if (column === 0 || !within.has(taxel - 1)) add([column, row + 1], [column, row]);
  }
  return linesThrough(edges);
}

/**
 * Follows edges from corner to corner until each has been gone along.
 * @param {Map<string, Page.Corner[]>} edges
 */
function linesThrough(edges) {
  /** @type {Page.Corner[][]} */
  const lines = [];
  for (const [start, ways] of edges) {
    while (ways.length > 0) {
      /** @type {Page.Corner[]} */
      const line = [];
      let at = start;
      for (let next = edges.get(at)?.pop(); next; next = edges.get(at)?.pop()) {
        line.push(next);
        at = String(next);
        if (at === start) break;
      }
      lines.push(line.filter((corner, i) => !isBetween(line.at(i - 1), corner, line[(i + 1) % line.length])));
    }
  }
  return lines;
}

/**
 * Whether a corner lies on the straight line from one to the next.
 * @param {Page.Corner | undefined} before
 * @param {Page.Corner} corner
 * @param {Page.Corner} after
 */
const isBetween = (before, corner, after) => before !== undefined && [0, 1].some((axis) => before[axis] === corner[axis] && corner[axis] === after[axis]);

/**
 * @param {[number, number]} centre
 * @returns {Page.Corner[]}
 */
const squareAround = ([x, y]) => [[x - 0.5, y - 0.5], [x + 0.5, y - 0.5], [x + 0.5, y + 0.5], [x - 0.5, y + 0.5]];
