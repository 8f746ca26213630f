// A grip session without a browser: its numbers, its clock, its curve and its words.

import assert from "node:assert/strict";
import { test } from "node:test";

import { Curve, MOST_POINTS } from "../web/js/grip/curve.js";
import { Deadline } from "../web/js/grip/deadline.js";
import {
  SteadyForce, bothForces, clock, countOf, forceOf, kilograms, lengthText, summaryOf, targetText, wholeNewtons, wrongWithPerson,
} from "../web/js/grip/numbers.js";
import { STEPS, announcement, filesOf, finishText, standing, taskText, trialText, wordsOf } from "../web/js/grip/words.js";
import { FLAG_NEWTONS, blankFrame } from "../web/js/wire.js";

const measured = (max, more = {}) => ({
  max_newtons: max, plateau_newtons: 0.9 * max, variation_percent: 2, time_to_peak_secs: 0.8, total_newtons: 1.5 * max, doubts: [], ...more,
});
const planned = (hand, number, max = null, repeats = 0) => ({ hand, number, repeats, accepted: max === null ? null : measured(max) });
const session = (more = {}) => ({
  phase: "ready", remaining_secs: null, lasts_secs: null, person: "P-1", folder: "", trial: 2, measured: null, warnings: [], trouble: "",
  trials: [planned("right", 1, 300), planned("left", 1, 280, 1), planned("right", 2), planned("left", 2), planned("right", 3), planned("left", 3)],
  protocol: { name: "", posture: "", hold_secs: 8, rest_secs: 60, target_newtons: null, force: "grip force" },
  is_resumed: false, is_simulated: false, files: [], ...more,
});

test("forces are written in kilograms and newtons", () => {
  assert.equal(kilograms(9.80665), "1.0");
  assert.equal(kilograms(326), "33.2");
  assert.equal(wholeNewtons(325.6), "326");
  assert.equal(bothForces(326), "33.2 kg · 326 N");
  assert.equal(targetText([80, 120]), "8.2 to 12.2 kg (80 to 120 N)");
  assert.deepEqual([kilograms(NaN), wholeNewtons(NaN), kilograms(-0.1)], ["–", "–", "0.0"]);
});

test("seconds are counted down to nothing, and minutes are written as such", () => {
  assert.deepEqual([3, 2.999, 2, 0.001, 0, -1].map(countOf), [3, 3, 2, 1, 0, 0]);
  assert.deepEqual([0, 59, 60, 61, 125].map(clock), ["0", "59", "1:00", "1:01", "2:05"]);
  assert.deepEqual([8, 2.5].map(lengthText), ["8\u00a0s", "2.5\u00a0s"]);
});

test("the force is that of the grip on a handle, else the total, and says which", () => {
  const frame = { ...blankFrame(1, 1), flags: FLAG_NEWTONS, total: 50, grip: 30 };
  assert.deepEqual(forceOf(frame, "grip force"), { newtons: 30, name: "grip force" });
  assert.deepEqual(forceOf(frame, "total normal force"), { newtons: 50, name: "total normal force" });
  assert.deepEqual(forceOf({ ...frame, grip: NaN }, "grip force"), { newtons: 50, name: "total normal force" });
  assert.ok(Number.isNaN(forceOf({ ...frame, flags: 0 }, "grip force").newtons), "conductances are no forces");
});

test("the best and the mean are those of the accepted trials of each hand", () => {
  const [right, left, ...more] = summaryOf([planned("right", 1, 300), planned("left", 1), planned("right", 2, 320), planned("left", 2), planned("right", 3)]);
  assert.equal(more.length, 0);
  assert.deepEqual([right.hand, right.accepted, right.best, right.mean], ["right", 2, 320, 310]);
  assert.deepEqual([left.hand, left.accepted, left.best, left.mean], ["left", 0, NaN, NaN]);
  assert.deepEqual(right.trials.map(({ number }) => number), [1, 2, 3]);
  assert.deepEqual(summaryOf([]), []);
});

test("an id is letters, digits, - and _, at most 40", () => {
  for (const good of ["P-017", "a", "x_9", "a".repeat(40)]) assert.equal(wrongWithPerson(good), "", good);
  for (const bad of ["", "Anna Maier", "ä1", "p/1", "p.1", "a".repeat(41)]) assert.notEqual(wrongWithPerson(bad), "", bad);
});

test("the shown force is a mean, and changes some times a second only", () => {
  const force = new SteadyForce();
  force.take(10, 0);
  assert.equal(force.shown, 10);
  for (let ms = 10; ms <= 140; ms += 10) force.take(20, ms);
  assert.equal(force.shown, 10);
  force.take(NaN, 145);
  force.take(20, 150);
  assert.equal(force.shown, 20);
  force.take(NaN, 300);
  assert.ok(Number.isNaN(force.shown), "nothing known is nothing shown");
});

test("the clock runs on by itself, and never jumps back", () => {
  const deadline = new Deadline();
  deadline.take("rest 3 0", 60, 60, 1000);
  assert.equal(deadline.remaining(1000), 60);
  assert.equal(deadline.remaining(2500), 58.5);
  // The same deadline, said 200 ms late.
  deadline.take("rest 3 0", 58.5, 60, 2700);
  assert.equal(deadline.remaining(2700), 58.3);
  // And said sooner than any before.
  deadline.take("rest 3 0", 58, 60, 2900);
  assert.equal(deadline.remaining(2900), 58);
  assert.equal(deadline.share(60900), 0);
  assert.equal(deadline.remaining(99999), 0);
  // Moved on purpose.
  deadline.take("rest 3 0", 30, 60, 3000);
  assert.equal(deadline.remaining(3000), 30);
  deadline.take("rest 3 0", 90, 60, 3000);
  assert.equal(deadline.remaining(3000), 90);
  assert.equal(deadline.share(3000), 1);
});

test("another phase has another clock, or none", () => {
  const deadline = new Deadline();
  deadline.take("countdown 0 0", 3, 3, 0);
  deadline.take("hold 0 0", 7.9, 8, 3100);
  assert.equal(deadline.remaining(3100), 7.9);
  assert.ok(Math.abs(deadline.begun - 3000) < 1e-6, `begun at ${deadline.begun}`);
  deadline.take("review 0 0", null, null, 12000);
  assert.ok(Number.isNaN(deadline.remaining(12000)));
});

test("the curve takes its times from the frames, however they arrive", () => {
  const curve = new Curve();
  const host = 1795255201.25;
  const times = [[0, 0.05], [0.1, 0.35], [0.2, 0.35], [0.3, 0.36]].map(([taken, arrived]) => curve.timeOf(host + taken, arrived));
  times.forEach((time, i) => assert.ok(Math.abs(time - (0.05 + 0.1 * i)) < 1e-6, `${time}`));
  // A clock that leaps is set anew; one that is not known is done without.
  assert.equal(curve.timeOf(host + 1000, 0.5), 0.5);
  assert.equal(curve.timeOf(NaN, 0.6), 0.6);
});

test("the largest force so far never falls, and a gap stays a gap", () => {
  const curve = new Curve();
  [[0, 10], [0.1, 30], [0.2, 20], [1, 25], [0.9, 99], [-1, 99]].forEach(([time, force]) => curve.push(time, force));
  assert.deepEqual(curve.times, [0, 0.1, 0.2, 0.6, 1]);
  assert.deepEqual(curve.forces, [10, 30, 20, null, 25]);
  assert.deepEqual(curve.largest, [10, 30, 30, 30, 30]);
  assert.equal(curve.max, 30);
  curve.clear();
  assert.ok(curve.isEmpty && Number.isNaN(curve.max));
  curve.push(0, NaN);
  curve.push(0.1, -2);
  assert.deepEqual([curve.forces, curve.largest], [[null, -2], [null, -2]]);
});

test("a long hold is thinned, and keeps its largest force", () => {
  const curve = new Curve();
  for (let i = 0; i <= MOST_POINTS; i += 1) curve.push(i / 1000, i === 5001 ? 500 : i % 7);
  assert.ok(curve.times.length <= MOST_POINTS / 2 + 1, `${curve.times.length} points`);
  assert.ok(curve.forces.includes(500));
  assert.ok(curve.times.every((time, i) => i === 0 || time > curve.times[i - 1]), "times grow");
  assert.equal(curve.times.length, curve.largest.length);
});

test("each phase belongs to one step, and has words", () => {
  const phases = ["setup", "zero", "ready", "countdown", "hold", "measuring", "review", "rest", "finishing", "done"];
  assert.deepEqual(STEPS.flatMap((step) => step.phases), phases);
  for (const phase of phases) {
    for (const trial of [2, null]) {
      const grip = session({ phase, trial });
      const { title, primary } = wordsOf(grip);
      assert.ok(title.length > 0, phase);
      assert.equal(primary === null, ["measuring", "finishing", "done"].includes(phase), phase);
      assert.ok(announcement(grip).includes(title));
    }
  }
});

test("trials are named, and how they stand is said", () => {
  const grip = session();
  assert.equal(trialText(grip), "Right hand, trial 2 of 3");
  assert.equal(trialText(session({ trial: null })), "");
  assert.deepEqual([0, 1, 2, 3].map((at) => standing(grip, at)), ["accepted", "accepted, repeated ×1", "now", "to come"]);
  assert.equal(standing(session({ phase: "rest" }), 2), "next");
  assert.equal(standing(session({ phase: "setup", trial: 0, trials: [planned("left", 1)] }), 0), "to come");
  assert.equal(standing(session({ phase: "done" }), 3), "not done");
  assert.equal(wordsOf(session({ phase: "rest" })).text, "Next: right hand, trial 2 of 3.");
  assert.equal(wordsOf(session({ trial: null })).primary.action, "finish");
});

test("what a trial came to, and what is doubtful, is said", () => {
  const text = announcement(session({ phase: "review", measured: measured(326, { doubts: ["the force fell"] }) }));
  for (const part of ["Right hand, trial 2 of 3", "33.2 kg · 326 N", "Doubtful: the force fell."]) assert.ok(text.includes(part), text);
  assert.ok(taskText(session().protocol).includes("as strongly as possible"));
  assert.ok(taskText({ ...session().protocol, target_newtons: [80, 120] }).includes("80 to 120 N"));
  assert.ok(finishText(session()).startsWith("2 of 6 trials are accepted; the other 4 stay empty."));
  assert.ok(finishText(session({ trials: [planned("left", 1, 9)] })).startsWith("All trials are accepted."));
});

test("the files come in the order in which people want them", () => {
  const files = filesOf(["results.json", "other.txt", "page.pdf", "results.csv", "page.html"]);
  assert.deepEqual(files.map(({ name }) => name), ["page.html", "page.pdf", "results.csv", "results.json", "other.txt"]);
  assert.equal(files[0].text, "Page to read");
  assert.equal(files[4].text, "other.txt");
});
