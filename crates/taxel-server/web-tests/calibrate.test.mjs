// A guided calibration without a browser: its numbers and its words.

import assert from "node:assert/strict";
import { test } from "node:test";

import { columnsOf, endsOf, errorText, lastError, loadText, saysText } from "../web/js/calibrate/numbers.js";
import {
  PRESSING, announcement, askedText, canFinish, filesOf, finishText, sentence, taxelOf, verdictText, whereText, wordsOf,
} from "../web/js/calibrate/words.js";

/** What people read: spaces that do not break are spaces. */
const read = (text) => text.replaceAll("\u00a0", " ");
const press = (row, column, load_g, more = {}) => ({ row, column, load_g, is_among_others: false, why: "", is_again: false, ...more });
const whole = (load_g) => press(null, null, load_g);
const taken = (asked, says_g = null, left_out = "") => ({ asked, says_g, left_out });
const error = (presses, mean_absolute_g, standard_error_g = 0) => ({ presses, mean_absolute_g, standard_error_g });
const seen = (row, column, more = {}) => ({ row, column, is_there: false, standing: 0, problem: "", ...more });
const session = (more = {}) => ({
  phase: "press", asked: press(3, 5, 200), seen: null, presses: [], progress: [], is_enough: false, advice: "", least_presses: 8,
  loads_g: [100, 200], sensor: "", folder: "/there", output: "", warnings: [], doubts: [], trouble: "", is_resumed: false, is_simulated: false,
  files: [], ...more,
});
const PHASES = ["empty", "reading", "others", "press", "elsewhere", "taking", "off", "finishing", "done"];

test("loads are written as on a weight", () => {
  assert.deepEqual([5, 0.5, 200, 999, 1000, 1500, 2250].map((grams) => read(loadText(grams))), ["5 g", "0.5 g", "200 g", "999 g", "1 kg", "1.5 kg", "2.25 kg"]);
  assert.equal(loadText(NaN), "–");
  assert.equal(read(saysText(212, 200)), "212 g (+6 %)");
  assert.equal(read(saysText(190.4, 200)), "190 g (−5 %)");
  assert.equal(read(saysText(5.012, 5)), "5.01 g (0 %)");
  assert.equal(read(saysText(4.99, 5)), "4.99 g (0 %)");
  assert.equal(saysText(null, 200), "–");
});

test("errors have the digits that their own error leaves them", () => {
  assert.equal(read(errorText(error(9, 6.34, 0.82))), "6.34 ± 0.82 g");
  assert.equal(read(errorText(error(9, 63.4, 15.8))), "63 ± 16 g");
  assert.equal(read(errorText(error(9, 14.23, 3.41))), "14.2 ± 3.4 g");
  assert.equal(read(errorText(error(9, 0.106, 0.04))), "0.106 ± 0.040 g");
  assert.equal(read(errorText(error(9, 6.34, 0))), "6.3 g");
  assert.equal(errorText(error(2, null)), "–");
  const known = error(6, 9, 1);
  assert.equal(lastError([error(5, 20, 3), known, error(7, null)]), known);
  assert.equal(lastError([error(1, null)]), null);
});

test("the chart has a band around the mean, and grows from press to press", () => {
  // A press was taken back, and another one taken.
  const columns = columnsOf([error(4, null), error(5, 20, 4), error(6, 99, 9), error(5, 22, 30), error(6, 10, 2)]);
  assert.deepEqual(columns, { presses: [4, 5, 6], mean: [null, 22, 10], above: [null, 52, 12], below: [null, 0, 8] });
  const { across, top } = endsOf(columns);
  assert.ok(across >= 10 && top >= 50 && top <= 60, `${across}, ${top}`);
  assert.ok(endsOf(columnsOf([error(1, 1000, 10), error(2, 10, 1)])).top <= 60, "the first fits may leave the chart");
  assert.ok(endsOf(columnsOf([error(30, 5, 1)])).across > 30, "the last point is not cut off");
  assert.ok(endsOf(columnsOf([])).top > 0);
  assert.ok(endsOf(columnsOf([error(9, 0, 0)])).top > 0, "no error at all is one that can be drawn");
});

test("a press is asked for by its taxel, or by the whole sensor", () => {
  assert.equal(read(askedText(press(3, 5, 200))), "Press row 3, column 5 with 200 g");
  assert.equal(read(askedText(press(0, 0, 1500, { is_again: true }))), "Press row 0, column 0 again with 1.5 kg");
  assert.equal(read(askedText(whole(5))), "Load the whole sensor evenly: 5 g on each taxel");
  assert.deepEqual(taxelOf(press(0, 2, 1)), { row: 0, column: 2 });
  assert.equal(taxelOf(whole(5)), null);
  assert.equal(whereText(whole(5)), "the whole sensor");
});

test("each phase has words, whatever is known", () => {
  for (const phase of PHASES) {
    for (const asked of [press(3, 5, 200, { is_among_others: true, why: "it is the first" }), whole(5), null]) {
      for (const what of [null, seen(1, 2), seen(3, 5, { is_there: true, problem: "too light" })]) {
        const now = session({ phase, asked, seen: what });
        const { title, primary } = wordsOf(now);
        assert.ok(title.length > 0, phase);
        const isElsewhere = phase === "elsewhere" && what && !what.is_there && asked?.row !== null;
        const action = isElsewhere ? "here" : ["empty", "others"].includes(phase) ? "ready" : null;
        assert.equal(primary?.action ?? null, action, phase);
        assert.ok(announcement(now).startsWith(title), phase);
        assert.doesNotMatch(announcement(now), /undefined|null|NaN|\.\.|  /, phase);
      }
    }
  }
  assert.ok(PRESSING.every((phase) => PHASES.includes(phase)));
});

test("what presses elsewhere is named, and where it is to go", () => {
  const { title, text, more, primary } = wordsOf(session({ phase: "elsewhere", seen: seen(1, 2, { problem: "two taxels are pressed" }) }));
  assert.equal(read(title), "It stands at row 1, column 2");
  assert.equal(text, "Two taxels are pressed.");
  assert.equal(read(more), "Move it to row 3, column 5, or take it where it stands.");
  assert.equal(primary.label, "Take it there");
  const there = wordsOf(session({ phase: "elsewhere", seen: seen(3, 5, { is_there: true, problem: "too light" }) }));
  assert.equal(there.primary, null, "it is known that it is there");
  assert.equal(there.text, "Too light.");
  const even = wordsOf(session({ phase: "elsewhere", asked: whole(5), seen: seen(1, 2) }));
  assert.deepEqual([even.title, even.primary], ["That is not the whole sensor", null]);
});

test("what is read before a press is the empty sensor, or what lies there", () => {
  assert.equal(wordsOf(session({ phase: "reading" })).title, "Reading the empty sensor…");
  assert.equal(wordsOf(session({ phase: "reading", asked: press(1, 1, 200, { is_among_others: true }) })).title, "Reading what lies there…");
});

test("what was taken is said, and what the others say of it", () => {
  const off = (last) => read(wordsOf(session({ phase: "off", asked: null, presses: [last] })).text);
  assert.ok(off(taken(press(1, 1, 200), 212)).startsWith("The other presses say 212 g (+6 %)."));
  assert.ok(off(taken(press(1, 1, 200))).startsWith("The next press"));
  const undone = wordsOf(session({ phase: "off", presses: [taken(press(1, 1, 200), 212, "undone by the operator")] }));
  assert.deepEqual([undone.title, undone.text.split(" The")[0]], ["Take it off", "Left out: undone by the operator."]);
  const among = wordsOf(session({ phase: "off", presses: [taken(press(1, 1, 200, { is_among_others: true }))] }));
  assert.ok(among.more.includes("other things"));
  assert.equal(read(wordsOf(session({ phase: "taking" })).text), "200 g at row 3, column 5.");
  assert.equal(read(wordsOf(session({ phase: "taking", asked: whole(5) })).text), "5 g on each taxel.");
});

test("it can be finished after enough presses, and what that means is said", () => {
  const presses = Array.from({ length: 8 }, () => taken(press(1, 1, 200)));
  assert.ok(!canFinish(session({ presses: presses.slice(1) })));
  assert.ok(canFinish(session({ presses })));
  assert.ok(!canFinish(session({ presses: presses.with(0, taken(press(1, 1, 200), null, "undone")) })), "what is left out does not count");
  assert.ok(!canFinish(session({ presses, phase: "done" })) && !canFinish(session({ presses, phase: "finishing" })));
  assert.ok(!canFinish(session({ least_presses: 0 })), "nothing can be fitted to nothing");
  assert.equal(verdictText(session({ presses: presses.slice(0, 1) })), "1 press taken. At least 8 are needed.");
  assert.equal(verdictText(session({ presses, advice: "the error still falls" })), "8 presses taken. The error still falls.");
  assert.equal(verdictText(session({ presses, is_enough: true, advice: "more gain nothing" })), "That is enough. More gain nothing.");
  assert.ok(finishText(session({ presses })).startsWith("8 presses are taken, and more would still"));
});

test("sentences end as such, and files come in order", () => {
  assert.deepEqual(["", "a b", "Why?", "so… ", "done."].map(sentence), ["", "A b.", "Why?", "So…", "Done."]);
  assert.deepEqual(filesOf(["parts.toml", "x.bin", "sensor.toml", "certificate.html"]).map(({ name }) => name), ["certificate.html", "sensor.toml", "parts.toml", "x.bin"]);
  assert.ok(read(wordsOf(session({ phase: "done", presses: [taken(press(1, 1, 1))], output: "/o.toml" })).text).includes("/o.toml"));
});
