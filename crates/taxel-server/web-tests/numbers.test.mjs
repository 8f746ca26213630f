// Units, the scale and the orientation.

import * as messages from "../testdata/messages.js";
import assert from "node:assert/strict";
import { test } from "node:test";

import { Orientation, Placement } from "../web/js/orientation.js";
import { Crossings, layoutOf } from "../web/js/places.js";
import { Scale } from "../web/js/scale.js";
import {
  UNITS, areaText, bytesText, decimalsFor, durationText, fixed, forceUnit, loadFactor, niceCeil, niceStep, pressureUnit, siemens, significant, unitOf,
} from "../web/js/units.js";

const near = (a, b) => assert.ok(Math.abs(a - b) <= 1e-12 * Math.max(1, Math.abs(b)), `${a}, expected ${b}`);

test("one newton on 5 mm² in every unit", () => {
  const expected = { N: 1, g: 1000 / 9.80665, kPa: 200, "N/cm2": 20, mmHg: 200 * 7.500617 };
  for (const unit of UNITS) near(loadFactor(unit, 5), expected[unit.key]);
  assert.equal(unitOf("stone").key, "N");
  assert.equal(forceUnit(unitOf("kPa")).key, "N");
  assert.equal(pressureUnit(unitOf("g")).key, "kPa");
});

test("numbers are written so that they do not flicker", () => {
  assert.equal(fixed(-0.001, 2), "0.00");
  assert.equal(fixed(-1.5, 1), "−1.5");
  assert.equal(fixed(NaN, 1), "–");
  assert.equal(significant(1234.5), "1235");
  assert.equal(significant(0.012345), "0.0123");
  assert.equal(decimalsFor(0), 2);
  assert.equal(siemens(1.5e-5), "15.0 µS");
  assert.equal(siemens(2e-3), "2.00 mS");
  assert.equal(areaText(999), "999 mm²");
  assert.equal(areaText(1250), "12.5 cm²");
  assert.equal(bytesText(4_096_000), "4.1 MB");
  assert.equal(durationText(62.5), "1:02.5");
});

test("round numbers", () => {
  for (const [value, expected] of [[0, 1], [0.9, 1], [1, 1], [1.01, 1.2], [6.1, 8], [81, 100], [2.4e-5, 2.5e-5]]) near(niceCeil(value), expected);
  near(niceStep(10, 4), 5);
  near(niceStep(0.9, 10), 0.1);
});

test("the scale follows up fast and down slowly, and stands still between", () => {
  const scale = new Scale();
  scale.update(10, 0, "follow", 1);
  assert.equal(scale.top, 12);
  for (let i = 1; i <= 20; i += 1) scale.update(9, i / 60, "follow", 1);
  assert.equal(scale.top, 12);
  for (let i = 1; i <= 600; i += 1) scale.update(1, 1 + i / 10, "follow", 1);
  assert.ok(scale.top < 1.6, String(scale.top));
  scale.update(3, 70, "fixed", 7);
  assert.equal(scale.top, 7);
  scale.makeRoom(7.5);
  assert.equal(scale.top, 8);
});

test("without a load the scale does not blow up the noise", () => {
  const scale = new Scale();
  scale.update(100, 0, "follow", 1);
  for (let i = 1; i <= 4000; i += 1) scale.update(0.001, i / 10, "follow", 1);
  assert.ok(scale.top >= 2, String(scale.top));
  const held = new Scale();
  held.update(100, 0, "hold", 1);
  held.update(1, 10, "hold", 1);
  assert.equal(held.top, 100);
});

test("a picture place and its taxel find each other in every orientation", () => {
  for (let quarters = 0; quarters < 4; quarters += 1) {
    for (const mirrorX of [false, true]) {
      for (const mirrorY of [false, true]) {
        const placement = new Placement(new Orientation({ quarters, mirrorX, mirrorY }), new Crossings(3, 5), 30, 8, 200, 100);
        const { row, column } = placement.toArray(placement.x(4.25, 1.5), placement.y(4.25, 1.5));
        near(row, 1.5);
        near(column, 4.25);
        const xs = [placement.x(0, 0), placement.x(5, 3)];
        near(Math.min(...xs), 30);
        near(Math.max(...xs), 230);
      }
    }
  }
});

test("four turns are none, with mirrors too, and a step on the screen is a step of the array", () => {
  for (const mirrorX of [false, true]) {
    let orientation = new Orientation({ mirrorX });
    const first = orientation.key;
    for (let i = 0; i < 4; i += 1) orientation = orientation.rotate();
    assert.equal(orientation.key, first);
  }
  assert.deepEqual(new Orientation().step(1, 0), { columns: 1, rows: 0 });
  const turned = new Orientation({ quarters: 1 });
  const placement = new Placement(turned, new Crossings(4, 4), 0, 0, 100, 100);
  const { columns, rows } = turned.step(1, 0);
  assert.ok(placement.x(columns + 0.5, rows + 0.5) > placement.x(0.5, 0.5));
  assert.equal(placement.y(columns + 0.5, rows + 0.5), placement.y(0.5, 0.5));
});

test("a taxel with a place of its own is found there, and nowhere else", () => {
  const sensor = { ...messages.hello.sensor, rows: 2, columns: 2, pitch_mm: [3, 2], positions_mm: [[10, 5], [16, 5], null, [10, 11]] };
  const layout = layoutOf(sensor);
  assert.equal(layout, layoutOf(sensor));
  const at = (x, y) => layout.at(...layout.cells(x, y));
  assert.deepEqual([at(10, 5), at(16, 5), at(10, 11), at(13, 8), at(0, 0)], [0, 1, 3, -1, -1]);
  near(layout.centre(0)[0], 0.5);
  near(layout.centre(0)[1], 0.5);
  // The server gives the centre of pressure in pitches.
  const [across, down] = layout.pressure(11 / 3, 10 / 2);
  near(across, layout.centre(3)[0]);
  near(down, layout.centre(3)[1]);
  assert.deepEqual(layout.extent(sensor), [8, 9]);
  const crossings = layoutOf({ ...sensor, positions_mm: null });
  assert.deepEqual([crossings.at(1.2, 0.3), crossings.at(2.1, 0), crossings.centre(3)], [1, -1, [1.5, 1.5]]);
});
