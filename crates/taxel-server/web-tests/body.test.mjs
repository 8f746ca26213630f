// The handle that an array is wrapped around: where its taxels lie, and which of them are neighbours.

import assert from "node:assert/strict";
import { test } from "node:test";

import { bodyOf, trianglesOf } from "../web/js/body.js";

const near = (found, wanted, what) => assert.ok(Math.abs(found - wanted) < 1e-6, `${what}: ${found}, not ${wanted}`);

/** Four lines along a cone of three rings, 20 mm apart along the axis. */
function sensor(rings, closes = true) {
  const [rows, columns] = rings === "rows" ? [3, 4] : [4, 3];
  const angles = [0, 1, 2, 3].map((line) => line * (closes ? Math.PI / 2 : 1));
  return { rows, columns, handle: { rings, angles, radii_mm: [30, 25, 20], heights_mm: [0, 20, 40], slope: Math.atan(5 / 20), closes } };
}

test("the first ring is on top, and lines follow each other to the right of who looks from outside", () => {
  for (const rings of ["rows", "columns"]) {
    const body = bodyOf(sensor(rings));
    const [rows, columns] = rings === "rows" ? [3, 4] : [4, 3];
    const place = (ring, line) => {
      const at = 3 * (rings === "rows" ? ring * columns + line : line * columns + ring);
      assert.ok(at < 3 * rows * columns);
      return body.places.slice(at, at + 3);
    };
    const scale = 1.2 / Math.hypot(40, 60);
    for (let ring = 0; ring < 3; ring += 1) {
      const radius = (30 - 5 * ring) * scale;
      const [front, right] = [place(ring, 0), place(ring, 1)];
      // The first line faces the eye, the second lies a quarter turn to the right.
      near(front[0], 0, "x of the first line");
      near(front[2], radius, "z of the first line");
      near(right[0], radius, "x of the second line");
      near(front[1], (20 - 20 * ring) * scale, "height");
    }
    // A body that is wider above faces downwards, by as much as its surface leans.
    for (let at = 0; at < body.outward.length; at += 3) {
      const [x, y, z] = body.outward.slice(at, at + 3);
      near(Math.hypot(x, y, z), 1, "length");
      near(y, -Math.sin(Math.atan(5 / 20)), "slope");
      const [px, , pz] = body.places.slice(at, at + 3);
      assert.ok(px * x + pz * z > 0, "outward");
    }
  }
});

test("a seam that closes is bridged, one that does not is not", () => {
  for (const rings of ["rows", "columns"]) {
    const { rows, columns } = sensor(rings);
    const quads = (closes) => trianglesOf(rows, columns, bodyOf(sensor(rings, closes))).length / 6;
    assert.deepEqual([quads(true), quads(false)], [8, 6]);
  }
  assert.equal(trianglesOf(3, 4, null).length / 6, 6);
  const corners = trianglesOf(3, 4, bodyOf(sensor("rows")));
  assert.equal(Math.max(...corners), 11);
  // Each triangle's taxels are neighbours: no edge leads across the body.
  const body = bodyOf(sensor("rows"));
  for (let i = 0; i < corners.length; i += 3) {
    const lines = [0, 1, 2].map((corner) => corners[i + corner] % 4);
    for (const [a, b] of [[0, 1], [1, 2], [2, 0]]) assert.ok([0, 1, 3].includes(Math.abs(lines[a] - lines[b])));
  }
  assert.equal(body.closes, true);
});

test("a flat array has no body", () => {
  assert.equal(bodyOf({ rows: 3, columns: 4, handle: null }), null);
});

test("what is inside stays inside, and the height of the full scale stands out", () => {
  const body = bodyOf(sensor("rows"));
  const scale = 1.2 / Math.hypot(40, 60);
  for (let at = 0; at < body.core.length; at += 3) {
    const [x, y, z] = body.core.slice(at, at + 3);
    const radius = 25 * scale + (5 / 20) * y;
    // Between two of four lines the surface is as near to the axis as this.
    assert.ok(Math.hypot(x, z) < radius * Math.cos(Math.PI / 4), "inside");
  }
  const [foot, top] = [body.edges.slice(-6, -3), body.edges.slice(-3)];
  near(Math.hypot(...top.map((part, axis) => part - foot[axis])), 0.2, "full scale");
});
