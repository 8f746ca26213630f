// Puts the page together: which parts there are, and what each of them gets.

import { Charts } from "./charts.js";
import { Connection } from "./connection.js";
import { Controls } from "./controls.js";
import { byId, dialogById, openDialog } from "./dom.js";
import { Drawing } from "./drawing.js";
import { savePicture, saveRegions, saveTable } from "./export.js";
import { Figures } from "./figures.js";
import { History } from "./history.js";
import { startKeys } from "./keys.js";
import { Overlay } from "./overlay.js";
import { Panel } from "./panel.js";
import { Playback } from "./playback.js";
import { Pointer } from "./pointer.js";
import { Requests } from "./requests.js";
import { MAX_REGIONS, Selection } from "./selection.js";
import { Session } from "./session.js";
import { Settings } from "./settings.js";
import { Sliders } from "./sliders.js";
import { Stage } from "./stage.js";
import { Status } from "./status.js";
import { startTheme } from "./theme.js";
import { toast } from "./toast.js";
import { loadFactor } from "./units.js";
import { View } from "./view.js";
import { Watch } from "./watch.js";

const NUMBERS_EVERY_MS = 125;

const settings = new Settings();
const selection = new Selection();
const view = new View(settings);
const history = new History(selection);
// Of the theme's colours the first drawing is made already.
startTheme(() => themeChanged());

/** @type {Session} */
let session;
const connection = new Connection({
  onText: (message) => session.takeText(message),
  onFrame: (message) => session.takeFrame(message),
  onStatus: () => view.set(connection.open ? { connection: connection.status, waitsSince: performance.now() } : { connection: connection.status }),
});
const requests = new Requests(connection);
const stage = new Stage(view, settings);
const { scale } = stage;
const playback = new Playback({ view, history, requests, makeRoom: (frame) => stage.makeRoom(frame) });
/** @param {number} time */
const goTo = (time) => playback.goTo(time);
const drawing = new Drawing({ view, settings, selection, history, stage });
const figures = new Figures(view);
const charts = new Charts({ view, settings, history, selection, figures, goTo, seek: (secs) => playback.seek(secs) });
const forceDecimals = () => charts.decimals("force");
const panel = new Panel({ view, history, selection, scale, forceDecimals, goTo });
const source = { view, settings, history, selection, stage };
const controls = new Controls({
  view, settings, requests, scale,
  savePicture: () => {
    drawing.drawNow();
    return savePicture(source);
  },
  saveTable: () => saveTable(source),
  saveRegions: () => saveRegions(source),
  onTheme: () => themeChanged(),
});
new Sliders(view, requests);
const overlay = new Overlay(view, connection);
const status = new Status(view, drawing.timing);
new Watch({ view, selection, connection });
session = new Session({
  view, history, selection, timing: drawing.timing,
  got: (sequence) => connection.got(sequence),
  onFrame: (frame) => stage.follow(frame),
  onDetails: (details) => {
    panel.takeDetails(details);
    figures.take(details);
  },
});
const pointer = new Pointer(stage, settings, {
  pick: (taxel) => view.pick(taxel),
  pin,
  region: addRegion,
  draft: (corners) => drawing.setDraft(corners),
  camera: () => drawing.redraw(),
});

/** @param {Page.Taxel} taxel */
function pin(taxel) {
  const { sensor } = view;
  if (sensor && selection.togglePin(taxel, { buffer: history.buffer, sensor }) === "full") toast("Eight taxels are pinned: take one away first", "bad");
}

/**
 * @param {string} shape
 * @param {Page.Corner[]} corners
 */
function addRegion(shape, corners) {
  const { sensor } = view;
  const done = sensor && selection.addRegion(shape, corners, { buffer: history.buffer, sensor });
  if (done === "empty") toast("No taxel lies inside", "bad");
  if (done === "full") toast(`There are ${MAX_REGIONS} regions: take one away first`, "bad");
}

/**
 * @param {number} right
 * @param {number} down
 * @param {number} taxels
 */
function movePicked(right, down, taxels) {
  const { sensor } = view;
  const { picked, shown } = view.now;
  if (!sensor || !shown) return;
  const from = picked || { row: sensor.rows >> 1, column: sensor.columns >> 1 };
  const step = picked ? settings.orientation.step(right * taxels, down * taxels) : { rows: 0, columns: 0 };
  /**
   * @param {number} value
   * @param {number} count
   */
  const within = (value, count) => Math.min(count - 1, Math.max(0, value));
  const to = { row: within(from.row + step.rows, sensor.rows), column: within(from.column + step.columns, sensor.columns) };
  view.pick(to);
  byId("announce").textContent = `row ${to.row}, column ${to.column}: ${panel.load}`;
}

startKeys({
  tare: () => controls.tare(),
  record: () => controls.toggleRecording(),
  event: () => controls.askEvent(),
  nextMethod: () => controls.nextMethod(),
  nextUnit: () => controls.nextUnit(),
  layout: (layout) => settings.set("layout", layout),
  difference: () => settings.toggle("difference"),
  smooth: () => settings.toggle("smooth"),
  surface: () => settings.toggle("surface"),
  marks: () => settings.toggle("marks"),
  cop: () => settings.toggle("cop"),
  help: () => openDialog(dialogById("keys-dialog")),
  pause: () => playback.toggle(),
  isPaused: () => view.now.paused,
  step: (frames) => playback.step(frames),
  movePicked,
  pin: () => view.now.picked && pin(view.now.picked),
  escape: () => {
    if (pointer.cancel()) return;
    if (view.now.picked) view.pick(null);
    else selection.clear();
  },
  hasLetters: () => settings.values.letters,
  leaveField: () => byId("stage").focus(),
});

// All from one frame, at one time: its number stands in the panel.
function numbers() {
  const { shown, paused } = view.now;
  connection.check();
  status.update();
  overlay.update();
  if (!shown || document.hidden) return;
  charts.update();
  stage.writeSums(shown, forceDecimals());
  panel.update();
  if (!paused) playback.write();
}

function themeChanged() {
  drawing.redraw();
  charts.update();
  panel.update();
}

// The fixed end of the scale is in the unit shown: another unit gets another number for the same load.
let lastFactor = NaN;
function keepFixedScale() {
  const factor = view.sensor ? loadFactor(view.unit, view.sensor.taxel_area_mm2) : NaN;
  if (lastFactor > 0 && factor > 0) settings.set("scaleFixed", Number(((settings.values.scaleFixed * factor) / lastFactor).toPrecision(4)));
  lastFactor = factor;
}

settings.onChange((name) => {
  if (["layout", "difference", "surface", "orientation"].includes(name)) stage.layOut();
  if (stage.surfaceMissing) controls.setSurfaceMissing();
  // What is shown is another quantity, or another map: the scale starts anew instead of creeping there.
  if (name === "unit" || name === "layout") scale.reset();
  if (name === "unit") keepFixedScale();
  const { shown } = view.now;
  if (["unit", "layout", "scaleMode", "scaleFixed"].includes(name) && shown) stage.follow(shown);
  drawing.redraw();
  numbers();
});
view.on(["hello"], () => {
  lastFactor = view.sensor ? loadFactor(view.unit, view.sensor.taxel_area_mm2) : NaN;
});
view.on(["shown"], () => {
  // What is looked at frame by frame is read so too.
  if (view.now.paused) numbers();
});
setInterval(numbers, NUMBERS_EVERY_MS);
connection.connect();

window.taxelView = Object.freeze({
  get frames() { return view.now.frames; },
  get lastSequence() { return view.now.live ? view.now.live.sequence : null; },
  get connected() { return connection.open; },
  shown: () => {
    const { shown, newtons } = view.now;
    return shown ? { sequence: shown.sequence, total_newtons: newtons ? shown.total : null, unit: view.unit.key, method: view.method } : null;
  },
});
