// Force against time since the hold began: a fixed time axis, the target as a band, the largest force so far as a line.

import { AXIS, splits, texts } from "../axes.js";
import { byId } from "../dom.js";
import { colourOf, faint, theme } from "../theme.js";
import { fixed, niceCeil } from "../units.js";
import { wholeNewtons } from "./numbers.js";

/** The axis of forces reaches at least so far, N: noise must not look like a grip. */
const LEAST_TOP = 50;

export class HoldChart {
  /** @param {import("./curve.js").Curve} curve */
  constructor(curve) {
    this.curve = curve;
    this.element = byId("chart");
    this.secs = 8;
    this.top = LEAST_TOP;
    /** @type {[number, number] | null} */
    this.target = null;
    this.plot = this.makePlot();
    new ResizeObserver(() => this.resize()).observe(this.element);
  }

  makePlot() {
    return new window.uPlot({
      ...this.size(),
      legend: { show: false },
      padding: [10, 14, 0, 0],
      cursor: { show: false },
      scales: { x: { time: false, range: () => [0, this.secs] }, y: { range: () => [0, this.top] } },
      axes: [
        { ...AXIS, size: 24, gap: 4, label: "Time since the hold began (s)", labelSize: 18, splits: (plot) => splits(this.secs, plot.width, 60), values: texts },
        { ...AXIS, size: 42, gap: 5, label: "Force (N)", labelSize: 18, splits: (plot) => splits(this.top, plot.height, 40), values: texts },
      ],
      series: [{}, { stroke: () => theme.comp, width: 2, points: { show: false } }, { stroke: () => theme.ink2, width: 1.5, dash: [6, 4], points: { show: false } }],
      hooks: { drawAxes: [(plot) => this.drawTarget(plot)] },
    }, this.data(), this.element);
  }

  data() {
    return /** @type {import("uplot").AlignedData} */ ([this.curve.times, this.curve.forces, this.curve.largest]);
  }

  size() {
    return { width: Math.max(120, this.element.clientWidth), height: Math.max(90, this.element.clientHeight) };
  }

  resize() {
    const { clientWidth, clientHeight } = this.element;
    if (clientWidth === 0 || clientHeight === 0) return;
    const size = this.size();
    if (size.width !== this.plot.width || size.height !== this.plot.height) this.plot.setSize(size);
  }

  /**
   * A new trial: the axes stand still from here on, as long as the force fits.
   * @param {Wire.GripProtocol} protocol
   * @param {Wire.GripTrial[]} trials
   */
  begin({ hold_secs, target_newtons }, trials) {
    this.secs = hold_secs > 0 ? hold_secs : 1;
    this.target = target_newtons;
    const before = trials.map(({ accepted }) => accepted?.max_newtons ?? 0);
    this.top = niceCeil(target_newtons ? 1.5 * target_newtons[1] : 1.15 * Math.max(LEAST_TOP, ...before));
    this.draw();
  }

  draw() {
    const { max } = this.curve;
    if (max > this.top) this.top = niceCeil(1.15 * max);
    this.plot.setData(this.data());
  }

  /** For those who cannot see it. */
  describe() {
    const { curve } = this;
    const last = curve.forces[curve.forces.length - 1] ?? NaN;
    const text = curve.isEmpty ? "no values yet" : `${wholeNewtons(last)} N at ${fixed(curve.times[curve.times.length - 1], 1)} s, largest ${wholeNewtons(curve.max)} N`;
    const label = `Force against time since the hold began: ${text}`;
    if (this.element.getAttribute("aria-label") !== label) this.element.setAttribute("aria-label", label);
    this.element.dataset.points = String(curve.times.length);
  }

  /** @param {import("uplot")} plot */
  drawTarget(plot) {
    if (!this.target) return;
    const { ctx, bbox } = plot;
    const ratio = window.devicePixelRatio || 1;
    const [low, high] = this.target.map((newtons) => plot.valToPos(newtons, "y", true));
    ctx.save();
    ctx.fillStyle = faint(colourOf("good"), 0.2);
    ctx.fillRect(bbox.left, high, bbox.width, low - high);
    ctx.strokeStyle = colourOf("good");
    ctx.lineWidth = ratio;
    ctx.strokeRect(bbox.left - 2 * ratio, high, bbox.width + 4 * ratio, low - high);
    ctx.font = `600 ${12 * ratio}px system-ui, sans-serif`;
    ctx.textAlign = "right";
    ctx.textBaseline = "bottom";
    ctx.fillStyle = theme.ink;
    ctx.fillText(`target ${wholeNewtons(this.target[0])} to ${wholeNewtons(this.target[1])} N`, bbox.left + bbox.width - 6 * ratio, high - 3 * ratio);
    ctx.restore();
  }
}
