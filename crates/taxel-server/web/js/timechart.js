// One chart over time: uPlot with this page's axes, the events as vertical lines, and the paused instant.

import { niceCeil, niceStep, fixed, decimalsFor } from "./units.js";
import { theme } from "./theme.js";

/** @typedef {{ colour: () => string, dash?: number[], fill?: () => string }} Line */
/** @typedef {[number[], ...(number | null)[][]]} Data x in seconds before the end, then a column a line */

const FONT = "11px system-ui, -apple-system, 'Segoe UI', Roboto, sans-serif";
const SHRINK_BELOW = 0.55;
// Room for the labels of the loads: most fit, so that the charts line up; longer ones, such as 0.00025, get more.
const LABELS_WIDE = 46;
const LABELS_GAP = 5;
const MIN_GAP = 0.25;
const USUAL_STEPS = 5;

/**
 * The longest time between two rows that a line may bridge: a few usual steps. Beyond it, frames are missing.
 * @param {(i: number) => number} time
 * @param {number} from
 * @param {number} to
 */
export function longestStep(time, from, to) {
  if (to - from < 2) return 1;
  return Math.max(MIN_GAP, (USUAL_STEPS * (time(to - 1) - time(from))) / (to - 1 - from));
}

export class TimeChart {
  /**
   * @param {HTMLElement} element
   * @param {Line[]} lines
   * @param {{ onClick?: (time: number) => void, nameEvents?: boolean }} options
   */
  constructor(element, lines, { onClick, nameEvents = false } = {}) {
    this.element = element;
    this.onClick = onClick;
    this.nameEvents = nameEvents;
    this.top = 1;
    this.span = 30;
    this.end = 0;
    /** @type {Page.Happening[]} */
    this.events = [];
    this.pausedAt = NaN;
    /** Times are said from the beginning on, not back from the end. */
    this.fromStart = false;
    /** What is drawn of a whole recording. @type {{ curve: Wire.Curve, factor: number, span: number, at: number, theme: number } | null} */
    this.whole = null;
    this.lines = lines;
    /** @type {Data} */
    this.data = [[], ...lines.map(() => [])];
    this.tip = document.createElement("div");
    this.plot = this.makePlot();
    new ResizeObserver(() => this.resize()).observe(element);
  }

  /** @param {Line[]} lines */
  setLines(lines) {
    this.lines = lines;
    this.plot.destroy();
    this.data = [[], ...lines.map(() => [])];
    this.plot = this.makePlot();
  }

  makePlot() {
    const { lines } = this;
    const axis = { stroke: () => theme.ink3, font: FONT, grid: { stroke: () => theme.line, width: 1 }, ticks: { show: false } };
    const plot = new window.uPlot({
      ...this.size(),
      legend: { show: false },
      padding: [8, 10, 0, 0],
      cursor: { y: false, drag: { x: false, y: false }, points: { show: false } },
      scales: { x: { time: false, range: () => [-this.span, 0] }, y: { range: (_, low, high) => this.rangeY(low ?? 0, high ?? 0) } },
      axes: [
        { ...axis, size: 22, gap: 4, splits: (plot) => this.splitsX(plot.width || 320), values: (_, splits) => splits.map((x, i) => this.textX(x, i === splits.length - 1)) },
        { ...axis, size: widthOfLabels, gap: LABELS_GAP, splits: (plot, _, low, high) => splitsY(low, high, plot.height || 120), values: (_, splits) => textsY(splits) },
      ],
      series: [{}, ...lines.map((line) => ({ stroke: line.colour, fill: line.fill, width: 1.5, dash: line.dash, points: { show: false } }))],
      hooks: { draw: [(plot) => this.drawOver(plot)], setCursor: [(plot) => this.tell(plot)] },
    }, /** @type {import("uplot").AlignedData} */ (this.data), this.element);
    this.tip = document.createElement("div");
    this.tip.className = "tip num";
    this.tip.hidden = true;
    plot.over.append(this.tip);
    plot.over.addEventListener("click", (event) => {
      // A finger moves no cursor before it taps.
      const x = plot.posToVal(event.clientX - plot.over.getBoundingClientRect().left, "x");
      if (this.onClick && Number.isFinite(x)) this.onClick(this.end + x);
    });
    return plot;
  }

  size() {
    return { width: Math.max(80, this.element.clientWidth), height: Math.max(60, this.element.clientHeight) };
  }

  resize() {
    const size = this.size();
    if (size.width !== this.plot.width || size.height !== this.plot.height) this.plot.setSize(size);
  }

  /**
   * @param {number} end seconds since 1970
   * @param {number} span seconds shown before it
   * @param {Page.Happening[]} events
   * @param {number} pausedAt seconds since 1970, or NaN
   * @param {boolean} fromStart times, also those given, are since the beginning
   */
  update(end, span, events, pausedAt, fromStart = false) {
    this.fromStart = fromStart;
    this.end = end;
    this.span = span;
    this.events = events;
    this.pausedAt = pausedAt;
    this.plot.setData(/** @type {import("uplot").AlignedData} */ (this.data));
  }

  /**
   * The same lines with another instant marked.
   * @param {number} pausedAt
   */
  moveTo(pausedAt) {
    if (this.pausedAt === pausedAt) return;
    this.pausedAt = pausedAt;
    this.plot.redraw(false, false);
  }

  /**
   * The chart in words, for those who cannot see it.
   * @param {string} name
   * @param {string[]} units of the lines
   * @param {string[]} names of the lines; none for a chart of one line
   */
  describe(name, units, names = []) {
    const decimals = decimalsFor(this.top);
    const parts = this.data.slice(1).map((column, i) => {
      const known = /** @type {number[]} */ (column.filter((value) => value !== null));
      const word = names[i] ? `${names[i]} ` : "";
      if (known.length === 0) return `${word}no values`;
      const [last, low, high] = [known[known.length - 1], Math.min(...known), Math.max(...known)].map((value) => fixed(value, decimals));
      return `${word}${last} ${units[i]}, between ${low} and ${high}`;
    });
    const over = this.fromStart ? "the whole file," : "the last";
    const text = `${name} over ${over} ${fixed(this.span, 0)} s: ${parts.length > 0 ? parts.join("; ") : "nothing is selected"}`;
    this.element.setAttribute("role", "img");
    if (this.element.getAttribute("aria-label") !== text) this.element.setAttribute("aria-label", text);
  }

  /**
   * The top moves between round numbers, with play, so that the ticks stand still.
   * @param {number} low
   * @param {number} high
   * @returns {[number, number]}
   */
  rangeY(low, high) {
    if (high > this.top || high < SHRINK_BELOW * this.top) this.top = high > 0 ? niceCeil(high * 1.05) : 1;
    return [low < -0.01 * this.top ? -niceCeil(-low) : 0, this.top];
  }

  /** @param {number} width */
  splitsX(width) {
    const most = Math.max(2, Math.min(6, Math.floor(width / 80)));
    const step = this.span / (most >= 6 ? 6 : most >= 5 ? 5 : most >= 3 ? 3 : 2);
    /** @type {number[]} */
    const splits = [];
    if (this.fromStart) {
      const round = niceStep(this.span, most);
      for (let i = 0; i * round <= this.span + 1e-6; i += 1) splits.push(i * round - this.span);
      return splits;
    }
    for (let x = -this.span; x <= 1e-6; x += step) splits.push(Math.abs(x) < 1e-6 ? 0 : x);
    return splits;
  }

  /**
   * @param {number} x
   * @param {boolean} last
   */
  textX(x, last) {
    if (this.fromStart) {
      const [secs, unit] = this.span > 90 ? [(x + this.span) / 60, " min"] : [x + this.span, " s"];
      return `${Number(secs.toFixed(2))}${last ? unit : ""}`;
    }
    if (last && x === 0) return "0 s";
    return this.span > 90 ? `${fixed(x / 60, Number.isInteger(x / 60) ? 0 : 1)} min` : fixed(x, Number.isInteger(x) ? 0 : 1);
  }

  /**
   * The values under the pointer, on the side of it that has room.
   * @param {import("uplot")} plot
   */
  tell({ cursor, data, over }) {
    const at = cursor.idx;
    const left = cursor.left ?? -1;
    const shown = left >= 0 && at !== null && at !== undefined && data[0].length > 0;
    this.tip.hidden = !shown;
    if (!shown) return;
    const decimals = decimalsFor(this.top);
    const values = data.slice(1).map((column) => fixed(column[at] ?? NaN, decimals));
    this.tip.textContent = `${fixed(data[0][at] + (this.fromStart ? this.span : 0), 1)} s: ${values.join(", ")}`;
    const toLeft = left > over.clientWidth / 2;
    this.tip.style.left = toLeft ? "auto" : `${left + 8}px`;
    this.tip.style.right = toLeft ? `${over.clientWidth - left + 8}px` : "auto";
  }

  /** @param {import("uplot")} plot */
  drawOver(plot) {
    const { ctx, bbox } = plot;
    const ratio = window.devicePixelRatio || 1;
    ctx.save();
    ctx.beginPath();
    ctx.rect(bbox.left, bbox.top, bbox.width, bbox.height);
    ctx.clip();
    for (const event of this.events) {
      const x = event.time - this.end;
      if (x < -this.span || x > 0) continue;
      const left = plot.valToPos(x, "x", true);
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
      stroke(ctx, plot.valToPos(this.pausedAt - this.end, "x", true), bbox, theme.ink, [], ratio * 1.5);
    }
    ctx.restore();
  }
}

/**
 * @param {CanvasRenderingContext2D} ctx
 * @param {number} x
 * @param {import("uplot").BBox} bbox
 * @param {string} colour
 * @param {number[]} dash
 * @param {number} width
 */
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

/**
 * @param {number} low
 * @param {number} high
 * @param {number} height
 */
function splitsY(low, high, height) {
  const step = niceStep(high - low, Math.max(2, Math.floor(height / 34)));
  const splits = [];
  for (let i = Math.ceil(low / step - 1e-6); i <= high / step + 1e-6; i += 1) splits.push(i * step);
  return splits;
}

/**
 * @param {import("uplot")} plot
 * @param {string[]} texts
 * @param {number} axis
 * @param {number} cycle
 */
function widthOfLabels(plot, texts, axis, cycle) {
  // uPlot keeps the size that it had before, and the font with its height, in fields that its types do not have.
  const { font, _size: before } = /** @type {{ font: [string, number], _size: number }} */ (/** @type {unknown} */ (plot.axes[axis]));
  // uPlot asks again until nothing changes; its first answers count.
  if (cycle > 1) return before;
  if (!texts) return LABELS_WIDE;
  plot.ctx.font = font[0];
  const ratio = window.devicePixelRatio || 1;
  const widest = Math.max(0, ...texts.map((text) => plot.ctx.measureText(text).width)) / ratio;
  return Math.max(LABELS_WIDE, Math.ceil(widest) + LABELS_GAP + 2);
}

/** @param {number[]} splits */
function textsY(splits) {
  const step = splits.length > 1 ? splits[1] - splits[0] : 1;
  return splits.map((value) => fixed(value, decimalsFor(step, 1)));
}
