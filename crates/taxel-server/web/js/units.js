// Units and numbers. Loads arrive in newtons (or siemens, without a load law); peaks in kPa; areas in mm2.

const GRAMS_PER_NEWTON = 1000 / 9.80665;
const MMHG_PER_KPA = 7.500617;

/**
 * `factor`: from newtons, or from kPa for a pressure.
 * @type {Page.Unit[]}
 */
export const UNITS = [
  { key: "N", text: "N", pressure: false, factor: 1 },
  { key: "g", text: "g", pressure: false, factor: GRAMS_PER_NEWTON },
  { key: "kPa", text: "kPa", pressure: true, factor: 1 },
  { key: "N/cm2", text: "N/cm²", pressure: true, factor: 0.1 },
  { key: "mmHg", text: "mmHg", pressure: true, factor: MMHG_PER_KPA },
];

/** @type {Page.Unit} */
export const MICROSIEMENS = { key: "uS", text: "µS", pressure: false, factor: 1e6 };

/** @param {string} key */
export function unitOf(key) {
  return UNITS.find((unit) => unit.key === key) || UNITS[0];
}

/**
 * What a load of one taxel is multiplied with to be shown in the unit.
 * @param {Page.Unit} unit
 * @param {number} areaSquareMm
 */
export function loadFactor(unit, areaSquareMm) {
  return unit.pressure ? (1000 / areaSquareMm) * unit.factor : unit.factor;
}

/**
 * The unit for a sum of loads: a sum has no pressure, so a pressure unit gives way to newtons.
 * @param {Page.Unit} unit
 */
export function forceUnit(unit) {
  return unit.pressure ? UNITS[0] : unit;
}

/**
 * The unit for a peak or a mean pressure: a force unit gives way to kPa.
 * @param {Page.Unit} unit
 */
export function pressureUnit(unit) {
  return unit.pressure ? unit : UNITS[2];
}

/**
 * Decimals that show a number of this size with so many digits.
 * @param {number} size
 */
export function decimalsFor(size, digits = 3) {
  if (!(size > 0)) return digits - 1;
  return Math.max(0, Math.min(8, digits - 1 - Math.floor(Math.log10(size) + 1e-9)));
}

const MINUS = "−";

/**
 * @param {number} value
 * @param {number} decimals
 */
export function fixed(value, decimals) {
  if (!Number.isFinite(value)) return "–";
  const text = value.toFixed(decimals);
  if (!text.startsWith("-")) return text;
  // "-0.00" would flicker with "0.00"
  return Number(text) === 0 ? text.slice(1) : MINUS + text.slice(1);
}

/**
 * Half the width of an interval, behind a number with so many decimals; empty where it means nothing.
 * @param {number} half
 * @param {number} decimals
 */
export function plusMinus(half, decimals) {
  if (!Number.isFinite(half)) return "";
  const least = 10 ** -decimals;
  return half < least / 2 ? ` ± <${fixed(least, decimals)}` : ` ± ${fixed(half, decimals)}`;
}

/** @param {number} value */
export const significant = (value, digits = 3) => fixed(value, decimalsFor(Math.abs(value), digits));

/** @type {[number, string][]} */
const PREFIXES = [[1, "S"], [1e-3, "mS"], [1e-6, "µS"], [1e-9, "nS"]];

/** @param {number} value */
export function siemens(value) {
  if (!Number.isFinite(value)) return "–";
  const [scale, text] = PREFIXES.find(([least]) => Math.abs(value) >= least) || PREFIXES[3];
  return `${significant(value / scale)} ${text}`;
}

/** @param {number} squareMm */
export function areaText(squareMm) {
  return squareMm >= 1000 ? `${significant(squareMm / 100)} cm²` : `${fixed(squareMm, 0)} mm²`;
}

/** @param {number} bytes */
export function bytesText(bytes) {
  if (bytes < 1e6) return `${fixed(bytes / 1e3, 0)} kB`;
  return bytes < 1e9 ? `${fixed(bytes / 1e6, 1)} MB` : `${fixed(bytes / 1e9, 2)} GB`;
}

/** @param {number} seconds */
export function durationText(seconds) {
  if (!Number.isFinite(seconds)) return "–";
  const whole = Math.floor(seconds / 60);
  const rest = fixed(seconds - 60 * whole, 1).padStart(4, "0");
  return `${whole}:${rest}`;
}

/** @param {number} hostSeconds */
export function clockText(hostSeconds) {
  const date = new Date(hostSeconds * 1000);
  if (Number.isNaN(date.getTime())) return "–";
  /** @param {number} n */
  const two = (n) => String(n).padStart(2, "0");
  return `${two(date.getHours())}:${two(date.getMinutes())}:${two(date.getSeconds())}.${Math.floor(date.getMilliseconds() / 100)}`;
}

const NICE = [1, 1.2, 1.5, 2, 2.5, 3, 4, 5, 6, 8, 10];

/**
 * The next round number at or above the value.
 * @param {number} value
 */
export function niceCeil(value) {
  if (!(value > 0)) return 1;
  const power = 10 ** Math.floor(Math.log10(value));
  const lead = value / power;
  return Number(((NICE.find((step) => step >= lead - 1e-9) || 10) * power).toPrecision(6));
}

/**
 * A round step that divides the range into at most so many.
 * @param {number} range
 * @param {number} most
 */
export function niceStep(range, most) {
  const rough = range / most;
  const power = 10 ** Math.floor(Math.log10(rough));
  const lead = rough / power;
  return (lead <= 1 ? 1 : lead <= 2 ? 2 : lead <= 5 ? 5 : 10) * power;
}
