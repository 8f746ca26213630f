// The maps and their colour bar: how they are laid out, on which scale, and the drawing of a frame.

import { Tile } from "./tile.js";
import { ColourBar, BAR_WIDTH } from "./colourbar.js";
import { MARGIN } from "./furniture.js";
import { Camera } from "./surface.js";
import { Scale } from "./scale.js";
import { colourTable, differenceTable } from "./colour.js";
import { fixed, forceUnit, loadFactor } from "./units.js";
import { isCounted, isNewtons, isRaw } from "./wire.js";

const CAPTION = 26;
const GAP = 14;
const SURFACE_ASPECT = 1.7;
const LEAST_CHARTS = 178;
const TWO_ROWS_OF_CHARTS = 380;
const NARROW = "(max-width: 1120px)";
// Marks whose values say nothing about the load must not set the scale: open, stuck, spike, flickering, shorted.
const NO_SCALE = [false, true, false, true, true, true, true, false, false, false];

export class Stage {
  constructor(app) {
    this.app = app;
    this.element = document.getElementById("stage");
    this.tiles = { raw: new Tile("raw"), compensated: new Tile("compensated"), difference: new Tile("difference") };
    this.bar = new ColourBar(document.getElementById("colour-bar"));
    this.camera = new Camera();
    this.scale = new Scale();
    this.narrow = matchMedia(NARROW);
    this.surfaceMissing = false;
  }

  get shownTiles() {
    return Object.values(this.tiles).filter((tile) => tile.visible);
  }

  reset() {
    const { rows, columns } = this.app.sensor;
    for (const tile of Object.values(this.tiles)) tile.reset(this.app.sensor);
    this.differences = new Float32Array(rows * columns);
    this.scale.reset();
    this.layOut();
  }

  layOut() {
    const { settings, sensor } = this.app;
    if (!sensor) return;
    const { layout, difference } = settings.values;
    this.tiles.raw.show(layout !== "compensated");
    this.tiles.compensated.show(layout !== "raw");
    this.tiles.difference.show(difference);
    let surface = settings.values.surface;
    for (const tile of this.shownTiles) {
      if (!tile.setSurface(surface, this.camera)) {
        this.surfaceMissing = true;
        surface = false;
        settings.set("surface", false);
        return;
      }
    }
    const tiles = this.shownTiles;
    const orientation = settings.orientation;
    const [width, height] = [sensor.columns * sensor.pitch_mm[1], sensor.rows * sensor.pitch_mm[0]];
    const aspect = surface ? SURFACE_ASPECT : orientation.turned ? height / width : width / height;
    const bars = difference ? 2 : 1;
    const roomWide = this.element.clientWidth - 24 - BAR_WIDTH * bars - 8;
    const place = arrange(tiles.length, roomWide, this.roomHigh(), aspect);
    const ratio = Math.min(2, window.devicePixelRatio || 1);
    document.getElementById("tiles").style.gridTemplateColumns = `repeat(${place.across}, auto)`;
    for (const tile of tiles) {
      tile.resize(place.width + MARGIN.left + MARGIN.right, place.height + MARGIN.top + MARGIN.bottom, ratio, orientation);
    }
    const tileHigh = place.height + MARGIN.top + MARGIN.bottom;
    this.barHeight = place.down * (tileHigh + CAPTION) + (place.down - 1) * GAP;
    this.ratio = ratio;
    // What the maps leave decides whether the charts lie in one row or in two.
    const room = document.getElementById("work").clientHeight - tileHigh * place.down - document.querySelector(".time").offsetHeight;
    document.getElementById("charts").classList.toggle("tall", !this.narrow.matches && room > TWO_ROWS_OF_CHARTS);
    // At once: resized canvases are blank, and would flash until the next frame.
    this.app.drawNow();
  }

  // What the charts and the time line leave, or half of the window where the page scrolls.
  roomHigh() {
    if (this.narrow.matches) return Math.round(window.innerHeight * 0.46);
    const work = document.getElementById("work");
    const time = work.querySelector(".time").offsetHeight;
    return Math.max(220, work.clientHeight - time - LEAST_CHARTS - 24);
  }

  follow(frame) {
    const { scaleMode, scaleFixed } = this.app.settings.values;
    this.scale.update(this.highest(frame), frame.host, scaleMode, scaleFixed);
  }

  // While paused, frames are compared on one scale, which only grows if one of them does not fit.
  makeRoom(frame) {
    if (this.app.settings.values.scaleMode !== "fixed") this.scale.makeRoom(this.highest(frame));
  }

  // The highest load that is shown, in the unit shown.
  highest(frame) {
    const { layout } = this.app.settings.values;
    const { raw, compensated, marks } = frame;
    let highest = 0;
    const useRaw = layout !== "compensated";
    const useCompensated = layout !== "raw";
    for (let i = 0; i < marks.length; i += 1) {
      if (NO_SCALE[marks[i]]) continue;
      if (useRaw && raw[i] > highest) highest = raw[i];
      if (useCompensated && compensated[i] > highest) highest = compensated[i];
    }
    return highest * loadFactor(this.app.unit, this.app.sensor.taxel_area_mm2);
  }

  draw(scene) {
    const { app, scale } = this;
    const { frame } = scene;
    const table = colourTable(app.settings.values.colours);
    const gain = loadFactor(app.unit, app.sensor.taxel_area_mm2) / scale.top;
    if (this.tiles.raw.visible) this.tiles.raw.draw(scene, frame.raw, table, gain, 0);
    if (this.tiles.compensated.visible) this.tiles.compensated.draw(scene, frame.compensated, table, gain, 0);
    const bars = [{ name: app.settings.values.colours, table, low: 0, high: scale.top, unit: app.unit.text, title: "Load" }];
    if (this.tiles.difference.visible) {
      for (let i = 0; i < this.differences.length; i += 1) this.differences[i] = frame.raw[i] - frame.compensated[i];
      this.tiles.difference.draw(scene, this.differences, differenceTable, gain / 2, 0.5);
      bars.push({ name: "difference", table: differenceTable, low: -scale.top, high: scale.top, unit: `Δ ${app.unit.text}`, title: "Difference" });
    }
    this.bar.draw(bars, this.barHeight, this.ratio);
  }

  // Over the taxels that count: the sum of the compensated loads is the total force.
  writeSums(frame) {
    const unit = forceUnit(this.app.unit);
    const sums = {
      raw: sumCounted(frame.raw, frame.marks),
      compensated: isNewtons(frame) ? frame.total : sumCounted(frame.compensated, frame.marks),
    };
    sums.difference = sums.raw - sums.compensated;
    const decimals = this.app.charts.decimals("force");
    for (const [name, tile] of Object.entries(this.tiles)) {
      tile.sum.textContent = `Σ ${fixed(sums[name] * unit.factor, decimals)} ${unit.text}`;
    }
    this.writeMethod(frame);
  }

  // The frame says whether its cross-talk is removed: the method chosen may be of frames to come.
  writeMethod(frame) {
    const raw = isRaw(frame);
    const title = document.querySelector("#compensated-tile b");
    const text = raw ? "Not compensated" : "Compensated";
    if (title.textContent !== text) title.textContent = text;
    const words = raw ? "method raw: cross-talk not removed" : this.app.method;
    const element = document.getElementById("compensated-method");
    if (element.textContent !== words) element.textContent = words;
  }
}

// The arrangement in columns that makes the maps largest; on a tie, side by side.
function arrange(count, roomWide, roomHigh, aspect) {
  let best = null;
  for (let across = count; across >= 1; across -= 1) {
    const down = Math.ceil(count / across);
    const mostWide = (roomWide - GAP * (across - 1)) / across - MARGIN.left - MARGIN.right;
    const mostHigh = (roomHigh - GAP * (down - 1)) / down - CAPTION - MARGIN.top - MARGIN.bottom;
    const width = Math.max(60, Math.min(mostWide, mostHigh * aspect));
    if (!best || width > best.width * 1.12) best = { across, down, width, height: width / aspect };
  }
  best.width = Math.floor(best.width);
  best.height = Math.floor(best.height);
  return best;
}

function sumCounted(values, marks) {
  let total = 0;
  for (let i = 0; i < values.length; i += 1) {
    const value = values[i];
    if (value === value && isCounted(marks[i])) total += value;
  }
  return total;
}

// Without a load law the server's sums mean nothing: the charts then show conductances.
export function sumSiemens(frame) {
  frame.total = sumCounted(frame.compensated, frame.marks);
  frame.peak = -Infinity;
  for (const value of frame.compensated) if (value > frame.peak) frame.peak = value;
}
