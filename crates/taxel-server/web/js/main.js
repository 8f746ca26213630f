// Puts the page together: what the server says goes to the parts, frames go to the buffer and the maps.

import { decodeFrame, isNewtons } from "./wire.js";
import { Connection } from "./connection.js";
import { FrameBuffer } from "./buffer.js";
import { Series } from "./series.js";
import { Trail } from "./trail.js";
import { Settings } from "./settings.js";
import { Selection } from "./selection.js";
import { Stage, sumSiemens } from "./stage.js";
import { Pointer } from "./pointer.js";
import { Charts } from "./charts.js";
import { Panel } from "./panel.js";
import { Playback } from "./playback.js";
import { Controls } from "./controls.js";
import { Sliders } from "./sliders.js";
import { Overlay } from "./overlay.js";
import { Status } from "./status.js";
import { startKeys, actionsOf } from "./keys.js";
import { startTheme } from "./theme.js";
import { toast } from "./toast.js";
import { unitOf, MICROSIEMENS, loadFactor } from "./units.js";

const SHOWN_PER_SECOND = 60;
const HIDDEN_PER_SECOND = 5;
const NUMBERS_EVERY_MS = 125;
const MOST_WATCHED = 16;
const PROTOCOL = 1;
const CLOCK_SLACK_SECONDS = 0.5;

class App {
  constructor() {
    this.settings = new Settings();
    this.hello = null;
    this.sensor = null;
    this.state = null;
    this.live = null; // the newest frame
    this.shown = null; // the frame on the screen
    this.paused = false;
    this.picked = null;
    this.frames = 0;
    this.frameAt = 0;
    this.helloAt = 0;
    this.badLines = { rows: [], columns: [] };
    this.timing = { mean: 0, last: 0, take: 0 };
    this.dirty = false;
    this.watched = "";
    this.lastFactor = NaN;
    this.series = new Series(["total", "peak", "area", "copRow", "copColumn"]);
    this.trail = new Trail();
    this.scene = { frame: null, marks: null, marksVersion: 0, badLinesKey: "", draft: null, trail: this.trail };
    this.selection = new Selection(() => this.selectionChanged());
    this.connection = new Connection({
      onText: (object) => this.takeText(object),
      onFrame: (message) => this.takeFrame(message),
      onStatus: () => this.connectionChanged(),
    });
  }

  start() {
    startTheme(() => this.themeChanged());
    this.stage = new Stage(this);
    this.playback = new Playback(this);
    this.charts = new Charts(this);
    this.panel = new Panel(this);
    this.controls = new Controls(this);
    this.sliders = new Sliders(this);
    this.overlay = new Overlay(this);
    this.status = new Status(this);
    this.pointer = new Pointer(this.stage, this.settings, {
      pick: (taxel) => this.pick(taxel),
      pin: (taxel) => this.pin(taxel),
      region: (shape, corners) => this.addRegion(shape, corners),
      draft: (corners) => {
        this.scene.draft = corners;
        this.redraw();
      },
      camera: () => this.redraw(),
    });
    startKeys(actionsOf(this));
    this.settings.onChange((name) => this.settingChanged(name));
    new ResizeObserver(() => this.stage.layOut()).observe(document.getElementById("work"));
    window.addEventListener("resize", () => this.stage.layOut());
    document.addEventListener("visibilitychange", () => this.sendRate());
    setInterval(() => this.numbers(), NUMBERS_EVERY_MS);
    const tick = () => {
      requestAnimationFrame(tick);
      if (this.dirty) this.drawNow();
    };
    requestAnimationFrame(tick);
    this.connection.connect();
  }

  get newtons() {
    return this.live ? isNewtons(this.live) : !this.sensor || this.sensor.has_load_law;
  }

  get unit() {
    return this.newtons ? unitOf(this.settings.values.unit) : MICROSIEMENS;
  }

  get methods() {
    return this.hello ? this.hello.methods : [];
  }

  get method() {
    return this.state ? this.state.method : this.methods[0] || "";
  }

  // Sends a command. A refusal is always shown; a success if it is given in words.
  command(command, success) {
    const sent = this.connection.send(command, (ok, text) => {
      if (!ok) toast(text || `The server refuses: ${command.do}`, "bad");
      else if (success) toast(text || success);
    });
    if (!sent) toast("Not connected: nothing was sent", "bad");
  }

  // A command whose answer the caller takes.
  ask(command, answer) {
    if (!this.connection.send(command, answer)) toast("Not connected: nothing was sent", "bad");
  }

  takeText(object) {
    if (object.kind === "hello") this.takeHello(object);
    else if (object.kind === "state") this.takeState(object);
    else if (object.kind === "event") this.playback.addEvent(object);
    else if (object.kind === "details") this.panel.takeDetails(object);
  }

  // A hello starts everything afresh: another sensor may be behind it.
  takeHello(hello) {
    if (hello.protocol !== PROTOCOL) toast(`The server speaks protocol ${hello.protocol}, this page ${PROTOCOL}: reload the page`, "bad");
    const same = this.sensor && JSON.stringify(this.sensor) === JSON.stringify(hello.sensor);
    this.hello = hello;
    this.sensor = hello.sensor;
    this.source = hello.source;
    this.helloAt = performance.now();
    this.state = null;
    this.live = null;
    this.shown = null;
    this.paused = false;
    this.watched = "";
    this.badLines = { rows: [], columns: [] };
    this.scene.badLinesKey = "";
    this.scene.marks = new Uint8Array(this.sensor.rows * this.sensor.columns);
    this.scene.marksVersion += 1;
    this.buffer = new FrameBuffer(this.sensor.rows, this.sensor.columns);
    this.series.clear();
    // After a reconnection to the same sensor the user finds his pins where they were.
    if (!same) {
      this.picked = null;
      this.selection.clear();
    } else {
      for (const item of this.selection.items) item.series.clear();
    }
    this.lastFactor = loadFactor(this.unit, this.sensor.taxel_area_mm2);
    this.playback.reset();
    this.stage.reset();
    this.controls.takeHello();
    this.status.takeHello();
    this.sliders.reset(hello.sliders || []);
    this.sendRate();
    this.sendWatch();
  }

  takeState(state) {
    this.state = state;
    this.badLines = state.bad_lines || { rows: [], columns: [] };
    const key = JSON.stringify(this.badLines);
    if (key !== this.scene.badLinesKey) {
      this.scene.badLinesKey = key;
      this.redraw();
    }
    this.controls.takeState();
    this.status.takeState();
    this.playback.takePlayer(state.player);
    this.sliders.takeState(state.sliders);
  }

  takeFrame(message) {
    const before = performance.now();
    let frame;
    try {
      frame = decodeFrame(message);
    } catch (error) {
      console.warn(error.message);
      return;
    }
    try {
      this.useFrame(frame);
    } finally {
      // Also for frames that are not shown: the server counts what is on the way.
      this.connection.got(frame.sequence);
    }
    this.timing.take = performance.now() - before;
  }

  useFrame(frame) {
    if (!this.sensor || frame.rows !== this.sensor.rows || frame.columns !== this.sensor.columns) return;
    if (!Number.isFinite(frame.host)) frame.host = Date.now() / 1000;
    if (!isNewtons(frame)) sumSiemens(frame);
    const unitBefore = this.unit;
    this.live = frame;
    this.frames += 1;
    this.frameAt = performance.now();
    if (this.unit !== unitBefore) this.controls.takeHello();
    if (this.paused) return;
    this.keep(frame);
    this.stage.follow(frame);
    this.show(frame);
  }

  keep(frame) {
    const back = this.series.lastTime - frame.host;
    // A file that is sought or starts over goes back in time: what is buffered lies then in the future.
    if (back > CLOCK_SLACK_SECONDS) this.forget();
    // A clock set back a little: the buffer stays in order without these few frames.
    else if (back > 0) return;
    this.buffer.push(frame);
    this.series.push(frame.host, frame);
    this.selection.takeFrame(frame, this.sensor);
  }

  forget() {
    this.buffer.clear();
    this.series.clear();
    for (const item of this.selection.items) item.series.clear();
  }

  show(frame) {
    this.shown = frame;
    this.scene.frame = frame;
    this.dirty = true;
    // What is looked at frame by frame is read so too.
    if (this.paused) this.numbers();
  }

  redraw() {
    if (this.shown) this.dirty = true;
  }

  drawNow() {
    if (!this.shown) return;
    const before = performance.now();
    this.dirty = false;
    const { scene, settings } = this;
    scene.sensor = this.sensor;
    scene.selection = this.selection;
    scene.picked = this.picked;
    scene.badLines = this.badLines;
    scene.smooth = settings.values.smooth;
    scene.showMarks = settings.values.marks;
    scene.showCop = settings.values.cop;
    this.noteMarks();
    if (scene.showCop) this.trail.lay(this.series, this.shown.host);
    this.stage.draw(scene);
    this.timing.last = performance.now() - before + this.timing.take;
    this.timing.mean += (this.timing.last - this.timing.mean) * 0.05;
  }

  // The layer with the marks is drawn again only if they differ from those it shows.
  noteMarks() {
    const { marks } = this.shown;
    const known = this.scene.marks;
    for (let i = 0; i < marks.length; i += 1) {
      if (marks[i] !== known[i]) {
        known.set(marks);
        this.scene.marksVersion += 1;
        return;
      }
    }
  }

  numbers() {
    this.connection.check();
    this.status.update();
    this.overlay.update();
    if (!this.shown || document.hidden) return;
    // All from one frame, at one time: its number stands in the panel.
    this.charts.update();
    this.stage.writeSums(this.shown);
    this.panel.update();
    if (!this.paused) this.playback.write();
  }

  setPaused(paused) {
    this.paused = paused;
    document.body.classList.toggle("paused", paused);
    if (!paused && this.live) {
      this.show(this.live);
    }
  }

  pick(taxel) {
    if (this.picked && taxel && this.picked.row === taxel.row && this.picked.column === taxel.column) return;
    this.picked = taxel;
    this.sendWatch();
    this.panel.update();
    this.redraw();
  }

  pin({ row, column }) {
    if (this.selection.togglePin(row, column, this) === "full") toast("Eight taxels are pinned: take one away first", "bad");
  }

  addRegion(shape, corners) {
    const done = this.selection.addRegion(shape, corners, this);
    if (done === "empty") toast("No taxel lies inside", "bad");
    if (done === "full") toast("There are eight regions: take one away first", "bad");
  }

  selectionChanged() {
    if (!this.charts) return;
    this.charts.takeSelection(this.selection);
    this.sendWatch();
    this.panel.update();
    this.charts.update();
    this.redraw();
  }

  movePicked(right, down, taxels) {
    if (!this.sensor || !this.shown) return;
    const { rows, columns } = this.sensor;
    const from = this.picked || { row: rows >> 1, column: columns >> 1 };
    const step = this.picked ? this.settings.orientation.step(right * taxels, down * taxels) : { rows: 0, columns: 0 };
    const within = (value, count) => Math.min(count - 1, Math.max(0, value));
    this.pick({ row: within(from.row + step.rows, rows), column: within(from.column + step.columns, columns) });
    const load = document.getElementById("taxel-load").textContent;
    document.getElementById("announce").textContent = `row ${this.picked.row}, column ${this.picked.column}: ${load}`;
  }

  escape() {
    if (this.pointer.cancel()) return;
    if (this.picked) this.pick(null);
    else this.selection.clear();
  }

  sendRate() {
    if (this.hello) this.connection.send({ do: "rate", frames_per_second: document.hidden ? HIDDEN_PER_SECOND : SHOWN_PER_SECOND });
  }

  sendWatch() {
    const taxels = [...(this.picked ? [this.picked] : []), ...this.selection.pins].map(({ row, column }) => [row, column]).slice(0, MOST_WATCHED);
    const key = JSON.stringify(taxels);
    if (key !== this.watched && this.connection.send({ do: "watch", taxels })) this.watched = key;
  }

  connectionChanged() {
    if (!this.overlay) return;
    if (this.connection.open) this.helloAt = performance.now();
    this.overlay.update();
    this.status.writeDevice();
  }

  themeChanged() {
    this.redraw();
    this.charts.update();
    this.panel.update();
  }

  settingChanged(name) {
    const { stage, settings } = this;
    if (["layout", "difference", "surface", "orientation"].includes(name)) stage.layOut();
    if (stage.surfaceMissing) this.controls.setSurfaceMissing();
    // What is shown is another quantity, or another map: the scale starts anew instead of creeping there.
    if (name === "unit" || name === "layout") stage.scale.reset();
    if (name === "unit") this.keepFixedScale();
    if (["unit", "layout", "scaleMode", "scaleFixed"].includes(name) && this.shown) stage.follow(this.shown);
    this.controls.write();
    this.redraw();
    this.numbers();
  }

  // The fixed end of the scale is in the unit shown: another unit gets another number for the same load.
  keepFixedScale() {
    const factor = this.sensor ? loadFactor(this.unit, this.sensor.taxel_area_mm2) : NaN;
    if (this.lastFactor > 0 && factor > 0) {
      this.settings.set("scaleFixed", Number(((this.settings.values.scaleFixed * factor) / this.lastFactor).toPrecision(4)));
    }
    this.lastFactor = factor;
  }
}

const app = new App();
app.start();

window.taxelView = Object.freeze({
  get frames() { return app.frames; },
  get lastSequence() { return app.live ? app.live.sequence : null; },
  get connected() { return app.connection.open; },
  shown: () => (app.shown ? { sequence: app.shown.sequence, total_newtons: app.newtons ? app.shown.total : null, unit: app.unit.key, method: app.method } : null),
});
