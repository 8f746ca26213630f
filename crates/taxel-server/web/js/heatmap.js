// Values to pixels: one pixel per taxel, or several, interpolated, when smooth. Where there is no taxel nothing is drawn. Taxels
// that lie elsewhere than at the crossings of their lines have pixels of their own, and are never smoothed.

import { TABLE_SIZE } from "./colour.js";
import { contextOf } from "./dom.js";

const MAX_SMOOTH_SIDE = 512;

export class Heatmap {
  /**
   * @param {number} rows
   * @param {number} columns
   * @param {import("./places.js").Owners | null} owners
   */
  constructor(rows, columns, owners = null) {
    this.rows = rows;
    this.columns = columns;
    this.owners = owners;
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
    const { owners } = this;
    const side = Math.max(this.rows, this.columns);
    this.factor = smooth && !owners ? Math.max(2, Math.min(8, Math.floor(MAX_SMOOTH_SIDE / side))) : 1;
    this.canvas.width = owners ? owners.columns : this.columns * this.factor;
    this.canvas.height = owners ? owners.rows : this.rows * this.factor;
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
   * @param {Uint8Array} marks
   * @param {number} absent the code of taxels that there are not
   */
  paint(values, table, gain, offset, marks, absent) {
    const scaledGain = gain * (TABLE_SIZE - 1);
    const scaledOffset = offset * (TABLE_SIZE - 1) + 0.5;
    const { owners } = this;
    if (owners) this.paintOwned(owners, values, table, scaledGain, scaledOffset);
    else if (this.smooth) this.paintSmooth(values, table, scaledGain, scaledOffset, marks, absent);
    else this.paintTaxels(values, table, scaledGain, scaledOffset, marks, absent);
    this.context.putImageData(this.image, 0, 0);
  }

  /**
   * @param {Float32Array} values
   * @param {import("./colour.js").ColourTable} table
   * @param {number} gain
   * @param {number} offset
   * @param {Uint8Array} marks
   * @param {number} absent
   */
  paintTaxels(values, table, gain, offset, marks, absent) {
    const { pixels } = this;
    const { words, missing } = table;
    const top = TABLE_SIZE - 1;
    for (let i = 0; i < pixels.length; i += 1) {
      const at = values[i] * gain + offset;
      pixels[i] = marks[i] === absent ? 0 : at !== at ? missing : words[at > 0 ? (at < top ? at | 0 : top) : 0];
    }
  }

  /**
   * @param {import("./places.js").Owners} owners
   * @param {Float32Array} values
   * @param {import("./colour.js").ColourTable} table
   * @param {number} gain
   * @param {number} offset
   */
  paintOwned(owners, values, table, gain, offset) {
    const { pixels } = this;
    const { words, missing } = table;
    const top = TABLE_SIZE - 1;
    for (let i = 0; i < pixels.length; i += 1) {
      const taxel = owners.taxels[i];
      const at = taxel < 0 ? 0 : values[taxel] * gain + offset;
      pixels[i] = taxel < 0 ? 0 : at !== at ? missing : words[at > 0 ? (at < top ? at | 0 : top) : 0];
    }
  }

  /**
   * Values are interpolated, not colours: a colour between two colours of the map would mean another value.
   * @param {Float32Array} values
   * @param {import("./colour.js").ColourTable} table
   * @param {number} gain
   * @param {number} offset
   * @param {Uint8Array} marks
   * @param {number} absent
   */
  paintSmooth(values, table, gain, offset, marks, absent) {
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
        const noLeft = marks[from + left] === absent;
        const noRight = marks[from + right] === absent;
        const a = values[from + (noLeft ? right : left)];
        const b = values[from + (noRight ? left : right)];
        const value = a + (b - a) * share;
        stretched[to + x] = noLeft && noRight ? NaN : value === value ? value : 0;
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
        const own = (share < 0.5 ? upper : lower) * columns + Math.floor(x / factor);
        if (marks[own] === absent) {
          pixels[to + x] = 0;
          continue;
        }
        const above = stretched[a + x];
        const below = stretched[b + x];
        const value = above !== above ? below : below !== below ? above : above + (below - above) * share;
        const at = value * gain + offset;
        pixels[to + x] = words[at > 0 ? (at < top ? at | 0 : top) : 0];
      }
    }
  }
}
