// What the page says in each phase. Nothing here knows the page.

import { capital, filesInOrder } from "../text.js";
import { bothForces, kilograms, lengthText, targetText } from "./numbers.js";

/** @typedef {{ action: string, label: string }} Button */
/** @typedef {{ title: string, text: string, primary: Button | null }} Words */

/** The steps that the operator sees, and the phases that each of them is made of. */
export const STEPS = [
  { name: "Person", phases: ["setup"] },
  { name: "Zero", phases: ["zero"] },
  { name: "Ready", phases: ["ready"] },
  { name: "Grip", phases: ["countdown", "hold"] },
  { name: "Review", phases: ["measuring", "review"] },
  { name: "Rest", phases: ["rest"] },
  { name: "Results", phases: ["finishing", "done"] },
];

/** Which a trial is repeated for; the words go into the results. */
export const REASONS = [
  "the hand slipped",
  "did not try as hard as possible",
  "began too early or too late",
  "pain or discomfort",
  "something was wrong with the sensor",
];

/** What the files of the results are, by the end of their name, in the order in which they are shown. */
const FILES = [
  { end: ".html", text: "Page to read" },
  { end: ".pdf", text: "Page to print (A4)" },
  { end: ".csv", text: "Table for statistics" },
  { end: ".json", text: "Everything, for programs" },
];

/** @param {Wire.GripTrial["hand"]} hand */
export const handText = (hand) => `${capital(hand)} hand`;

/**
 * "Right hand, trial 2 of 3"; empty where no trial is next.
 * @param {Wire.GripSession} grip
 */
export function trialText({ trials, trial }) {
  const there = trial === null ? undefined : trials[trial];
  if (!there) return "";
  const ofHand = trials.filter(({ hand }) => hand === there.hand).length;
  return `${handText(there.hand)}, trial ${there.number} of ${ofHand}`;
}

/**
 * How a planned trial stands.
 * @param {Wire.GripSession} grip
 * @param {number} at its place
 */
export function standing({ trials, trial, phase }, at) {
  const { accepted, repeats } = trials[at];
  const isNow = at === trial && !["setup", "zero", "rest", "finishing", "done"].includes(phase);
  const isNext = at === trial && ["zero", "rest"].includes(phase);
  const isOver = ["finishing", "done"].includes(phase);
  const word = accepted ? "accepted" : isNow ? "now" : isNext ? "next" : isOver ? "not done" : "to come";
  return repeats > 0 ? `${word}, repeated ×${repeats}` : word;
}

/** @param {Wire.GripProtocol} protocol */
export function taskText({ target_newtons, hold_secs }) {
  const length = lengthText(hold_secs);
  if (target_newtons) return `Squeeze to ${targetText(target_newtons)} and hold it there for ${length}.`;
  return `Squeeze as strongly as possible and hold for ${length}.`;
}

/**
 * @param {string} trial may be empty
 * @param {string} text
 */
const sentences = (trial, text) => (trial ? `${trial}. ${text}` : text);

/**
 * @param {Wire.GripSession} grip
 * @returns {Words}
 */
export function wordsOf(grip) {
  const { protocol } = grip;
  const trial = trialText(grip);
  switch (grip.phase) {
    case "setup":
      return { title: "Who grips?", text: "Give the person an id that says nothing about who it is.", primary: { action: "begin", label: "Begin the session" } };
    case "zero":
      return { title: "Take the hand off the handle", text: "Nothing may touch the handle while its zero is taken.", primary: { action: "zero", label: "Take zero" } };
    case "ready":
      if (!trial) return { title: "All trials are done", text: "Finish the session to write the results.", primary: { action: "finish", label: "Finish session" } };
      return { title: trial, text: taskText(protocol), primary: { action: "start", label: "Start trial" } };
    case "countdown":
      return { title: "Get ready", text: sentences(trial, taskText(protocol)), primary: { action: "cancel", label: "Cancel" } };
    case "hold":
      return { title: "Squeeze – hold", text: trial, primary: { action: "cancel", label: "Cancel" } };
    case "measuring":
      return { title: "Measuring…", text: sentences(trial, "Let go of the handle."), primary: null };
    case "review":
      return { title: trial || "The trial", text: "Let go of the handle. Does this trial count?", primary: { action: "accept", label: "Accept" } };
    case "rest":
      return { title: "Rest", text: trial ? `Next: ${trial.slice(0, 1).toLowerCase()}${trial.slice(1)}.` : "", primary: { action: "skip-rest", label: "Skip the rest" } };
    case "finishing":
      return { title: "Writing the results…", text: "This takes some seconds. Leave the page open.", primary: null };
    case "done":
      return { title: "The session is finished", text: "The largest force of each trial, and what was written.", primary: null };
  }
}

/**
 * A change of phase, for those who listen.
 * @param {Wire.GripSession} grip
 */
export function announcement(grip) {
  const { title, text } = wordsOf(grip);
  const { measured } = grip;
  if (grip.phase !== "review" || !measured) return `${title}. ${text}`;
  const doubts = measured.doubts.length > 0 ? ` Doubtful: ${measured.doubts.join("; ")}.` : "";
  return `${title}: largest ${bothForces(measured.max_newtons)}.${doubts} ${text}`;
}

/** @param {Wire.GripSession} grip */
export function finishText({ trials }) {
  const accepted = trials.filter((trial) => trial.accepted).length;
  const rest = trials.length - accepted;
  if (rest === 0) return `All trials are accepted. The results are written, and nothing can be added afterwards.`;
  return `${accepted} of ${trials.length} trials ${accepted === 1 ? "is" : "are"} accepted; the other ${rest === 1 ? "one stays" : `${rest} stay`} empty. The results are written, and nothing can be added afterwards.`;
}

/** @param {string[]} names */
export const filesOf = (names) => filesInOrder(names, FILES);

/** @param {Wire.GripTrial} trial */
export const maxText = ({ accepted }) => (accepted ? kilograms(accepted.max_newtons) : "–");
