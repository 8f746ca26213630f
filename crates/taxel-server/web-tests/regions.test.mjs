// Regions: their names, their boxes, the lines around them, and those that a sensor brings.

import assert from "node:assert/strict";
import { beforeEach, test } from "node:test";

import { FrameBuffer } from "../web/js/buffer.js";
import { boxesOf, nameProblem, outlinesOf, placeAt, taxelsOf } from "../web/js/regions.js";
import { MAX_REGIONS, Selection, titleOf } from "../web/js/selection.js";
import * as messages from "../testdata/messages.js";

const sensor = { ...messages.hello.sensor, rows: 6, columns: 8 };
let selection, context;
beforeEach(() => {
  selection = new Selection();
  context = { sensor, buffer: new FrameBuffer(6, 8) };
});

/** A square of so many taxels from a corner. */
const square = (column, row, side) => [[column, row], [column + side, row], [column + side, row + side], [column, row + side]];

test("taxels make boxes, and boxes the same taxels", () => {
  const taxels = [9, 10, 11, 17, 18, 19, 25, 40, 42];
  const boxes = boxesOf(taxels, 8);
  assert.deepEqual(boxes, [[1, 2, 1, 3], [3, 3, 1, 1], [5, 5, 0, 0], [5, 5, 2, 2]]);
  assert.deepEqual(taxelsOf(boxes, 8).sort((a, b) => a - b), taxels);
});

test("the line around taxels goes from corner to corner, one around each part and each hole", () => {
  const [line, ...others] = outlinesOf(taxelsOf([[1, 2, 1, 3], [3, 3, 1, 1]], 8), sensor);
  assert.deepEqual(others, []);
  assert.deepEqual(new Set(line.map(String)), new Set(["1,1", "4,1", "4,3", "2,3", "2,4", "1,4"]));
  assert.equal(line.length, 6);
  const ring = taxelsOf([[0, 2, 0, 2]], 8).filter((taxel) => taxel !== 9);
  assert.deepEqual(outlinesOf(ring, sensor).map((one) => one.length), [4, 4]);
  // Across a seam, or at both ends of a row: two parts.
  assert.equal(outlinesOf([7, 8], sensor).length, 2);
  const anywhere = { ...sensor, rows: 1, columns: 2, pitch_mm: [1, 1], positions_mm: [[0, 0], [3, 0]] };
  assert.equal(outlinesOf([0, 1], anywhere).length, 2);
});

test("names are refused in words, as the command would refuse them", () => {
  assert.equal(nameProblem("Ball of the thumb", ["R1", "index"]), "");
  assert.match(nameProblem("  ", []), /needs a name/);
  assert.match(nameProblem("THUMB ", ["thumb"]), /Another region is called “thumb”/);
  assert.match(nameProblem("ring-finger", ["ring finger"]), /called “ring finger”/);
  assert.match(nameProblem("Total", []), /taxel measure/);
  assert.match(nameProblem("thumb error", ["thumb"]), /same column/);
  assert.match(nameProblem("x".repeat(61), []), /at most 60 letters/);
  assert.match(nameProblem("a\u0007b", []), /nothing but letters/);
});

test("a region is renamed, keeps its name where the new one is refused, and is called by it", () => {
  let heard = 0;
  selection.onChange(() => { heard += 1; });
  assert.equal(selection.addRegion("rectangle", square(0, 0, 2), context), "added");
  assert.equal(selection.addRegion("lasso", square(3, 3, 2), context), "added");
  const [first, second] = selection.regions;
  assert.deepEqual([first.name, second.name], ["R1", "R2"]);
  assert.equal(selection.rename(first, " thumb "), "");
  assert.equal(titleOf(first), "thumb");
  assert.equal(heard, 3);
  assert.match(selection.rename(second, "Thumb"), /Another region/);
  assert.equal(second.name, "R2");
  // What it is called now is no other region's name.
  assert.equal(selection.rename(first, "Thumb"), "");
  // A name that looks like the next label.
  assert.equal(selection.rename(second, "R3"), "");
  selection.addRegion("rectangle", square(5, 0, 1), context);
  assert.deepEqual(selection.regions.map(({ name, label }) => [name, label])[2], ["R3 2", "R3"]);
});

test("regions of the sensor are there with their names, as many as there is room for", () => {
  assert.equal(selection.addKnown(messages.hello.sensor.regions, { ...context, sensor: messages.hello.sensor }), 0);
  const [thumb] = selection.regions;
  assert.deepEqual([thumb.name, thumb.taxels], ["thumb", [1, 2, 4, 5]]);
  assert.equal(thumb.outlines.length, 1);
  selection.clear();
  const many = Array.from({ length: 30 }, (_, i) => ({ name: `part ${i}`, boxes: [[0, 0, 0, 0]], windows: [] }));
  assert.equal(selection.addKnown(many, context), 30 - MAX_REGIONS);
  assert.equal(selection.regions.length, MAX_REGIONS);
  assert.equal(selection.addRegion("rectangle", square(0, 0, 2), context), "full");
});

test("a region that moves is where the frame has it, measured there, and nowhere in frames that it is not said of", () => {
  const { sensor } = messages.hello;
  const buffer = new FrameBuffer(sensor.rows, sensor.columns);
  selection.addKnown(sensor.regions, { sensor, buffer });
  const moving = selection.regions[1];
  assert.deepEqual([moving.name, moving.shape], ["index", "of a file, moving"]);
  const loads = new Float32Array([5, 0, 0, 7, 0, 0]);
  for (const [sequence, taxels, force] of [[0, [0], 5], [9, [0], 5], [10, [], NaN], [20, [3], 7], [30, [], NaN]]) {
    assert.deepEqual(placeAt(moving, sequence).taxels, taxels);
    selection.takeFrame({ sequence, compensated: loads, area: 3, host: sequence }, sensor);
    assert.deepEqual(moving.series.columns.force[moving.series.end - 1], force);
  }
  assert.equal(placeAt(moving, 10).outlines.length, 0);
  // One that lies still is the same in all.
  assert.equal(placeAt(selection.regions[0], 10), selection.regions[0]);
});
