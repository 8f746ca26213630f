// What total force and contact area are uncertain by: shown only where it is of what is shown.

import assert from "node:assert/strict";
import { beforeEach, mock, test } from "node:test";

import * as messages from "../testdata/messages.js";
import { Figures } from "../web/js/figures.js";
import { Settings } from "../web/js/settings.js";
import { plusMinus } from "../web/js/units.js";
import { View } from "../web/js/view.js";
import { Watch } from "../web/js/watch.js";

globalThis.localStorage = { getItem: () => null, setItem() {} };

const { figures: told } = messages.details;
const frame = (change = {}) => ({ sequence: told.sequence, total: told.total_newtons, area: told.contact_area_mm2, ...change });

let view, figures, now;
beforeEach(() => {
  mock.restoreAll();
  now = 1e6;
  mock.method(performance, "now", () => now);
  view = new View(new Settings());
  view.set({ frameAt: now });
  figures = new Figures(view);
  figures.take(messages.details);
});

test("half of the interval stands beside the figure that it is of", () => {
  assert.deepEqual([figures.of("force", frame()).half, figures.of("area", frame()).half], [0.75, 2.5]);
  assert.equal(figures.of("force", frame()).words, "± is half of the 95 % interval");
  assert.equal(figures.of("peak", frame()).half, null);
  // The next frame of the same load has the same.
  assert.equal(figures.of("force", frame({ sequence: told.sequence + 40, total: told.total_newtons * 1.09 })).half, 0.75);
});

test("an interval of another load is none of this one", () => {
  assert.equal(figures.of("force", frame({ total: told.total_newtons * 1.2 })).half, null);
  assert.equal(figures.of("force", frame({ total: NaN })).half, null);
  // What was told before that, of the load that there is now again, will do.
  const twice = structuredClone(messages.details);
  Object.assign(twice.figures, { total_newtons: 2 * told.total_newtons, total_half_width_95_newtons: 1.5 });
  now += 1000;
  figures.take(twice);
  assert.deepEqual([1, 2].map((times) => figures.of("force", frame({ total: times * told.total_newtons })).half), [0.75, 1.5]);
  now += 2000;
  assert.equal(figures.of("force", frame()).half, null);
  view.set({ frameAt: now });
  assert.equal(figures.of("force", frame({ total: 2 * told.total_newtons })).half, 1.5);
  // Not even a tenth, but within what it is uncertain by.
  const nothing = structuredClone(messages.details);
  nothing.figures.total_newtons = 0.01;
  figures.take(nothing);
  assert.equal(figures.of("force", frame({ total: -0.3 })).half, 0.75);
});

test("what is old, of a paused view, of conductances or of another sensor is not shown", () => {
  const half = () => figures.of("force", frame()).half;
  view.set({ paused: true });
  assert.equal(half(), null);
  view.set({ paused: false, newtons: false });
  assert.equal(half(), null);
  view.set({ newtons: true });
  assert.equal(half(), 0.75);
  now += 2600;
  assert.equal(half(), null);
  figures.take(messages.details);
  assert.equal(half(), 0.75);
  // A frame that stands still has its own or none.
  assert.equal(figures.of("force", frame({ sequence: told.sequence + 1 })).half, null);
  view.set({ hello: messages.hello });
  assert.equal(half(), null);
});

test("where nothing bounds a figure the reason is told, and a server that knows none is no fault", () => {
  figures.take(messages.detailsUnbounded);
  assert.deepEqual(figures.of("force", frame()), { half: null, words: "No ± now: a taxel is at the converter's ceiling" });
  const noise = structuredClone(messages.details);
  noise.figures.noise_only = true;
  figures.take(noise);
  assert.match(figures.of("force", frame()).words, /noise only/);
  figures.take({ kind: "details", taxels: [] });
  assert.deepEqual(figures.of("force", frame()), { half: null, words: "" });
});

test("half of an interval has the decimals of its number", () => {
  assert.deepEqual([plusMinus(0.75, 1), plusMinus(0.004, 1), plusMinus(12, 0), plusMinus(Infinity, 1)], [" ± 0.8", " ± <0.1", " ± 12", ""]);
});

test("the page asks for it while somebody reads newtons", () => {
  const hear = new Map();
  globalThis.document = { hidden: false, addEventListener: (name, tell) => hear.set(name, tell) };
  const sent = [];
  const connection = { send: (request) => request.do !== "watch" || sent.push(request) };
  new Watch({ view, selection: { pins: [], onChange() {} }, connection });
  view.set({ hello: messages.hello });
  view.pick({ row: 1, column: 2 });
  globalThis.document.hidden = true;
  hear.get("visibilitychange")();
  globalThis.document.hidden = false;
  view.set({ newtons: false });
  hear.get("visibilitychange")();
  assert.deepEqual(sent.map(({ taxels, figures }) => [taxels.length, figures]), [[0, true], [1, true], [1, false]]);
  delete globalThis.document;
});
