// Numbers of a grip session in words, and what the accepted trials come to. Nothing here knows the page.

import { fixed } from "../units.js";
import { isNewtons } from "../wire.js";

/** What weighs one kilogram presses with this force. */
export const NEWTONS_PER_KG = 9.80665;

/** @param {number} newtons */
export const kilograms = (newtons) => fixed(newtons / NEWTONS_PER_KG, 1);

/** @param {number} newtons */
export const wholeNewtons = (newtons) => fixed(newtons, 0);

/** @param {number} newtons */
export const bothForces = (newtons) => `${kilograms(newtons)} kg · ${wholeNewtons(newtons)} N`;

/** @param {[number, number]} target newtons */
export function targetText([low, high]) {
  return `${kilograms(low)} to ${kilograms(high)} kg (${wholeNewtons(low)} to ${wholeNewtons(high)} N)`;
}

/**
 * Whole seconds that are left, as people count down: 1 until nothing is left.
 * @param {number} seconds
 */
export const countOf = (seconds) => Math.max(0, Math.ceil(seconds - 1e-6));

/** @param {number} seconds whole ones; from a minute on as minutes and seconds */
export function clock(seconds) {
  if (seconds < 60) return String(seconds);
  return `${Math.floor(seconds / 60)}:${String(seconds % 60).padStart(2, "0")}`;
}

/** @param {number} seconds a length that a protocol asks for */
export const lengthText = (seconds) => `${fixed(seconds, Number.isInteger(seconds) ? 0 : 1)}\u00a0s`;

/**
 * The force that the protocol speaks of, and its name: grip force on a handle, else the total. NaN where loads are no forces.
 * @param {Page.Frame} frame
 * @param {string} asked what the protocol calls it
 * @returns {{ newtons: number, name: string }}
 */
export function forceOf(frame, asked) {
  const isGrip = Number.isFinite(frame.grip) && !/total/i.test(asked);
  const name = isGrip || /total/i.test(asked) ? asked : "total normal force";
  if (!isNewtons(frame)) return { newtons: NaN, name };
  return { newtons: isGrip ? frame.grip : frame.total, name };
}

/** @typedef {{ hand: Wire.GripTrial["hand"], trials: Wire.GripTrial[], accepted: number, best: number, mean: number }} HandSummary */

/**
 * Best and mean of what was accepted, hand by hand, in the order in which they come; NaN without any.
 * @param {Wire.GripTrial[]} trials
 * @returns {HandSummary[]}
 */
export function summaryOf(trials) {
  const hands = [...new Set(trials.map(({ hand }) => hand))];
  return hands.map((hand) => {
    const own = trials.filter((trial) => trial.hand === hand).sort((a, b) => a.number - b.number);
    const maxima = own.flatMap(({ accepted }) => (accepted ? [accepted.max_newtons] : []));
    const sum = maxima.reduce((all, value) => all + value, 0);
    return {
      hand, trials: own, accepted: maxima.length,
      best: maxima.length > 0 ? Math.max(...maxima) : NaN,
      mean: maxima.length > 0 ? sum / maxima.length : NaN,
    };
  });
}

const PERSON = /^[A-Za-z0-9_-]{1,40}$/;

/**
 * What is wrong with a person's id; empty where nothing is.
 * @param {string} person
 */
export function wrongWithPerson(person) {
  if (person === "") return "An id is needed.";
  if (person.length > 40) return `At most 40 characters; these are ${person.length}.`;
  return PERSON.test(person) ? "" : "Letters (a to z), digits, - and _ only.";
}

/** The number on the screen is the mean over this long: single frames would make its last digit flicker. */
const STEADY_MS = 150;

export class SteadyForce {
  shown = NaN;
  sum = 0;
  count = 0;
  since = -Infinity;

  /**
   * @param {number} newtons
   * @param {number} now ms
   */
  take(newtons, now) {
    if (Number.isFinite(newtons)) {
      this.sum += newtons;
      this.count += 1;
    }
    if (now - this.since < STEADY_MS) return;
    this.shown = this.count > 0 ? this.sum / this.count : NaN;
    this.sum = 0;
    this.count = 0;
    this.since = now;
  }

  forget() {
    this.shown = NaN;
    this.sum = 0;
    this.count = 0;
    this.since = -Infinity;
  }
}
