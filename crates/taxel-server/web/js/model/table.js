// The values as a table: for those who read rather than look, and for copying.

import { fixed } from "../units.js";

/** @type {Record<Model.Quantity, [quantity: Model.Quantity, words: string, decimals: number][]>} */
const COLUMNS = {
  volts: [["volts", "V_out (V)", 5], ["drop", "drop (%)", 3]],
  counts: [["counts", "counts", 0], ["drop", "drop (%)", 3]],
  drop: [["volts", "V_out (V)", 5], ["drop", "drop (%)", 3]],
};
/** @type {["circuit" | "paper", string][]} */
const MODELS = [["circuit", "circuit"], ["paper", "paper"]];

/**
 * @param {"th" | "td" | "caption"} name
 * @param {string} text
 */
const cell = (name, text, properties = {}) => Object.assign(document.createElement(name), { textContent: text, ...properties });

/**
 * @param {HTMLTableElement} table
 * @param {{ curves: Model.Curves[], y: Model.Quantity, last: number }} what
 */
export function writeTable(table, { curves, y, last }) {
  const columns = COLUMNS[y].flatMap(([quantity, words, decimals]) => MODELS.map(([model, modelWords]) => ({ quantity, model, decimals, text: `${words}, ${modelWords}` })));
  const top = document.createElement("tr");
  const second = document.createElement("tr");
  top.append(cell("th", "N", { scope: "col", rowSpan: 2 }));
  for (const { name, colour } of curves) {
    const head = cell("th", name, { scope: "colgroup", colSpan: columns.length, title: name });
    head.dataset.colour = String(colour);
    top.append(head);
    columns.forEach(({ text }, i) => second.append(cell("th", text, { scope: "col", className: i === 0 ? "first" : "" })));
  }
  const body = document.createElement("tbody");
  for (let n = 0; n <= last; n += 1) {
    const row = document.createElement("tr");
    row.append(cell("th", String(n), { scope: "row" }));
    curves.forEach((curve, setting) => columns.forEach(({ quantity, model, decimals }, i) => {
      const value = curve[model][quantity][n];
      const saturates = curve[model].saturates[n];
      const one = cell("td", fixed(value, decimals), { className: [i === 0 ? "first" : "", saturates ? "saturates" : ""].join(" ").trim() });
      if (saturates) one.title = "saturates: beyond the converter's full scale";
      // Every digit, for those who compute on.
      Object.assign(one.dataset, { setting, model, quantity, value });
      row.append(one);
    }));
    body.append(row);
  }
  const head = document.createElement("thead");
  head.append(top, second);
  const caption = cell("caption", "Both models of each setting against N, the number of other pressed taxels in the row", { className: "sr" });
  table.replaceChildren(caption, head, body);
}
