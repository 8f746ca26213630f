// The buffer of frames, and the numbers over time.

import assert from "node:assert/strict";
import { test } from "node:test";

import { FrameBuffer } from "../web/js/buffer.js";
import { Series } from "../web/js/series.js";
import { contactThreshold, measure } from "../web/js/selection.js";
import { cellArea, evened, taxelArea } from "../web/js/areas.js";
import { blankFrame } from "../web/js/wire.js";
import * as messages from "../testdata/messages.js";
import { unitOf } from "../web/js/units.js";

function frameAt(host, rows = 2, columns = 3) {
  const frame = blankFrame(rows, columns);
  frame.host = host;
  frame.sequence = Math.round(host * 100);
  frame.total = host;
  frame.raw.forEach((_, i) => {
    frame.raw[i] = i - 1;
    frame.compensated[i] = i === 2 ? NaN : host + i;
    frame.counts[i] = 1000 * i;
    frame.marks[i] = i;
  });
  return frame;
}

test("a frame comes back as it went in, its loads to a 65,534th of their range", () => {
  const buffer = new FrameBuffer(2, 3);
  const frame = frameAt(1.25);
  buffer.push(frame);
  const back = blankFrame(2, 3);
  buffer.read(0, back);
  assert.deepEqual(back.counts, frame.counts);
  assert.deepEqual(back.marks, frame.marks);
  assert.equal(back.sequence, 125);
  assert.ok(Number.isNaN(back.compensated[2]));
  for (const i of [0, 1, 3, 4, 5]) assert.ok(Math.abs(back.compensated[i] - frame.compensated[i]) <= 5 / 65534, `taxel ${i}`);
  for (let i = 0; i < 6; i += 1) assert.ok(Math.abs(back.raw[i] - frame.raw[i]) <= 5 / 65534, `taxel ${i}`);
});

test("the newest frames are all kept, the older ones thinned, in order and within the memory", () => {
  // So many taxels that the memory holds a few hundred frames.
  const buffer = new FrameBuffer(128, 256);
  const frame = blankFrame(128, 256);
  const most = buffer.rings.reduce((sum, { slots }) => sum + slots.length, 0);
  const frames = 3 * most;
  for (let i = 0; i < frames; i += 1) {
    frame.host = i / 100;
    buffer.push(frame);
  }
  assert.ok(buffer.length <= most);
  const hosts = Array.from({ length: buffer.length }, (_, i) => buffer.at(i).host);
  assert.deepEqual(hosts, [...hosts].sort((a, b) => a - b));
  const newest = buffer.rings[0].slots.length;
  for (let i = 1; i < newest; i += 1) assert.ok(Math.abs(hosts[hosts.length - i] - hosts[hosts.length - i - 1] - 0.01) < 1e-9);
  const older = hosts.slice(0, hosts.length - newest - 1);
  for (let i = 1; i < older.length; i += 1) assert.ok(older[i] - older[i - 1] > 0.1 - 1e-9);
  assert.ok(hosts[hosts.length - 1] - hosts[0] > newest / 100);
  for (const host of [hosts[0], hosts[5], hosts[hosts.length - 1]]) assert.equal(buffer.at(buffer.indexAt(host + 1e-4)).host, host);
  assert.equal(buffer.indexAt(-1), 0);
  buffer.clear();
  assert.equal(buffer.length, 0);
  assert.throws(() => buffer.at(0), RangeError);
});

test("a series finds its rows by time, and moves on when it is full", () => {
  const series = new Series(["total"]);
  for (let i = 0; i < 50000; i += 1) series.push(i, { total: -i });
  assert.equal(series.length, 24000);
  assert.equal(series.lastTime, 49999);
  const at = series.indexFrom(40000);
  assert.equal(series.columns.time[at], 40000);
  assert.equal(series.columns.total[at], -40000);
  assert.equal(series.indexFrom(0), series.start);
  series.clear();
  assert.ok(Number.isNaN(series.lastTime));
});

test("the threshold of contact leaves as large an area above it as the server counts", () => {
  const sensor = { ...messages.hello.sensor, rows: 10, columns: 10, cell_area_mm2: 3 };
  const values = Float32Array.from({ length: 100 }, (_, i) => i / 10);
  for (const count of [1, 10, 50]) {
    const threshold = contactThreshold(values, 3 * count, sensor);
    assert.equal(values.filter((value) => value > threshold).length, count);
  }
  assert.equal(contactThreshold(values, 0, sensor), Infinity);
});

test("on a cone the same load presses harder where it is narrow, and less of it is touched", () => {
  // Rings of 80, 70 and 60 mm: each taxel is so much smaller than on the widest.
  const { sensor } = messages.helloOfCone;
  const { rows, columns } = sensor;
  assert.deepEqual([taxelArea(sensor, 0), taxelArea(sensor, 2), cellArea(sensor, 0)], [40, 30, 80]);
  const loads = new Float32Array(rows * columns).fill(2);
  const scratch = new Float32Array(rows * columns);
  assert.equal(evened(loads, sensor, unitOf("N"), scratch), loads);
  const pressures = evened(loads, sensor, unitOf("kPa"), scratch);
  for (let taxel = 0; taxel < loads.length; taxel += 1) {
    assert.ok(Math.abs(pressures[taxel] / 40 - 2 / taxelArea(sensor, taxel)) < 1e-7);
  }
  const all = loads.reduce((sum, _, taxel) => sum + cellArea(sensor, taxel), 0);
  const threshold = contactThreshold(loads, all, sensor);
  // One taxel of each ring: 2 N on 40, 35 and 30 mm².
  const numbers = measure([0, 1, 2], loads, threshold, sensor, {});
  assert.equal(numbers.force, 6);
  assert.ok(Math.abs(numbers.peak / 40 - 2 / 30) < 1e-12);
  assert.ok(Math.abs(numbers.mean / 40 - 6 / 105) < 1e-12);
  assert.ok(Math.abs(numbers.area - 210) < 1e-9);
  // Conductances are no pressures.
  const lawless = { ...sensor, has_load_law: false };
  assert.equal(evened(loads, lawless, unitOf("kPa"), scratch), loads);
  assert.equal(measure([0, 1, 2], loads, threshold, lawless, {}).peak, 2);
});
