// The curves: uPlot gives the axes and the pointer, the rest is drawn over them, because curves of settings that differ
// little lie on each other and all must still be seen.

import { niceStep, fixed, decimalsFor } from "../units.js";
import { colourOf, theme } from "../theme.js";
import { MAX_COUNT } from "./circuit.js";

const FONT = "system-ui, -apple-system, 'Segoe UI', Roboto, sans-serif";
const SMALL = `11px ${FONT}`;
const DASH = 6;
const FAINT = 0.3;
// A mark at each N, as long as they stand apart.
const MAX_MARKED = 40;

/** @type {Record<Model.Quantity, string>} */
export const Y_TEXT = { volts: "V_out (V)", counts: "Counts (16 bit)", drop: "Drop against N = 0 (%)" };

export class Chart {
  /**
   * @param {HTMLElement} element
   * @param {(n: number) => void} onPick
   */
  constructor(element, onPick) {
    this.element = element;
    this.onPick = onPick;
    /** @type {Model.Shown} */
    this.shown = { curves: [], points: [], summary: [], y: "volts", fromZero: true, last: 20, fullScaleVolts: 2.2, at: 20 };
    /** @type {[number, number]} */
    this.range = [0, 1];
    this.step = 1;
    /** @type {number[]} */
    this.splitsY = [];
    const axis = { stroke: () => theme.ink2, font: SMALL, labelFont: `12px ${FONT}`, labelSize: 20, grid: { stroke: () => theme.line, width: 1 }, ticks: { show: false } };
    this.plot = new window.uPlot({
      ...this.size(),
      legend: { show: false },
      padding: [12, 18, 0, 0],
      cursor: { show: false },
      scales: { x: { time: false, range: () => [0, this.shown.last] }, y: { range: () => this.range } },
      axes: [
        { ...axis, size: 24, gap: 6, label: "N, other pressed taxels in the row", splits: (plot) => this.splitsX(plot.width || 600), values: (_, splits) => splits.map(String) },
        { ...axis, size: 56, gap: 6, label: "y", splits: () => this.splitsY, values: (_, splits) => splits.map((value) => fixed(value, decimalsFor(this.step, 1))) },
      ],
      series: [{}, { show: true, stroke: "transparent", points: { show: false } }],
      hooks: { draw: [(plot) => this.draw(plot)] },
    }, [[0, 1], [0, 0]], element);
    /** @param {MouseEvent} event */
    const pick = (event) => {
      const box = this.plot.over.getBoundingClientRect();
      this.onPick(this.plot.posToVal(event.clientX - box.left, "x"));
    };
    this.plot.over.addEventListener("pointermove", pick);
    this.plot.over.addEventListener("pointerdown", pick);
    new ResizeObserver(() => this.resize()).observe(element);
  }

  size() {
    return { width: Math.max(120, this.element.clientWidth), height: Math.max(120, this.element.clientHeight) };
  }

  resize() {
    const size = this.size();
    if (size.width === this.plot.width && size.height === this.plot.height) return;
    this.setRange(size.height);
    this.plot.setSize(size);
  }

  /** @param {Model.Shown} shown points and summary in the unit of the axis */
  show(shown) {
    this.shown = shown;
    this.plot.axes[1].label = Y_TEXT[shown.y];
    this.setRange(this.plot.height);
    this.plot.setData([[0, shown.last], [0, 0]]);
  }

  get ceiling() {
    const { y, fullScaleVolts } = this.shown;
    return { volts: -fullScaleVolts, counts: MAX_COUNT, drop: NaN }[y];
  }

  /**
   * What the converter would give; a drop is the circuit's own.
   * @param {Model.Curve} curve
   * @param {number} n
   */
  drawn(curve, n) {
    const { y } = this.shown;
    if (y !== "drop" && curve.saturates[n]) return this.ceiling;
    return curve[y][n];
  }

  /** @param {number} height */
  setRange(height) {
    const { curves, points, summary, fromZero, last } = this.shown;
    let low = Infinity;
    let high = -Infinity;
    /** @param {number} value */
    const take = (value) => {
      low = Math.min(low, value);
      high = Math.max(high, value);
    };
    for (const { circuit, paper } of curves) {
      for (const curve of [circuit, paper]) for (let n = 0; n <= last; n += 1) take(this.drawn(curve, n));
    }
    for (const { n, value } of points) if (n <= last) take(value);
    for (const { n, mean, half } of summary) if (n <= last && half !== null) [mean - half, mean + half].forEach(take);
    if (fromZero) take(0);
    if (high - low < 1e-12 * Math.max(1, Math.abs(high))) [low - 1e-3 * (Math.abs(low) || 1), high + 1e-3 * (Math.abs(high) || 1)].forEach(take);
    const room = 0.06 * (high - low);
    this.range = [fromZero && low === 0 ? 0 : low - room, fromZero && high === 0 ? 0 : high + room];
    this.step = niceStep(this.range[1] - this.range[0], Math.max(2, Math.floor(height / 48)));
    this.splitsY = [];
    for (let i = Math.ceil(this.range[0] / this.step - 1e-6); i <= this.range[1] / this.step + 1e-6; i += 1) this.splitsY.push(i * this.step);
  }

  /** @param {number} width */
  splitsX(width) {
    const { last } = this.shown;
    const step = Math.max(1, niceStep(last, Math.max(2, Math.min(21, width / 44))));
    return Array.from({ length: Math.floor(last / step) + 1 }, (_, i) => i * step);
  }

  /** @param {import("uplot")} plot */
  draw(plot) {
    if (!this.plot) return;
    const { ctx: g, bbox } = plot;
    const ratio = window.devicePixelRatio || 1;
    g.save();
    g.beginPath();
    g.rect(bbox.left - 6 * ratio, bbox.top - 6 * ratio, bbox.width + 12 * ratio, bbox.height + 12 * ratio);
    g.clip();
    this.drawCeiling(g, bbox, ratio);
    this.drawAt(g, bbox, ratio);
    const { curves } = this.shown;
    curves.forEach(({ colour, circuit }) => this.drawCurve(g, circuit, colourOf(`setting-${colour}`), 2.5 * ratio, [], 0));
    // Dashes of different settings take turns and leave a gap, so that of curves on one another each is seen.
    const gap = DASH * curves.length * ratio;
    curves.forEach(({ colour, paper }, i) => this.drawCurve(g, paper, colourOf(`setting-${colour}-paper`), 1.75 * ratio, [DASH * ratio, gap], -i * DASH * ratio));
    if (this.shown.last <= MAX_MARKED) curves.forEach(({ colour, circuit }) => this.drawMarks(g, circuit, colourOf(`setting-${colour}`), ratio));
    this.drawPoints(g, ratio);
    g.restore();
  }

  /**
   * @param {number} n
   * @param {number} value
   * @returns {[number, number]}
   */
  at(n, value) {
    return [this.plot.valToPos(n, "x", true), this.plot.valToPos(value, "y", true)];
  }

  /**
   * @param {CanvasRenderingContext2D} g
   * @param {import("uplot").BBox} bbox
   * @param {number} ratio
   */
  drawCeiling(g, bbox, ratio) {
    const [low, high] = this.range;
    const { ceiling } = this;
    if (!(ceiling >= low && ceiling <= high)) return;
    const [, y] = this.at(0, ceiling);
    g.strokeStyle = theme.warn;
    g.lineWidth = ratio;
    g.setLineDash([2 * ratio, 3 * ratio]);
    g.beginPath();
    g.moveTo(bbox.left, y);
    g.lineTo(bbox.left + bbox.width, y);
    g.stroke();
    g.setLineDash([]);
    g.fillStyle = theme.warn;
    g.font = `${11 * ratio}px ${FONT}`;
    // At the left, where a curve that reaches the converter's end lies on the line itself.
    g.textAlign = "left";
    // On the side where the other values are.
    const below = this.shown.y === "counts";
    g.textBaseline = below ? "top" : "bottom";
    const full = this.shown.y === "volts" ? `${fixed(ceiling, 2)} V` : `${MAX_COUNT} counts`;
    const stuck = this.shown.curves.some(({ circuit, paper }) => circuit.saturates[0] || paper.saturates[0]);
    g.fillText(`full scale, ${full}${stuck ? ": saturates" : ""}`, bbox.left + 10 * ratio, y + (below ? 5 : -5) * ratio);
  }

  /**
   * @param {CanvasRenderingContext2D} g
   * @param {import("uplot").BBox} bbox
   * @param {number} ratio
   */
  drawAt(g, bbox, ratio) {
    const [x] = this.at(this.shown.at, 0);
    g.strokeStyle = theme.ink3;
    g.lineWidth = ratio;
    g.beginPath();
    g.moveTo(x, bbox.top);
    g.lineTo(x, bbox.top + bbox.height);
    g.stroke();
  }

  /**
   * In two strokes, faint where the converter is full. Readings fall with N, so the faint part comes first.
   * @param {CanvasRenderingContext2D} g
   * @param {Model.Curve} curve
   * @param {string} colour
   * @param {number} width
   * @param {number[]} dash
   * @param {number} offset
   */
  drawCurve(g, curve, colour, width, dash, offset) {
    const { last } = this.shown;
    const firstGood = curve.saturates.indexOf(false);
    const turn = firstGood < 0 ? last : firstGood;
    g.strokeStyle = colour;
    g.lineWidth = width;
    g.lineJoin = "round";
    g.setLineDash(dash);
    g.lineDashOffset = offset;
    for (const [from, to, alpha] of [[0, turn, FAINT], [turn, last, 1]]) {
      if (to <= from) continue;
      g.globalAlpha = alpha;
      g.beginPath();
      for (let n = from; n <= to; n += 1) g.lineTo(...this.at(n, this.drawn(curve, n)));
      g.stroke();
    }
    g.globalAlpha = 1;
    g.setLineDash([]);
    g.lineDashOffset = 0;
  }

  /**
   * @param {CanvasRenderingContext2D} g
   * @param {Model.Curve} curve
   * @param {string} colour
   * @param {number} ratio
   */
  drawMarks(g, curve, colour, ratio) {
    const { last, at } = this.shown;
    g.fillStyle = colour;
    for (let n = 0; n <= last; n += 1) {
      g.globalAlpha = curve.saturates[n] ? FAINT : 1;
      g.beginPath();
      g.arc(...this.at(n, this.drawn(curve, n)), (n === at ? 5 : 2.75) * ratio, 0, 2 * Math.PI);
      g.fill();
    }
    g.globalAlpha = 1;
  }

  /**
   * @param {CanvasRenderingContext2D} g
   * @param {number} ratio
   */
  drawPoints(g, ratio) {
    const { points, summary, last } = this.shown;
    g.strokeStyle = theme.ink;
    g.lineWidth = ratio;
    g.globalAlpha = points.length > 200 ? 0.35 : 0.7;
    for (const { n, value } of points) {
      if (n > last) continue;
      g.beginPath();
      g.arc(...this.at(n, value), 3 * ratio, 0, 2 * Math.PI);
      g.stroke();
    }
    g.globalAlpha = 1;
    g.lineWidth = 1.5 * ratio;
    for (const { n, mean, half } of summary) {
      if (n > last || half === null) continue;
      const [x, top] = this.at(n, mean + half);
      const [, y] = this.at(n, mean);
      const [, bottom] = this.at(n, mean - half);
      const wide = 5 * ratio;
      g.beginPath();
      g.moveTo(x, top);
      g.lineTo(x, bottom);
      for (const end of [top, bottom]) {
        g.moveTo(x - wide, end);
        g.lineTo(x + wide, end);
      }
      g.stroke();
      // A square with a rim, so that it stands apart from a curve's own marks.
      g.fillStyle = theme.ink;
      g.fillRect(x - 4 * ratio, y - 4 * ratio, 8 * ratio, 8 * ratio);
      g.strokeStyle = theme.ground;
      g.strokeRect(x - 4 * ratio, y - 4 * ratio, 8 * ratio, 8 * ratio);
      g.strokeStyle = theme.ink;
    }
  }
}
