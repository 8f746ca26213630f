// What axe-core finds wrong with a page, in words: one line a rule, with the places.

import { createRequire } from "node:module";
import { readFileSync } from "node:fs";

const source = readFileSync(createRequire(import.meta.url).resolve("axe-core/axe.min.js"), "utf8");

export async function violations(page) {
  await page.evaluate(source);
  return page.evaluate(async () => {
    const { violations } = await window.axe.run(document, { resultTypes: ["violations"] });
    return violations.map(({ id, impact, help, nodes }) => `${id} (${impact}): ${help}: ${nodes.map(({ target, any, all, none }) => `${target.join(" ")} [${[...any, ...all, ...none].map(({ message }) => message).join("; ")}]`).join(", ")}`);
  });
}
