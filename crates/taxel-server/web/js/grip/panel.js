// What is always to be seen: the steps, the trials, the warnings, and whose session it is.

import { byId, inside, made, write } from "../dom.js";
import { SidePanel } from "../sidepanel.js";
import { capital } from "../text.js";
import { kilograms, lengthText, targetText } from "./numbers.js";
import { STEPS, maxText, standing } from "./words.js";

export class Panel extends SidePanel {
  constructor() {
    super();
    byId("steps").replaceChildren(...STEPS.map(({ name }, i) => {
      const item = document.createElement("li");
      item.append(made("span", String(i + 1), "number num"), made("span", name, "name"));
      return item;
    }));
  }

  /** @param {Wire.GripSession} grip */
  show(grip) {
    if (this.isNew("steps", grip.phase)) this.showSteps(grip.phase);
    if (this.isNew("trials", [grip.trials, grip.trial, grip.phase])) this.showTrials(grip);
    this.showWarnings(grip.warnings);
    this.showFacts(factsOf(grip));
    byId("person-chip").hidden = !grip.person;
    write("person-name", grip.person);
    byId("simulated").hidden = !grip.is_simulated;
    byId("resumed").hidden = !grip.is_resumed || grip.phase === "done";
  }

  /** @param {Wire.GripPhase} phase */
  showSteps(phase) {
    const now = STEPS.findIndex(({ phases }) => phases.includes(phase));
    [...byId("steps").children].forEach((item, i) => {
      // Ready, grip, review and rest come again and again: only what comes once is over.
      const isOver = i < now && (i < 2 || now === STEPS.length - 1);
      item.classList.toggle("over", isOver);
      if (i === now) item.setAttribute("aria-current", "step");
      else item.removeAttribute("aria-current");
    });
  }

  /** @param {Wire.GripSession} grip */
  showTrials(grip) {
    const rows = grip.trials.map((trial, at) => {
      const row = document.createElement("tr");
      const word = standing(grip, at);
      row.dataset.status = word.split(",")[0].replace(" ", "-");
      if (word.startsWith("now") || word.startsWith("next")) row.setAttribute("aria-current", "true");
      const status = document.createElement("td");
      status.append(made("span", "", "sign"), word);
      row.append(made("td", capital(trial.hand)), made("td", String(trial.number), "num"), status, made("td", maxText(trial), "num"));
      return row;
    });
    inside(byId("trials"), "tbody").replaceChildren(...rows);
    const done = grip.trials.filter(({ accepted }) => accepted).length;
    write("trials-done", `${done} of ${grip.trials.length} accepted`);
  }
}

/**
 * @param {Wire.GripSession} grip
 * @returns {[string, string][]}
 */
function factsOf({ person, folder, protocol }) {
  return [
    ["Person", person || "not given yet"],
    ["Folder", folder || "chosen when the session begins"],
    ["Protocol", protocol.name],
    ["Hold, rest", `${lengthText(protocol.hold_secs)}, ${lengthText(protocol.rest_secs)}`],
    ["Target", protocol.target_newtons ? targetText(protocol.target_newtons) : "as strongly as possible"],
    ["Force", `${protocol.force}; 1 kg = 9.80665 N`],
  ];
}

/** @param {number} newtons */
export const kgCell = (newtons) => made("td", kilograms(newtons), "num");
