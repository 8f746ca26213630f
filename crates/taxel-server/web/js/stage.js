// The maps and their colour bar: how they are laid out, on which scale, and the drawing of a frame.

import { evened } from "./areas.js";
import { Tile } from "./tile.js";
import { ColourBar, BAR_WIDTH } from "./colourbar.js";
import { MARGIN } from "./furniture.js";
import { Camera } from "./surface.js";
import { Scale } from "./scale.js";
import { colourTable, differenceTable } from "./colour.js";
import { fixed, forceUnit, loadFactor, significant } from "./units.js";
import { isNewtons, isRaw } from "./wire.js";
import { byId, canvasById, inside, write } from "./dom.js";
import { layoutOf } from "./places.js";

const CAPTION = 26;
const GAP = 14;
const SURFACE_ASPECT = 1.7;
const MIN_CHARTS = 178;
const TWO_ROWS_OF_CHARTS = 380;
const NARROW = "(max-width: 1120px)";
// Below the charts' least height and the time line, the maps still get this much.
const MIN_MAPS = 220;
const SUMMARY_EVERY_MS = 1000;

export class Stage {
  /**
   * @param {import("./view.js").View} view
   * @param {import("./settings.js").Settings} settings
   */
  constructor(view, settings) {
    this.view = view;
    this.settings = settings;
    this.element = byId("stage");
    this.tiles = { raw: new Tile("raw", true), compensated: new Tile("compensated", true), difference: new Tile("difference", false) };
    this.bar = new ColourBar(canvasById("colour-bar"));
    this.camera = new Camera();
    this.scale = new Scale();
    this.narrow = matchMedia(NARROW);
    this.surfaceMissing = false;
    this.differences = new Float32Array(0);
    /** Of pressures on taxels of different areas. */
    this.evened = { raw: new Float32Array(0), compensated: new Float32Array(0) };
    this.barHeight = 0;
    this.ratio = 1;
    this.summaryAt = -Infinity;
    /** Called when the maps have new sizes: resized canvases are blank, and would flash until the next frame. */
    this.onLaidOut = () => {};
    new ResizeObserver(() => this.layOut()).observe(byId("work"));
    window.addEventListener("resize", () => this.layOut());
  }

  get shownTiles() {
    return Object.values(this.tiles).filter((tile) => tile.visible);
  }

  /** @param {Wire.SensorFacts} sensor */
  reset(sensor) {
    for (const tile of Object.values(this.tiles)) tile.reset(sensor);
    const taxels = sensor.rows * sensor.columns;
    this.differences = new Float32Array(taxels);
    this.evened = { raw: new Float32Array(taxels), compensated: new Float32Array(taxels) };
    this.scale.reset();
    this.layOut();
  }

  layOut() {
    const { settings } = this;
    const { sensor } = this.view;
    if (!sensor) return;
    const { surface } = settings.values;
    const { layout, difference } = this.view.maps;
    this.tiles.raw.show(layout !== "compensated");
    this.tiles.compensated.show(layout !== "raw");
    this.tiles.difference.show(difference);
    for (const tile of this.shownTiles) {
      if (!tile.setSurface(surface, this.camera)) {
        this.surfaceMissing = true;
        // Which comes back here without it.
        settings.set("surface", false);
        return;
      }
    }
    const tiles = this.shownTiles;
    const orientation = settings.orientation;
    const [width, height] = layoutOf(sensor).extent(sensor);
    const aspect = surface ? SURFACE_ASPECT : orientation.turned ? height / width : width / height;
    const bars = difference ? 2 : 1;
    const roomWide = this.element.clientWidth - 24 - BAR_WIDTH * bars - 8;
    const place = arrange(tiles.length, roomWide, this.roomHigh(), aspect);
    const ratio = Math.min(2, window.devicePixelRatio || 1);
    byId("tiles").style.gridTemplateColumns = `repeat(${place.across}, auto)`;
    for (const tile of tiles) {
      tile.resize(place.width + MARGIN.left + MARGIN.right, place.height + MARGIN.top + MARGIN.bottom, ratio, orientation);
    }
    const tileHigh = place.height + MARGIN.top + MARGIN.bottom;
    this.barHeight = place.down * (tileHigh + CAPTION) + (place.down - 1) * GAP;
    this.ratio = ratio;
    // What the maps leave decides whether the charts lie in one row or in two.
    const work = byId("work");
    const room = work.clientHeight - tileHigh * place.down - inside(work, ".time").offsetHeight;
    byId("charts").classList.toggle("tall", !this.narrow.matches && room > TWO_ROWS_OF_CHARTS);
    this.onLaidOut();
  }

  // What the charts and the time line leave, or half of the window where the page scrolls.
  roomHigh() {
    if (this.narrow.matches) return Math.round(window.innerHeight * 0.46);
    const work = byId("work");
    return Math.max(MIN_MAPS, work.clientHeight - inside(work, ".time").offsetHeight - MIN_CHARTS - 24);
  }

  /** @param {Page.Frame} frame */
  follow(frame) {
    const { scaleMode, scaleFixed } = this.settings.values;
    this.scale.update(this.highest(frame), frame.host, scaleMode, scaleFixed);
  }

  /**
   * While paused, frames are compared on one scale, which only grows if one of them does not fit.
   * @param {Page.Frame} frame
   */
  makeRoom(frame) {
    if (this.settings.values.scaleMode !== "fixed") this.scale.makeRoom(this.highest(frame));
  }

  /**
   * Both loads of a frame, so that one factor shows those of all taxels.
   * @param {Page.Frame} frame
   */
  shownLoads(frame) {
    const { unit, sensor } = this.view;
    if (!sensor) return frame;
    return {
      raw: evened(frame.raw, sensor, unit, this.evened.raw),
      compensated: evened(frame.compensated, sensor, unit, this.evened.compensated),
    };
  }

  /** What a load is multiplied with to be shown. */
  get factor() {
    const { unit, sensor } = this.view;
    return loadFactor(unit, sensor ? sensor.taxel_area_mm2 : NaN);
  }

  /**
   * The highest load that is shown, in the unit shown.
   * @param {Page.Frame} frame
   */
  highest(frame) {
    const { layout } = this.view.maps;
    const { marks: meanings } = this.view.now;
    const { marks } = frame;
    const { raw, compensated } = this.shownLoads(frame);
    let highest = 0;
    const useRaw = layout !== "compensated";
    const useCompensated = layout !== "raw";
    for (let i = 0; i < marks.length; i += 1) {
      if (!meanings.scales(marks[i])) continue;
      if (useRaw && raw[i] > highest) highest = raw[i];
      if (useCompensated && compensated[i] > highest) highest = compensated[i];
    }
    return highest * this.factor;
  }

  /** @param {Page.Scene} scene */
  draw(scene) {
    const { scale, tiles } = this;
    const { frame } = scene;
    const { colours } = this.settings.values;
    const unit = this.view.unit.text;
    const table = colourTable(colours);
    const gain = this.factor / scale.top;
    const { raw, compensated } = this.shownLoads(frame);
    if (tiles.raw.visible) tiles.raw.draw(scene, raw, table, gain, 0);
    if (tiles.compensated.visible) tiles.compensated.draw(scene, compensated, table, gain, 0);
    const bars = [{ name: colours, table, low: 0, high: scale.top, unit, title: "Load" }];
    if (tiles.difference.visible) {
      for (let i = 0; i < this.differences.length; i += 1) this.differences[i] = raw[i] - compensated[i];
      tiles.difference.draw(scene, this.differences, differenceTable, gain / 2, 0.5);
      bars.push({ name: "difference", table: differenceTable, low: -scale.top, high: scale.top, unit: `Δ ${unit}`, title: "Difference" });
    }
    this.bar.draw(bars, this.barHeight, this.ratio);
  }

  /**
   * Over the taxels that count: the sum of the compensated loads is the total force.
   * @param {Page.Frame} frame
   * @param {number} decimals
   */
  writeSums(frame, decimals) {
    const { marks } = this.view.now;
    const unit = forceUnit(this.view.unit);
    const raw = marks.sum(frame.raw, frame.marks);
    const compensated = isNewtons(frame) ? frame.total : marks.sum(frame.compensated, frame.marks);
    const sums = { raw, compensated, difference: raw - compensated };
    for (const name of /** @type {(keyof sums)[]} */ (Object.keys(sums))) {
      this.tiles[name].sum.textContent = `Σ ${fixed(sums[name] * unit.factor, decimals)} ${unit.text}`;
    }
    this.writeMethod(frame);
    this.writeSummaries(frame);
  }

  /**
   * The frame says whether its cross-talk is removed: the method chosen may be of frames to come.
   * @param {Page.Frame} frame
   */
  writeMethod(frame) {
    if (this.view.exported) {
      write(this.tiles.compensated.title, "As exported");
      write("compensated-method", "cross-talk not removed");
      return;
    }
    const raw = isRaw(frame);
    write(this.tiles.compensated.title, raw ? "Not compensated" : "Compensated");
    write("compensated-method", raw ? "method raw: cross-talk not removed" : this.view.method);
  }

  /**
   * What the maps show, in words: for those who cannot see them. Read when a map gets the focus, not by itself: a text
   * that changes all the time and spoke would never be silent.
   * @param {Page.Frame} frame
   */
  writeSummaries(frame) {
    const now = performance.now();
    if (now - this.summaryAt < SUMMARY_EVERY_MS) return;
    this.summaryAt = now;
    const { raw, compensated, difference } = this.tiles;
    const loads = this.shownLoads(frame);
    for (const [tile, values] of /** @type {[Tile, Float32Array][]} */ ([[raw, loads.raw], [compensated, loads.compensated], [difference, this.differences]])) {
      if (tile.visible) write(tile.summary, this.summaryOf(frame, values, tile.sum.textContent || ""));
    }
  }

  /**
   * @param {Page.Frame} frame
   * @param {Float32Array} values
   * @param {string} sum
   */
  summaryOf(frame, values, sum) {
    const { marks, badLines } = this.view.now;
    let at = -1;
    let bad = 0;
    for (let i = 0; i < values.length; i += 1) {
      if (frame.marks[i] === marks.absent) continue;
      if (marks.of(frame.marks[i]).severity === 2) bad += 1;
      else if (at < 0 || values[i] > values[at]) at = i;
    }
    const place = at < 0 ? "" : `, highest ${significant(values[at] * this.factor)} ${this.view.unit.text} at row ${Math.floor(at / frame.columns)}, column ${at % frame.columns}`;
    const centre = Number.isFinite(frame.copRow) ? `, centre of pressure at row ${fixed(frame.copRow, 0)}, column ${fixed(frame.copColumn, 0)}` : "";
    const lines = badLines.rows.length + badLines.columns.length;
    const faults = [bad > 0 ? `${bad} bad taxels` : "", lines > 0 ? `${lines} bad lines` : ""].filter(Boolean).join(", ");
    return `Frame ${frame.sequence}: sum ${sum.replace("Σ ", "")}${place}${centre}${faults ? `; ${faults}` : ""}.`;
  }
}

/**
 * The arrangement in columns that makes the maps largest; on a tie, side by side.
 * @param {number} count
 * @param {number} roomWide
 * @param {number} roomHigh
 * @param {number} aspect
 */
function arrange(count, roomWide, roomHigh, aspect) {
  let best = { across: 0, down: 0, width: 0, height: 0 };
  for (let across = count; across >= 1; across -= 1) {
    const down = Math.ceil(count / across);
    const mostWide = (roomWide - GAP * (across - 1)) / across - MARGIN.left - MARGIN.right;
    const mostHigh = (roomHigh - GAP * (down - 1)) / down - CAPTION - MARGIN.top - MARGIN.bottom;
    const width = Math.max(60, Math.min(mostWide, mostHigh * aspect));
    if (width > best.width * 1.12) best = { across, down, width, height: width / aspect };
  }
  best.width = Math.floor(best.width);
  best.height = Math.floor(best.height);
  return best;
}
