// One map of the stage: heatmap or surface, with axes, marks, centre of pressure, pins and regions on it.

import { Heatmap } from "./heatmap.js";
import { Furniture, MARGIN } from "./furniture.js";
import { Orientation, Placement } from "./orientation.js";
import { Surface } from "./surface.js";
import { byId, canvasById, contextOf, inside } from "./dom.js";
import { layoutOf } from "./places.js";
import { theme } from "./theme.js";
import { placeAt } from "./regions.js";

export class Tile {
  /**
   * @param {string} name
   * @param {boolean} hasSurface
   */
  constructor(name, hasSurface) {
    this.name = name;
    this.figure = byId(`${name}-tile`);
    this.title = inside(this.figure, "b");
    this.canvas = canvasById(`${name}-canvas`);
    this.surfaceCanvas = hasSurface ? canvasById(`${name}-surface`) : null;
    this.sum = byId(`${name}-sum`);
    this.summary = byId(`${name}-summary`);
    this.context = contextOf(this.canvas);
    this.furniture = new Furniture();
    /** @type {Surface | null} */
    this.surface = null;
    this.inSurface = false;
    this.heatmap = new Heatmap(1, 1);
    this.orientation = new Orientation();
    /** @type {Wire.SensorFacts | null} */
    this.sensor = null;
    /** @type {Placement | null} */
    this.placement = null;
    this.visible = false;
    this.width = 0;
    this.height = 0;
    this.ratio = 1;
  }

  /** @param {Wire.SensorFacts} sensor */
  reset(sensor) {
    this.sensor = sensor;
    this.heatmap = new Heatmap(sensor.rows, sensor.columns, layoutOf(sensor).owners);
    this.furniture.key = "";
    if (this.surface) this.surface.setSensor(sensor);
  }

  /** @param {boolean} visible */
  show(visible) {
    this.visible = visible;
    this.figure.hidden = !visible;
  }

  /**
   * Sizes in CSS pixels, with the margins.
   * @param {number} width
   * @param {number} height
   * @param {number} ratio
   * @param {Orientation} orientation
   */
  resize(width, height, ratio, orientation) {
    if (!this.sensor) return;
    this.width = width;
    this.height = height;
    this.ratio = ratio;
    for (const canvas of [this.canvas, this.surfaceCanvas]) {
      if (!canvas) continue;
      canvas.width = Math.round(width * ratio);
      canvas.height = Math.round(height * ratio);
      canvas.style.width = `${width}px`;
      canvas.style.height = `${height}px`;
    }
    this.placement = new Placement(orientation, layoutOf(this.sensor), MARGIN.left, MARGIN.top,
      width - MARGIN.left - MARGIN.right, height - MARGIN.top - MARGIN.bottom);
    this.orientation = orientation;
  }

  /**
   * Returns false if this browser has no WebGL 2.
   * @param {boolean} on
   * @param {import("./surface.js").Camera} camera
   */
  setSurface(on, camera) {
    if (!this.surfaceCanvas || !this.sensor) return true;
    if (on && !this.surface) {
      this.surface = Surface.create(this.surfaceCanvas, camera);
      if (!this.surface) return false;
      this.surface.setSensor(this.sensor);
    }
    this.inSurface = on;
    this.surfaceCanvas.hidden = !on;
    return true;
  }

  /**
   * @param {Page.Scene} scene
   * @param {Float32Array} values
   * @param {import("./colour.js").ColourTable} table
   * @param {number} gain
   * @param {number} offset
   */
  draw(scene, values, table, gain, offset) {
    const p = this.placement;
    if (!p) return;
    const g = this.context;
    g.setTransform(1, 0, 0, 1, 0, 0);
    g.clearRect(0, 0, this.canvas.width, this.canvas.height);
    if (this.inSurface && this.surface) {
      this.surface.draw(values, table, gain, this.orientation, scene.sensor.pitch_mm);
      g.setTransform(this.ratio, 0, 0, this.ratio, 0, 0);
      this.drawPinsOnSurface(g, scene, this.surface, values, gain);
      return;
    }
    this.heatmap.setSmooth(scene.smooth);
    this.heatmap.paint(values, table, gain, offset, scene.frame.marks, scene.meanings.absent);
    const { ratio } = this;
    const { canvas } = this.heatmap;
    g.imageSmoothingEnabled = scene.smooth;
    const across = (ratio * p.columns) / canvas.width;
    const down = (ratio * p.rows) / canvas.height;
    g.setTransform(p.a * across, p.b * across, p.c * down, p.d * down, p.e * ratio, p.f * ratio);
    g.drawImage(canvas, 0, 0);
    g.setTransform(1, 0, 0, 1, 0, 0);
    this.furniture.draw(scene, p, this.width, this.height, ratio);
    g.drawImage(this.furniture.canvas, 0, 0);
    g.setTransform(ratio, 0, 0, ratio, 0, 0);
    for (const region of scene.selection.regions) drawRegion(g, p, placeAt(region, scene.frame.sequence).outlines, region.colour, region.name);
    if (scene.draft) drawRegion(g, p, [scene.draft], "#ffffff", "");
    if (scene.showCop) drawCentre(g, p, scene);
    for (const pin of scene.selection.pins) drawPin(g, p, pin, scene.sensor.columns);
    if (scene.picked) drawPicked(g, p, scene.picked, scene.sensor.columns);
  }

  /**
   * @param {CanvasRenderingContext2D} g
   * @param {Page.Scene} scene
   * @param {Surface} surface
   * @param {Float32Array} values
   * @param {number} gain
   */
  drawPinsOnSurface(g, scene, surface, values, gain) {
    const taxels = scene.picked ? [...scene.selection.pins, { ...scene.picked, colour: theme.ink, label: "" }] : scene.selection.pins;
    for (const { row, column, colour, label: text } of taxels) {
      const value = values[row * scene.sensor.columns + column];
      const spot = surface.project(column + 0.5, row + 0.5, value * gain, this.width, this.height);
      g.beginPath();
      g.moveTo(spot.x, spot.y);
      g.lineTo(spot.x, spot.y - 22);
      outlined(g, colour, 1.5);
      g.beginPath();
      g.arc(spot.x, spot.y - 24, 3.5, 0, 2 * Math.PI);
      g.fillStyle = colour;
      g.fill();
      if (text) label(g, text, spot.x + 2, spot.y - 24, colour, { left: 0, top: 0, width: this.width, height: this.height });
    }
  }
}

/**
 * @param {CanvasRenderingContext2D} g
 * @param {Placement} p
 * @param {Page.Scene} scene
 */
function drawCentre(g, p, scene) {
  const { trail, frame } = scene;
  g.lineCap = "round";
  for (let pass = 0; pass < 2; pass += 1) {
    g.strokeStyle = pass === 0 ? "rgb(0 0 0 / 0.55)" : "#ffffff";
    g.lineWidth = pass === 0 ? 3.5 : 1.6;
    // A few strokes, each fainter than the next, instead of one for each step of the trail.
    const pieces = 6;
    for (let piece = 0; piece < pieces; piece += 1) {
      const from = Math.floor((trail.length * piece) / pieces);
      const to = Math.min(trail.length - 1, Math.floor((trail.length * (piece + 1)) / pieces));
      if (to <= from) continue;
      g.globalAlpha = ((piece + 1) / pieces) * 0.85;
      g.beginPath();
      for (let i = from; i <= to; i += 1) {
        const spot = p.layout.pressure(trail.rows[i], trail.columns[i]);
        const x = p.x(...spot);
        const y = p.y(...spot);
        if (i === from) g.moveTo(x, y);
        else g.lineTo(x, y);
      }
      g.stroke();
    }
    g.globalAlpha = 1;
  }
  if (!Number.isFinite(frame.copRow) || !Number.isFinite(frame.copColumn)) return;
  const spot = p.layout.pressure(frame.copRow, frame.copColumn);
  const x = p.x(...spot);
  const y = p.y(...spot);
  g.beginPath();
  g.arc(x, y, 5, 0, 2 * Math.PI);
  for (const [dx, dy] of [[1, 0], [-1, 0], [0, 1], [0, -1]]) {
    g.moveTo(x + 5 * dx, y + 5 * dy);
    g.lineTo(x + 10 * dx, y + 10 * dy);
  }
  outlined(g, "#ffffff", 1.6);
}

/**
 * @param {CanvasRenderingContext2D} g
 * @param {Placement} p
 * @param {[number, number]} centre
 * @param {number} grow
 */
function taxelPath(g, p, [across, down], grow) {
  const x1 = p.x(across - 0.5, down - 0.5), y1 = p.y(across - 0.5, down - 0.5), x2 = p.x(across + 0.5, down + 0.5), y2 = p.y(across + 0.5, down + 0.5);
  g.beginPath();
  g.rect(Math.min(x1, x2) - grow, Math.min(y1, y2) - grow, Math.abs(x1 - x2) + 2 * grow, Math.abs(y1 - y2) + 2 * grow);
}

/**
 * @param {CanvasRenderingContext2D} g
 * @param {Placement} p
 * @param {Page.Taxel} taxel
 * @param {number} columns
 */
function drawPicked(g, p, { row, column }, columns) {
  taxelPath(g, p, p.layout.centre(row * columns + column), 1.5);
  outlined(g, "#ffffff", 1.5);
}

/**
 * @param {CanvasRenderingContext2D} g
 * @param {Placement} p
 * @param {Page.Pin} pin
 * @param {number} columns
 */
function drawPin(g, p, pin, columns) {
  const centre = p.layout.centre(pin.row * columns + pin.column);
  taxelPath(g, p, centre, 1.5);
  outlined(g, pin.colour, 2);
  label(g, pin.label, p.x(...centre), p.y(...centre), pin.colour, p);
}

/**
 * @param {CanvasRenderingContext2D} g
 * @param {Placement} p
 * @param {Page.Corner[][]} outlines
 * @param {string} colour
 * @param {string} text
 */
function drawRegion(g, p, outlines, colour, text) {
  g.beginPath();
  for (const corners of outlines) {
    corners.forEach(([column, row], i) => (i === 0 ? g.moveTo(p.x(column, row), p.y(column, row)) : g.lineTo(p.x(column, row), p.y(column, row))));
    g.closePath();
  }
  g.setLineDash([5, 3]);
  outlined(g, colour, 1.6);
  g.setLineDash([]);
  if (!text || outlines.length === 0) return;
  const corners = outlines.flat();
  const highest = corners.reduce((best, [column, row]) => (p.y(column, row) < p.y(best[0], best[1]) ? [column, row] : best), corners[0]);
  label(g, text, p.x(...highest), p.y(...highest), colour, p);
}

/**
 * @param {CanvasRenderingContext2D} g
 * @param {string} colour
 * @param {number} width
 */
function outlined(g, colour, width) {
  g.strokeStyle = "rgb(0 0 0 / 0.6)";
  g.lineWidth = width + 2;
  g.stroke();
  g.strokeStyle = colour;
  g.lineWidth = width;
  g.stroke();
}

/**
 * A small tag above and right of the spot, kept inside the map.
 * @param {CanvasRenderingContext2D} g
 * @param {string} text
 * @param {number} x
 * @param {number} y
 * @param {string} colour
 * @param {{ left: number, top: number, width: number, height: number }} box
 */
function label(g, text, x, y, colour, box) {
  g.font = "600 9px system-ui, sans-serif";
  const width = g.measureText(text).width + 6;
  const left = Math.max(box.left, Math.min(x + 4, box.left + box.width - width));
  const top = Math.max(box.top, Math.min(y - 17, box.top + box.height - 12));
  g.fillStyle = colour;
  g.beginPath();
  g.roundRect(left, top, width, 12, 3);
  g.fill();
  g.fillStyle = "#0b0d10";
  g.textAlign = "left";
  g.textBaseline = "middle";
  g.fillText(text, left + 3, top + 6.5);
}
