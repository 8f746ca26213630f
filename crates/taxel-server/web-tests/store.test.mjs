import assert from "node:assert/strict";
import { test } from "node:test";

import { Store } from "../web/js/store.js";

test("listeners hear of their names alone, once, when all is written", () => {
  const store = new Store({ a: 1, b: 2, c: 3 });
  const heard = [];
  store.on(["a", "b"], () => heard.push([store.now.a, store.now.b]));
  store.set({ a: 10, b: 20 });
  store.set({ c: 30 });
  store.set({ a: 10 });
  assert.deepEqual(heard, [[10, 20]]);
});

test("NaN is the same value as before", () => {
  const store = new Store({ a: NaN });
  let heard = 0;
  store.on(["a"], () => { heard += 1; });
  store.set({ a: NaN });
  assert.equal(heard, 0);
});

test("what a listener writes is told after what it was told itself", () => {
  const store = new Store({ a: 0, twice: 0 });
  const heard = [];
  store.on(["a"], () => store.set({ twice: 2 * store.now.a }));
  store.on(["a"], () => heard.push(`a ${store.now.a}`));
  store.on(["twice"], () => heard.push(`twice ${store.now.twice}`));
  store.set({ a: 4 });
  assert.deepEqual(heard, ["a 4", "twice 8"]);
});

test("the same object with other content is told of when it is touched", () => {
  const list = [1];
  const store = new Store({ list });
  let heard = 0;
  store.on(["list"], () => { heard += 1; });
  list.push(2);
  store.set({ list });
  assert.equal(heard, 0);
  store.touch("list");
  assert.equal(heard, 1);
});

test("a listener that has ended hears nothing, and one that fails does not silence the store", () => {
  const store = new Store({ a: 0 });
  const heard = [];
  const end = store.on(["a"], () => heard.push("ended"));
  end();
  let fails = true;
  store.on(["a"], () => {
    if (fails) throw new Error("once");
    heard.push(store.now.a);
  });
  assert.throws(() => store.set({ a: 1 }), /once/);
  fails = false;
  store.set({ a: 2 });
  assert.deepEqual(heard, [2]);
});
