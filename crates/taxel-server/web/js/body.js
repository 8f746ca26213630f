// The handle that an array is wrapped around, as the 3D surface draws it: the map rolled up and seen from outside, its first
// ring on top, the lines along it in their order to the right.

/**
 * @typedef {object} Body
 * @property {Float32Array} places x, y and z of each taxel, row by row
 * @property {Float32Array} outward the direction that each of them faces
 * @property {[number, number]} steps from one line to the next where it is widest, and from one ring to the next
 * @property {number} middle angle of the middle line along it, radians
 * @property {boolean} rowsAreRings
 * @property {boolean} closes
 * @property {Float32Array} core triangles of what is inside: the ends, and what shows through the seam
 * @property {Float32Array} edges lines: both ends, and one that stands out of the first taxel as high as the full scale
 */

// Its longest way is so long, as the diagonal of a flat array is 1.8.
const SIZE = 1.2;
/** How far a taxel of the full scale stands out. */
export const BODY_LIFT = 0.2;
// The inside, as a share of where the surface is nearest to the axis, midway between two lines: too little less to be seen.
const INSIDE = 0.985;
const CORNERS = 96;

/**
 * The body of a sensor; null where it is flat.
 * @param {Wire.SensorFacts} sensor
 * @returns {Body | null}
 */
export function bodyOf({ handle, rows, columns }) {
  if (!handle) return null;
  const { angles, radii_mm: radii, heights_mm: heights, slope } = handle;
  const rowsAreRings = handle.rings === "rows";
  const last = radii.length - 1;
  const widest = Math.max(...radii);
  const scale = SIZE / Math.hypot(heights[last], 2 * widest);
  const middle = heights[last] / 2;
  /** @param {number} radius @param {number} angle @param {number} height */
  const point = (radius, angle, height) => [radius * scale * Math.sin(angle), (middle - height) * scale, radius * scale * Math.cos(angle)];
  const [sin, cos] = [Math.sin(slope), Math.cos(slope)];
  const places = new Float32Array(3 * rows * columns);
  const outward = new Float32Array(3 * rows * columns);
  for (let row = 0; row < rows; row += 1) {
    for (let column = 0; column < columns; column += 1) {
      const [ring, line] = rowsAreRings ? [row, column] : [column, row];
      const at = 3 * (row * columns + column);
      places.set(point(radii[ring], angles[line], heights[ring]), at);
      outward.set([cos * Math.sin(angles[line]), -sin, cos * Math.cos(angles[line])], at);
    }
  }
  const step = last > 0 ? heights[last] / last / cos : widest;
  return {
    places,
    outward,
    steps: [angles[1] * widest * scale, step * scale],
    middle: angles[angles.length - 1] / 2,
    rowsAreRings,
    closes: handle.closes,
    core: coreOf(point, [radii[0], radii[last]].map((radius) => INSIDE * Math.cos(angles[1] / 2) * radius), heights[last]),
    edges: edgesOf(point, [radii[0], radii[last]], heights[last], angles[0], BODY_LIFT / scale),
  };
}

/**
 * @param {(radius: number, angle: number, height: number) => number[]} point
 * @param {number[]} radii of the first ring and the last
 * @param {number} height
 */
function coreOf(point, [upper, lower], height) {
  const triangles = [];
  for (let corner = 0; corner < CORNERS; corner += 1) {
    const [from, to] = [corner, corner + 1].map((i) => (2 * Math.PI * i) / CORNERS);
    const [a, b] = [from, to].map((angle) => point(upper, angle, 0));
    const [c, d] = [from, to].map((angle) => point(lower, angle, height));
    triangles.push(...a, ...c, ...b, ...b, ...c, ...d);
    triangles.push(...point(0, 0, 0), ...a, ...b, ...point(0, 0, height), ...d, ...c);
  }
  return new Float32Array(triangles);
}

/**
 * @param {(radius: number, angle: number, height: number) => number[]} point
 * @param {[number, number]} radii of the first ring and the last
 * @param {number} height
 * @param {number} first angle of the first line along it
 * @param {number} lift
 */
function edgesOf(point, [upper, lower], height, first, lift) {
  const lines = [];
  for (const [radius, z] of [[upper, 0], [lower, height]]) {
    for (let corner = 0; corner < CORNERS; corner += 1) {
      for (const i of [corner, corner + 1]) lines.push(...point(radius, (2 * Math.PI * i) / CORNERS, z));
    }
  }
  lines.push(...point(upper, first, 0), ...point(upper + lift, first, 0));
  return new Float32Array(lines);
}

/**
 * Corners of all triangles between neighbouring taxels, across a seam that closes too.
 * @param {number} rows
 * @param {number} columns
 * @param {Body | null} body
 */
export function trianglesOf(rows, columns, body) {
  const wraps = body !== null && body.closes;
  const down = rows - (wraps && !body.rowsAreRings ? 0 : 1);
  const across = columns - (wraps && body.rowsAreRings ? 0 : 1);
  const indices = new Uint32Array(Math.max(0, down * across * 6));
  let n = 0;
  for (let row = 0; row < down; row += 1) {
    for (let column = 0; column < across; column += 1) {
      const [below, right] = [((row + 1) % rows) * columns, (column + 1) % columns];
      const [a, b, c, d] = [row * columns + column, row * columns + right, below + column, below + right];
      indices.set([a, c, b, b, c, d], n);
      n += 6;
    }
  }
  return indices;
}
