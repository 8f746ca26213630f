// The binary messages: frames, as docs/formats.md lays them out. crates/taxel-server/testdata has some to test this with.

const HEADER_BYTES = 68;
const TYPE_FRAME = 1;
const VERSION = 2;

export const FLAG_NEWTONS = 1;
export const FLAG_TARED = 2;
export const FLAG_RAW = 4;

/** @param {{ flags: number }} frame */
export const isNewtons = (frame) => (frame.flags & FLAG_NEWTONS) !== 0;
/**
 * By the method "raw": the load law alone, no cross-talk removed.
 * @param {{ flags: number }} frame
 */
export const isRaw = (frame) => (frame.flags & FLAG_RAW) !== 0;
/** @param {{ flags: number }} frame */
export const isTared = (frame) => (frame.flags & FLAG_TARED) !== 0;

/**
 * The same as `decodeFrame`; a message that is none is a warning in the console, and null.
 * @param {ArrayBuffer} message
 * @returns {Page.Frame | null}
 */
export function frameOf(message) {
  try {
    return decodeFrame(message);
  } catch (error) {
    console.warn(error instanceof Error ? error.message : error);
    return null;
  }
}

/**
 * The arrays of the frame are views into the message: nothing is copied here.
 * @param {ArrayBuffer} message
 * @returns {Page.Frame}
 */
export function decodeFrame(message) {
  if (message.byteLength < HEADER_BYTES) throw new Error("a frame message is shorter than its header");
  const view = new DataView(message);
  if (view.getUint8(0) !== TYPE_FRAME) throw new Error(`unknown message type ${view.getUint8(0)}`);
  if (view.getUint8(1) !== VERSION) throw new Error(`frame version ${view.getUint8(1)}, this page reads ${VERSION}`);
  const rows = view.getUint16(2, true);
  const columns = view.getUint16(4, true);
  const taxels = rows * columns;
  const loadsAt = (HEADER_BYTES + 2 * taxels + 3) & ~3;
  if (message.byteLength < loadsAt + 9 * taxels) throw new Error("a frame message is too short for its taxels");
  return {
    rows,
    columns,
    flags: view.getUint16(6, true),
    sequence: Number(view.getBigUint64(8, true)),
    device: view.getFloat64(16, true),
    host: view.getFloat64(24, true),
    total: view.getFloat32(32, true),
    peak: view.getFloat32(36, true),
    area: view.getFloat32(40, true),
    copRow: view.getFloat32(44, true),
    copColumn: view.getFloat32(48, true),
    outliers: view.getFloat32(52, true),
    age: view.getFloat32(56, true),
    rate: view.getFloat32(60, true),
    grip: view.getFloat32(64, true),
    counts: new Uint16Array(message, HEADER_BYTES, taxels),
    raw: new Float32Array(message, loadsAt, taxels),
    compensated: new Float32Array(message, loadsAt + 4 * taxels, taxels),
    marks: new Uint8Array(message, loadsAt + 8 * taxels, taxels),
  };
}

/**
 * A frame of its own memory, for one that is read back from the buffer.
 * @param {number} rows
 * @param {number} columns
 * @returns {Page.Frame}
 */
export function blankFrame(rows, columns) {
  const taxels = rows * columns;
  return {
    rows, columns, flags: 0, sequence: 0, device: NaN, host: NaN, total: NaN, peak: NaN, area: NaN,
    copRow: NaN, copColumn: NaN, outliers: 0, age: NaN, rate: NaN, grip: NaN,
    counts: new Uint16Array(taxels),
    raw: new Float32Array(taxels),
    compensated: new Float32Array(taxels),
    marks: new Uint8Array(taxels),
  };
}
