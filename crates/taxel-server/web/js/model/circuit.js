// One pressed taxel is read while N others in its row are pressed: what comes out, by the full circuit and by the
// paper's equation 6. Pure functions, nothing of the page, so that node can test them.
//
// Symbols of "Compensation of Cross-talk in a Large Piezoresistive Sensor Array": A open-loop gain, R_k feedback,
// R_taxel the taxel that is read, R_i each of the N others, V_test, R_mux each switch (the columns' and the row's),
// R_v in series with the source.

/** @type {Model.Numbers} */
export const TABLE_V = {
  openLoopGain: 1e5, feedbackOhms: 2000, otherOhms: 1000, taxelOhms: 1000, testVolts: 0.4, switchOhms: 0, sourceOhms: 0,
};

export const MAX_COUNT = 2 ** 16 - 1;

// V_out in volts, exact for the read-out tia-grounded-columns: each other taxel in a column of its own, which R_mux
// grounds; all else open. The row line's voltage v follows from
//   (V_test − v)/(R_mux + R_v + R_taxel) = v·N/(R_mux + R_i) + v·g,   g = 1/(R_mux + R_k/(1+A)),
// and V_out = −A/(1+A)·R_k·g·v. Written without g, which is infinite for an ideal amplifier behind no switch.
/**
 * @param {Model.Numbers} setting
 * @param {number} others
 */
export function circuitVolts(setting, others) {
  const { openLoopGain, feedbackOhms, otherOhms, taxelOhms, testVolts, switchOhms, sourceOhms } = setting;
  const endOhms = switchOhms + feedbackOhms / (1 + openLoopGain);
  const driveOhms = switchOhms + sourceOhms + taxelOhms;
  const amperes = testVolts / (driveOhms * (1 + endOhms * (1 / driveOhms + others / (switchOhms + otherOhms))));
  return (-feedbackOhms / (1 + 1 / openLoopGain)) * amperes;
}

// V_out in volts by equation 6, as `v_out_alike` in crates/taxel/src/circuit/simplified.rs has it:
//   V_out ≈ −V_test·A·R_k·R_i / ((A·R_i + N·R_k)·R_taxel)
/**
 * @param {Model.Numbers} setting
 * @param {number} others
 */
export function paperVolts({ openLoopGain, feedbackOhms, otherOhms, taxelOhms, testVolts }, others) {
  const leakOhms = otherOhms / others;
  return (-testVolts * feedbackOhms) / taxelOhms / (feedbackOhms / (openLoopGain * leakOhms) + 1);
}

/**
 * Counts of the e-Cone's converter, which grow as V_out falls; neither rounded nor clipped.
 * @param {number} volts
 * @param {number} fullScaleVolts
 */
export const countsFromVolts = (volts, fullScaleVolts) => -volts / (fullScaleVolts / MAX_COUNT);

/**
 * @param {number} counts
 * @param {number} fullScaleVolts
 */
export const voltsFromCounts = (counts, fullScaleVolts) => -counts * (fullScaleVolts / MAX_COUNT);

/**
 * How much of the V_out at N = 0 is gone.
 * @param {number} volts
 * @param {number} alone
 */
export const dropPercent = (volts, alone) => (alone === 0 ? 0 : 100 * (1 - volts / alone));

/**
 * Both models of a setting at N = 0 … last, an array a quantity.
 * @param {Model.Numbers} setting
 * @param {number} last
 * @param {number} fullScaleVolts
 */
export function curvesOf(setting, last, fullScaleVolts) {
  /** @param {(setting: Model.Numbers, others: number) => number} volts */
  const along = (volts) => {
    /** @type {Model.Curve} */
    const curve = { volts: [], counts: [], drop: [], saturates: [] };
    const alone = volts(setting, 0);
    for (let others = 0; others <= last; others += 1) {
      const value = volts(setting, others);
      curve.volts.push(value);
      curve.counts.push(countsFromVolts(value, fullScaleVolts));
      curve.drop.push(dropPercent(value, alone));
      curve.saturates.push(Math.abs(value) > fullScaleVolts);
    }
    return curve;
  };
  return { circuit: along(circuitVolts), paper: along(paperVolts) };
}
