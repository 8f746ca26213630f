// Frames and messages as the server writes them, through the page's own decoder.

import assert from "node:assert/strict";
import { readFileSync } from "node:fs";
import { test } from "node:test";

import { MarkTable } from "../web/js/marks.js";
import { blankFrame, decodeFrame, isNewtons, isRaw, isTared } from "../web/js/wire.js";
import * as messages from "../testdata/messages.js";
import { requests } from "../testdata/requests.js";

const testdata = (name) => readFileSync(new URL(`../testdata/${name}`, import.meta.url));
const bytesOf = (name) => {
  const { buffer, byteOffset, byteLength } = testdata(`${name}.frame`);
  return buffer.slice(byteOffset, byteOffset + byteLength);
};
const expected = JSON.parse(testdata("frames.json"));
// Totals and loads travel as single-precision numbers; null is no number.
const single = (value) => (value === null ? NaN : Math.fround(value));
const double = (value) => (value === null ? NaN : value);

for (const [name, there] of Object.entries(expected)) {
  test(`the frame '${name}' is read as it was written`, () => {
    const frame = decodeFrame(bytesOf(name));
    for (const key of ["rows", "columns", "sequence"]) assert.equal(frame[key], there[key], key);
    for (const key of ["device", "host"]) assert.equal(frame[key], double(there[key]), key);
    for (const key of ["total", "peak", "area", "copRow", "copColumn", "outliers", "age", "rate", "grip"]) {
      assert.equal(frame[key], single(there[key]), key);
    }
    assert.deepEqual([isNewtons(frame), isTared(frame), isRaw(frame)], [there.newtons, there.tared, there.rawMethod]);
    assert.deepEqual([...frame.counts], there.counts);
    assert.deepEqual([...frame.raw], there.raw.map(single));
    assert.deepEqual([...frame.compensated], there.compensated.map(single));
    assert.deepEqual([...frame.marks], there.marks);
    const blank = blankFrame(there.rows, there.columns);
    assert.deepEqual(Object.keys(blank).sort(), Object.keys(frame).sort());
  });
}

test("what is no frame is refused with a reason", () => {
  const good = bytesOf("full");
  const changed = (at, to) => {
    const bytes = new Uint8Array(good.slice(0));
    bytes[at] = to;
    return bytes.buffer;
  };
  assert.throws(() => decodeFrame(good.slice(0, 67)), /shorter than its header/);
  assert.throws(() => decodeFrame(good.slice(0, good.byteLength - 1)), /too short for its taxels/);
  assert.throws(() => decodeFrame(changed(0, 2)), /message type 2/);
  assert.throws(() => decodeFrame(changed(1, 9)), /frame version 9/);
});

test("the server's table of marks says what counts, what sets the scale, and how bad it is", () => {
  const table = new MarkTable(messages.hello.marks);
  const where = (holds) => messages.hello.marks.map((_, code) => code).filter(holds);
  assert.deepEqual(where((code) => table.counts(code)), [0, 2, 7, 11]);
  assert.deepEqual(where((code) => !table.scales(code)), [1, 3, 4, 5, 6, 10]);
  assert.deepEqual(where((code) => table.of(code).severity === 1), [7, 8, 9, 11]);
  assert.deepEqual([table.saturated, table.absent, table.belowFloor], [2, 10, 11]);
  assert.equal(table.of(200).word, "mark 200");
  assert.equal(table.counts(200), false);
  const frame = decodeFrame(bytesOf("full"));
  // Of the marks 0 to 5, good and saturated count.
  assert.equal(table.sum(frame.compensated, frame.marks), -0.25 + 0.5);
});

test("messages and requests go through JSON unchanged", () => {
  for (const [name, message] of Object.entries(messages)) assert.deepEqual(JSON.parse(JSON.stringify(message)), message, name);
  assert.deepEqual(JSON.parse(JSON.stringify(requests)), requests);
});
