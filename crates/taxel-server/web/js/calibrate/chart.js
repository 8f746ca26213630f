// The error of presses held out against how many there are: a line, and a band of one standard error to each side.

import { AXIS, splits, texts } from "../axes.js";
import { byId } from "../dom.js";
import { faint, theme } from "../theme.js";
import { columnsOf, endsOf, errorText, lastError } from "./numbers.js";
import { countText } from "./words.js";

export class ErrorChart {
  constructor() {
    this.element = byId("error-chart");
    this.columns = columnsOf([]);
    this.ends = endsOf(this.columns);
    this.plot = this.makePlot();
    new ResizeObserver(() => this.resize()).observe(this.element);
  }

  makePlot() {
    const edge = { stroke: "transparent", width: 0, points: { show: false } };
    return new window.uPlot({
      ...this.size(),
      legend: { show: false },
      padding: [10, 12, 0, 0],
      cursor: { show: false },
      scales: { x: { time: false, range: () => [0, this.ends.across] }, y: { range: () => [0, this.ends.top] } },
      axes: [
        { ...AXIS, size: 24, gap: 4, label: "Presses taken", labelSize: 18, splits: (plot) => splits(this.ends.across, plot.width, 50), values: texts },
        { ...AXIS, size: 42, gap: 5, label: "Error (g)", labelSize: 18, splits: (plot) => splits(this.ends.top, plot.height, 40), values: texts },
      ],
      series: [{}, { stroke: () => theme.comp, width: 2, points: { show: true, size: 6, fill: () => theme.comp, stroke: () => theme.comp } }, edge, edge],
      bands: [{ series: [2, 3], fill: () => faint(theme.comp, 0.25) }],
    }, this.data(), this.element);
  }

  data() {
    const { presses, mean, above, below } = this.columns;
    return /** @type {import("uplot").AlignedData} */ ([presses, mean, above, below]);
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

  /** @param {Wire.HeldOutError[]} progress */
  show(progress) {
    this.columns = columnsOf(progress);
    this.ends = endsOf(this.columns);
    this.draw();
    this.describe(progress);
  }

  draw() {
    this.plot.setData(this.data());
  }

  /**
   * For those who cannot see it.
   * @param {Wire.HeldOutError[]} progress
   */
  describe(progress) {
    const known = progress.filter(({ mean_absolute_g }) => mean_absolute_g !== null);
    const last = lastError(progress);
    const text = last ? `${errorText(known[0])} after ${countText(known[0].presses)}, ${errorText(last)} after ${countText(last.presses)}` : "no values yet";
    this.element.setAttribute("aria-label", `Held-out error against the number of presses: ${text}`);
    this.element.dataset.points = String(known.length);
  }
}
