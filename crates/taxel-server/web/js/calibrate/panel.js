// What is always to be seen: how good it is by now, the presses, the warnings, and whose calibration it is.

import { byId, inside, made, write } from "../dom.js";
import { SidePanel } from "../sidepanel.js";
import { errorText, lastError, loadText, saysText } from "./numbers.js";
import { countText, counting, taxelOf } from "./words.js";

export class Panel extends SidePanel {
  /** @param {import("./chart.js").ErrorChart} chart */
  constructor(chart) {
    super();
    this.chart = chart;
  }

  /** @param {Wire.CalibrationSession} session */
  show(session) {
    const { presses, progress, warnings } = session;
    if (this.isNew("progress", progress)) this.showProgress(progress);
    if (this.isNew("presses", presses)) this.showPresses(presses);
    this.showWarnings(warnings);
    this.showFacts(factsOf(session));
    write("sensor-name", session.sensor);
    byId("sensor-chip").hidden = session.sensor === "";
    byId("simulated").hidden = !session.is_simulated;
    byId("resumed").hidden = !session.is_resumed || session.phase === "done";
  }

  /** There is no calibration: whose it was stands nowhere any more. */
  hide() {
    byId("sensor-chip").hidden = true;
    byId("simulated").hidden = true;
  }

  /** @param {Wire.HeldOutError[]} progress */
  showProgress(progress) {
    const last = lastError(progress);
    write("error-last", last ? errorText(last) : "");
    byId("error-empty").hidden = last !== null;
    byId("error-legend").hidden = last === null;
    this.chart.show(progress);
  }

  /** @param {Wire.TakenPress[]} presses */
  showPresses(presses) {
    const out = presses.length - counting(presses);
    write("presses-count", `${counting(presses)} taken${out > 0 ? `, ${out} left out` : ""}`);
    byId("presses-empty").hidden = presses.length > 0;
    byId("presses-box").hidden = presses.length === 0;
    inside(byId("presses"), "tbody").replaceChildren(...presses.map(line).reverse());
  }
}

/**
 * @param {Wire.TakenPress} press
 * @param {number} at its place
 */
function line({ asked, says_g, left_out }, at) {
  const row = document.createElement("tr");
  const number = made("th", String(at + 1), "num");
  number.setAttribute("scope", "row");
  const taxel = taxelOf(asked);
  const where = made("td", taxel ? `${taxel.row}, ${taxel.column}` : "all", "num");
  if (asked.is_among_others) where.append(made("span", "among others", "note-line"));
  const says = made("td", "");
  says.append(made("span", saysText(says_g, asked.load_g), "num"));
  if (left_out) {
    row.dataset.leftOut = "true";
    says.append(made("span", `Left out: ${left_out}`, "note-line why-out"));
  }
  row.append(number, where, made("td", loadText(asked.load_g), "num"), says);
  return row;
}

/**
 * @param {Wire.CalibrationSession} session
 * @returns {[string, string][]}
 */
function factsOf({ sensor, folder, output, loads_g, presses, least_presses }) {
  return [
    ["Sensor", sensor || "–"],
    ["Loads", loads_g.map(loadText).join(", ") || "–"],
    ["Presses", `${countText(counting(presses))}, at least ${least_presses}`],
    ["Folder", folder || "–"],
    ["Output", output || "–"],
  ];
}
