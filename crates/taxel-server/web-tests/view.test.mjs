// The view and the session: what the server says, and what the page then knows and shows.

import assert from "node:assert/strict";
import { readFileSync } from "node:fs";
import { beforeEach, test } from "node:test";

import * as messages from "../testdata/messages.js";
import { History } from "../web/js/history.js";
import { Selection } from "../web/js/selection.js";
import { Session } from "../web/js/session.js";
import { Settings } from "../web/js/settings.js";
import { View } from "../web/js/view.js";

const stored = new Map();
globalThis.localStorage = { getItem: (key) => stored.get(key) ?? null, setItem: (key, value) => stored.set(key, value) };

const frame = () => {
  const { buffer, byteOffset, byteLength } = readFileSync(new URL("../testdata/full.frame", import.meta.url));
  return buffer.slice(byteOffset, byteOffset + byteLength);
};

let view, session, history, selection, got;
beforeEach(() => {
  stored.clear();
  selection = new Selection();
  view = new View(new Settings());
  history = new History(selection);
  got = [];
  session = new Session({ view, history, selection, timing: { take: 0 }, got: (sequence) => got.push(sequence), onFrame() {}, onDetails() {} });
});

test("a hello, a state and a frame", () => {
  session.takeText(messages.hello);
  assert.equal(view.sensor.rows, 2);
  assert.equal(view.method, "exact");
  session.takeText(messages.state);
  assert.deepEqual(view.now.badLines, { rows: [1], columns: [0, 2], suspect_rows: [], suspect_columns: [7] });
  session.takeFrame(frame());
  assert.equal(view.now.shown.sequence, 2 ** 40 + 7);
  assert.equal(view.now.frames, 1);
  assert.deepEqual(got, [2 ** 40 + 7]);
  assert.equal(history.buffer.length, 1);
  session.takeText(messages.event);
  assert.deepEqual(history.events, [{ time: messages.event.host_secs, text: "let go" }]);
});

test("a frame of another shape is not shown, but acknowledged", () => {
  session.takeText(messages.helloOfFile);
  session.takeFrame(frame());
  assert.equal(view.now.shown, null);
  assert.equal(got.length, 1);
});

test("while paused frames come but the shown one stays; then the newest is shown", () => {
  session.takeText(messages.hello);
  session.takeFrame(frame());
  const { shown } = view.now;
  view.setPaused(true);
  session.takeFrame(frame());
  assert.equal(view.now.shown, shown);
  assert.equal(view.now.frames, 2);
  assert.equal(history.buffer.length, 1);
  view.setPaused(false);
  assert.equal(view.now.shown, view.now.live);
});

test("the same sensor again keeps pins and the picked taxel; another one does not", () => {
  session.takeText(messages.hello);
  session.takeFrame(frame());
  selection.togglePin({ row: 1, column: 2 }, { buffer: history.buffer, sensor: view.sensor });
  view.pick({ row: 1, column: 2 });
  session.takeText(messages.hello);
  assert.equal(selection.pins.length, 1);
  // That of the sensor, once.
  assert.deepEqual(selection.regions.map(({ name }) => name), ["thumb", "index"]);
  assert.deepEqual(view.now.picked, { row: 1, column: 2 });
  assert.equal(history.buffer.length, 0);
  session.takeText(messages.helloOfFile);
  assert.equal(selection.pins.length, 0);
  assert.equal(view.now.picked, null);
});

test("bad lines that are the same are no change", () => {
  session.takeText(messages.hello);
  let heard = 0;
  view.on(["badLines"], () => { heard += 1; });
  session.takeText(messages.state);
  session.takeText(structuredClone(messages.state));
  assert.equal(heard, 1);
});

test("the pointer on the same taxel is no change", () => {
  let heard = 0;
  view.on(["picked"], () => { heard += 1; });
  view.pick({ row: 0, column: 1 });
  view.pick({ row: 0, column: 1 });
  view.pick(null);
  assert.equal(heard, 2);
});

test("settings are kept from visit to visit, those of another type are not", () => {
  const settings = new Settings();
  settings.toggle("letters");
  settings.set("unit", "g");
  assert.deepEqual([new Settings().values.letters, new Settings().values.unit], [false, "g"]);
  stored.set("taxel.view", JSON.stringify({ letters: "no", unit: 3, window: 60 }));
  assert.deepEqual([new Settings().values.letters, new Settings().values.unit, new Settings().values.window], [true, "N", 60]);
});

test("numbers of another program keep their unit, and one map", () => {
  session.takeText(messages.hello);
  assert.equal(view.exported, null);
  assert.deepEqual(view.maps, { layout: "both", difference: false });
  assert.equal(view.unit.text, "N");
  session.takeText(messages.helloOfFile);
  assert.deepEqual(view.maps, { layout: "compensated", difference: false });
  assert.deepEqual(view.unit, { key: "kPa", text: "kPa", pressure: false, factor: 2e8 });
});
