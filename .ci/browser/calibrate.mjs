// End-to-end tests of the guided calibration's page: the real program with its simulated operator, a real Chromium, no stand-ins.
//
//   node calibrate.mjs PATH_OF_TAXEL [WORDS ...]     WORDS: run only the tests whose names contain one of them
//
// Environment: as for test.mjs; with TAXEL_SCREENSHOTS every step of a calibration is kept there as a picture.

import { mkdirSync, readFileSync, readdirSync } from "node:fs";
import path from "node:path";

import { violations } from "./axe.mjs";
import { check, scratch, sleep, until } from "./common.mjs";
import { open, runAll, start, test } from "./harness.mjs";

const SHOTS = process.env.TAXEL_SCREENSHOTS;
// Keys within this time after a step do nothing: nobody has read yet what they would do.
const READ_MS = 450;
const STEP_MS = 120000;
const ROWS = "#presses tbody tr";

let calibrations = 0;

async function calibrate(source, { folder = path.join(scratch, `calibrations-${(calibrations += 1)}`) } = {}) {
  const output = path.join(scratch, `calibrated-${calibrations}.toml`);
  const server = await start("calibrate", "--live", source, "--weights", "50,200,500", "-o", output, "--listen", "127.0.0.1:0", "--folder", folder);
  return Object.assign(server, { folder, output });
}

const phase = (page) => page.evaluate(() => document.body.dataset.phase);
const taken = (page) => page.locator(ROWS).count();

const looked = new Set();

// What is wrong with the page as it stands; a picture a phase, once.
async function look(page, wanted, name) {
  const shot = `calibrate-${name}-${wanted}`;
  if (looked.has(shot)) return;
  looked.add(shot);
  const found = await violations(page);
  check(found.length === 0, `axe finds at ${wanted}: ${found.join("\n")}`);
  const wide = await page.evaluate(() => document.documentElement.scrollWidth - document.documentElement.clientWidth);
  check(wide <= 0, `at ${wanted} the page is ${wide} pixels too wide`);
  if (!SHOTS) return;
  mkdirSync(SHOTS, { recursive: true });
  await page.screenshot({ path: path.join(SHOTS, `${shot}.png`), fullPage: name.startsWith("phone") });
}

async function at(page, wanted, name) {
  await until(async () => (await phase(page)) === wanted, async () => `the calibration does not come to ${wanted}: it is at ${await phase(page)}, and says ${await page.textContent("#message")}`, STEP_MS);
  await look(page, wanted, name);
}

// Looks at every phase on the way to so many presses.
async function untilTaken(page, count, name) {
  await until(async () => {
    const now = await phase(page);
    if (["press", "elsewhere", "taking", "off", "others"].includes(now)) await look(page, now, name);
    return (await taken(page)) >= count;
  }, async () => `${count} presses are not taken: ${await taken(page)} are, at ${await phase(page)}`, STEP_MS);
}

// What the files of a finished calibration say, and that they are whole.
function checkResults(server) {
  const folders = readdirSync(server.folder);
  check(folders.length === 1, `calibrations: ${folders}`);
  const folder = path.join(server.folder, folders[0]);
  const files = readdirSync(folder);
  for (const name of ["certificate.pdf", "certificate.html", "sensor.toml", "presses.csv", "session.json"]) check(files.includes(name), `${name} is missing: ${files}`);
  const pdf = readFileSync(path.join(folder, "certificate.pdf")).toString("latin1");
  check(Number(/\/Count (\d+)/.exec(pdf)[1]) === 1, "the certificate is no single page");
  check(readFileSync(server.output, "utf8") === readFileSync(path.join(folder, "sensor.toml"), "utf8"), "two calibrated sensors differ");
  return folder;
}

test("a calibration from the first click to the certificate, a press moved and one undone", async () => {
  const server = await calibrate("sim:mat-16x16-cd4067?uniform&fps=50");
  const page = await open(server.url);
  await at(page, "empty", "desktop");
  await sleep(READ_MS);
  await page.click("#primary");
  await at(page, "press", "desktop");
  await untilTaken(page, 2, "desktop");
  const said = await page.textContent("#phase-title");
  await page.click("#undo");
  await until(async () => (await page.locator(`${ROWS}[data-left-out]`).count()) === 1, "the press that was undone is not said to be left out");
  check(/row|Taken|off/i.test(said), `the page says '${said}'`);
  await untilTaken(page, 10, "desktop");
  check(looked.has("calibrate-desktop-elsewhere"), "a press beside was never told of");
  await until(async () => Number(await page.getAttribute("#error-chart", "data-points")) >= 1, "no error is drawn", STEP_MS);
  await page.click("#finish");
  await page.click("#finish-send");
  await at(page, "done", "desktop");
  const folder = checkResults(server);
  const link = await page.getAttribute('#files a[href*="certificate.pdf"]', "href");
  const answer = await page.request.get(new URL(link, server.url).href);
  check((await answer.body()).equals(readFileSync(path.join(folder, "certificate.pdf"))), "another certificate comes from the page");
});

test("by keyboard on a phone; the program is killed in the middle, and the calibration goes on where it was", async () => {
  const source = "sim:mat-16x16-cd4067?uniform&fps=50";
  const options = { viewport: { width: 390, height: 844 }, colorScheme: "light" };
  const first = await calibrate(source);
  let page = await open(first.url, { ...options, expected: [/WebSocket|ERR_CONNECTION/] });
  await at(page, "empty", "phone");
  await sleep(READ_MS);
  await page.keyboard.press("Enter");
  await untilTaken(page, 5, "phone");
  first.kill();
  const second = await calibrate(source, { folder: first.folder });
  page = await open(second.url, options);
  await at(page, "empty", "phone");
  check((await taken(page)) >= 5, `${await taken(page)} presses are left of 5`);
  check(await page.isVisible("#resumed"), "it does not say that it goes on");
  await sleep(READ_MS);
  await page.keyboard.press("Enter");
  await untilTaken(page, 9, "phone");
  await page.click("#finish");
  await page.click("#finish-send");
  await at(page, "done", "phone");
  checkResults(second);
});

await runAll();
