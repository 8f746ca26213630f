// The figures of both recordings in one table: of the frames shown, and of the whole.

import { byId, made, write } from "../dom.js";
import { decimalsFor, fixed, plusMinus } from "../units.js";
import { largest } from "./curves.js";

/**
 * @typedef {object} Row
 * @property {string} name
 * @property {number} factor
 * @property {(side: import("./side.js").Side) => number} of
 * @property {"force" | "area"} [error]
 */

/** @type {(Row | string)[]} */
const ROWS = [
  "Now",
  { name: "Total force, N", factor: 1, of: ({ frame }) => frame?.total ?? NaN, error: "force" },
  { name: "Grip force, N", factor: 1, of: ({ frame }) => frame?.grip ?? NaN },
  { name: "Highest pressure, kPa", factor: 1, of: ({ frame }) => frame?.peak ?? NaN },
  { name: "Contact area, cm²", factor: 0.01, of: ({ frame, shown }) => (shown.newtons && frame ? frame.area : NaN), error: "area" },
  { name: "Highest conductance, µS", factor: 1e6, of: ({ siemens }) => siemens },
  "Whole recording",
  { name: "Largest force, N", factor: 1, of: ({ curve }) => (curve ? largest(curve.total_newtons) : NaN) },
  { name: "Highest pressure, kPa", factor: 1, of: ({ curve }) => (curve ? largest(curve.peak_kilopascals) : NaN) },
  { name: "Largest area, cm²", factor: 0.01, of: ({ curve }) => (curve ? largest(curve.contact_area_mm2) : NaN) },
  { name: "Length, s", factor: 1, of: ({ duration }) => duration },
];

export class Numbers {
  constructor() {
    this.rows = ROWS.map((row) => {
      const element = document.createElement("tr");
      const head = /** @type {HTMLTableCellElement} */ (made("th", typeof row === "string" ? row : row.name));
      head.scope = typeof row === "string" ? "colgroup" : "row";
      element.append(head);
      byId("figures").append(element);
      if (typeof row === "string") {
        head.colSpan = 4;
        element.className = "part";
        return null;
      }
      const cells = [0, 1, 2].map(() => {
        const cell = document.createElement("td");
        const [value, error] = [made("span", "", "num"), made("span", "", "num error")];
        cell.append(value, error);
        element.append(cell);
        return { value, error };
      });
      return { row, element, cells };
    });
  }

  /** @param {import("./side.js").Side[]} sides */
  write(sides) {
    for (const one of this.rows) {
      if (!one) continue;
      const { row, element, cells } = one;
      const values = sides.map((side) => row.of(side) * row.factor);
      element.hidden = !values.some(Number.isFinite);
      // As many decimals for both: they are compared.
      const decimals = decimalsFor(Math.max(...values.map((value) => (Number.isFinite(value) ? Math.abs(value) : 0))));
      values.forEach((value, i) => {
        write(cells[i].value, fixed(value, decimals));
        const { frame, figures } = sides[i];
        const told = row.error && frame ? figures.of(row.error, frame) : null;
        write(cells[i].error, told && told.half !== null ? plusMinus(told.half * row.factor, decimals).trim() : "");
      });
      write(cells[2].value, fixed(values[1] - values[0], decimals));
    }
  }
}
