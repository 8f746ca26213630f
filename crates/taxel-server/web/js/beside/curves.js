// Two curves on one axis of time, each of a recording of its own.

/** @typedef {(number | null)[]} Column */

/**
 * Both over all seconds of either: straight between the points of each, nothing where it has none.
 * @param {{ secs: number[], values: Column }[]} curves
 * @returns {{ secs: number[], columns: Column[] }}
 */
export function together(curves) {
  const secs = [...new Set(curves.flatMap((curve) => curve.secs))].sort((a, b) => a - b);
  return { secs, columns: curves.map((curve) => over(curve, secs)) };
}

/**
 * @param {{ secs: number[], values: Column }} curve
 * @param {number[]} wanted ascending
 * @returns {Column}
 */
function over({ secs, values }, wanted) {
  let at = 0;
  return wanted.map((wish) => {
    while (at < secs.length && secs[at] < wish) at += 1;
    if (at === secs.length || (at === 0 && secs[0] > wish)) return null;
    if (secs[at] === wish) return values[at];
    const [before, after] = [values[at - 1], values[at]];
    if (before === null || after === null) return null;
    return before + ((after - before) * (wish - secs[at - 1])) / (secs[at] - secs[at - 1]);
  });
}

/**
 * The largest value of a column; NaN of none.
 * @param {Column} values
 */
export function largest(values) {
  return /** @type {number} */ (values.reduce((most, value) => (value !== null && !(value <= /** @type {number} */ (most)) ? value : most), NaN));
}
