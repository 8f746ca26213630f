// What the codes of marks mean, as the server says it in its first message.

export class MarkTable {
  /** @param {Wire.MarkMeaning[]} meanings in the order of their codes */
  constructor(meanings) {
    this.meanings = meanings;
    /** @param {string} wanted */
    const code = (wanted) => meanings.findIndex(({ word }) => word === wanted);
    this.saturated = code("saturated");
    this.belowFloor = code("below-floor");
    this.absent = code("absent");
  }

  get length() {
    return this.meanings.length;
  }

  /**
   * @param {number} code
   * @returns {Wire.MarkMeaning}
   */
  of(code) {
    return this.meanings[code] || { word: `mark ${code}`, severity: 2, text: "A mark this page does not know.", counts: false, scales: true };
  }

  /**
   * Whether such a taxel counts in totals.
   * @param {number} code
   */
  counts(code) {
    const meaning = this.meanings[code];
    return meaning !== undefined && meaning.counts;
  }

  /**
   * Whether the value of such a taxel may set the scale of colours.
   * @param {number} code
   */
  scales(code) {
    const meaning = this.meanings[code];
    return meaning === undefined || meaning.scales;
  }

  /**
   * Over the taxels that count.
   * @param {Float32Array} values
   * @param {Uint8Array} marks
   */
  sum(values, marks) {
    let total = 0;
    for (let i = 0; i < values.length; i += 1) {
      const value = values[i];
      if (value === value && this.counts(marks[i])) total += value;
    }
    return total;
  }
}
