// What the page knows and shows, in one store. The parts read it and hear of its changes; few of them write.

import { Store } from "./store.js";
import { MarkTable } from "./marks.js";
import { MICROSIEMENS, unitOf } from "./units.js";

/**
 * @typedef {object} ViewValues
 * @property {Wire.Hello | null} hello the server's first message
 * @property {MarkTable} marks what the codes of marks mean
 * @property {Wire.State | null} state how things stand, as the server said last
 * @property {Wire.BadLines} badLines
 * @property {boolean} newtons loads are newtons, not siemens
 * @property {Page.Frame | null} live the newest frame
 * @property {number} frames how many have come
 * @property {number} frameAt when the newest came, by the page's clock, ms
 * @property {Page.Frame | null} shown the frame on the screen
 * @property {boolean} paused
 * @property {Page.Taxel | null} picked
 * @property {import("./connection.js").Status} connection
 * @property {number} waitsSince since when the page waits for a frame, by its clock, ms
 */

/** @type {Wire.BadLines} */
export const NO_LINES = { rows: [], columns: [], suspect_rows: [], suspect_columns: [] };

/** @returns {ViewValues} */
const atFirst = () => ({
  hello: null, marks: new MarkTable([]), state: null, badLines: NO_LINES, newtons: true,
  live: null, frames: 0, frameAt: 0, shown: null, paused: false, picked: null, connection: "connecting", waitsSince: 0,
});

/** @extends {Store<ViewValues>} */
export class View extends Store {
  /** @param {import("./settings.js").Settings} settings */
  constructor(settings) {
    super(atFirst());
    this.settings = settings;
  }

  get sensor() {
    return this.now.hello ? this.now.hello.sensor : null;
  }

  /** Whether what is shown is a recording. */
  get isFile() {
    return this.now.hello !== null && this.now.hello.file !== null;
  }

  get isOpen() {
    return this.now.connection === "open";
  }

  get methods() {
    return this.now.hello ? this.now.hello.methods : [];
  }

  get method() {
    return this.now.state ? this.now.state.method : this.methods[0] || "";
  }

  /** The unit that loads of a taxel are shown in. */
  get unit() {
    if (this.now.newtons) return unitOf(this.settings.values.unit);
    const { exported } = this;
    return exported && exported.unit !== null ? { key: exported.unit, text: exported.unit, pressure: false, factor: exported.per_siemens } : MICROSIEMENS;
  }

  /** What has to be known of numbers that another program has found; null where they are read here. */
  get exported() {
    return this.sensor ? this.sensor.exported : null;
  }

  /** Which maps are shown: one alone of loads that another program has found, since nothing was taken off them here. */
  get maps() {
    const { layout, difference } = this.settings.values;
    return this.exported ? { layout: /** @type {import("./settings.js").Layout} */ ("compensated"), difference: false } : { layout, difference };
  }

  /** @param {Page.Frame} frame may be the one that is shown, with other content */
  show(frame) {
    if (this.now.shown === frame) this.touch("shown");
    else this.set({ shown: frame });
  }

  /** @param {boolean} paused */
  setPaused(paused) {
    const { live } = this.now;
    this.set(!paused && live ? { paused, shown: live } : { paused });
  }

  /** @param {Page.Taxel | null} taxel */
  pick(taxel) {
    const { picked } = this.now;
    if (picked && taxel && picked.row === taxel.row && picked.column === taxel.column) return;
    this.set({ picked: taxel });
  }
}
