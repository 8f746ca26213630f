// Axes of charts that begin at zero, for uPlot.

import { theme } from "./theme.js";
import { decimalsFor, fixed, niceStep } from "./units.js";

const FONT = "12px system-ui, -apple-system, 'Segoe UI', Roboto, sans-serif";

/** How each of them looks. */
export const AXIS = {
  stroke: () => theme.ink2, font: FONT, labelFont: FONT, grid: { stroke: () => theme.line, width: 1 }, ticks: { show: false },
};

/**
 * @param {number} top
 * @param {number} pixels
 * @param {number} apart
 */
export function splits(top, pixels, apart) {
  const step = niceStep(top, Math.max(2, Math.floor((pixels || 300) / apart)));
  const all = [];
  for (let i = 0; i * step <= top + 1e-6; i += 1) all.push(i * step);
  return all;
}

/**
 * @param {import("uplot")} _
 * @param {number[]} values
 */
export function texts(_, values) {
  const step = values.length > 1 ? values[1] - values[0] : 1;
  return values.map((value) => fixed(value, decimalsFor(step, 1)));
}
