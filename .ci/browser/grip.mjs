// End-to-end tests of the grip session's page: the real program with its simulated person, a real Chromium, no stand-ins.
//
//   node grip.mjs PATH_OF_TAXEL [WORDS ...]     WORDS: run only the tests whose names contain one of them; "usual protocol" has a
//                                               session as long as a real one, three minutes, which else is left out
//
// Environment: as for test.mjs; with TAXEL_SCREENSHOTS every step of a session is kept there as a picture.

import { existsSync, mkdirSync, readFileSync, readdirSync, writeFileSync } from "node:fs";
import path from "node:path";

import { violations } from "./axe.mjs";
import { check, scratch, sleep, until } from "./common.mjs";
import { open, runAll, start, test } from "./harness.mjs";

const SHOTS = process.env.TAXEL_SCREENSHOTS;
// Keys within this time after a step do nothing: nobody has read yet what they would do.
const READ_MS = 350;
const STEP_MS = 120000;
const USUAL = "usual protocol";

let sessions = 0;

// A session of its own folder, of grips that take no longer than they must.
async function grip(source, { protocol = "", folder = path.join(scratch, `grips-${(sessions += 1)}`), more = [] } = {}) {
  const file = path.join(scratch, `protocol-${sessions}.toml`);
  writeFileSync(file, `hold_secs = 2\nplateau_secs = 1\nrest_secs = 30\ncountdown_secs = 1\n${protocol}`);
  const server = await start("grip", source, "--listen", "127.0.0.1:0", "--folder", folder, "--protocol", file, ...more);
  return Object.assign(server, { folder });
}

const phase = (page) => page.evaluate(() => document.body.dataset.phase);
const focused = (page) => page.evaluate(() => document.activeElement.id || document.activeElement.tagName);

// One picture a phase, once.
const looked = new Set();

async function at(page, wanted, name = null) {
  await until(async () => (await phase(page)) === wanted, async () => `the session does not come to ${wanted}: it is at ${await phase(page)}, and says ${await page.textContent("#message")}`, STEP_MS);
  if (!name) return;
  const found = await violations(page);
  check(found.length === 0, `axe finds at ${wanted}: ${found.join("\n")}`);
  const wide = await page.evaluate(() => document.documentElement.scrollWidth - document.documentElement.clientWidth);
  check(wide <= 0, `at ${wanted} the page is ${wide} pixels too wide`);
  // With a hand on it.
  if (SHOTS && wanted === "hold" && !looked.has(`${name}-${wanted}`)) await sleep(1400);
  await look(page, `${name}-${wanted}`, name.startsWith("phone"));
}

// Keeps a picture, where they are wanted.
async function look(page, name, fullPage = false) {
  if (!SHOTS || looked.has(name)) return;
  looked.add(name);
  mkdirSync(SHOTS, { recursive: true });
  await page.screenshot({ path: path.join(SHOTS, `grip-${name}.png`), fullPage });
}

// The primary button, once it can be read.
async function go(page, press) {
  await sleep(READ_MS);
  await press(page);
}

const click = (page) => page.click("#primary");
const enter = (page) => page.keyboard.press("Enter");

// One trial, from ready to review.
async function trial(page, press, name) {
  await at(page, "ready", name);
  await go(page, press);
  await at(page, "countdown", name);
  await at(page, "hold", name);
  await at(page, "review", name);
}

// The folder of the one session that there is of a person.
function folderOf(server, person) {
  const folders = readdirSync(path.join(server.folder, person));
  check(folders.length === 1, `sessions of ${person}: ${folders}`);
  return path.join(server.folder, person, folders[0]);
}

const pagesOf = (pdf) => Number(/\/Count (\d+)/.exec(pdf.toString("latin1"))[1]);

// What the files of a finished session say, and that they are whole.
function checkResults(folder, trials) {
  const pdf = readFileSync(path.join(folder, "page.pdf"));
  check(pdf.subarray(0, 5).toString() === "%PDF-", "page.pdf is no PDF");
  check(pagesOf(pdf) === 1, `page.pdf has ${pagesOf(pdf)} pages instead of one sheet`);
  const results = JSON.parse(readFileSync(path.join(folder, "results.json"), "utf8"));
  const all = results.hands.flatMap((hand) => hand.trials);
  check(all.length === trials, `results.json has ${all.length} trials instead of ${trials}`);
  for (const { max, true_max_newtons: truth, recording } of all) {
    check(existsSync(path.join(folder, recording)), `${recording} is not kept`);
    // Twice half a 95 % interval is four standard errors; frames may come apart by one, and the tremor moves 0.2 % meanwhile.
    const bound = Math.max(2 * max.half_width_95_newtons, 0.002 * truth);
    check(Math.abs(max.newtons - truth) < bound, `${recording}: ${max.newtons} ± ${max.half_width_95_newtons} N were measured of ${truth} N`);
  }
  const lines = readFileSync(path.join(folder, "results.csv"), "utf8").trim().split("\n");
  check(lines.length === trials + 1, `results.csv has ${lines.length} lines`);
  check(readFileSync(path.join(folder, "page.html"), "utf8").includes("Not a medical device"), "page.html does not say what it is not");
  return results;
}

test("a session from the first click to the PDF, a trial repeated on the way", async () => {
  const server = await grip("sim:econe?grip&seed=3", { protocol: "trials = 1\n" });
  const page = await open(server.url);
  const name = "desk-dark";
  await at(page, "setup", name);
  await page.fill("#person", "P-01");
  await page.fill("#note", "first visit");
  await click(page);
  await at(page, "zero", name);
  await go(page, click);
  await trial(page, click, name);
  check(Number(await page.getAttribute("#chart", "data-points")) > 25, "the force over time is not drawn");
  await page.click("#repeat");
  await until(() => page.isVisible("#repeat-reasons"), "nobody asks for a reason");
  await page.click("#reasons label:first-child");
  await page.click("#repeat-send");
  // The same hand again: it rests first. The other one may go on at once.
  await at(page, "rest", name);
  await go(page, click);
  for (const hand of ["right", "left"]) {
    await trial(page, click, name);
    const told = await page.textContent("#figures-list");
    check(/\d kg/.test(told) && /\d N/.test(told), `the review of the ${hand} hand says: ${told}`);
    await go(page, click);
  }
  await at(page, "done", name);
  const links = await page.$$eval("#files a", (all) => all.map((link) => link.getAttribute("href")));
  for (const file of ["page.html", "page.pdf", "results.csv", "results.json"]) {
    const link = links.find((link) => link.includes(file));
    check(link, `no link to ${file}: ${links}`);
    const answer = await page.request.get(new URL(link, server.url).href);
    check(answer.ok(), `${file} is answered with ${answer.status()}`);
    check((await answer.body()).equals(readFileSync(path.join(folderOf(server, "P-01"), file))), `${file} is another one than that on the disk`);
  }
  const folder = folderOf(server, "P-01");
  const results = checkResults(folder, 2);
  check(results.hands.map((hand) => hand.hand).join() === "right,left", "not both hands");
  const kept = JSON.parse(readFileSync(path.join(folder, "session.json"), "utf8"));
  check(kept.attempts.length === 3 && kept.note === "first visit", "the repeated trial, or the note, is not kept");
  check((await server.stop()) === 0, `the program ends badly: ${server.said()}`);
});

test("by keyboard alone; the program is killed in the middle, and the session goes on where it was", async () => {
  const first = await grip("sim:econe?grip&seed=4", { protocol: "trials = 1\n" });
  const options = { viewport: { width: 820, height: 1180 }, colorScheme: "light" };
  const name = "tablet-light";
  const lost = [/WebSocket connection|ERR_CONNECTION/];
  const page = await open(first.url, { ...options, expected: lost });
  await at(page, "setup", name);
  check((await focused(page)) === "person", `the focus is on ${await focused(page)}`);
  await page.keyboard.type("P-02");
  await enter(page);
  await at(page, "zero", name);
  await go(page, enter);
  await trial(page, enter, name);
  await go(page, enter);
  await at(page, "ready");
  first.kill();
  await until(() => page.isVisible("#connection-alert"), "the page does not say that the program is gone");

  const again = await grip("sim:econe?grip&seed=4", { protocol: "trials = 1\n", folder: first.folder, more: ["--person", "P-02"] });
  const other = await open(again.url, options);
  await at(other, "zero", name);
  check(await other.isVisible("#resumed"), "the page does not say that the session goes on");
  await go(other, enter);
  await trial(other, enter, name);
  await go(other, enter);
  await at(other, "done", name);
  checkResults(folderOf(again, "P-02"), 2);
});

test("a session on a phone, on a flat mat, ended early; what was left out is not made up", async () => {
  const server = await grip("sim:mat-16x16-cd4067?grip&seed=5", { protocol: "hands = [\"left\"]\ntrials = 3\n" });
  const page = await open(server.url, { viewport: { width: 390, height: 844 }, colorScheme: "dark", hasTouch: true });
  const name = "phone-dark";
  await at(page, "setup", name);
  await page.fill("#person", "P-03");
  await page.tap("#primary");
  await at(page, "zero", name);
  const tap = (page) => page.tap("#primary");
  await go(page, tap);
  await trial(page, tap, name);
  await go(page, tap);
  await at(page, "rest", name);
  await page.tap("#finish");
  await until(() => page.isVisible("#finish-dialog"), "nobody asks whether to end");
  await page.tap("#finish-send");
  await at(page, "done", name);
  const results = checkResults(folderOf(server, "P-03"), 1);
  check(results.force === "total normal force", `a flat mat measures ${results.force}`);
});

test("a trial that is cancelled is kept, and does not count", async () => {
  const server = await grip("sim:econe?grip&seed=6", { protocol: "hands = [\"right\"]\ntrials = 1\n", more: ["--person", "P-04"] });
  const page = await open(server.url, { colorScheme: "light" });
  await at(page, "zero");
  await go(page, click);
  await at(page, "ready");
  await go(page, click);
  await at(page, "hold");
  await sleep(1500);
  await page.keyboard.press("Escape");
  await at(page, "rest", "desk-light");
  await go(page, click);
  await trial(page, click, "desk-light");
  await go(page, click);
  await at(page, "done", "desk-light");
  const folder = folderOf(server, "P-04");
  checkResults(folder, 1);
  const { attempts } = JSON.parse(readFileSync(path.join(folder, "session.json"), "utf8"));
  check(attempts.length === 2 && existsSync(path.join(folder, attempts[0].recording)), "the cancelled trial is not kept");
});

// Three minutes: only where it is asked for by name.
if (process.argv.slice(3).includes(USUAL)) {
  test(`the ${USUAL}: six trials of 8 s, every step looked at`, async () => {
    const folder = path.join(scratch, "grips");
    const server = Object.assign(await start("grip", "sim:econe?grip&seed=3", "--listen", "127.0.0.1:0", "--folder", folder), { folder });
    const page = await open(server.url, { colorScheme: "light" });
    const name = "usual";
    await at(page, "setup", name);
    await page.fill("#person", "P-05");
    await click(page);
    await at(page, "zero", name);
    await go(page, click);
    for (let count = 1; count <= 6; count += 1) {
      await trial(page, click, name);
      await go(page, click);
      if (count === 2) await at(page, "rest", name);
    }
    await at(page, "done", name);
    const kept = folderOf(server, "P-05");
    checkResults(kept, 6);
    const sheet = await open(`file://${kept}/page.html`, { viewport: { width: 885, height: 1123 }, colorScheme: "light" });
    await sheet.emulateMedia({ media: "print" });
    // The margins of the paper, which a screen has none of.
    await sheet.addStyleTag({ content: "body { margin: 14mm 12mm }" });
    await look(sheet, `${name}-page`, true);
    check((await server.stop()) === 0, `the program ends badly: ${server.said()}`);
  });
}

await runAll();
