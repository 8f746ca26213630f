// One chart over time: uPlot with this page's axes, the events as vertical lines, and the paused instant.

import { niceCeil, niceStep, fixed, decimalsFor } from "./units.js";
import { theme } from "./theme.js";

const FONT = "11px system-ui, -apple-system, 'Segoe UI', Roboto, sans-serif";
const SHRINK_BELOW = 0.55;
// Room for the labels of the loads: most fit, so that the charts line up; longer ones, such as 0.00025, get more.
const LABELS_WIDE = 46;
const LABELS_GAP = 5;
const LEAST_GAP = 0.25;
const USUAL_STEPS = 5;

// The longest time between two rows that a line may bridge: a few usual steps. Beyond it, frames are missing.
export function longestStep(time, from, to) {
  if (to - from < 2) return 1;
  return Math.max(LEAST_GAP, (USUAL_STEPS * (time(to - 1) - time(from))) / (to - 1 - from));
}

export class TimeChart {
  // lines: [{ colour(), dash, fill }]; the x of the data is in seconds before `end`.
  constructor(element, lines, { onClick, nameEvents = false } = {}) {
    this.element = element;
    this.onClick = onClick;
    this.nameEvents = nameEvents;
    this.top = 1;
    this.span = 30;
    this.end = 0;
    this.events = [];
    this.pausedAt = NaN;
    this.plot = null;
    this.setLines(lines);
    new ResizeObserver(() => this.resize()).observe(element);
  }

  setLines(lines) {
    this.lines = lines;
    if (this.plot) this.plot.destroy();
    this.data = [[], ...lines.map(() => [])];
    const axis = { stroke: () => theme.ink3, font: FONT, grid: { stroke: () => theme.line, width: 1 }, ticks: { show: false } };
    this.plot = new window.uPlot({
      ...this.size(),
      legend: { show: false },
      padding: [8, 10, 0, 0],
      cursor: { y: false, drag: { x: false, y: false }, points: { show: false } },
      scales: { x: { time: false, range: () => [-this.span, 0] }, y: { range: (_, low, high) => this.rangeY(low, high) } },
      axes: [
        { ...axis, size: 22, gap: 4, splits: () => this.splitsX(), values: (_, splits) => splits.map((x, i) => this.textX(x, i === splits.length - 1)) },
        { ...axis, size: widthOfLabels, gap: LABELS_GAP, splits: (_, __, low, high) => splitsY(low, high, this.plot ? this.plot.height : 120), values: (_, splits) => textsY(splits) },
      ],
      series: [{}, ...lines.map((line) => ({ stroke: line.colour, fill: line.fill, width: 1.5, dash: line.dash, points: { show: false } }))],
      hooks: { draw: [() => this.drawOver()], setCursor: [() => this.tell()] },
    }, this.data, this.element);
    this.tip = document.createElement("div");
    this.tip.className = "tip num";
    this.tip.hidden = true;
    this.plot.over.append(this.tip);
    this.plot.over.addEventListener("click", () => {
      const x = this.plot.posToVal(this.plot.cursor.left, "x");
      if (this.onClick && Number.isFinite(x)) this.onClick(this.end + x);
    });
  }

  size() {
    return { width: Math.max(80, this.element.clientWidth), height: Math.max(60, this.element.clientHeight) };
  }

  resize() {
    const size = this.size();
    if (size.width !== this.plot.width || size.height !== this.plot.height) this.plot.setSize(size);
  }

  update(end, span, events, pausedAt) {
    this.end = end;
    this.span = span;
    this.events = events;
    this.pausedAt = pausedAt;
    this.plot.setData(this.data);
  }

  // The top moves between round numbers, with play, so that the ticks stand still.
  rangeY(low, high) {
    if (high > this.top || high < SHRINK_BELOW * this.top) this.top = high > 0 ? niceCeil(high * 1.05) : 1;
    return [low < -0.01 * this.top ? -niceCeil(-low) : 0, this.top];
  }

  splitsX() {
    const most = Math.max(2, Math.min(6, Math.floor(this.plot ? this.plot.width / 80 : 4)));
    const step = this.span / (most >= 6 ? 6 : most >= 5 ? 5 : most >= 3 ? 3 : 2);
    const splits = [];
    for (let x = -this.span; x <= 1e-6; x += step) splits.push(Math.abs(x) < 1e-6 ? 0 : x);
    return splits;
  }

  textX(x, last) {
    if (last && x === 0) return "0 s";
    return this.span > 90 ? `${fixed(x / 60, Number.isInteger(x / 60) ? 0 : 1)} min` : fixed(x, Number.isInteger(x) ? 0 : 1);
  }

  // The values under the pointer, on the side of it that has room.
  tell() {
    const { cursor, data } = this.plot;
    const at = cursor.idx;
    const shown = cursor.left >= 0 && at !== null && at !== undefined && data[0].length > 0;
    this.tip.hidden = !shown;
    if (!shown) return;
    const decimals = decimalsFor(this.top);
    const values = data.slice(1).map((column) => (column[at] === null || column[at] === undefined ? "–" : fixed(column[at], decimals)));
    this.tip.textContent = `${fixed(data[0][at], 1)} s: ${values.join(", ")}`;
    const toLeft = cursor.left > this.plot.over.clientWidth / 2;
    this.tip.style.left = toLeft ? "auto" : `${cursor.left + 8}px`;
    this.tip.style.right = toLeft ? `${this.plot.over.clientWidth - cursor.left + 8}px` : "auto";
  }

  drawOver() {
    const { ctx, bbox } = this.plot;
    const ratio = window.devicePixelRatio || 1;
    ctx.save();
    ctx.beginPath();
    ctx.rect(bbox.left, bbox.top, bbox.width, bbox.height);
    ctx.clip();
    for (const event of this.events) {
      const x = event.time - this.end;
      if (x < -this.span || x > 0) continue;
      const left = this.plot.valToPos(x, "x", true);
      stroke(ctx, left, bbox, theme.warn, [3 * ratio, 3 * ratio], ratio);
      if (!this.nameEvents) continue;
      ctx.font = `${11 * ratio}px system-ui, sans-serif`;
      ctx.textBaseline = "top";
      const width = ctx.measureText(event.text).width;
      const fits = left + width + 4 * ratio < bbox.left + bbox.width;
      ctx.textAlign = fits ? "left" : "right";
      const at = left + (fits ? 4 : -4) * ratio;
      ctx.fillStyle = theme.panel;
      ctx.globalAlpha = 0.8;
      ctx.fillRect(fits ? at - 2 : at - width - 2, bbox.top, width + 4, 14 * ratio);
      ctx.globalAlpha = 1;
      ctx.fillStyle = theme.warn;
      ctx.fillText(event.text, at, bbox.top + ratio);
    }
    if (Number.isFinite(this.pausedAt)) {
      stroke(ctx, this.plot.valToPos(this.pausedAt - this.end, "x", true), bbox, theme.ink, [], ratio * 1.5);
    }
    ctx.restore();
  }
}

function stroke(ctx, x, bbox, colour, dash, width) {
  ctx.strokeStyle = colour;
  ctx.lineWidth = width;
  ctx.setLineDash(dash);
  ctx.beginPath();
  ctx.moveTo(x, bbox.top);
  ctx.lineTo(x, bbox.top + bbox.height);
  ctx.stroke();
  ctx.setLineDash([]);
}

function splitsY(low, high, height) {
  const step = niceStep(high - low, Math.max(2, Math.floor(height / 34)));
  const splits = [];
  for (let i = Math.ceil(low / step - 1e-6); i <= high / step + 1e-6; i += 1) splits.push(i * step);
  return splits;
}

function widthOfLabels(plot, texts, axis, cycle) {
  const { font, _size: before } = plot.axes[axis];
  // uPlot asks again until nothing changes; its first answers count.
  if (cycle > 1) return before;
  if (!texts) return LABELS_WIDE;
  plot.ctx.font = font[0];
  const ratio = window.devicePixelRatio || 1;
  const widest = Math.max(0, ...texts.map((text) => plot.ctx.measureText(text).width)) / ratio;
  return Math.max(LABELS_WIDE, Math.ceil(widest) + LABELS_GAP + 2);
}

function textsY(splits) {
  const step = splits.length > 1 ? splits[1] - splits[0] : 1;
  return splits.map((value) => fixed(value, decimalsFor(step, 1)));
}
