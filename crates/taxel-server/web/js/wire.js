// The wire format: what the server sends as binary messages, and the words for its codes.

const HEADER_BYTES = 64;
const TYPE_FRAME = 1;
const VERSION = 1;

export const FLAG_NEWTONS = 1;
export const FLAG_TARED = 2;
export const FLAG_RAW = 4;

// Marks of taxels that count in totals: good, saturated, interpolated; as the server has it.
const COUNTS = [true, false, true, false, false, false, false, true];
export const isCounted = (mark) => COUNTS[mark] === true;

// `severity` says how a mark is drawn: 2 with a cross (do not trust the value), 1 with a dot.
export const MARKS = [
  { word: "good", severity: 0, text: "Nothing is known against it." },
  { word: "open", severity: 2, text: "On a line that is dead: the frame says nothing about it." },
  { word: "saturated", severity: 2, text: "At the converter's ceiling: the value is a lower bound." },
  { word: "stuck", severity: 2, text: "Stuck at an end of the converter." },
  { word: "spike", severity: 2, text: "A spike against its neighbours or over time." },
  { word: "flickering", severity: 2, text: "On a line that comes and goes." },
  { word: "shorted", severity: 2, text: "On lines that read alike because they are shorted together." },
  { word: "interpolated", severity: 1, text: "Not measured: the median of its neighbours." },
  { word: "unresolved", severity: 1, text: "The cross-talk cannot be undone: its standard error exceeds its value." },
  { word: "unfamiliar", severity: 1, text: "A network's estimate from an input unlike those it was trained with." },
];

export function markOf(code) {
  return MARKS[code] || { word: `mark ${code}`, severity: 2, text: "A mark this page does not know." };
}

export const isNewtons = (frame) => (frame.flags & FLAG_NEWTONS) !== 0;
// By the method "raw": the load law alone, no cross-talk removed.
export const isRaw = (frame) => (frame.flags & FLAG_RAW) !== 0;
export const isTared = (frame) => (frame.flags & FLAG_TARED) !== 0;

// The arrays of the frame are views into the message: nothing is copied here.
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
    counts: new Uint16Array(message, HEADER_BYTES, taxels),
    raw: new Float32Array(message, loadsAt, taxels),
    compensated: new Float32Array(message, loadsAt + 4 * taxels, taxels),
    marks: new Uint8Array(message, loadsAt + 8 * taxels, taxels),
  };
}

// A frame of its own memory, for one that is read back from the buffer.
export function blankFrame(rows, columns) {
  const taxels = rows * columns;
  return {
    rows, columns, flags: 0, sequence: 0, device: NaN, host: NaN, total: NaN, peak: NaN, area: NaN,
    copRow: NaN, copColumn: NaN, outliers: 0, age: NaN, rate: NaN,
    counts: new Uint16Array(taxels),
    raw: new Float32Array(taxels),
    compensated: new Float32Array(taxels),
    marks: new Uint8Array(taxels),
  };
}
