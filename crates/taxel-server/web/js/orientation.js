// How the array lies on the screen: turned by quarters, then mirrored.

export class Orientation {
  constructor({ quarters = 0, mirrorX = false, mirrorY = false } = {}) {
    this.quarters = quarters;
    this.mirrorX = mirrorX;
    this.mirrorY = mirrorY;
  }

  get key() {
    return `${this.quarters}${this.mirrorX ? "x" : ""}${this.mirrorY ? "y" : ""}`;
  }

  get turned() {
    return this.quarters % 2 === 1;
  }

  // A turn on the screen comes after the mirrors; with one mirror that is the opposite turn before it.
  rotate() {
    const step = this.mirrorX !== this.mirrorY ? 3 : 1;
    return new Orientation({ ...this, quarters: (this.quarters + step) % 4 });
  }

  /** [a, b, c, d, e, f] as for setTransform, from shares of the array (column, row) to shares of the picture. */
  matrix() {
    let m = [[1, 0, 0, 1, 0, 0], [0, 1, -1, 0, 1, 0], [-1, 0, 0, -1, 1, 1], [0, -1, 1, 0, 0, 1]][this.quarters];
    if (this.mirrorX) m = [-m[0], m[1], -m[2], m[3], 1 - m[4], m[5]];
    if (this.mirrorY) m = [m[0], -m[1], m[2], -m[3], m[4], 1 - m[5]];
    return m;
  }

  /**
   * The step of (row, column) that a step on the screen to the right and down means.
   * @param {number} right
   * @param {number} down
   */
  step(right, down) {
    const [a, b, c, d] = this.matrix();
    return { columns: Math.round(a * right + b * down), rows: Math.round(c * right + d * down) };
  }
}

// Between (column, row) in taxels, or in cells of a map of places, and pixels of one canvas.
export class Placement {
  /**
   * @param {Orientation} orientation
   * @param {import("./places.js").Crossings} layout
   * @param {number} left
   * @param {number} top
   * @param {number} width
   * @param {number} height
   */
  constructor(orientation, layout, left, top, width, height) {
    const { rows, columns } = layout;
    this.layout = layout;
    const [a, b, c, d, e, f] = orientation.matrix();
    this.rows = rows;
    this.columns = columns;
    this.left = left;
    this.top = top;
    this.width = width;
    this.height = height;
    this.a = (a * width) / columns;
    this.b = (b * height) / columns;
    this.c = (c * width) / rows;
    this.d = (d * height) / rows;
    this.e = left + e * width;
    this.f = top + f * height;
    this.turned = orientation.turned;
    this.key = orientation.key;
  }

  /**
   * @param {number} column
   * @param {number} row
   */
  x(column, row) {
    return this.a * column + this.c * row + this.e;
  }

  /**
   * @param {number} column
   * @param {number} row
   */
  y(column, row) {
    return this.b * column + this.d * row + this.f;
  }

  // Pixels per taxel along the shorter side of a taxel.
  get taxelPixels() {
    return Math.min(Math.abs(this.a + this.b), Math.abs(this.c + this.d));
  }

  /**
   * @param {number} x
   * @param {number} y
   */
  toArray(x, y) {
    const scale = 1 / (this.a * this.d - this.b * this.c);
    const dx = x - this.e;
    const dy = y - this.f;
    return { column: (this.d * dx - this.c * dy) * scale, row: (this.a * dy - this.b * dx) * scale };
  }
}
