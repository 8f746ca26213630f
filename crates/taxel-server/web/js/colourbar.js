// The colour bar: the common scale with its unit and ticks, and one for the difference when that is shown.

import { decimalsFor, fixed, niceStep } from "./units.js";
import { contextOf } from "./dom.js";
import { theme } from "./theme.js";

/**
 * Values are in the unit shown.
 * @typedef {{ name: string, table: import("./colour.js").ColourTable, low: number, high: number, unit: string, title: string }} Bar
 */

export const BAR_WIDTH = 66;
const BAR = 14;
const TOP = 30;
const BOTTOM = 20;

export class ColourBar {
  /** @param {HTMLCanvasElement} canvas */
  constructor(canvas) {
    this.canvas = canvas;
    this.context = contextOf(canvas);
    this.key = "";
  }

  /**
   * @param {Bar[]} bars
   * @param {number} height
   * @param {number} ratio
   */
  draw(bars, height, ratio) {
    const key = `${height} ${ratio} ${theme.version} ${bars.map((bar) => `${bar.name} ${bar.low} ${bar.high} ${bar.unit}`).join()}`;
    if (key === this.key) return;
    this.key = key;
    const width = BAR_WIDTH * bars.length;
    this.canvas.width = Math.round(width * ratio);
    this.canvas.height = Math.round(height * ratio);
    this.canvas.style.width = `${width}px`;
    this.canvas.style.height = `${height}px`;
    const g = this.context;
    g.setTransform(ratio, 0, 0, ratio, 0, 0);
    g.clearRect(0, 0, width, height);
    bars.forEach((bar, i) => drawBar(g, bar, i * BAR_WIDTH, height));
    this.canvas.setAttribute("aria-label", bars.map((bar) => `${bar.title}: ${bar.low} to ${bar.high} ${bar.unit}`).join("; "));
  }
}

/**
 * @param {CanvasRenderingContext2D} g
 * @param {Bar} bar
 * @param {number} left
 * @param {number} height
 */
function drawBar(g, bar, left, height) {
  const length = Math.max(20, height - TOP - BOTTOM);
  const x = left + 2;
  for (let y = 0; y < length; y += 1) {
    g.fillStyle = bar.table.css(1 - (y + 0.5) / length);
    g.fillRect(x, TOP + y, BAR, 1.5);
  }
  g.strokeStyle = theme.line;
  g.strokeRect(x - 0.5, TOP - 0.5, BAR + 1, length + 1);
  g.font = "600 12px system-ui, -apple-system, 'Segoe UI', Roboto, sans-serif";
  g.fillStyle = theme.ink;
  g.textAlign = "left";
  g.textBaseline = "middle";
  g.fillText(bar.unit, x, 12);
  g.font = "11px system-ui, -apple-system, 'Segoe UI', Roboto, sans-serif";
  g.fillStyle = theme.ink2;
  g.strokeStyle = theme.ink3;
  const range = bar.high - bar.low;
  const step = niceStep(range, Math.max(2, Math.min(8, Math.floor(length / 34))));
  const decimals = Math.max(0, decimalsFor(step, 1));
  g.beginPath();
  for (let i = Math.ceil(bar.low / step - 1e-6); i <= bar.high / step + 1e-6; i += 1) {
    const value = i * step;
    const y = TOP + (1 - (value - bar.low) / range) * length;
    g.moveTo(x + BAR + 1, y);
    g.lineTo(x + BAR + 5, y);
    g.fillText(fixed(value, decimals), x + BAR + 8, y);
  }
  g.stroke();
}
