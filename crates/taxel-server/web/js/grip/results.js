// What the session came to: a table of the accepted trials, and what was written.

import { byId, made } from "../dom.js";
import { showFiles } from "../filelinks.js";
import { summaryOf, wholeNewtons } from "./numbers.js";
import { kgCell } from "./panel.js";
import { filesOf, handText } from "./words.js";

/** @typedef {import("./numbers.js").HandSummary} HandSummary */

export class Results {
  /** @param {() => string} token what the server wants to be told with each address; empty where it wants nothing */
  constructor(token) {
    this.token = token;
    this.key = "";
  }

  /** @param {Wire.GripSession} grip */
  show({ phase, trials, files }) {
    byId("results").hidden = phase !== "done";
    const key = JSON.stringify([trials, files]);
    if (phase !== "done" || key === this.key) return;
    this.key = key;
    this.showSummary(summaryOf(trials));
    showFiles(filesOf(files), this.token());
  }

  /** @param {HandSummary[]} hands */
  showSummary(hands) {
    const head = document.createElement("thead");
    const over = document.createElement("tr");
    over.append(heading("Trial", "col", 1, 2), ...hands.map(({ hand }) => heading(handText(hand), "colgroup", 2)));
    const under = document.createElement("tr");
    under.append(...hands.flatMap(() => [heading("max kg", "col"), heading("max N", "col")]));
    head.append(over, under);
    const body = document.createElement("tbody");
    const numbers = [...new Set(hands.flatMap(({ trials }) => trials.map(({ number }) => number)))].sort((a, b) => a - b);
    for (const number of numbers) {
      body.append(line(String(number), hands.map(({ trials }) => trials.find((trial) => trial.number === number)?.accepted?.max_newtons ?? NaN)));
    }
    const foot = document.createElement("tfoot");
    foot.append(line("Best", hands.map(({ best }) => best)), line(meanText(hands), hands.map(({ mean }) => mean)));
    const caption = made("caption", "Largest force of each accepted trial");
    byId("summary").replaceChildren(caption, head, body, foot);
  }
}

/** @param {HandSummary[]} hands */
function meanText(hands) {
  const counts = hands.map(({ accepted }) => accepted);
  return new Set(counts).size === 1 ? `Mean of ${counts[0]}` : `Mean of ${counts.join(" and ")}`;
}

/**
 * @param {string} text
 * @param {"col" | "colgroup" | "row"} scope
 */
function heading(text, scope, columns = 1, rows = 1) {
  const cell = document.createElement("th");
  cell.scope = scope;
  cell.textContent = text;
  cell.colSpan = columns;
  cell.rowSpan = rows;
  return cell;
}

/**
 * @param {string} name
 * @param {number[]} forces newtons
 */
function line(name, forces) {
  const row = document.createElement("tr");
  row.append(heading(name, "row"), ...forces.flatMap((newtons) => [kgCell(newtons), made("td", wholeNewtons(newtons), "num")]));
  return row;
}
