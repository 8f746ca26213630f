// Two curves on one axis of time.

import assert from "node:assert/strict";
import { test } from "node:test";

import { largest, together } from "../web/js/beside/curves.js";

test("both have a value at every second of either, where they have frames", () => {
  const found = together([
    { secs: [0, 1, 2], values: [0, 10, 30] },
    { secs: [0.5, 1, 1.5, 4], values: [1, 2, 3, 8] },
  ]);
  assert.deepEqual(found.secs, [0, 0.5, 1, 1.5, 2, 4]);
  assert.deepEqual(found.columns, [[0, 5, 10, 20, 30, null], [null, 1, 2, 3, 4, 8]]);
});

test("a frame without an answer stays a gap, and no curve is no line", () => {
  const found = together([
    { secs: [0, 1, 2], values: [0, null, 2] },
    { secs: [], values: [] },
  ]);
  assert.deepEqual(found.columns, [[0, null, 2], [null, null, null]]);
  const half = together([{ secs: [0, 1, 2], values: [0, null, 2] }, { secs: [0.5], values: [7] }]);
  assert.deepEqual(half.columns[0], [0, null, null, 2]);
});

test("the largest of a curve, whatever is missing in it", () => {
  assert.equal(largest([null, -3, -1, null]), -1);
  assert.ok(Number.isNaN(largest([null])));
});
