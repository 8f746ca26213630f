// The last minutes of frames, within a fixed memory. New frames are all kept; older ones are thinned
// out in two steps, so that a 64 x 128 sensor reaches back about five minutes in 96 MB.

const MEMORY_BYTES = 96 * 1024 * 1024;
const MAX_FRAMES = 24000;
const BYTES_PER_TAXEL = 7;
const NOT_A_NUMBER = 65535;
const STEPS = 65534;

// share of the memory, and the shortest time in seconds between two frames that are kept there
const LEVELS = [
  { share: 0.4, spacing: 0 },
  { share: 0.3, spacing: 0.1 },
  { share: 0.3, spacing: 0.5 },
];

/** @type {(keyof Page.FrameScalars)[]} */
const SCALARS = ["sequence", "host", "device", "flags", "total", "peak", "area", "copRow", "copColumn", "outliers", "age", "rate", "grip"];

class Ring {
  /** @param {number} capacity */
  constructor(capacity) {
    /** @type {(Page.Slot | null)[]} */
    this.slots = new Array(capacity).fill(null);
    this.first = 0;
    this.length = 0;
  }

  /**
   * @param {number} i less than the length
   * @returns {Page.Slot}
   */
  at(i) {
    return /** @type {Page.Slot} */ (this.slots[(this.first + i) % this.slots.length]);
  }

  /** @param {Page.Slot} slot */
  push(slot) {
    this.slots[(this.first + this.length) % this.slots.length] = slot;
    this.length += 1;
  }

  shift() {
    const slot = this.at(0);
    this.slots[this.first] = null;
    this.first = (this.first + 1) % this.slots.length;
    this.length -= 1;
    return slot;
  }

  get full() {
    return this.length === this.slots.length;
  }
}

export class FrameBuffer {
  /**
   * @param {number} rows
   * @param {number} columns
   */
  constructor(rows, columns) {
    this.taxels = rows * columns;
    const frames = Math.min(MAX_FRAMES, Math.floor(MEMORY_BYTES / (BYTES_PER_TAXEL * this.taxels)));
    this.rings = LEVELS.map((level) => new Ring(Math.max(2, Math.floor(level.share * frames))));
    /** @type {Page.Slot[]} */
    this.free = [];
  }

  get length() {
    return this.rings[0].length + this.rings[1].length + this.rings[2].length;
  }

  /**
   * @param {number} i 0 is the oldest frame
   * @returns {Page.Slot}
   */
  at(i) {
    for (let level = LEVELS.length - 1; level >= 0; level -= 1) {
      const ring = this.rings[level];
      if (i < ring.length) return ring.at(i);
      i -= ring.length;
    }
    throw new RangeError("the buffer has fewer frames");
  }

  clear() {
    while (this.length > 0) {
      for (const ring of this.rings) if (ring.length > 0) this.free.push(ring.shift());
    }
  }

  /**
   * The last frame at or before this time; 0 if all are later.
   * @param {number} host
   */
  indexAt(host) {
    let low = 0;
    let high = this.length - 1;
    while (low < high) {
      const middle = (low + high + 1) >> 1;
      if (this.at(middle).host <= host) low = middle;
      else high = middle - 1;
    }
    return low;
  }

  /** @param {Page.Frame} frame */
  push(frame) {
    if (this.rings[0].full) this.age(0);
    const slot = this.free.pop() || this.newSlot();
    for (const key of SCALARS) slot[key] = frame[key];
    slot.threshold = NaN;
    slot.counts.set(frame.counts);
    slot.marks.set(frame.marks);
    pack(frame.raw, slot.raw, slot.rawRange);
    pack(frame.compensated, slot.compensated, slot.compensatedRange);
    this.rings[0].push(slot);
  }

  /**
   * Makes room in one level: its oldest frame goes on to the next if that has none as recent.
   * @param {number} level
   */
  age(level) {
    const slot = this.rings[level].shift();
    const next = this.rings[level + 1];
    if (!next) {
      this.free.push(slot);
      return;
    }
    const newest = next.length > 0 ? next.at(next.length - 1).host : -Infinity;
    if (slot.host - newest < LEVELS[level + 1].spacing) {
      this.free.push(slot);
      return;
    }
    if (next.full) this.age(level + 1);
    next.push(slot);
  }

  /** @returns {Page.Slot} */
  newSlot() {
    const n = this.taxels;
    const memory = new ArrayBuffer(BYTES_PER_TAXEL * n);
    return {
      sequence: 0, host: NaN, device: NaN, flags: 0, total: NaN, peak: NaN, area: NaN, copRow: NaN, copColumn: NaN,
      outliers: NaN, age: NaN, rate: NaN, grip: NaN, threshold: NaN,
      counts: new Uint16Array(memory, 0, n),
      raw: new Uint16Array(memory, 2 * n, n),
      compensated: new Uint16Array(memory, 4 * n, n),
      marks: new Uint8Array(memory, 6 * n, n),
      rawRange: { low: 0, step: 0 },
      compensatedRange: { low: 0, step: 0 },
    };
  }

  /**
   * Unpacks a frame.
   * @param {number} i
   * @param {Page.Frame} frame where to
   */
  read(i, frame) {
    const slot = this.at(i);
    for (const key of SCALARS) frame[key] = slot[key];
    frame.counts.set(slot.counts);
    frame.marks.set(slot.marks);
    unpack(slot.raw, slot.rawRange, frame.raw);
    unpack(slot.compensated, slot.compensatedRange, frame.compensated);
  }
}

/**
 * @param {number} packed
 * @param {Page.PackedRange} range
 */
export function slotValue(packed, range) {
  return packed === NOT_A_NUMBER ? NaN : range.low + packed * range.step;
}

/**
 * @param {Float32Array} values
 * @param {Uint16Array} packed
 * @param {Page.PackedRange} range
 */
function pack(values, packed, range) {
  let low = Infinity;
  let high = -Infinity;
  for (let i = 0; i < values.length; i += 1) {
    const value = values[i];
    if (value < low) low = value;
    if (value > high) high = value;
  }
  range.low = low === Infinity ? 0 : low;
  range.step = high > low ? (high - low) / STEPS : 0;
  const scale = range.step > 0 ? 1 / range.step : 0;
  for (let i = 0; i < values.length; i += 1) {
    const value = values[i];
    packed[i] = value === value ? (value - range.low) * scale + 0.5 : NOT_A_NUMBER;
  }
}

/**
 * @param {Uint16Array} packed
 * @param {Page.PackedRange} range
 * @param {Float32Array} values
 */
function unpack(packed, range, values) {
  for (let i = 0; i < packed.length; i += 1) values[i] = slotValue(packed[i], range);
}
