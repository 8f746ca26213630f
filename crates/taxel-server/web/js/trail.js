// The way of the centre of pressure over the last two seconds before the shown frame.

const SECONDS = 2;
const MAX_POINTS = 256;

export class Trail {
  constructor() {
    this.rows = new Float32Array(MAX_POINTS);
    this.columns = new Float32Array(MAX_POINTS);
    this.length = 0;
  }

  /**
   * @template {string} N
   * @param {import("./series.js").Series<N | "copRow" | "copColumn">} series
   * @param {number} host
   */
  lay(series, host) {
    const { copRow, copColumn } = series.columns;
    const from = series.indexFrom(host - SECONDS);
    const to = series.indexFrom(host + 1e-6);
    const stride = Math.max(1, Math.ceil((to - from) / MAX_POINTS));
    this.length = 0;
    for (let i = from; i < to; i += stride) {
      // The trail starts anew where there was no load.
      if (copRow[i] !== copRow[i]) {
        this.length = 0;
        continue;
      }
      this.rows[this.length] = copRow[i];
      this.columns[this.length] = copColumn[i];
      this.length += 1;
    }
  }
}
