// End-to-end tests of the interactive model: the real program, a real Chromium, no stand-ins.
//
//   node model.mjs PATH_OF_TAXEL [WORDS ...]     WORDS: run only the tests whose names contain one of them
//
// Environment: as for test.mjs. With TAXEL_WEB the pages themselves come from that folder too, with the headers of "/".

import { chromium } from "playwright-core";
import { spawn } from "node:child_process";
import { existsSync, mkdirSync, readFileSync, rmSync } from "node:fs";
import path from "node:path";

import { violations } from "./axe.mjs";
import { check, program, scratch, until, wanted } from "./common.mjs";

function startProgram(...more) {
  const child = spawn(program, ["live", "sim:econe", "--listen", "127.0.0.1:0", "--folder", path.join(scratch, "recordings"), ...more], { cwd: scratch, stdio: ["ignore", "pipe", "pipe"] });
  const server = { child, printed: "", said: "" };
  child.stdout.on("data", (data) => { server.printed += data; });
  child.stderr.on("data", (data) => { server.said += data; });
  server.ended = new Promise((resolve) => child.on("exit", resolve));
  return server;
}

// What these tests cause: they read canvases back, and a page that is handed to the browser may open no WebSocket.
const OWN_DOING = process.env.TAXEL_WEB ? /willReadFrequently|LOCAL_NETWORK_ACCESS/ : /willReadFrequently|GL Driver Message/;

let browser = null;
let origin = "";
let opened = [];

async function open(hash = "", options = {}) {
  const context = await browser.newContext({ viewport: { width: 1440, height: 900 }, colorScheme: "dark", acceptDownloads: true, ...options });
  await context.addInitScript(() => {
    document.addEventListener("securitypolicyviolation", (event) => console.error(`content policy: ${event.violatedDirective} forbids ${event.blockedURI}`));
  });
  if (process.env.TAXEL_WEB) await context.route((asked) => asked.pathname.startsWith("/assets/") || asked.pathname in PAGES, serveFromFolder);
  const page = await context.newPage();
  page.complaints = [];
  page.on("console", (message) => {
    if (["error", "warning"].includes(message.type()) && !OWN_DOING.test(message.text())) page.complaints.push(`${message.type()}: ${message.text()}`);
  });
  page.on("pageerror", (error) => page.complaints.push(`uncaught: ${error.stack || error}`));
  opened.push({ page, context });
  page.answer = await page.goto(`${origin}/model${hash}`);
  await until(() => page.locator("#values tbody tr").count(), "the table of values stays empty");
  return page;
}

const PAGES = { "/": "index.html", "/model": "model.html" };
const KINDS = { html: "text/html; charset=utf-8", css: "text/css; charset=utf-8", js: "text/javascript; charset=utf-8", svg: "image/svg+xml" };

// With the program's own headers, so that the content policy still holds; a file that the program lacks gets those of "/".
async function serveFromFolder(route) {
  const { pathname } = new URL(route.request().url());
  const name = PAGES[pathname] ?? pathname.slice("/assets/".length);
  const file = path.join(process.env.TAXEL_WEB, name);
  const response = await route.fetch({ url: `${origin}/` });
  if (!existsSync(file)) await route.fulfill({ response: await route.fetch() });
  else await route.fulfill({ response, headers: { ...response.headers(), "content-type": KINDS[path.extname(name).slice(1)] }, body: readFileSync(file) });
}

const text = (page, id) => page.evaluate((id) => document.getElementById(id).textContent, id);
const attribute = (page, selector, name) => page.locator(selector).getAttribute(name);

// A cell of the table, with every digit.
const value = (page, n, setting, model, quantity) =>
  page.evaluate(([n, setting, model, quantity]) => {
    const row = document.querySelectorAll("#values tbody tr")[n];
    return Number(row.querySelector(`[data-setting="${setting}"][data-model="${model}"][data-quantity="${quantity}"]`).dataset.value);
  }, [n, setting, model, quantity]);

// How many pixels of the chart have this setting's colour.
const inked = (page, setting) =>
  page.evaluate((setting) => {
    const wanted = getComputedStyle(document.documentElement).getPropertyValue(`--setting-${setting}`).trim();
    const [red, green, blue] = [1, 3, 5].map((at) => parseInt(wanted.slice(at, at + 2), 16));
    const canvas = document.querySelector("#chart canvas");
    const { data } = canvas.getContext("2d").getImageData(0, 0, canvas.width, canvas.height);
    let count = 0;
    for (let i = 0; i < data.length; i += 4) if (data[i] === red && data[i + 1] === green && data[i + 2] === blue && data[i + 3] === 255) count += 1;
    return count;
  }, setting);

// As a file manager does it.
async function drop(page, name, content) {
  const transfer = await page.evaluateHandle(([name, content]) => {
    const transfer = new DataTransfer();
    transfer.items.add(new File([content], name, { type: "text/csv" }));
    return transfer;
  }, [name, content]);
  for (const kind of ["dragenter", "dragover", "drop"]) await page.dispatchEvent("body", kind, { dataTransfer: transfer });
}

const shownPoints = async (page) => Number(await attribute(page, "#chart", "data-points"));

const close = (a, b) => Math.abs(a - b) <= 1e-9 * Math.max(1, Math.abs(b));

// --------------------------------------------------------------------------------------- the models, once more

// From the equations as they are printed, not from the page's own files.
const TABLE_V = { a: 1e5, rk: 2000, ri: 1000, rt: 1000, vt: 0.4, rm: 0, rv: 0 };

function circuit({ a, rk, ri, rt, vt, rm, rv }, n) {
  const g = 1 / (rm + rk / (1 + a));
  const drive = 1 / (rm + rv + rt);
  const v = (vt * drive) / (drive + n / (rm + ri) + g);
  return (-a / (1 + a)) * rk * g * v;
}

const equation6 = ({ a, rk, ri, rt, vt }, n) => (-vt * a * rk * ri) / ((a * ri + n * rk) * rt);

// ---------------------------------------------------------------------------------------------------- the tests

const tests = [];
const test = (name, run) => tests.push({ name, run });

test("the model opens with Table V, and its numbers are those of the closed forms", async () => {
  const page = await open();
  check(page.answer.headers()["content-security-policy"]?.includes("default-src 'self'"), "the page comes without a content policy");
  for (const [setting, numbers] of [[0, TABLE_V], [1, { ...TABLE_V, rm: 10 }]]) {
    for (const n of [0, 1, 20]) {
      for (const [model, formula] of [["circuit", circuit], ["paper", equation6]]) {
        const expected = formula(numbers, n);
        const got = await value(page, n, setting, model, "volts");
        check(close(got, expected), `setting ${setting}, ${model}, N = ${n}: ${got} V instead of ${expected}`);
        const drop = 100 * (1 - expected / formula(numbers, 0));
        const gotDrop = await value(page, n, setting, model, "drop");
        check(close(gotDrop, drop), `setting ${setting}, ${model}, N = ${n}: a drop of ${gotDrop} % instead of ${drop}`);
      }
    }
  }
  const drops = [await value(page, 20, 0, "circuit", "drop"), await value(page, 20, 1, "circuit", "drop")];
  check(drops[0] < 0.05 && drops[1] > 16, `the switches should make the drop; it is ${drops} %`);
  await page.click("#y-counts");
  const counts = await until(() => value(page, 20, 0, "circuit", "counts").catch(() => 0), "the table does not turn to counts");
  check(close(counts, (-circuit(TABLE_V, 20) / 2.2) * 65535), `${counts} counts at N = 20`);
});

test("curves are drawn, and follow a slider and a number", async () => {
  const page = await open();
  for (const setting of [0, 1]) check((await inked(page, setting)) > 500, `the curve of setting ${setting} is not drawn`);
  check((await inked(page, 2)) === 0, "a third setting is drawn, and there is none");
  await page.click("#add-button");
  await page.keyboard.type("third");
  await page.fill("#switchOhms-2", "50");
  const expected = circuit({ ...TABLE_V, rm: 50 }, 20);
  await until(async () => close(await value(page, 20, 2, "circuit", "volts").catch(() => NaN), expected), "the third setting does not take R_mux = 50 Ω");
  check((await text(page, "legend")).includes("third"), "the legend lacks the new name");
  check((await inked(page, 2)) > 500, "the curve of the third setting is not drawn");
  await page.focus("#feedbackOhms-0-slider");
  const before = await value(page, 20, 0, "circuit", "volts");
  for (let i = 0; i < 3; i += 1) await page.keyboard.press("ArrowRight");
  await until(async () => (await value(page, 20, 0, "circuit", "volts")) < before, "a larger R_k does not raise |V_out|");
  await page.fill("#taxelOhms-0", "-5");
  check((await attribute(page, "#taxelOhms-0", "aria-invalid")) === "true", "a negative resistance is not marked");
  await page.focus("#taxelOhms-1");
  check((await page.inputValue("#taxelOhms-0")) === "1000", "what cannot be is left in the field");
  await page.focus("#chart");
  await page.keyboard.press("Home");
  await until(async () => (await text(page, "at")) === "N = 0", "the keyboard does not move along N");
});

test("settings come, go and are shared by the address", async () => {
  const page = await open();
  await page.locator(".duplicate").nth(1).click();
  await page.locator(".duplicate").nth(0).click();
  check((await page.locator(".setting").count()) === 4, "there are not four settings");
  check(await page.locator("#add-button").isDisabled(), "a fifth setting may be added");
  await page.fill("#sourceOhms-3", "1000");
  await page.click("#y-drop");
  await page.locator(".remove").nth(0).click();
  const expected = circuit({ ...TABLE_V, rv: 1000 }, 20);
  await until(async () => close(await value(page, 20, 2, "circuit", "volts").catch(() => NaN), expected), "the shared setting has no R_v of 1 kΩ");
  await until(() => page.url().includes("#") && page.url().includes("y=drop"), "the address does not change");
  const shared = await open(new URL(page.url()).hash);
  const names = (there) => there.locator(".setting .name").evaluateAll((all) => all.map((input) => input.value));
  check(JSON.stringify(await names(page)) === JSON.stringify(await names(shared)), `the names differ: ${await names(shared)}`);
  check((await value(shared, 20, 2, "circuit", "volts")) === (await value(page, 20, 2, "circuit", "volts")), "the values differ");
  check((await attribute(shared, "#y-drop", "aria-pressed")) === "true", "the y axis differs");
  await shared.click("#reset-button");
  await until(() => !shared.url().includes("#"), "a reset leaves the address as it was");
  check((await names(shared)).length === 2, "a reset leaves other settings");
  const broken = await open("#y=weight&n=-3&s=1~2~3");
  await until(async () => (await text(broken, "toasts")).includes("y=weight"), "an address that makes no sense is not spoken of");
  check((await names(broken))[0] === "Table V", "an address that makes no sense leaves no settings");
});

test("measured points are shown, and broken lines are named", async () => {
  const page = await open();
  await drop(page, "row.csv", "n,value\n0,23400\n0,23300\n0,23500\n5,22300\n5,22200\n30,18000\n");
  await until(async () => (await shownPoints(page)) === 6, async () => `${await shownPoints(page)} of 6 points are shown`);
  check((await page.inputValue("#last-input")) === "30", "the axis does not reach the last point");
  check((await text(page, "points-note")).includes("6 readings at 3 values of N"), await text(page, "points-note"));
  await drop(page, "bad.csv", "n,value\n0,23400\n1;\n2,many\n-1,5\n");
  const error = await until(() => text(page, "points-error"), "a broken file is not refused");
  for (const words of ["bad.csv", "line 3", "line 4", "“many”", "line 5", "expected a whole number"]) check(error.includes(words), `“${words}” is not in: ${error}`);
  check((await shownPoints(page)) === 6, "a broken file takes the good points away");
  await page.setInputFiles("#points-input", { name: "volts.csv", mimeType: "text/csv", buffer: Buffer.from("1;-0.79\n2;-0.78\n") });
  await until(async () => (await shownPoints(page)) === 2, "a picked file is not shown");
  check((await text(page, "points-error")) === "", "the error stays after a good file");
  await page.selectOption("#unit-select", "volts");
  await page.click("#y-drop");
  await until(async () => (await text(page, "points-note")).includes("needs a reading at N = 0"), "a drop without N = 0 is not spoken of");
  await page.selectOption("#counting-select", "pressed");
  await until(async () => (await shownPoints(page)) === 2, "n that counts all pressed taxels is not moved to N = 0");
  await page.click("#points-clear");
  await until(async () => (await shownPoints(page)) === 0, "the points stay");
});

test("saturation is said", async () => {
  const page = await open();
  check((await text(page, "saturation")) === "", "Table V saturates");
  await page.fill("#testVolts-1", "1.5");
  await until(async () => (await text(page, "saturation")).includes("saturates"), "1.5 V does not saturate");
  await until(() => page.locator("#values td.saturates").count(), "the table does not mark what saturates");
});

test("picture and table are saved", async () => {
  const page = await open();
  const save = async (id) => {
    const [download] = await Promise.all([page.waitForEvent("download"), page.click(id)]);
    return { name: download.suggestedFilename(), data: readFileSync(await download.path()) };
  };
  const picture = await save("#png-button");
  check(picture.name.endsWith(".png") && picture.data.subarray(1, 4).toString() === "PNG" && picture.data.length > 10000, `the picture has ${picture.data.length} bytes`);
  const table = (await save("#csv-button")).data.toString().trim().split("\n");
  check(table.length === 1 + 2 * 21, `the table has ${table.length} lines`);
  const column = table[0].split(",").indexOf("v_out_circuit_volts");
  check(close(Number(table[21].split(",")[column]), circuit(TABLE_V, 20)), `the line of N = 20 is ${table[21]}`);
});

test("the live page leads to the model and back", async () => {
  const page = await open();
  await page.click("#live-link");
  await page.waitForURL(`${origin}/`);
  await page.click("#model-link");
  await page.waitForURL(`${origin}/model`);
  check((await page.title()).includes("Interactive model"), "the link leads elsewhere");
});

test("text fits, in both sizes and themes", async () => {
  const folder = process.env.TAXEL_SCREENSHOTS;
  if (folder) mkdirSync(folder, { recursive: true });
  for (const [width, height] of [[1440, 900], [820, 1180], [390, 844]]) {
    for (const colorScheme of ["dark", "light"]) {
      const page = await open("", { viewport: { width, height }, colorScheme });
      await page.locator(".duplicate").nth(0).click();
      await page.locator(".duplicate").nth(1).click();
      const wide = await page.evaluate(() => document.documentElement.scrollWidth);
      check(wide <= width, `the page is ${wide} pixels wide in a window of ${width}`);
      const cut = await page.evaluate(() => [...document.querySelectorAll("button, .parameter input[type=number], h2:not(.sr), label")]
        .filter((element) => element.clientWidth > 0 && element.scrollWidth > element.clientWidth + 1).map((element) => element.id || element.textContent));
      check(cut.length === 0, `cut at ${width} pixels: ${cut.join(", ")}`);
      if (folder) await page.screenshot({ path: path.join(folder, `model-${colorScheme}-${width}x${height}.png`) });
    }
  }
});

test("axe-core finds nothing, in both sizes and themes", async () => {
  for (const [width, height] of [[1440, 900], [390, 844]]) {
    for (const colorScheme of ["dark", "light"]) {
      const page = await open("", { viewport: { width, height }, colorScheme });
      await drop(page, "bad.csv", "1;\n");
      await until(() => text(page, "points-error"), "a broken file is not refused");
      await page.fill("#testVolts-1", "1.5");
      await until(async () => (await text(page, "saturation")).includes("saturates"), "1.5 V does not saturate");
      const found = await violations(page);
      check(found.length === 0, `${colorScheme}, ${width} pixels:\n      ${found.join("\n      ")}`);
    }
  }
});

test("without the token there is no model", async () => {
  const server = startProgram("--token", "a-long-secret");
  try {
    const found = await until(() => /^(http:\S+)\n/m.exec(server.printed) || (server.child.exitCode !== null && "ended"), () => `no address; it says: ${server.said}`);
    check(found !== "ended", `the program ended: ${server.said.trim().split("\n")[0]}`);
    const own = new URL(found[1]).origin;
    const answer = await fetch(`${own}/model`);
    check(answer.status === 401, `without the token it answers ${answer.status}`);
    if (process.env.TAXEL_WEB) return "";
    const given = await fetch(`${own}/model?token=a-long-secret`);
    check(given.status === 200 && given.headers.get("set-cookie")?.includes("=a-long-secret;"), `with the token it answers ${given.status}`);
  } finally {
    server.child.kill("SIGINT");
    await server.ended;
  }
  return "";
});

// -------------------------------------------------------------------------------------------------------- run

async function runOne({ name, run }) {
  const begun = performance.now();
  let failure = null;
  let note = "";
  opened = [];
  try {
    note = (await run()) ?? "";
  } catch (error) {
    failure = error.constructor === Error ? error.message : error.stack;
  }
  const complaints = opened.flatMap(({ page }) => page.complaints);
  if (complaints.length > 0) failure = [failure, "the page complains:", ...new Set(complaints)].filter(Boolean).join("\n      ");
  for (const { context } of opened) {
    // A file may still be on its way.
    await context.unrouteAll({ behavior: "ignoreErrors" }).catch(() => {});
    await context.close().catch(() => {});
  }
  const seconds = ((performance.now() - begun) / 1000).toFixed(1);
  console.log(`${failure ? "FAILED" : "ok    "} ${name} (${seconds} s)${note ? `: ${note}` : ""}`);
  if (failure) console.log(`      ${failure}`);
  return !failure;
}

const chosen = tests.filter(({ name }) => wanted.length === 0 || wanted.some((words) => name.includes(words)));
const begun = performance.now();
let failed = 0;
const server = startProgram();
try {
  const [, url] = await until(() => /^(http:\S+)\n/m.exec(server.printed), () => `taxel live prints no address; it says: ${server.said}`);
  origin = new URL(url).origin;
  browser = await chromium.launch({
    executablePath: process.env.CHROMIUM || "/usr/bin/chromium",
    args: ["--headless", "--no-sandbox", "--disable-gpu", "--disable-quic", "--no-first-run", "--disable-background-networking",
      "--disable-component-update", "--disable-sync"],
  });
  for (const one of chosen) if (!(await runOne(one))) failed += 1;
} finally {
  await browser?.close();
  if (server.child.exitCode === null) server.child.kill("SIGINT");
  await server.ended;
  rmSync(scratch, { recursive: true, force: true });
}
console.log(`${chosen.length - failed} of ${chosen.length} tests pass, ${((performance.now() - begun) / 1000).toFixed(0)} s`);
process.exitCode = failed > 0 || chosen.length === 0 ? 1 : 0;
