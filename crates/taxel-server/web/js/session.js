// What the server says, into the view and the history.

import { MarkTable } from "./marks.js";
import { NO_LINES } from "./view.js";
import { frameOf, isNewtons } from "./wire.js";
import { MAX_REGIONS } from "./selection.js";
import { toast } from "./toast.js";

const PROTOCOL = 3;

export class Session {
  /**
   * @param {object} parts
   * @param {import("./view.js").View} parts.view
   * @param {import("./history.js").History} parts.history
   * @param {import("./selection.js").Selection} parts.selection
   * @param {{ take: number }} parts.timing how long the newest frame took, ms
   * @param {(sequence: number) => void} parts.got tells the server that a frame is here
   * @param {(frame: Page.Frame) => void} parts.onFrame before a frame is shown
   * @param {(details: Wire.Details) => void} parts.onDetails
   */
  constructor(parts) {
    this.parts = parts;
  }

  /** @param {Wire.Message} message */
  takeText(message) {
    if (message.kind === "hello") this.takeHello(message);
    else if (message.kind === "state") this.takeState(message);
    else if (message.kind === "event") this.parts.history.addEvent(message);
    else if (message.kind === "details") this.parts.onDetails(message);
    else if (message.kind === "curve") this.parts.history.curve = message;
  }

  /**
   * A hello starts everything afresh: another sensor may be behind it.
   * @param {Wire.Hello} hello
   */
  takeHello(hello) {
    const { view, history, selection } = this.parts;
    if (hello.protocol !== PROTOCOL) toast(`The server speaks protocol ${hello.protocol}, this page ${PROTOCOL}: reload the page`, "bad");
    const same = view.sensor !== null && JSON.stringify(view.sensor) === JSON.stringify(hello.sensor);
    history.reset(hello.sensor);
    // After a reconnection to the same sensor the user finds his pins where they were.
    view.set({
      hello, marks: new MarkTable(hello.marks), state: null, badLines: NO_LINES, newtons: hello.sensor.has_load_law,
      live: null, shown: null, paused: false, picked: same ? view.now.picked : null, waitsSince: performance.now(),
    });
    if (same) {
      selection.forget();
      return;
    }
    selection.clear();
    const left = selection.addKnown(hello.sensor.regions, { buffer: history.buffer, sensor: hello.sensor });
    if (left > 0) toast(`${left} of the sensor's ${hello.sensor.regions.length} regions are not shown: ${MAX_REGIONS} are the most`, "bad");
  }

  /** @param {Wire.State} state */
  takeState(state) {
    const { view } = this.parts;
    const before = view.now.badLines;
    const same = JSON.stringify(before) === JSON.stringify(state.bad_lines);
    view.set({ state, badLines: same ? before : state.bad_lines });
  }

  /** @param {ArrayBuffer} message */
  takeFrame(message) {
    const before = performance.now();
    const frame = frameOf(message);
    if (!frame) return;
    try {
      this.useFrame(frame);
    } finally {
      // Also for frames that are not shown: the server counts what is on the way.
      this.parts.got(frame.sequence);
    }
    this.parts.timing.take = performance.now() - before;
  }

  /** @param {Page.Frame} frame */
  useFrame(frame) {
    const { view, history, onFrame } = this.parts;
    const { sensor } = view;
    if (!sensor || frame.rows !== sensor.rows || frame.columns !== sensor.columns) return;
    if (!Number.isFinite(frame.host)) frame.host = Date.now() / 1000;
    const newtons = isNewtons(frame);
    if (!newtons) sumSiemens(frame, view.now.marks);
    view.set({ live: frame, frames: view.now.frames + 1, frameAt: performance.now(), newtons });
    if (view.now.paused) return;
    history.keep(frame, sensor);
    onFrame(frame);
    view.show(frame);
  }
}

/**
 * Without a load law the server's sums mean nothing: the charts then show conductances.
 * @param {Page.Frame} frame
 * @param {MarkTable} marks
 */
function sumSiemens(frame, marks) {
  frame.total = marks.sum(frame.compensated, frame.marks);
  frame.peak = -Infinity;
  for (const value of frame.compensated) if (value > frame.peak) frame.peak = value;
}
