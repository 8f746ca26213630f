// One map of what the sensor feels now, beside a guided task: the viewer's map of the compensated loads, with its marks and a scale.

import { evened } from "./areas.js";
import { ColourBar, BAR_WIDTH } from "./colourbar.js";
import { colourTable } from "./colour.js";
import { byId, canvasById, write } from "./dom.js";
import { MARGIN } from "./furniture.js";
import { MarkTable } from "./marks.js";
import { layoutOf } from "./places.js";
import { Scale } from "./scale.js";
import { Selection } from "./selection.js";
import { Settings } from "./settings.js";
import { Tile } from "./tile.js";
import { Trail } from "./trail.js";
import { fixed, loadFactor, unitOf } from "./units.js";
import { isNewtons } from "./wire.js";
import { NO_LINES } from "./view.js";

/** Before there are newtons: a light press conducts as much, and noise does not fill the colours. */
const LEAST_TOP_MICROSIEMENS = 40;
export const MAP_COLOURS = "inferno";
/** The number is written less often than the map is drawn, and what is read out even less. */
const WRITE_EVERY_MS = 250;
const SUMMARY_EVERY_MS = 2000;

/**
 * @typedef {object} Shows
 * @property {string} name what the ids of its parts begin with
 * @property {string} unit of forces; conductances are shown as such
 * @property {number} least colours reach at least to this, so that an empty sensor does not show its noise
 * @property {string} title of the scale
 * @property {Scale} [scale] one for several maps, which only grows; without it the map follows what it shows
 */
/** @typedef {(g: CanvasRenderingContext2D, placement: import("./orientation.js").Placement, sensor: Wire.SensorFacts) => void} DrawOver */

export class LiveMap {
  /** @param {Shows} shows */
  constructor(shows) {
    this.shows = shows;
    this.box = byId(`${shows.name}-map`);
    this.tile = new Tile(shows.name, false);
    this.tile.show(true);
    this.barCanvas = canvasById(`${shows.name}-bar`);
    this.bar = new ColourBar(this.barCanvas);
    this.scale = shows.scale ?? new Scale();
    // The sensor lies here as it lies in the live view.
    this.orientation = new Settings().orientation;
    this.selection = new Selection();
    this.trail = new Trail();
    /** @type {Wire.SensorFacts | null} */
    this.sensor = null;
    this.meanings = new MarkTable([]);
    this.badLines = NO_LINES;
    this.badLinesKey = "";
    this.marks = new Uint8Array(0);
    this.marksVersion = 0;
    this.evened = new Float32Array(0);
    this.saidAt = -Infinity;
    this.writtenAt = -Infinity;
    this.ratio = 1;
    this.height = 0;
    /** The map is empty then, and to be drawn again. */
    this.onLaidOut = () => {};
    new ResizeObserver(() => this.layOut()).observe(this.box);
  }

  /** @param {Wire.Hello} hello */
  reset({ sensor, marks }) {
    this.sensor = sensor;
    this.meanings = new MarkTable(marks);
    this.marks = new Uint8Array(sensor.rows * sensor.columns);
    this.marksVersion += 1;
    this.evened = new Float32Array(sensor.rows * sensor.columns);
    if (!this.shows.scale) this.scale.reset();
    this.tile.reset(sensor);
    this.layOut();
  }

  /** @param {Wire.BadLines} lines */
  takeBadLines(lines) {
    const key = lines.rows.length + lines.columns.length > 0 ? JSON.stringify(lines) : "";
    if (key === this.badLinesKey) return;
    this.badLines = lines;
    this.badLinesKey = key;
  }

  // Where the screen is small the scale gives way to the map.
  get hasBar() {
    return getComputedStyle(this.barCanvas).display !== "none";
  }

  // As large as its place allows, with the sensor's own proportions.
  layOut() {
    const { sensor, orientation, box } = this;
    if (!sensor || box.clientWidth === 0) return;
    const [width, height] = layoutOf(sensor).extent(sensor);
    const aspect = orientation.turned ? height / width : width / height;
    // Where the page scrolls, its style sheet makes the place as high as the sensor needs it.
    box.style.setProperty("--aspect", aspect.toFixed(4));
    const style = getComputedStyle(box);
    const wide = box.clientWidth - parseFloat(style.paddingLeft) - parseFloat(style.paddingRight) - (this.hasBar ? BAR_WIDTH : 0) - MARGIN.left - MARGIN.right - 2;
    const high = box.clientHeight - parseFloat(style.paddingTop) - parseFloat(style.paddingBottom) - 30 - MARGIN.top - MARGIN.bottom;
    const across = Math.max(40, Math.floor(Math.min(wide, high * aspect)));
    const down = Math.max(30, Math.floor(across / aspect));
    this.ratio = Math.min(2, window.devicePixelRatio || 1);
    this.height = down + MARGIN.top + MARGIN.bottom;
    this.tile.resize(across + MARGIN.left + MARGIN.right, this.height, this.ratio, orientation);
    this.onLaidOut();
  }

  /**
   * @param {Page.Frame} frame
   * @param {DrawOver} [drawOver] draws what belongs on top, in CSS pixels of the map
   */
  draw(frame, drawOver) {
    const { sensor, tile } = this;
    if (!sensor || frame.marks.length !== this.marks.length || this.box.clientWidth === 0) return;
    this.noteMarks(frame);
    const newtons = isNewtons(frame);
    const factor = newtons ? loadFactor(unitOf(this.shows.unit), sensor.taxel_area_mm2) : 1e6;
    const values = newtons ? evened(frame.compensated, sensor, unitOf(this.shows.unit), this.evened) : frame.compensated;
    const highest = this.highest(values, frame.marks) * factor;
    const reach = Math.max(highest, newtons ? this.shows.least : LEAST_TOP_MICROSIEMENS);
    if (this.shows.scale) this.scale.makeRoom(reach);
    else this.scale.update(reach, frame.host, "follow", 0);
    const table = colourTable(MAP_COLOURS);
    const unit = newtons ? this.shows.unit : "µS";
    tile.draw({
      frame, sensor, meanings: this.meanings, marks: this.marks, marksVersion: this.marksVersion, badLines: this.badLines,
      badLinesKey: this.badLinesKey, draft: null, trail: this.trail, selection: this.selection, picked: null,
      smooth: false, showMarks: true, showCop: false,
    }, values, table, factor / this.scale.top, 0);
    this.bar.draw([{ name: MAP_COLOURS, table, low: 0, high: this.scale.top, unit, title: newtons ? this.shows.title : "Conductance" }], this.height, this.ratio);
    if (drawOver && tile.placement) drawOver(tile.context, tile.placement, sensor);
    this.say(frame, highest, unit);
  }

  /**
   * @param {Float32Array} values
   * @param {Uint8Array} marks
   */
  highest(values, marks) {
    let highest = 0;
    for (let i = 0; i < marks.length; i += 1) {
      if (values[i] > highest && this.meanings.scales(marks[i])) highest = values[i];
    }
    return highest;
  }

  /** @param {Page.Frame} frame */
  noteMarks({ marks }) {
    if (marks.every((mark, i) => mark === this.marks[i])) return;
    this.marks.set(marks);
    this.marksVersion += 1;
  }

  /**
   * @param {Page.Frame} frame
   * @param {number} highest
   * @param {string} unit
   */
  say(frame, highest, unit) {
    const now = performance.now();
    if (now - this.writtenAt > WRITE_EVERY_MS) {
      this.writtenAt = now;
      write(this.tile.sum, `highest ${fixed(highest, highest < 10 ? 1 : 0)} ${unit}`);
    }
    if (now - this.saidAt < SUMMARY_EVERY_MS) return;
    this.saidAt = now;
    const bad = frame.marks.reduce((count, mark) => count + (this.meanings.of(mark).severity === 2 ? 1 : 0), 0);
    write(this.tile.summary, `Highest ${fixed(highest, 1)} ${unit}, contact area ${fixed(frame.area, 0)} mm², ${bad} bad taxels.`);
  }
}
