// What the page says in each phase. Nothing here knows the page.

import { capital, filesInOrder } from "../text.js";
import { loadText, saysText } from "./numbers.js";

/** @typedef {{ action: string, label: string }} Button */
/** @typedef {{ title: string, text: string, more: string, primary: Button | null }} Words */

/** @type {Wire.CalibrationPhase[]} */
export const PRESSING = ["press", "elsewhere", "taking", "off"];

/** What the files are, by the end of their name, in the order in which they are shown. */
const FILES = [
  { end: ".html", text: "Certificate to read" },
  { end: ".pdf", text: "Certificate to print (A4)" },
  { end: "sensor.toml", text: "The calibrated sensor" },
  { end: "presses.csv", text: "Table of the presses" },
  { end: "even.csv", text: "Table of the even loads" },
  { end: "residuals.csv", text: "What each press is off by" },
  { end: "parts.toml", text: "The sensor before it was calibrated" },
];

/** @param {string[]} names */
export const filesOf = (names) => filesInOrder(names, FILES);

const OTHERS_STAY = "Leave the other things where they lie.";

/** @type {Button} */
const READY = { action: "ready", label: "Ready" };

/**
 * A sentence of words that may be none yet.
 * @param {string} words
 */
export function sentence(words) {
  const text = capital(words.trim());
  return text === "" || /[.!?…]$/.test(text) ? text : `${text}.`;
}

/** @param {string[]} parts some may be empty */
const joined = (...parts) => parts.filter((part) => part !== "").join(" ");

/** @param {Page.Taxel} taxel */
export const taxelText = ({ row, column }) => `row\u00a0${row}, column\u00a0${column}`;

/**
 * Of one taxel; null where the whole sensor is to be loaded.
 * @param {Wire.AskedPress} asked
 * @returns {Page.Taxel | null}
 */
export const taxelOf = ({ row, column }) => (row === null || column === null ? null : { row, column });

/** @param {Wire.AskedPress} asked */
export function whereText(asked) {
  const taxel = taxelOf(asked);
  return taxel ? taxelText(taxel) : "the whole sensor";
}

/** @param {Wire.AskedPress} asked */
export function askedText(asked) {
  const taxel = taxelOf(asked);
  const load = loadText(asked.load_g);
  const again = asked.is_again ? " again" : "";
  if (!taxel) return `Load the whole sensor evenly${again}: ${load} on each taxel`;
  return `Press ${taxelText(taxel)}${again} with ${load}`;
}

/** @param {Wire.AskedPress} asked */
function standsText(asked) {
  const load = loadText(asked.load_g);
  return taxelOf(asked) ? `${load} at ${whereText(asked)}` : `${load} on each taxel`;
}

/**
 * @param {Wire.SeenPress} seen
 * @param {Wire.AskedPress | null} asked
 * @returns {Words}
 */
function elsewhereWords(seen, asked) {
  const here = taxelText(seen);
  const text = sentence(seen.problem);
  if (asked && !taxelOf(asked)) return { title: "That is not the whole sensor", text, more: "Load it evenly, or skip this one.", primary: null };
  // That it is there is known already: to say so would change nothing.
  if (seen.is_there) return { title: `Something is wrong at ${here}`, text, more: "Put it right, or choose another load.", primary: null };
  const move = asked ? `Move it to ${whereText(asked)}` : "Take it off";
  return { title: `It stands at ${here}`, text, more: `${move}, or take it where it stands.`, primary: { action: "here", label: "Take it there" } };
}

/** @param {Wire.CalibrationSession} session */
function offText({ presses }) {
  const last = presses.at(-1);
  if (last?.left_out) return `${sentence(`left out: ${last.left_out}`)} The next press is asked for by itself.`;
  if (!last || last.says_g === null) return "The next press is asked for by itself.";
  return `The other presses say ${saysText(last.says_g, last.asked.load_g)}. The next press is asked for by itself.`;
}

/** @param {Wire.CalibrationSession} session */
function doneText({ presses, output, folder }) {
  return `${capital(countText(counting(presses)))} taken. The calibrated sensor is in ${output || folder}.`;
}

/**
 * How many of them count.
 * @param {Wire.TakenPress[]} presses
 */
export const counting = (presses) => presses.filter(({ left_out }) => left_out === "").length;

/** @param {number} presses */
export const countText = (presses) => `${presses} ${presses === 1 ? "press" : "presses"}`;

/**
 * @param {Wire.CalibrationSession} session
 * @returns {Words}
 */
export function wordsOf(session) {
  const { phase, asked, seen } = session;
  const others = asked?.is_among_others ? OTHERS_STAY : "";
  switch (phase) {
    case "empty":
      return { title: "Take everything off the sensor", text: "Nothing may touch it while it is read empty.", more: "", primary: READY };
    case "reading":
      return { title: asked?.is_among_others ? "Reading what lies there…" : "Reading the empty sensor…", text: "Touch nothing for some seconds.", more: "", primary: null };
    case "others": {
      const free = asked && taxelOf(asked) ? `Leave ${whereText(asked)} free.` : "";
      return { title: "Lay something heavy on other places", text: joined("A hand, or bottles: how heavy they are does not matter.", free), more: "", primary: READY };
    }
    case "press":
      if (!asked) return { title: "Wait for the next press", text: "", more: "", primary: null };
      return { title: askedText(asked), text: sentence(asked.why), more: others, primary: null };
    case "elsewhere":
      if (!seen) return { title: "Something else presses", text: asked ? `${askedText(asked)}.` : "", more: "", primary: null };
      return elsewhereWords(seen, asked);
    case "taking":
      return { title: "Hold still", text: asked ? `${standsText(asked)}.` : "", more: others, primary: null };
    case "off":
      return { title: session.presses.at(-1)?.left_out ? "Take it off" : "Taken. Take it off", text: offText(session), more: session.presses.at(-1)?.asked.is_among_others ? OTHERS_STAY : "", primary: null };
    case "finishing":
      return { title: "Writing the results…", text: "The last fit takes some seconds. Leave the page open.", more: "", primary: null };
    case "done":
      return { title: "The calibration is finished", text: doneText(session), more: "", primary: null };
  }
}

/**
 * What is asked for, for those who listen.
 * @param {Wire.CalibrationSession} session
 */
export function announcement(session) {
  const { title, text, more } = wordsOf(session);
  return joined(sentence(title), text, more);
}

/**
 * Whether it is enough, and what is missing.
 * @param {Wire.CalibrationSession} session
 */
export function verdictText({ presses, least_presses, is_enough, advice }) {
  const count = counting(presses);
  const taken = `${capital(countText(count))} taken.`;
  if (count < least_presses) return `${taken} At least ${least_presses} are needed.`;
  if (is_enough) return joined("That is enough.", sentence(advice));
  return joined(taken, sentence(advice));
}

/** @param {Wire.CalibrationSession} session */
export function finishText({ presses, advice }) {
  const count = counting(presses);
  return joined(`${capital(countText(count))} ${count === 1 ? "is" : "are"} taken, and more would still make it better.`, sentence(advice),
    "The results are written, and nothing can be added afterwards.");
}

/** @param {Wire.CalibrationSession} session */
export function canFinish({ phase, presses, least_presses }) {
  return counting(presses) >= Math.max(1, least_presses) && !["finishing", "done"].includes(phase);
}
