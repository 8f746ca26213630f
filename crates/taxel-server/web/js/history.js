// What was seen: frames of the last minutes, their figures over time, and what happened.

import { FrameBuffer } from "./buffer.js";
import { Series } from "./series.js";

const MAX_EVENTS = 200;
const CLOCK_SLACK_SECONDS = 0.5;

export class History {
  /** @param {import("./selection.js").Selection} selection its numbers are kept with the frames */
  constructor(selection) {
    this.selection = selection;
    this.buffer = new FrameBuffer(0, 0);
    this.series = new Series(["total", "peak", "area", "copRow", "copColumn"]);
    /** @type {Page.Happening[]} */
    this.events = [];
    /** All of the file that is played, once the server knows it. @type {Wire.Curve | null} */
    this.curve = null;
  }

  /** @param {Wire.SensorFacts} sensor */
  reset(sensor) {
    this.curve = null;
    this.buffer = new FrameBuffer(sensor.rows, sensor.columns);
    this.series.clear();
    this.events = [];
  }

  /**
   * @param {Page.Frame} frame
   * @param {Wire.SensorFacts} sensor
   */
  keep(frame, sensor) {
    const back = this.series.lastTime - frame.host;
    // A file that is sought or starts over goes back in time: what is buffered lies then in the future.
    if (back > CLOCK_SLACK_SECONDS) this.forget();
    // A clock set back a little: the buffer stays in order without these few frames.
    else if (back > 0) return;
    this.buffer.push(frame);
    this.series.push(frame.host, frame);
    this.selection.takeFrame(frame, sensor);
  }

  forget() {
    this.buffer.clear();
    this.series.clear();
    this.selection.forget();
  }

  /** @param {Wire.Event} event */
  addEvent(event) {
    this.events.push({ time: event.host_secs, text: event.text });
    if (this.events.length > MAX_EVENTS) this.events.shift();
  }

  /** When the newest frame was, and how far back the oldest lies, s. */
  get reach() {
    const { buffer } = this;
    const last = buffer.length > 0 ? buffer.at(buffer.length - 1).host : NaN;
    return { last, seconds: buffer.length > 0 ? Math.max(last - buffer.at(0).host, 1e-3) : 0 };
  }
}
