// Measured points: reading the file, and what replicates of the same N have in common. Nothing of the page.

import { MAX_COUNT, voltsFromCounts, countsFromVolts, dropPercent } from "./circuit.js";

const MAX_BYTES = 5e6;
const MAX_ERRORS = 4;
const EXPECTED = "expected two columns, n and value, such as “4,23810”";

export class PointsError extends Error {}

/**
 * Columns `n,value`, with or without a header; comma, semicolon or tab between them. With a header that names both,
 * there may be more columns, in any order. Throws a PointsError that names the lines.
 * @param {string} text
 */
export function readPoints(text) {
  if (text.length > MAX_BYTES) throw new PointsError(`the file is larger than ${MAX_BYTES / 1e6} MB: this is no table of points`);
  const lines = text.replace(/^\uFEFF/, "").split(/\r\n|\n|\r/);
  /** @type {Model.Point[]} */
  const points = [];
  /** @type {string[]} */
  const errors = [];
  /** @type {Columns | null} */
  let columns = null;
  lines.forEach((line, i) => {
    if (line.trim() === "" || line.startsWith("#")) return;
    const cells = line.split(/[,;\t]/).map((cell) => cell.trim().replace(/^"(.*)"$/, "$1"));
    if (columns === null) {
      columns = columnsOf(cells);
      if (columns.isHeader) return;
    }
    const problem = problemOf(cells, columns);
    if (problem) errors.push(`line ${i + 1}: ${problem}`);
    else points.push({ n: Number(cells[columns.n]), value: Number(cells[columns.value]) });
  });
  if (errors.length > 0) {
    const more = errors.length > MAX_ERRORS ? [`and ${errors.length - MAX_ERRORS} more`] : [];
    throw new PointsError([...errors.slice(0, MAX_ERRORS), ...more].join("\n"));
  }
  if (points.length === 0) throw new PointsError(`line ${lines.length}: the file ends without a point; ${EXPECTED}`);
  return points;
}

/** @typedef {{ isHeader: boolean, n: number, value: number, count: number }} Columns */

/**
 * @param {string[]} cells
 * @returns {Columns}
 */
function columnsOf(cells) {
  const isHeader = cells.length >= 2 && cells.every((cell) => cell !== "" && !isNumber(cell));
  const names = cells.map((cell) => cell.toLowerCase());
  const n = names.indexOf("n");
  const value = names.indexOf("value");
  if (isHeader && n >= 0 && value >= 0) return { isHeader, n, value, count: cells.length };
  return { isHeader, n: 0, value: 1, count: 2 };
}

/**
 * @param {string[]} cells
 * @param {Columns} columns
 */
function problemOf(cells, { n, value, count }) {
  if (cells.length !== count) {
    const expected = count === 2 ? EXPECTED : `expected ${count} columns as in the header`;
    return `${cells.length} column${cells.length === 1 ? "" : "s"}; ${expected}`;
  }
  if (!/^\+?\d+$/.test(cells[n])) return `n is “${cells[n]}”; expected a whole number, 0 or more`;
  if (!isNumber(cells[value])) return `the value is “${cells[value]}”; expected a number with a decimal point`;
  return null;
}

/** @param {string} text */
const isNumber = (text) => text !== "" && Number.isFinite(Number(text));

/**
 * Mean and 95 % interval of the mean for every n (Student 1908); of a single reading there is no interval.
 * @param {Model.Point[]} points
 * @returns {Model.Summary[]}
 */
export function summaryOf(points) {
  /** @type {Map<number, number[]>} */
  const groups = new Map();
  for (const { n, value } of points) groups.set(n, [...(groups.get(n) || []), value]);
  return [...groups].sort(([a], [b]) => a - b).map(([n, values]) => {
    const count = values.length;
    const mean = values.reduce((sum, value) => sum + value, 0) / count;
    if (count < 2) return { n, count, mean, half: null };
    const variance = values.reduce((sum, value) => sum + (value - mean) ** 2, 0) / (count - 1);
    return { n, count, mean, half: student(count - 1) * Math.sqrt(variance / count) };
  });
}

const STUDENT = [12.7062, 4.3027, 3.1824, 2.7764, 2.5706, 2.4469, 2.3646, 2.306, 2.2622, 2.2281];

/**
 * The 97.5 % quantile of Student's t; beyond the table Fisher's expansion around the normal one (Abramowitz and
 * Stegun 26.7.5), good to four decimals there.
 * @param {number} freedom
 */
export function student(freedom) {
  if (freedom <= STUDENT.length) return STUDENT[freedom - 1];
  const z = 1.959964;
  return z + (z ** 3 + z) / (4 * freedom) + (5 * z ** 5 + 16 * z ** 3 + 3 * z) / (96 * freedom ** 2)
    + (3 * z ** 7 + 19 * z ** 5 + 17 * z ** 3 - 15 * z) / (384 * freedom ** 3);
}

/**
 * What a measured value may be. A drop is a share of a reading that the file does not have, so it stays a drop.
 * @type {{ key: string, text: string, toVolts: ((value: number, fullScaleVolts: number) => number) | null }[]}
 */
export const POINT_UNITS = [
  { key: "counts", text: "counts (16 bit)", toVolts: voltsFromCounts },
  { key: "volts", text: "V_out (V)", toVolts: (value) => value },
  { key: "magnitude", text: "|V_out| (V)", toVolts: (value) => -value },
  { key: "drop", text: "drop (%)", toVolts: null },
];

/**
 * The points in the unit of the y axis. `why` says in words why there are none, or is empty.
 * `offset` is added to n: a file may count the taxel that is read among the pressed ones.
 * @param {Model.Quantity} y
 * @param {Model.Point[]} measured
 * @param {{ unit: string, offset: number, fullScaleVolts: number }} how
 * @returns {{ points: Model.Point[], why: string }}
 */
export function pointsIn(y, measured, { unit, offset, fullScaleVolts }) {
  const { toVolts } = POINT_UNITS.find(({ key }) => key === unit) || POINT_UNITS[0];
  const moved = measured.map(({ n, value }) => ({ n: n + offset, value }));
  if (moved.some(({ n }) => n < 0)) return { points: [], why: "n = 0 pressed taxels cannot be: n seems to count the others alone" };
  if (!toVolts) {
    if (y === "drop") return { points: moved, why: "" };
    return { points: [], why: "points in percent can only be shown when the y axis is the drop" };
  }
  const volts = moved.map(({ n, value }) => ({ n, value: toVolts(value, fullScaleVolts) }));
  if (y === "volts") return { points: volts, why: "" };
  if (y === "counts") return { points: volts.map(({ n, value }) => ({ n, value: countsFromVolts(value, fullScaleVolts) })), why: "" };
  const alone = volts.filter(({ n }) => n === 0);
  if (alone.length === 0) return { points: [], why: "their drop needs a reading at N = 0, and the file has none" };
  const mean = alone.reduce((sum, { value }) => sum + value, 0) / alone.length;
  if (mean === 0) return { points: [], why: "their drop needs a reading other than 0 at N = 0" };
  return { points: volts.map(({ n, value }) => ({ n, value: dropPercent(value, mean) })), why: "" };
}

/**
 * Readings at the converter's end, which say only "at least".
 * @param {Model.Point[]} measured
 * @param {string} unit
 */
export const atCeiling = (measured, unit) => (unit === "counts" ? measured.filter(({ value }) => value >= MAX_COUNT).length : 0);
