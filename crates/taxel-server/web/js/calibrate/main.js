// A guided calibration: joins what the server says with the task, the map, the chart and the beeps.

import { Banners, STALE_MS } from "../banners.js";
import { Connection } from "../connection.js";
import { byId, onClick, write } from "../dom.js";
import { FinishDialog } from "../finishdialog.js";
import { LiveMap } from "../livemap.js";
import { Sound } from "../sound.js";
import { startTheme, toggleTheme } from "../theme.js";
import { frameOf } from "../wire.js";
import { ErrorChart } from "./chart.js";
import { drawGuides } from "./guides.js";
import { Panel } from "./panel.js";
import { Task } from "./task.js";
import { announcement, canFinish, finishText, wordsOf } from "./words.js";

const CHECK_MS = 250;
/** What changes while something is moved is read out no more often than this, ms. */
const SAY_AGAIN_MS = 3000;

const BEEPS = /** @satisfies {Record<string, import("../sound.js").Beep>} */ ({
  taken: [[880, 0.12]],
  elsewhere: [[330, 0.14], [330, 0.14]],
  done: [[660, 0.12], [880, 0.2]],
});

/** @type {import("../banners.js").Subject} */
const BANNERS = {
  of: ({ calibration }) => calibration && { trouble: calibration.trouble, isAtWork: !["finishing", "done"].includes(calibration.phase) },
  parts: ["work", "side"],
  missing: { title: "No guided calibration here", text: "Begin one with “taxel calibrate --live”. This server shows its sensor in the live view." },
  lost: "Connection lost. The calibration goes on where it was; trying again.",
  connecting: "the calibration",
  noFrames: "No frames arrive: what presses at this moment is not known.",
};

class App {
  constructor() {
    /** @type {Wire.CalibrationSession | null} */
    this.session = null;
    /** @type {Wire.State | null} */
    this.state = null;
    /** @type {Page.Frame | null} */
    this.frame = null;
    this.frameAt = -Infinity;
    /** The map is to be drawn again. */
    this.isDue = false;
    this.phase = "";
    this.key = "";
    this.said = "";
    this.saidAt = -Infinity;
    startTheme(() => this.redraw());
    this.sound = new Sound();
    this.chart = new ErrorChart();
    this.panel = new Panel(this.chart);
    this.map = new LiveMap({ name: "sensor", unit: "g", least: 20, title: "Load of a taxel" });
    this.map.onLaidOut = () => this.redraw();
    this.task = new Task((step) => this.step(step), () => this.connection.token);
    this.finish = new FinishDialog(() => this.step({ is: "finish" }));
    this.connection = new Connection({
      onText: (message) => this.takeText(message),
      onFrame: (message) => this.takeFrame(message),
      onStatus: () => this.check(),
    });
    this.banners = new Banners(this.connection, BANNERS);
    onClick("theme-button", () => toggleTheme(() => this.redraw()));
    byId("finish").addEventListener("click", (event) => this.askToFinish(event.detail));
    this.connection.connect();
    setInterval(() => this.check(), CHECK_MS);
    const tick = () => {
      requestAnimationFrame(tick);
      this.draw();
    };
    requestAnimationFrame(tick);
  }

  /** @param {number} clicks one after the other */
  askToFinish(clicks) {
    const { session } = this;
    if (!session || !canFinish(session) || clicks > 1 || this.task.primary.isWaiting) return;
    if (session.is_enough) this.step({ is: "finish" });
    else this.finish.open(finishText(session));
  }

  /** @param {Wire.CalibrationStep} step */
  step(step) {
    const asked = this.key;
    const isSent = this.connection.send({ do: "calibrate", step }, (ok, text) => {
      this.task.primary.wait(false);
      if (!ok && step.is === "load") this.task.controls.showAsked(this.session?.asked ?? null);
      // What is refused because the phase is another one by now is no news.
      if (asked === this.key) this.task.say(ok ? "" : text || "The server refuses.");
    });
    if (isSent) this.task.primary.wait(true);
    else this.task.say("Not connected: nothing was sent.");
  }

  /** @param {Wire.Message} message */
  takeText(message) {
    if (message.kind === "hello") {
      this.map.reset(message);
      write("status-program", message.program);
      write("status-device", message.sensor.name);
      this.frame = null;
    } else if (message.kind === "state") this.takeState(message);
  }

  /** @param {Wire.State} state */
  takeState(state) {
    const before = this.session;
    this.state = state;
    this.session = state.calibration;
    this.map.takeBadLines(state.bad_lines);
    this.check();
    const { session } = this;
    if (!session) {
      document.body.dataset.phase = "none";
      this.panel.hide();
      this.finish.close();
      return;
    }
    this.task.show(session);
    this.panel.show(session);
    this.isDue = true;
    const { phase, asked, presses } = session;
    const key = JSON.stringify([phase, asked, presses.length]);
    if (key !== this.key) this.enter(session, before, key);
    else this.sayAgain(session);
  }

  /**
   * Another phase begins, or another press is asked for.
   * @param {Wire.CalibrationSession} session
   * @param {Wire.CalibrationSession | null} before
   * @param {string} key
   */
  enter(session, before, key) {
    const { phase, presses } = session;
    const isNewPhase = phase !== this.phase;
    this.key = key;
    this.phase = phase;
    document.body.dataset.phase = phase;
    this.task.say("");
    if (phase === "finishing" || phase === "done") this.finish.close();
    if (before && presses.length > before.presses.length) this.sound.play(BEEPS.taken);
    else if (before && isNewPhase && phase === "elsewhere") this.sound.play(BEEPS.elsewhere);
    else if (before && isNewPhase && phase === "done") this.sound.play(BEEPS.done);
    this.said = "";
    this.saidAt = -Infinity;
    this.sayAgain(session);
    document.title = `${wordsOf(session).title} · Taxel`;
    if (isNewPhase) this.task.takeFocus();
  }

  /** @param {Wire.CalibrationSession} session */
  sayAgain(session) {
    const text = announcement(session);
    const now = performance.now();
    if (text === this.said || now - this.saidAt < SAY_AGAIN_MS) return;
    this.said = text;
    this.saidAt = now;
    write("announce", text);
  }

  /** @param {ArrayBuffer} message */
  takeFrame(message) {
    const frame = frameOf(message);
    if (!frame) return;
    this.connection.got(frame.sequence);
    this.frame = frame;
    this.frameAt = performance.now();
    this.isDue = true;
  }

  // Several times a second: what nobody says.
  check() {
    this.connection.check();
    const age = performance.now() - this.frameAt;
    this.banners.show(this.state, age);
    document.body.classList.toggle("stale", age > STALE_MS || !this.connection.open);
    if (this.connection.status !== "open") this.task.primary.wait(false);
  }

  redraw() {
    this.isDue = true;
    this.chart.draw();
  }

  draw() {
    const { session, frame } = this;
    if (!this.isDue || !session || !frame) return;
    this.isDue = false;
    this.map.draw(frame, (g, placement, sensor) => drawGuides(session, g, placement, sensor));
  }
}

new App();
