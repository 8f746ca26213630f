// Draws the shown frame, at most once a picture of the screen.

import { NO_LINES } from "./view.js";
import { Trail } from "./trail.js";

export class Drawing {
  /**
   * @param {object} parts
   * @param {import("./view.js").View} parts.view
   * @param {import("./settings.js").Settings} parts.settings
   * @param {import("./selection.js").Selection} parts.selection
   * @param {import("./history.js").History} parts.history
   * @param {import("./stage.js").Stage} parts.stage
   */
  constructor({ view, settings, selection, history, stage }) {
    this.view = view;
    this.settings = settings;
    this.selection = selection;
    this.history = history;
    this.stage = stage;
    /** Milliseconds: for a frame on average, for the last one, and of that for taking it over. */
    this.timing = { mean: 0, last: 0, take: 0 };
    this.trail = new Trail();
    this.marks = new Uint8Array(0);
    this.marksVersion = 0;
    /** @type {Page.Corner[] | null} */
    this.draft = null;
    this.isDue = false;
    view.on(["hello"], () => this.reset());
    view.on(["shown", "picked", "badLines"], () => this.redraw());
    selection.onChange(() => this.redraw());
    stage.onLaidOut = () => this.drawNow();
    const tick = () => {
      requestAnimationFrame(tick);
      if (this.isDue) this.drawNow();
    };
    requestAnimationFrame(tick);
  }

  reset() {
    const { sensor } = this.view;
    if (!sensor) return;
    this.marks = new Uint8Array(sensor.rows * sensor.columns);
    this.marksVersion += 1;
    this.stage.reset(sensor);
  }

  redraw() {
    if (this.view.now.shown) this.isDue = true;
  }

  /** @param {Page.Corner[] | null} corners of a region that is being drawn */
  setDraft(corners) {
    this.draft = corners;
    this.redraw();
  }

  drawNow() {
    const { shown: frame, marks: meanings, badLines, picked } = this.view.now;
    const { sensor } = this.view;
    if (!frame || !sensor) return;
    const before = performance.now();
    this.isDue = false;
    const { smooth, marks: showMarks, cop: showCop } = this.settings.values;
    this.noteMarks(frame);
    const { trail } = this;
    if (showCop) trail.lay(this.history.series, frame.host);
    this.stage.draw({
      frame, sensor, meanings, marks: this.marks, marksVersion: this.marksVersion, badLines,
      badLinesKey: badLines === NO_LINES ? "" : JSON.stringify(badLines),
      draft: this.draft, trail, selection: this.selection, picked, smooth, showMarks, showCop,
    });
    this.timing.last = performance.now() - before + this.timing.take;
    this.timing.mean += (this.timing.last - this.timing.mean) * 0.05;
  }

  /**
   * The layer with the marks is drawn again only if they differ from those it shows.
   * @param {Page.Frame} frame
   */
  noteMarks({ marks }) {
    for (let i = 0; i < marks.length; i += 1) {
      if (marks[i] !== this.marks[i]) {
        this.marks.set(marks);
        this.marksVersion += 1;
        return;
      }
    }
  }
}
