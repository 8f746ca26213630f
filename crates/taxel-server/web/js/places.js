// Where taxels lie on a map, in cells from its top left corner: at the crossings of their lines, or at places of their own.

/** Taxels are at least this share of their mean distance wide, where the pitch says less. */
const FILLED = 0.5;
/** Pixels along a cell, by which it is found whose a spot is. */
export const CELL_PIXELS = 8;
const MAX_SIDE = 2048;

/** At the crossings of rows and columns. */
export class Crossings {
  /**
   * @param {number} rows
   * @param {number} columns
   */
  constructor(rows, columns) {
    this.rows = rows;
    this.columns = columns;
    this.lines = columns;
    /** @type {Owners | null} */
    this.owners = null;
  }

  /**
   * The middle of a taxel, across and down.
   * @param {number} taxel
   * @returns {[number, number]}
   */
  centre(taxel) {
    return [(taxel % this.lines) + 0.5, Math.floor(taxel / this.lines) + 0.5];
  }

  /**
   * @param {number} across
   * @param {number} down
   * @returns {number} the taxel there, or -1
   */
  at(across, down) {
    const column = Math.floor(across);
    const row = Math.floor(down);
    return row >= 0 && row < this.rows && column >= 0 && column < this.columns ? row * this.lines + column : -1;
  }

  /**
   * Width and height in mm.
   * @param {Wire.SensorFacts} sensor
   * @returns {[number, number]}
   */
  extent({ pitch_mm }) {
    return [this.columns * pitch_mm[1], this.rows * pitch_mm[0]];
  }

  /**
   * Where the centre of pressure is drawn that the server gives in rows and columns.
   * @param {number} row
   * @param {number} column
   * @returns {[number, number]}
   */
  pressure(row, column) {
    return [column + 0.5, row + 0.5];
  }
}

/** Whose every pixel is; -1 of none. */
export class Owners {
  /**
   * @param {number} columns
   * @param {number} rows
   */
  constructor(columns, rows) {
    this.columns = columns;
    this.rows = rows;
    this.taxels = new Int32Array(columns * rows).fill(-1);
  }
}

/** At places of their own. */
export class Places extends Crossings {
  /** @param {Wire.SensorFacts & { positions_mm: NonNullable<Wire.SensorFacts["positions_mm"]> }} sensor */
  constructor(sensor) {
    const there = sensor.positions_mm.filter((place) => place !== null);
    /** @param {0 | 1} axis */
    const ends = (axis) => there.reduce(([low, high], place) => [Math.min(low, place[axis]), Math.max(high, place[axis])], [Infinity, -Infinity]);
    const [x, y] = [ends(0), ends(1)];
    const apart = Math.sqrt(((x[1] - x[0]) * (y[1] - y[0])) / there.length);
    const wide = Math.max(sensor.pitch_mm[1], FILLED * apart);
    const high = Math.max(sensor.pitch_mm[0], FILLED * apart);
    super((y[1] - y[0]) / high + 1, (x[1] - x[0]) / wide + 1);
    this.lines = sensor.columns;
    this.cell = [wide, high];
    this.pitch = sensor.pitch_mm;
    this.corner = [x[0] - wide / 2, y[0] - high / 2];
    /** @type {[number, number][]} */
    this.centres = sensor.positions_mm.map((place) => (place === null ? [NaN, NaN] : this.cells(place[0], place[1])));
    this.owners = this.owned();
  }

  /**
   * @param {number} x
   * @param {number} y
   * @returns {[number, number]}
   */
  cells(x, y) {
    return [(x - this.corner[0]) / this.cell[0], (y - this.corner[1]) / this.cell[1]];
  }

  /** @param {number} taxel */
  centre(taxel) {
    return this.centres[taxel];
  }

  /** @returns {[number, number]} */
  extent() {
    return [this.columns * this.cell[0], this.rows * this.cell[1]];
  }

  /**
   * @param {number} across
   * @param {number} down
   */
  at(across, down) {
    const { owners } = this;
    if (!owners) return -1;
    const x = Math.floor((across / this.columns) * owners.columns);
    const y = Math.floor((down / this.rows) * owners.rows);
    return x >= 0 && x < owners.columns && y >= 0 && y < owners.rows ? owners.taxels[y * owners.columns + x] : -1;
  }

  /**
   * @param {number} row
   * @param {number} column
   */
  pressure(row, column) {
    return this.cells(column * this.pitch[1], row * this.pitch[0]);
  }

  /** The nearest taxel of those whose cell covers a pixel. */
  owned() {
    /** @param {number} cells */
    const side = (cells) => Math.max(1, Math.min(MAX_SIDE, Math.round(cells * CELL_PIXELS)));
    const owners = new Owners(side(this.columns), side(this.rows));
    const nearest = new Float32Array(owners.taxels.length).fill(Infinity);
    const [stepX, stepY] = [this.columns / owners.columns, this.rows / owners.rows];
    this.centres.forEach(([across, down], taxel) => {
      if (across !== across) return;
      for (let y = Math.max(0, Math.floor((down - 0.5) / stepY)); y < owners.rows; y += 1) {
        const dy = (y + 0.5) * stepY - down;
        if (dy > 0.5) break;
        if (dy < -0.5) continue;
        for (let x = Math.max(0, Math.floor((across - 0.5) / stepX)); x < owners.columns; x += 1) {
          const dx = (x + 0.5) * stepX - across;
          if (dx > 0.5) break;
          const distance = dx * dx + dy * dy;
          const at = y * owners.columns + x;
          if (dx >= -0.5 && distance < nearest[at]) {
            nearest[at] = distance;
            owners.taxels[at] = taxel;
          }
        }
      }
    });
    return owners;
  }
}

/** @type {WeakMap<Wire.SensorFacts, Crossings>} */
const known = new WeakMap();

/**
 * @param {Wire.SensorFacts} sensor
 * @returns {Crossings}
 */
export function layoutOf(sensor) {
  let layout = known.get(sensor);
  if (!layout) {
    const { positions_mm } = sensor;
    layout = positions_mm ? new Places({ ...sensor, positions_mm }) : new Crossings(sensor.rows, sensor.columns);
    known.set(sensor, layout);
  }
  return layout;
}
