// A grip session: joins what the server says with the task, the chart, the map and the beeps.

import { Banners, STALE_MS } from "../banners.js";
import { Connection } from "../connection.js";
import { byId, onClick, write } from "../dom.js";
import { FinishDialog } from "../finishdialog.js";
import { LiveMap } from "../livemap.js";
import { Sound } from "../sound.js";
import { capital } from "../text.js";
import { startTheme, toggleTheme } from "../theme.js";
import { frameOf } from "../wire.js";
import { HoldChart } from "./chart.js";
import { Curve } from "./curve.js";
import { Deadline } from "./deadline.js";
import { RepeatDialog } from "./dialogs.js";
import { SteadyForce, bothForces, countOf, forceOf, kilograms, wholeNewtons } from "./numbers.js";
import { Panel } from "./panel.js";
import { Results } from "./results.js";
import { Ring } from "./ring.js";
import { Task } from "./task.js";
import { announcement, finishText, trialText } from "./words.js";

const CHECK_MS = 250;
/** A rest that ends by itself has no more than this left, s. */
const JUST_OVER_SECS = 1.5;

/** For each second of the countdown, for the beginning and the end of a hold, for the end of a rest. */
const BEEPS = /** @satisfies {Record<string, import("../sound.js").Beep>} */ ({
  second: [[660, 0.09]],
  begin: [[1100, 0.35]],
  end: [[880, 0.16], [550, 0.32]],
  rested: [[660, 0.12], [880, 0.2]],
});

/** @type {import("../banners.js").Subject} */
const BANNERS = {
  of: ({ grip }) => grip && { trouble: grip.trouble, isAtWork: !["finishing", "done"].includes(grip.phase) },
  parts: ["work", "side", "steps-nav"],
  missing: { title: "This is not a grip session", text: "Start one with “taxel grip”. This server shows its sensor in the live view." },
  lost: "Connection lost. The session goes on where it was; trying again.",
  connecting: "the session",
  noFrames: "No frames arrive: the force at this moment is not known.",
};

class App {
  constructor() {
    /** @type {Wire.State | null} */
    this.state = null;
    /** @type {Page.Frame | null} */
    this.frame = null;
    this.frameAt = -Infinity;
    /** That of the largest force of a hold. @type {Page.Frame | null} */
    this.strongest = null;
    /** A new frame is to be drawn; and the chart, which changes in a hold only. */
    this.isDue = false;
    this.isChartDue = false;
    this.isStale = true;
    this.phaseKey = "";
    this.phase = "";
    this.counted = NaN;
    this.deadline = new Deadline();
    this.force = new SteadyForce();
    this.curve = new Curve();
    this.sound = new Sound();
    this.panel = new Panel();
    this.ring = new Ring();
    this.map = new LiveMap({ name: "hand", unit: "kPa", least: 2, title: "Pressure" });
    this.map.onLaidOut = () => this.redraw();
    this.task = new Task((action) => this.act(action));
    this.repeat = new RepeatDialog((reason) => this.step({ is: "repeat", reason }));
    this.finish = new FinishDialog(() => this.step({ is: "finish" }));
    startTheme(() => this.redraw());
    this.chart = new HoldChart(this.curve);
    this.connection = new Connection({
      onText: (message) => this.takeText(message),
      onFrame: (message) => this.takeFrame(message),
      onStatus: () => this.check(),
    });
    this.banners = new Banners(this.connection, BANNERS);
    this.results = new Results(() => this.connection.token);
    this.startControls();
    this.connection.connect();
    setInterval(() => this.check(), CHECK_MS);
    const tick = () => {
      requestAnimationFrame(tick);
      this.draw(performance.now());
    };
    requestAnimationFrame(tick);
  }

  get grip() {
    return this.state?.grip ?? null;
  }

  startControls() {
    onClick("theme-button", () => toggleTheme(() => this.redraw()));
    onClick("finish", () => this.act("finish"));
    document.addEventListener("keydown", (event) => {
      const runs = this.phase === "countdown" || this.phase === "hold";
      if (event.key !== "Escape" || !runs || document.querySelector("dialog[open]")) return;
      event.preventDefault();
      this.act("cancel");
    });
  }

  /** @param {string} action */
  act(action) {
    if (action === "begin") {
      const who = this.task.person();
      if (who) this.step({ is: "begin", person: who.person, ...(who.note ? { note: who.note } : {}) });
    } else if (action === "repeat") this.repeat.open();
    else if (action === "finish" && this.grip) this.finish.open(finishText(this.grip));
    else if (action === "zero" || action === "zero-again") this.step({ is: "zero" });
    else if (action === "zero-anyway") this.step({ is: "zero", force: true });
    else if (action === "start" || action === "cancel" || action === "accept" || action === "skip-rest") this.step({ is: action });
  }

  /** @param {Wire.GripStep} step */
  step(step) {
    const asked = this.phaseKey;
    const isSent = this.connection.send({ do: "grip", step }, (ok, text) => {
      this.task.primary.wait(false);
      // What is refused because the phase is another one by now is no news.
      if (asked === this.phaseKey) this.task.say(ok ? "" : text || "The server refuses.", !ok && step.is === "zero");
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
    this.state = state;
    this.map.takeBadLines(state.bad_lines);
    const { grip } = state;
    this.check();
    if (!grip) {
      document.body.dataset.phase = "none";
      return;
    }
    const trial = grip.trial === null ? undefined : grip.trials[grip.trial];
    const key = `${grip.phase} ${grip.trial} ${trial?.repeats}`;
    const isNew = key !== this.phaseKey;
    const left = this.deadline.remaining(performance.now());
    this.deadline.take(key, grip.remaining_secs, grip.lasts_secs, performance.now());
    this.task.show(grip);
    this.panel.show(grip);
    this.results.show(grip);
    if (isNew) this.enter(grip, key, left);
  }

  /**
   * A phase begins.
   * @param {Wire.GripSession} grip
   * @param {string} key
   * @param {number} left what the phase before had left, s; NaN where it had no end
   */
  enter(grip, key, left) {
    const { phase } = grip;
    const before = this.phase;
    this.phaseKey = key;
    this.phase = phase;
    document.body.dataset.phase = phase;
    this.counted = NaN;
    this.task.say("");
    this.force.forget();
    if (phase !== "review") this.repeat.close();
    if (phase === "finishing" || phase === "done") this.finish.close();
    if (phase === "ready" || phase === "countdown" || phase === "hold" || this.curve.isEmpty) this.beginCurve(grip);
    byId("curve-empty").hidden = !(["measuring", "review", "rest"].includes(phase) && this.curve.isEmpty);
    if (phase === "hold") this.sound.play(BEEPS.begin);
    if (before === "hold" && (phase === "measuring" || phase === "review")) this.sound.play(BEEPS.end);
    if (before === "rest" && phase === "ready" && left < JUST_OVER_SECS) this.sound.play(BEEPS.rested);
    write("announce", announcement(grip));
    document.title = `${trialText(grip) || "Grip session"} · Taxel`;
    this.task.takeFocus();
    this.redraw();
  }

  /** @param {Wire.GripSession} grip */
  beginCurve(grip) {
    this.curve.clear();
    this.strongest = null;
    this.chart.begin(grip.protocol, grip.trials);
    const trial = trialText(grip);
    write("curve-title", trial ? `Force against time – ${trial}` : "Force against time");
  }

  /** @param {ArrayBuffer} message */
  takeFrame(message) {
    const frame = frameOf(message);
    if (!frame) return;
    this.connection.got(frame.sequence);
    const now = performance.now();
    this.frame = frame;
    this.frameAt = now;
    this.isDue = true;
    const { grip } = this;
    if (!grip) return;
    const { newtons, name } = forceOf(frame, grip.phase === "zero" ? "total normal force" : grip.protocol.force);
    this.force.take(newtons, now);
    write("force-label", capital(name));
    if (grip.phase !== "hold") return;
    const time = this.curve.timeOf(frame.host, (now - this.deadline.begun) / 1000);
    if (time > this.chart.secs) return;
    if (!(newtons <= this.curve.max)) this.strongest = frame;
    this.curve.push(time, newtons);
    this.isChartDue = true;
  }

  // Several times a second: what nobody says.
  check() {
    this.connection.check();
    const age = performance.now() - this.frameAt;
    this.banners.show(this.state, age);
    document.body.classList.toggle("stale", age > STALE_MS || !this.connection.open);
    if (this.connection.status !== "open") this.task.primary.wait(false);
    this.chart.describe();
  }

  redraw() {
    this.isDue = true;
    this.isChartDue = true;
  }

  /** @param {number} now ms */
  draw(now) {
    const { grip } = this;
    if (!grip) return;
    this.ring.draw(this.deadline, now);
    this.count(now);
    if (this.isChartDue) this.chart.draw();
    this.isChartDue = false;
    const isStale = now - this.frameAt >= STALE_MS;
    if (!this.isDue && isStale === this.isStale) return;
    this.isDue = false;
    this.isStale = isStale;
    const newtons = isStale ? NaN : this.force.shown;
    write("force-kg", kilograms(newtons));
    write("force-n", wholeNewtons(newtons));
    write("largest", this.curve.max >= 0 ? bothForces(this.curve.max) : "");
    // The hand has let go by then: what it did is what is judged.
    const past = ["measuring", "review", "rest"].includes(this.phase) ? this.strongest : null;
    write("hand-title", past ? "Hand at the largest force" : "Hand on the handle");
    const frame = past ?? this.frame;
    if (frame) this.map.draw(frame);
  }

  /** @param {number} now ms */
  count(now) {
    if (this.phase !== "countdown" || !this.connection.open) return;
    const count = countOf(this.deadline.remaining(now));
    if (count === this.counted || !Number.isFinite(count)) return;
    this.counted = count;
    if (count > 0) this.sound.play(BEEPS.second);
  }
}

new App();
