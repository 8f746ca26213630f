// Two recordings side by side: one scale of colours, one axis of time, one player.

import { colourTable } from "../colour.js";
import { byId, onClick, write } from "../dom.js";
import { MAP_COLOURS } from "../livemap.js";
import { Scale } from "../scale.js";
import { startTheme, theme, toggleTheme } from "../theme.js";
import { TimeChart } from "../timechart.js";
import { significant } from "../units.js";
import { together } from "./curves.js";
import { Numbers } from "./numbers.js";
import { Player } from "./player.js";
import { Side } from "./side.js";

const CHECK_MS = 250;
const STOPS = 16;

class App {
  constructor() {
    startTheme(() => this.redraw());
    this.scale = new Scale();
    this.isDue = false;
    /** What is drawn of the whole of both. @type {unknown[]} */
    this.drawn = [];
    const line = () => [{ colour: () => theme.comp }, { colour: () => theme.raw, dash: [6, 4] }];
    const options = { onClick: (/** @type {number} */ secs) => this.player.seek(secs) };
    this.charts = {
      total: new TimeChart(byId("chart-total"), line(), options),
      peak: new TimeChart(byId("chart-peak"), line(), options),
    };
    const onNews = () => { this.isDue = true; };
    this.sides = [
      new Side({ name: "a", path: "/live", scale: this.scale, onNews }),
      new Side({ name: "b", path: "/beside/live", scale: this.scale, onNews }),
    ];
    this.player = new Player(this.sides);
    this.numbers = new Numbers();
    onClick("theme-button", () => toggleTheme(() => this.redraw()));
    setInterval(() => this.check(), CHECK_MS);
    const tick = () => {
      requestAnimationFrame(tick);
      if (this.isDue) this.draw();
    };
    requestAnimationFrame(tick);
  }

  redraw() {
    this.drawn = [];
    this.isDue = true;
  }

  // Several times a second: what nobody says.
  check() {
    for (const side of this.sides) side.connection.check();
    this.player.hold();
    this.tell();
    // What is written less often than frames come is written of the last one too.
    this.isDue = true;
    this.drawCurves();
  }

  // What is wrong, above everything.
  tell() {
    const [a, b] = this.sides.map((side) => side.connection);
    const words = a.status === "refused" ? "A token is needed: open the address that the program printed, with its ?token=."
      : a.everOpen && !a.open ? "Connection lost; trying again."
        : a.open && !b.everOpen && b.status === "waiting" ? "There is no second recording: “taxel view A --beside B” shows two."
          : "";
    write("trouble", words);
    byId("trouble").hidden = words === "";
  }

  draw() {
    this.isDue = false;
    // Colours reach as far as the highest pressure of either, from the first frame on.
    this.scale.makeRoom(Math.max(...this.sides.map((side) => side.highest)));
    for (const side of this.sides) side.draw();
    const newtons = this.sides.every((side) => side.shown.newtons);
    const table = colourTable(MAP_COLOURS);
    const stops = Array.from({ length: STOPS + 1 }, (_, i) => table.css(i / STOPS));
    byId("scale-colours").style.background = `linear-gradient(to right, ${stops.join(", ")})`;
    write("scale-top", `${significant(this.scale.top)} ${newtons ? "kPa" : "µS"}`);
    this.player.write();
    this.numbers.write(this.sides);
    for (const chart of Object.values(this.charts)) chart.moveTo(this.player.position);
  }

  // The whole of both, when the server has found it.
  drawCurves() {
    const curves = this.sides.map((side) => side.curve);
    const isThere = curves.some((curve) => curve !== null);
    byId("charts-empty").hidden = isThere;
    // Conductances have no curves.
    byId("charts").hidden = this.sides.every(({ hello }) => hello !== null && !hello.sensor.has_load_law);
    const span = this.player.duration;
    const key = [...curves, span, theme.version];
    if (!isThere || !(span > 0) || key.every((value, i) => value === this.drawn[i])) return;
    this.drawn = key;
    /** @param {"total_newtons" | "peak_kilopascals"} name */
    const both = (name) => together(curves.map((curve) => (curve ? { secs: curve.secs, values: curve[name] } : { secs: [], values: [] })));
    const shown = { total: both("total_newtons"), peak: both("peak_kilopascals") };
    for (const name of /** @type {("total" | "peak")[]} */ (Object.keys(shown))) {
      const { secs, columns } = shown[name];
      const chart = this.charts[name];
      chart.data = [secs.map((at) => at - span), ...columns];
      chart.update(span, span, [], this.player.position, true);
      const [title, unit] = name === "total" ? ["Total force", "N"] : ["Highest pressure", "kPa"];
      chart.describe(title, [unit, unit], ["A", "B"]);
    }
  }
}

new App();
