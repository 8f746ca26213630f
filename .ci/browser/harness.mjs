// What the tests of the program's own pages share: a program that serves, a browser, and running test after test.

import { chromium } from "playwright-core";
import { spawn } from "node:child_process";
import { existsSync, readFileSync, rmSync } from "node:fs";
import path from "node:path";

import { check, program, scratch, until, wanted } from "./common.mjs";

const cleanups = [];
const tests = [];
export const test = (name, run) => tests.push({ name, run });

// ------------------------------------------------------------------------------------------------- the program

// Starts `taxel` and waits for the address of its page, which is all it prints to standard output.
export async function start(...args) {
  const child = spawn(program, args, { cwd: scratch, stdio: ["ignore", "pipe", "pipe"] });
  let said = "";
  let printed = "";
  child.stderr.on("data", (data) => { said += data; });
  child.stdout.on("data", (data) => { printed += data; });
  const exited = new Promise((resolve) => child.on("exit", (code, signal) => resolve(code ?? signal)));
  const server = {
    args,
    said: () => said,
    running: () => child.exitCode === null && child.signalCode === null,
    // As a power cut does.
    kill: () => child.kill("SIGKILL"),
    // As Ctrl-C does; gives the exit code.
    async stop() {
      if (server.running()) child.kill("SIGINT");
      const slow = setTimeout(() => child.kill("SIGKILL"), 10000);
      const code = await exited;
      clearTimeout(slow);
      return code;
    },
  };
  cleanups.push(() => server.stop());
  await until(() => /^http:\S+\n/m.test(printed) || !server.running(), () => `taxel ${args.join(" ")} prints no address; it says: ${said}`);
  check(server.running(), `taxel ${args.join(" ")} ended at once; it says: ${said}`);
  server.url = printed.trim();
  server.address = new URL(server.url).host;
  return server;
}

// ------------------------------------------------------------------------------------------------- the browser

let browser = null;

// Warnings that these tests cause: they read canvases back, and drive WebGL without a GPU.
const OWN_DOING = /willReadFrequently|GL Driver Message/;

// Opens a page in a context of its own: contexts share neither storage nor a renderer process. What the page complains
// of is kept; a test that provokes complaints says which ones are `expected`.
export async function open(url, { expected = [], ...options } = {}) {
  const context = await browser.newContext({ viewport: { width: 1440, height: 900 }, colorScheme: "dark", acceptDownloads: true, ...options });
  cleanups.push(() => context.close());
  await context.addInitScript(() => {
    // Errors of this kind are not all told as messages of the console.
    document.addEventListener("securitypolicyviolation", (event) => console.error(`content policy: ${event.violatedDirective} forbids ${event.blockedURI}`));
  });
  if (process.env.TAXEL_WEB) await context.route((asked) => asked.pathname.startsWith("/assets/"), serveFromFolder);
  const page = await context.newPage();
  const complaints = [];
  page.on("console", (message) => {
    if (["error", "warning"].includes(message.type()) && !OWN_DOING.test(message.text())) complaints.push(`${message.type()}: ${message.text()} (${message.location().url})`);
  });
  page.on("pageerror", (error) => complaints.push(`uncaught: ${error.stack || error}`));
  page.complaints = () => complaints.filter((text) => !expected.some((pattern) => pattern.test(text)));
  opened.push(page);
  page.answer = await page.goto(url);
  return page;
}

// With the program's own headers, so that the content policy still holds.
async function serveFromFolder(route) {
  const response = await route.fetch();
  const file = path.join(process.env.TAXEL_WEB, new URL(route.request().url()).pathname.slice("/assets/".length));
  if (response.ok() && existsSync(file)) await route.fulfill({ response, body: readFileSync(file) });
  else await route.fulfill({ response });
}

let opened = [];

// -------------------------------------------------------------------------------------------------------- run

async function cleanUp() {
  for (const clean of cleanups.splice(0).reverse()) await clean().catch(() => {});
}

async function runOne({ name, run }) {
  const begun = performance.now();
  let failure = null;
  let note = "";
  opened = [];
  try {
    note = (await run()) ?? "";
  } catch (error) {
    failure = error.message;
    if (!(error instanceof Error) || error.constructor !== Error) failure = error.stack ?? String(error);
  }
  const complaints = opened.flatMap((page) => page.complaints());
  if (complaints.length > 0) failure = [failure, "the page complains:", ...new Set(complaints)].filter(Boolean).join("\n      ");
  await cleanUp();
  const seconds = ((performance.now() - begun) / 1000).toFixed(1);
  console.log(`${failure ? "FAILED" : "ok    "} ${name} (${seconds} s)${note ? `: ${note}` : ""}`);
  if (failure) console.log(`      ${failure}`);
  return !failure;
}

// Runs those whose names contain one of the words that were given, or all.
export async function runAll() {
  const chosen = tests.filter(({ name }) => wanted.length === 0 || wanted.some((words) => name.includes(words)));
  const begun = performance.now();
  let failed = 0;
  try {
    browser = await chromium.launch({
      executablePath: process.env.CHROMIUM || "/usr/bin/chromium",
      args: ["--headless", "--no-sandbox", "--disable-gpu", "--enable-unsafe-swiftshader", "--disable-quic", "--no-first-run",
        "--disable-background-networking", "--disable-component-update", "--disable-sync"],
    });
    for (const one of chosen) if (!(await runOne(one))) failed += 1;
  } finally {
    await cleanUp();
    await browser?.close();
    rmSync(scratch, { recursive: true, force: true });
  }
  console.log(`${chosen.length - failed} of ${chosen.length} tests pass, ${((performance.now() - begun) / 1000).toFixed(0)} s`);
  process.exitCode = failed > 0 || chosen.length === 0 ? 1 : 0;
}
