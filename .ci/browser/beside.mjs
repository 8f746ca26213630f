// End-to-end tests of two recordings side by side: the real program, a real Chromium, no stand-ins.
//
//   node beside.mjs PATH_OF_TAXEL [WORDS ...]     WORDS: run only the tests whose names contain one of them
//
// Environment: as for test.mjs; with TAXEL_SCREENSHOTS pictures of the page are kept there.

import { execFileSync } from "node:child_process";
import { mkdirSync } from "node:fs";
import path from "node:path";

import { violations } from "./axe.mjs";
import { check, program, scratch, sleep, until } from "./common.mjs";
import { open, runAll, start, test } from "./harness.mjs";

const SHOTS = process.env.TAXEL_SCREENSHOTS;
const SIZES = { desktop: { width: 1440, height: 900 }, tablet: { width: 820, height: 1180 }, phone: { width: 390, height: 844 } };

let isRecorded = false;

// A grip of 6 s and a harder one of 4 s.
function record() {
  if (isRecorded) return;
  isRecorded = true;
  const taxel = (...words) => execFileSync(program, words, { cwd: scratch, stdio: "ignore" });
  for (const [name, load, frames] of [["soft", "300", "300"], ["hard", "900", "200"]]) {
    taxel("simulate", "--sensor", "econe", "--pattern", "hand", "--load-g", load, "--frames", frames, "--seed", name === "soft" ? "3" : "4", "-o", `${name}.txt`);
    taxel("convert", `${name}.txt`, "--sensor", "econe", "--frames-per-second", "50", "-o", `${name}.mcap`);
  }
}

async function serve() {
  record();
  return start("view", "soft.mcap", "--beside", "hard.mcap", "--listen", "127.0.0.1:0");
}

async function beside(options = {}, server = null) {
  const page = await open((server ?? (await serve())).url, options);
  await until(async () => (await cells(page, "Largest force, N")).every(Number.isFinite), "the curves of both do not come");
  return page;
}

const seconds = async (page) => {
  const [minutes, rest] = (await page.textContent("#position")).split(" / ")[0].split(":");
  return 60 * Number(minutes) + Number(rest);
};
const cells = (page, name, part = 0) => page.evaluate(([name, part]) => {
  const rows = [...document.querySelectorAll("#figures tr")].filter((row) => row.firstChild.textContent === name);
  return [...rows[part].querySelectorAll("td .num:first-child")].map((cell) => Number(cell.textContent.replace("−", "-")));
}, [name, part]);
const statuses = (page) => Promise.all(["#status-a", "#status-b"].map((id) => page.textContent(id)));

test("both stand at their first frame, in one scale, with their whole curves and figures", async () => {
  const page = await beside();
  check((await page.textContent("#a-file")) === "soft.mcap" && (await page.textContent("#b-file")) === "hard.mcap", "the files are not named");
  const [soft, hard, more] = await cells(page, "Largest force, N");
  check(hard > 1.5 * soft && Math.abs(hard - soft - more) < 0.02 * hard, `largest forces: ${soft}, ${hard}, ${more}`);
  const highest = Math.max(...(await cells(page, "Highest pressure, kPa", 1)).slice(0, 2));
  const top = parseFloat(await page.textContent("#scale-top"));
  check(top >= highest && top < 2 * highest, `colours reach to ${top} kPa, pressures to ${highest}`);
  check((await page.textContent("#position")) === "0:00.0 / 0:06.0", await page.textContent("#position"));
  await page.fill("#seek", "2");
  await until(async () => {
    const now = await cells(page, "Total force, N");
    return now[0] > 1 && now[1] > now[0];
  }, async () => `forces at 2 s: ${await cells(page, "Total force, N")}`);
});

test("one player plays both; the shorter one waits at its end; play at the end begins anew", async () => {
  const page = await beside();
  await page.selectOption("#speed", "2");
  await page.click("#play");
  await until(async () => (await seconds(page)) > 1, "nothing is played");
  await page.keyboard.press("Tab");
  await page.click("#play");
  await until(async () => (await page.textContent("#play")) === "Play" && (await statuses(page)).every((text) => text.includes("paused")), async () => `both do not pause: ${await statuses(page)}`);
  // They are brought to one place first.
  let at = await seconds(page);
  await until(async () => {
    await sleep(700);
    const before = at;
    at = await seconds(page);
    return at === before;
  }, "the position goes on while both are paused");
  const before = await cells(page, "Total force, N");
  await page.fill("#seek", "5");
  await until(async () => Math.abs((await seconds(page)) - 5) < 0.05, "they do not go to 5 s");
  await until(() => page.evaluate(() => document.getElementById("b-tile").classList.contains("ended")), "the shorter one is not at its end");
  check(JSON.stringify(before) !== JSON.stringify(await cells(page, "Total force, N")), "the figures stay");
  await page.click("#play");
  await until(async () => (await seconds(page)) > 5.95 && (await page.textContent("#play")) === "Play", "it does not come to the end");
  await page.click("#play");
  await until(async () => (await seconds(page)) < 2 && (await page.textContent("#play")) === "Pause", "it does not begin anew");
  check(!(await page.evaluate(() => document.getElementById("b-tile").classList.contains("ended"))), "the shorter one stays at its end");
  await page.click("#play");
});

test("the keys play and move both, and a click in a curve goes there", async () => {
  const page = await beside();
  await page.fill("#seek", "0");
  await page.evaluate(() => document.activeElement.blur());
  for (let i = 0; i < 2; i += 1) {
    await page.keyboard.press("ArrowRight");
    await until(async () => Math.abs((await seconds(page)) - (i + 1)) < 0.05, "the arrow does not move by a second");
  }
  const box = await page.locator("#chart-total .u-over").boundingBox();
  await page.mouse.click(box.x + box.width / 2, box.y + box.height / 2);
  await until(async () => Math.abs((await seconds(page)) - 3) < 0.1, "a click in the middle does not go to 3 s");
  await page.keyboard.press(" ");
  await until(async () => (await page.textContent("#play")) === "Pause", "space does not play");
  await page.keyboard.press(" ");
  await until(async () => (await page.textContent("#play")) === "Play", "space does not pause");
});

test("axe finds nothing and nothing is too wide, light and dark, on a desktop, a tablet and a phone", async () => {
  const server = await serve();
  for (const [size, viewport] of Object.entries(SIZES)) {
    for (const colorScheme of ["light", "dark"]) {
      const page = await beside({ viewport, colorScheme }, server);
      await page.fill("#seek", "2");
      await until(async () => Math.abs((await seconds(page)) - 2) < 0.05, "they do not go to 2 s");
      const found = await violations(page);
      check(found.length === 0, `axe finds on a ${size}, ${colorScheme}: ${found.join("\n")}`);
      const wide = await page.evaluate(() => document.documentElement.scrollWidth - document.documentElement.clientWidth);
      check(wide <= 0, `on a ${size} the page is ${wide} pixels too wide`);
      if (!SHOTS) continue;
      mkdirSync(SHOTS, { recursive: true });
      await sleep(400);
      await page.screenshot({ path: path.join(SHOTS, `beside-${size}-${colorScheme}.png`), fullPage: true });
    }
  }
});

test("what stands beside is refused without the token, and is not there where nothing does", async () => {
  record();
  const guarded = await start("view", "soft.mcap", "--beside", "hard.mcap", "--listen", "127.0.0.1:0", "--token", "abcdefgh1");
  const bare = await fetch(guarded.url.replace(/\?.*/, ""));
  check(bare.status === 401, `without the token the page is answered with ${bare.status}`);
  const alone = await start("view", "soft.mcap", "--listen", "127.0.0.1:0");
  const page = await open(`${alone.url}beside`, { expected: [/beside\/live|404/] });
  await until(async () => (await page.textContent("#trouble")).includes("--beside B"), "the page does not say that there is no second recording");
});

await runAll();
