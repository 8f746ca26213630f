// What stands still on a map while the frames go by: axes, marks on bad taxels, marks on bad lines.
// It is drawn into its own layer, and again only when something of it has changed.

import { contextOf } from "./dom.js";
import { theme } from "./theme.js";

export const MARGIN = { left: 30, right: 8, top: 8, bottom: 20 };

// On the map, which is dark in either theme.
const LINE_COLOUR = "#e8b93a";
const MIN_LABEL_GAP = 34;
const FONT = "11px system-ui, -apple-system, 'Segoe UI', Roboto, sans-serif";

export class Furniture {
  constructor() {
    this.canvas = document.createElement("canvas");
    this.context = contextOf(this.canvas);
    this.key = "";
  }

  /**
   * @param {Page.Scene} scene
   * @param {import("./orientation.js").Placement} placement
   * @param {number} width
   * @param {number} height
   * @param {number} ratio
   */
  draw(scene, placement, width, height, ratio) {
    const key = `${width} ${height} ${ratio} ${placement.key} ${theme.version} ${scene.showMarks} ${scene.marksVersion} ${scene.badLinesKey}`;
    if (key === this.key) return;
    this.key = key;
    this.canvas.width = Math.round(width * ratio);
    this.canvas.height = Math.round(height * ratio);
    const g = this.context;
    g.setTransform(ratio, 0, 0, ratio, 0, 0);
    g.clearRect(0, 0, width, height);
    this.drawAxes(g, placement);
    if (scene.showMarks) {
      this.drawLines(g, scene, placement);
      this.drawMarks(g, scene, placement);
    }
  }

  /**
   * @param {CanvasRenderingContext2D} g
   * @param {import("./orientation.js").Placement} p
   */
  drawAxes(g, p) {
    g.strokeStyle = theme.line;
    g.lineWidth = 1;
    g.strokeRect(p.left - 0.5, p.top - 0.5, p.width + 1, p.height + 1);
    g.font = FONT;
    g.fillStyle = theme.ink3;
    g.strokeStyle = theme.ink3;
    // Taxels at places of their own stand on no lines that could be numbered.
    if (p.layout.owners) return;
    const [across, down] = p.turned ? ["row", "column"] : ["column", "row"];
    const bottom = p.top + p.height;
    const nameWidth = g.measureText(across).width;
    g.beginPath();
    g.textAlign = "center";
    g.textBaseline = "top";
    for (const i of ticks(p.turned ? p.rows : p.columns, p.width)) {
      const x = p.turned ? p.x(0, i + 0.5) : p.x(i + 0.5, 0);
      g.moveTo(x, bottom + 1);
      g.lineTo(x, bottom + 4);
      if (x < p.left + p.width - nameWidth - 14) g.fillText(String(i), x, bottom + 6);
    }
    g.textAlign = "right";
    g.textBaseline = "middle";
    for (const i of ticks(p.turned ? p.columns : p.rows, p.height)) {
      const y = p.turned ? p.y(i + 0.5, 0) : p.y(0, i + 0.5);
      g.moveTo(p.left - 4, y);
      g.lineTo(p.left - 1, y);
      g.fillText(String(i), p.left - 7, y);
    }
    g.stroke();
    g.textBaseline = "top";
    g.fillText(across, p.left + p.width, bottom + 6);
    g.fillText(down === "row" ? "row" : "col", p.left - 7, bottom + 6);
  }

  /**
   * A bad line has a triangle outside the map at its end, and a thin line along it.
   * @param {CanvasRenderingContext2D} g
   * @param {Page.Scene} scene
   * @param {import("./orientation.js").Placement} p
   */
  drawLines(g, scene, p) {
    const { rows, columns } = scene.badLines;
    if (p.layout.owners) return;
    g.fillStyle = theme.warn;
    g.strokeStyle = LINE_COLOUR;
    for (const row of rows) this.drawLine(g, p, [0, row + 0.5], [p.columns, row + 0.5]);
    for (const column of columns) this.drawLine(g, p, [column + 0.5, 0], [column + 0.5, p.rows]);
  }

  /**
   * @param {CanvasRenderingContext2D} g
   * @param {import("./orientation.js").Placement} p
   * @param {Page.Corner} from
   * @param {Page.Corner} to
   */
  drawLine(g, p, from, to) {
    const x1 = p.x(...from), y1 = p.y(...from), x2 = p.x(...to), y2 = p.y(...to);
    g.globalAlpha = 0.55;
    g.lineWidth = 1;
    g.setLineDash([3, 3]);
    g.beginPath();
    g.moveTo(x1, y1);
    g.lineTo(x2, y2);
    g.stroke();
    g.setLineDash([]);
    g.globalAlpha = 1;
    g.beginPath();
    if (Math.abs(x1 - x2) > Math.abs(y1 - y2)) {
      const x = p.left + p.width;
      g.moveTo(x + 1, y1);
      g.lineTo(x + 7, y1 - 4);
      g.lineTo(x + 7, y1 + 4);
    } else {
      g.moveTo(x1, p.top - 1);
      g.lineTo(x1 - 4, p.top - 7);
      g.lineTo(x1 + 4, p.top - 7);
    }
    g.fill();
  }

  /**
   * Taxels on a bad line are not marked one by one: the line says it.
   * @param {CanvasRenderingContext2D} g
   * @param {Page.Scene} scene
   * @param {import("./orientation.js").Placement} p
   */
  drawMarks(g, scene, p) {
    const badRow = new Set(p.layout.owners ? [] : scene.badLines.rows);
    const badColumn = new Set(p.layout.owners ? [] : scene.badLines.columns);
    const { columns } = scene.sensor;
    const arm = Math.min(4, Math.max(1.5, p.taxelPixels * 0.3));
    const crosses = new Path2D();
    const dots = new Path2D();
    for (let row = 0; row < scene.sensor.rows; row += 1) {
      if (badRow.has(row)) continue;
      for (let column = 0; column < columns; column += 1) {
        const code = scene.marks[row * columns + column];
        if (code === 0 || code === scene.meanings.absent || badColumn.has(column)) continue;
        const centre = p.layout.centre(row * columns + column);
        const x = p.x(...centre);
        const y = p.y(...centre);
        if (scene.meanings.of(code).severity === 2) {
          crosses.moveTo(x - arm, y - arm);
          crosses.lineTo(x + arm, y + arm);
          crosses.moveTo(x + arm, y - arm);
          crosses.lineTo(x - arm, y + arm);
        } else {
          dots.rect(x - 0.6, y - 0.6, 1.2, 1.2);
        }
      }
    }
    g.strokeStyle = "rgb(0 0 0 / 0.6)";
    g.lineWidth = 2.5;
    g.stroke(crosses);
    g.strokeStyle = "#7fe3ff";
    g.lineWidth = 1.1;
    g.stroke(crosses);
    g.fillStyle = "rgb(255 255 255 / 0.45)";
    g.fill(dots);
  }
}

/**
 * Steps of powers of two: the sizes of such arrays are powers of two.
 * @param {number} count
 * @param {number} pixels
 */
function* ticks(count, pixels) {
  let step = 1;
  while ((step * pixels) / count < MIN_LABEL_GAP) step *= 2;
  for (let i = 0; i < count; i += step) yield i;
}
