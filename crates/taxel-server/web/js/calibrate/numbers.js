// Numbers of a guided calibration in words, and the columns of its chart. Nothing here knows the page.

import { decimalsFor, fixed, niceCeil, plusMinus } from "../units.js";

const NARROW = "\u00a0";
/** The first fits may be off by many times what they are off by later: they may leave the chart at its top. */
const MOST_TIMES_LAST = 5;
/** The chart is at least so many presses wide. */
const LEAST_PRESSES = 10;
/** As long as nothing is known, grams. */
const EMPTY_TOP = 10;

/**
 * A load as it is written on a weight.
 * @param {number} grams
 */
export function loadText(grams) {
  if (!Number.isFinite(grams)) return "–";
  const [value, unit] = Math.abs(grams) >= 1000 ? [grams / 1000, "kg"] : [grams, "g"];
  return `${Number(value.toPrecision(4))}${NARROW}${unit}`;
}

/**
 * A load that was worked out, beside the one it is to be.
 * @param {number | null} saysG
 * @param {number} askedG
 */
export function saysText(saysG, askedG) {
  if (saysG === null) return "–";
  const percent = fixed((100 * (saysG - askedG)) / askedG, 0);
  const off = percent === "0" ? "0" : percent.replace(/^(?=\d)/, "+");
  return `${fixed(saysG, decimalsFor(askedG, 3))}${NARROW}g (${off}${NARROW}%)`;
}

/** @param {Wire.HeldOutError} error */
export function errorText({ mean_absolute_g: mean, standard_error_g: error }) {
  if (mean === null) return "–";
  // As the server writes it in its advice: two digits of the error's own.
  const decimals = Math.min(4, decimalsFor(error > 0 ? error : mean, 2));
  return `${fixed(mean, decimals)}${error > 0 ? plusMinus(error, decimals) : ""}${NARROW}g`;
}

/**
 * The last one that is known.
 * @param {Wire.HeldOutError[]} progress
 */
export function lastError(progress) {
  const known = progress.filter(({ mean_absolute_g }) => mean_absolute_g !== null);
  return known.length > 0 ? known[known.length - 1] : null;
}

/**
 * @typedef {object} Columns
 * @property {number[]} presses
 * @property {(number | null)[]} mean grams; null: nothing could be fitted
 * @property {(number | null)[]} above by a standard error
 * @property {(number | null)[]} below
 */

/**
 * For a chart, whose x must grow: after a press was taken back, the same number of presses comes again, and the newer counts.
 * @param {Wire.HeldOutError[]} progress
 * @returns {Columns}
 */
export function columnsOf(progress) {
  const newest = new Map(progress.map((one) => [one.presses, one]));
  const all = [...newest.values()].sort((a, b) => a.presses - b.presses);
  /** @param {-1 | 0 | 1} side */
  const column = (side) => all.map(({ mean_absolute_g: mean, standard_error_g: error }) => (mean === null ? null : Math.max(0, mean + side * error)));
  return { presses: all.map(({ presses }) => presses), mean: column(0), above: column(1), below: column(-1) };
}

/**
 * Up to where the axes of the chart go.
 * @param {Columns} columns
 */
export function endsOf({ presses, mean, above }) {
  const known = mean.filter((value) => value !== null);
  const last = known[known.length - 1] || 1;
  const highest = Math.max(0, ...above.map((value) => value ?? 0)) || 1;
  const top = known.length > 0 ? niceCeil(1.05 * Math.min(highest, MOST_TIMES_LAST * last)) : EMPTY_TOP;
  return { across: niceCeil(Math.max(LEAST_PRESSES, ...presses.map((count) => count + 1))), top };
}
