// Values to pixels: one pixel per taxel, or several, interpolated, when smooth.

import { TABLE_SIZE } from "./colour.js";
import { contextOf } from "./dom.js";

const MAX_SMOOTH_SIDE = 512;

export class Heatmap {
  /**
   * @param {number} rows
   * @param {number} columns
   */
  constructor(rows, columns) {
    this.rows = rows;
    this.columns = columns;
    this.canvas = document.createElement("canvas");
    this.context = contextOf(this.canvas);
    this.image = this.context.createImageData(1, 1);
    this.pixels = new Uint32Array(0);
    this.stretched = new Float32Array(0);
    this.factor = 1;
    /** @type {boolean | null} */
    this.smooth = null;
    this.setSmooth(false);
  }

  /** @param {boolean} smooth */
  setSmooth(smooth) {
    if (smooth === this.smooth) return;
    this.smooth = smooth;
    const side = Math.max(this.rows, this.columns);
    this.factor = smooth ? Math.max(2, Math.min(8, Math.floor(MAX_SMOOTH_SIDE / side))) : 1;
    this.canvas.width = this.columns * this.factor;
    this.canvas.height = this.rows * this.factor;
    this.image = this.context.createImageData(this.canvas.width, this.canvas.height);
    this.pixels = new Uint32Array(this.image.data.buffer);
    this.stretched = new Float32Array(smooth ? this.rows * this.columns * this.factor : 0);
  }

  /**
   * The colour of a value is table[value * gain + offset], with gain and offset as shares of the table.
   * @param {Float32Array} values
   * @param {import("./colour.js").ColourTable} table
   * @param {number} gain
   * @param {number} offset
   */
  paint(values, table, gain, offset) {
    const scaledGain = gain * (TABLE_SIZE - 1);
    const scaledOffset = offset * (TABLE_SIZE - 1) + 0.5;
    if (this.smooth) this.paintSmooth(values, table, scaledGain, scaledOffset);
    else this.paintTaxels(values, table, scaledGain, scaledOffset);
    this.context.putImageData(this.image, 0, 0);
  }

  /**
   * @param {Float32Array} values
   * @param {import("./colour.js").ColourTable} table
   * @param {number} gain
   * @param {number} offset
   */
  paintTaxels(values, table, gain, offset) {
    const { pixels } = this;
    const { words, missing } = table;
    const top = TABLE_SIZE - 1;
    for (let i = 0; i < pixels.length; i += 1) {
      const at = values[i] * gain + offset;
      pixels[i] = at !== at ? missing : words[at > 0 ? (at < top ? at | 0 : top) : 0];
    }
  }

  /**
   * Values are interpolated, not colours: a colour between two colours of the map would mean another value.
   * @param {Float32Array} values
   * @param {import("./colour.js").ColourTable} table
   * @param {number} gain
   * @param {number} offset
   */
  paintSmooth(values, table, gain, offset) {
    const { rows, columns, factor, stretched, pixels } = this;
    const { words } = table;
    const width = columns * factor;
    const top = TABLE_SIZE - 1;
    for (let row = 0; row < rows; row += 1) {
      const from = row * columns;
      const to = row * width;
      for (let x = 0; x < width; x += 1) {
        const position = (x + 0.5) / factor - 0.5;
        const left = position <= 0 ? 0 : Math.min(position | 0, columns - 1);
        const right = left + 1 < columns ? left + 1 : left;
        const share = position <= 0 ? 0 : position - left;
        const a = values[from + left];
        const b = values[from + right];
        const value = a + (b - a) * share;
        stretched[to + x] = value === value ? value : 0;
      }
    }
    for (let y = 0; y < rows * factor; y += 1) {
      const position = (y + 0.5) / factor - 0.5;
      const upper = position <= 0 ? 0 : Math.min(position | 0, rows - 1);
      const lower = upper + 1 < rows ? upper + 1 : upper;
      const share = position <= 0 ? 0 : position - upper;
      const a = upper * width;
      const b = lower * width;
      const to = y * width;
      for (let x = 0; x < width; x += 1) {
        const value = stretched[a + x] + (stretched[b + x] - stretched[a + x]) * share;
        const at = value * gain + offset;
        pixels[to + x] = words[at > 0 ? (at < top ? at | 0 : top) : 0];
      }
    }
  }
}
