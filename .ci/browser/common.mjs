// What the tests of every page share: which program, which tests, a folder for what they write, and waiting.

import { existsSync, mkdtempSync } from "node:fs";
import { tmpdir } from "node:os";
import path from "node:path";

export const PATIENCE_MS = 20000;
export const LOOK_MS = 50;

const [, script, givenProgram, ...words] = process.argv;
if (!givenProgram || !existsSync(givenProgram)) {
  console.error(`usage: node ${path.basename(script)} PATH_OF_TAXEL [WORDS ...]${givenProgram ? `\nthere is no ${givenProgram}` : ""}`);
  process.exit(2);
}
export const wanted = words;
export const program = path.resolve(givenProgram);
export const scratch = mkdtempSync(path.join(tmpdir(), "taxel-browser-"));

export function check(holds, text) {
  if (!holds) throw new Error(text);
}

export const sleep = (ms) => new Promise((resolve) => setTimeout(resolve, ms));

// Waits until `probe` gives something true, and gives it back. `text` says what was waited for; a function is
// called with what the probe gave last, so that the failure tells what was there instead.
export async function until(probe, text, patience = PATIENCE_MS) {
  const end = Date.now() + patience;
  let last;
  for (;;) {
    last = await probe();
    if (last) return last;
    if (Date.now() > end) throw new Error(`${typeof text === "function" ? await text(last) : text} (waited ${patience / 1000} s)`);
    await sleep(LOOK_MS);
  }
}
