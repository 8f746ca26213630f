// On the map: where to press, and what presses now. The two differ in shape, not by colour alone.

import { MARGIN } from "../furniture.js";
import { theme } from "../theme.js";
import { loadText } from "./numbers.js";
import { taxelOf } from "./words.js";

/** @typedef {import("../orientation.js").Placement} Placement */
/** @typedef {{ x: number, y: number }} Spot in CSS pixels of the map */

// The map is dark in either theme.
export const ASKED = "#5cf2b4";
export const SEEN = "#ffffff";
const INK = "#0b0d10";
const LEAST_RADIUS = 13;
/** So wide is the name of the axis at its end, in pixels. */
const AXIS_NAME = 44;
const BOLD = "700 13px system-ui, -apple-system, 'Segoe UI', Roboto, sans-serif";

/** @type {Wire.CalibrationPhase[]} */
const WITH_ASKED = ["others", "press", "elsewhere", "taking"];

/**
 * @param {Wire.CalibrationSession} session
 * @param {CanvasRenderingContext2D} g
 * @param {Placement} p
 * @param {Wire.SensorFacts} sensor
 */
export function drawGuides({ phase, asked, seen }, g, p, sensor) {
  const there = asked && WITH_ASKED.includes(phase) ? asked : null;
  const taxel = there && taxelOf(there);
  const to = taxel && spotOf(p, sensor, taxel);
  const from = seen && phase !== "done" ? spotOf(p, sensor, seen) : null;
  if (there && !taxel) drawWhole(g, p, `${loadText(there.load_g)} on each`);
  if (to) drawLines(g, p, to);
  if (from) drawSquare(g, p, from);
  if (from && to && seen && !seen.is_there) drawArrow(g, p, from, to);
  if (there && to) {
    drawAsked(g, p, to, seen?.is_there ?? false);
    drawTag(g, p, loadText(there.load_g), to, radiusOf(p));
  }
  if (taxel && to) drawNumbers(g, p, to, taxel);
}

/**
 * @param {Placement} p
 * @param {Wire.SensorFacts} sensor
 * @param {Page.Taxel} taxel
 * @returns {Spot | null} null where there is no such taxel
 */
function spotOf(p, sensor, { row, column }) {
  if (row >= sensor.rows || column >= sensor.columns) return null;
  const centre = p.layout.centre(row * sensor.columns + column);
  const spot = { x: p.x(...centre), y: p.y(...centre) };
  return Number.isFinite(spot.x + spot.y) ? spot : null;
}

/** @param {Placement} p */
const radiusOf = (p) => Math.max(LEAST_RADIUS, p.taxelPixels / 2 + 6);

/**
 * They lead the eye to the taxel, also where it stands at a place of its own.
 * @param {CanvasRenderingContext2D} g
 * @param {Placement} p
 * @param {Spot} spot
 */
function drawLines(g, p, { x, y }) {
  const radius = radiusOf(p);
  const [right, bottom] = [p.left + p.width, p.top + p.height];
  g.beginPath();
  for (const [x1, y1, x2, y2] of [
    [p.left, y, Math.max(p.left, x - radius), y], [Math.min(right, x + radius), y, right, y],
    [x, p.top, x, Math.max(p.top, y - radius)], [x, Math.min(bottom, y + radius), x, bottom],
  ]) {
    g.moveTo(x1, y1);
    g.lineTo(x2, y2);
  }
  outlined(g, ASKED, 1.5, [7, 5]);
}

/**
 * Row and column at the edge of the map. Taxels at places of their own stand on no lines with numbers.
 * @param {CanvasRenderingContext2D} g
 * @param {Placement} p
 * @param {Spot} spot
 * @param {Page.Taxel} taxel
 */
function drawNumbers(g, p, { x, y }, { row, column }) {
  if (p.layout.owners) return;
  const [right, bottom] = [p.left + p.width, p.top + p.height];
  // The name of the axis gives way.
  if (x > right - AXIS_NAME - 12) g.clearRect(right - AXIS_NAME, bottom + 5, AXIS_NAME + 4, 15);
  const [across, down] = p.turned ? [row, column] : [column, row];
  g.font = BOLD;
  g.textAlign = "center";
  g.textBaseline = "middle";
  for (const [text, middleX, middleY] of /** @type {[number, number, number][]} */ ([[down, p.left / 2 - 1, y], [across, x, bottom + 11]])) {
    const wide = Math.max(20, g.measureText(String(text)).width + 8);
    const centre = Math.min(middleX, right + MARGIN.right - wide / 2);
    g.fillStyle = theme.ink;
    g.beginPath();
    g.roundRect(centre - wide / 2, middleY - 9, wide, 18, 4);
    g.fill();
    g.fillStyle = theme.panel;
    g.fillText(String(text), centre, middleY + 1);
  }
}

/**
 * @param {CanvasRenderingContext2D} g
 * @param {Placement} p
 * @param {Spot} spot
 * @param {boolean} isThere
 */
function drawAsked(g, p, { x, y }, isThere) {
  const radius = radiusOf(p);
  g.beginPath();
  g.arc(x, y, radius, 0, 2 * Math.PI);
  for (const [dx, dy] of isThere ? [] : [[1, 0], [-1, 0], [0, 1], [0, -1]]) {
    g.moveTo(x + (radius - 6) * dx, y + (radius - 6) * dy);
    g.lineTo(x + (radius + 2) * dx, y + (radius + 2) * dy);
  }
  outlined(g, ASKED, isThere ? 5 : 3);
}

/**
 * @param {CanvasRenderingContext2D} g
 * @param {Placement} p
 * @param {Spot} spot
 */
function drawSquare(g, p, { x, y }) {
  const half = Math.max(6, p.taxelPixels / 2 - 1);
  g.beginPath();
  g.rect(x - half, y - half, 2 * half, 2 * half);
  outlined(g, SEEN, 2.5);
}

/**
 * From where it stands to where it is to stand.
 * @param {CanvasRenderingContext2D} g
 * @param {Placement} p
 * @param {Spot} from
 * @param {Spot} to
 */
function drawArrow(g, p, from, to) {
  const length = Math.hypot(to.x - from.x, to.y - from.y);
  const [begin, end] = [Math.max(10, p.taxelPixels / 2 + 4), length - radiusOf(p) - 5];
  if (end - begin < 8) return;
  const [dx, dy] = [(to.x - from.x) / length, (to.y - from.y) / length];
  const tip = { x: from.x + end * dx, y: from.y + end * dy };
  g.beginPath();
  g.moveTo(from.x + begin * dx, from.y + begin * dy);
  g.lineTo(tip.x, tip.y);
  g.moveTo(tip.x - 9 * dx - 6 * dy, tip.y - 9 * dy + 6 * dx);
  g.lineTo(tip.x, tip.y);
  g.lineTo(tip.x - 9 * dx + 6 * dy, tip.y - 9 * dy - 6 * dx);
  outlined(g, SEEN, 2.5);
}

/**
 * @param {CanvasRenderingContext2D} g
 * @param {Placement} p
 * @param {string} text
 */
function drawWhole(g, p, text) {
  g.beginPath();
  g.rect(p.left + 4, p.top + 4, p.width - 8, p.height - 8);
  outlined(g, ASKED, 3, [12, 8]);
  drawTag(g, p, text, { x: p.left, y: p.top + 30 }, 8);
}

/**
 * Right above the ring, kept on the map.
 * @param {CanvasRenderingContext2D} g
 * @param {Placement} p
 * @param {string} text
 * @param {Spot} spot
 * @param {number} radius
 */
function drawTag(g, p, text, { x, y }, radius) {
  g.font = BOLD;
  const wide = g.measureText(text).width + 12;
  const isRight = x + radius + 6 + wide <= p.left + p.width;
  const left = isRight ? x + radius + 6 : x - radius - 6 - wide;
  const top = Math.min(Math.max(p.top + 2, y - radius - 16), p.top + p.height - 22);
  g.fillStyle = ASKED;
  g.beginPath();
  g.roundRect(Math.max(p.left, left), top, wide, 20, 4);
  g.fill();
  g.fillStyle = INK;
  g.textAlign = "left";
  g.textBaseline = "middle";
  g.fillText(text, Math.max(p.left, left) + 6, top + 11);
}

/**
 * Legible on any colour of the map.
 * @param {CanvasRenderingContext2D} g
 * @param {string} colour
 * @param {number} width
 * @param {number[]} dash
 */
function outlined(g, colour, width, dash = []) {
  g.lineJoin = "round";
  g.lineCap = "butt";
  g.setLineDash([]);
  g.strokeStyle = "rgb(0 0 0 / 0.65)";
  g.lineWidth = width + 2.5;
  g.stroke();
  g.setLineDash(dash);
  g.strokeStyle = colour;
  g.lineWidth = width;
  g.stroke();
  g.setLineDash([]);
}
