// What area the taxels have. On a cone it differs from ring to ring, so that the same load is another pressure.

/** @type {WeakMap<Wire.SensorFacts, Float64Array | null>} */
const known = new WeakMap();

/**
 * The area of each taxel as a share of that of the widest ring; null where all are alike.
 * @param {Wire.SensorFacts} sensor
 */
function sharesOf(sensor) {
  let shares = known.get(sensor);
  if (shares === undefined) {
    const { handle, columns } = sensor;
    shares = null;
    if (handle && handle.narrowness.some((share) => share !== handle.narrowness[0])) {
      const { rings, narrowness } = handle;
      shares = Float64Array.from({ length: sensor.rows * columns }, (_, taxel) => narrowness[rings === "rows" ? Math.floor(taxel / columns) : taxel % columns]);
    }
    known.set(sensor, shares);
  }
  return shares;
}

/**
 * The area that a taxel's load acts on, mm².
 * @param {Wire.SensorFacts} sensor
 * @param {number} taxel
 */
export function taxelArea(sensor, taxel) {
  const shares = sharesOf(sensor);
  return sensor.taxel_area_mm2 * (shares ? shares[taxel] : 1);
}

/**
 * The area that a taxel stands for, as the server counts contact, mm².
 * @param {Wire.SensorFacts} sensor
 * @param {number} taxel
 */
export function cellArea(sensor, taxel) {
  const shares = sharesOf(sensor);
  return sensor.cell_area_mm2 * (shares ? shares[taxel] : 1);
}

/**
 * What a taxel's load is multiplied with for the load that is the same pressure on a taxel of the widest ring. That is what loads are
 * shown by as pressures: one factor then holds for all. Conductances are no pressures.
 * @param {Wire.SensorFacts} sensor
 * @param {number} taxel
 */
export function evening(sensor, taxel) {
  const shares = sensor.has_load_law ? sharesOf(sensor) : null;
  return shares ? 1 / shares[taxel] : 1;
}

/**
 * Loads of all taxels for a map in this unit: of a pressure, where taxels differ, each evened.
 * @param {Float32Array} values
 * @param {Wire.SensorFacts} sensor
 * @param {Page.Unit} unit
 * @param {Float32Array} scratch is filled and returned where they differ
 */
export function evened(values, sensor, unit, scratch) {
  if (!unit.pressure || !sensor.has_load_law || !sharesOf(sensor)) return values;
  for (let i = 0; i < values.length; i += 1) scratch[i] = values[i] * evening(sensor, i);
  return scratch;
}
