// One of two recordings: its connection, its map, and what the server says of it.

import { Connection } from "../connection.js";
import { byId, write } from "../dom.js";
import { Figures } from "../figures.js";
import { LiveMap } from "../livemap.js";
import { frameOf, isNewtons } from "../wire.js";

/** A recording whose last frame is shown is at its end, s. */
const AT_END = 1e-6;

export class Side {
  /**
   * @param {object} parts
   * @param {"a" | "b"} parts.name
   * @param {string} parts.path where its frames come from
   * @param {import("../scale.js").Scale} parts.scale of both
   * @param {() => void} parts.onNews something that is shown has changed
   */
  constructor({ name, path, scale, onNews }) {
    this.name = name;
    this.onNews = onNews;
    this.map = new LiveMap({ name, unit: "kPa", least: 1, title: "Pressure", scale });
    this.map.onLaidOut = onNews;
    /** @type {Wire.Hello | null} */
    this.hello = null;
    /** @type {Wire.State | null} */
    this.state = null;
    /** @type {Wire.Curve | null} */
    this.curve = null;
    /** @type {Page.Frame | null} */
    this.frame = null;
    /** The highest conductance of the frame shown, where there are no loads. */
    this.siemens = NaN;
    const shown = { paused: false, newtons: true, frameAt: -Infinity };
    this.shown = shown;
    this.figures = new Figures({ now: shown, on: () => {} });
    this.connection = new Connection({
      onText: (message) => this.takeText(message),
      onFrame: (message) => this.takeFrame(message),
      onStatus: onNews,
    }, path);
    this.connection.connect();
  }

  /** The player of the recording, as it was told last. @type {Wire.Player | null} */
  get player() {
    return this.state ? this.state.player : null;
  }

  get duration() {
    return this.player ? this.player.duration_secs : NaN;
  }

  /** Of the frame shown, else as it was told last. */
  get position() {
    const told = this.player ? this.player.position_secs : NaN;
    return this.frame && Number.isFinite(this.frame.device) ? this.frame.device : told;
  }

  // The server may have told that it has ended before its last frame is here.
  get isAtEnd() {
    const hasEnded = this.state !== null && this.state.device.state === "ended";
    return hasEnded || this.position >= this.duration - AT_END;
  }

  /** Held by somebody; one that has ended is not: to be played would begin it anew. */
  get isHeld() {
    return this.state !== null && this.state.device.state === "paused";
  }

  /** @param {Wire.Request} request */
  send(request) {
    this.connection.send(request);
  }

  /** @param {Wire.Message} message */
  takeText(message) {
    if (message.kind === "hello") this.takeHello(message);
    else if (message.kind === "state") this.takeState(message);
    else if (message.kind === "curve") this.curve = message;
    else if (message.kind === "details") this.figures.take(message);
    this.onNews();
  }

  /** @param {Wire.Hello} hello */
  takeHello(hello) {
    this.hello = hello;
    this.curve = null;
    this.frame = null;
    this.map.reset(hello);
    const { address } = hello.source;
    write(`${this.name}-file`, address.slice(address.lastIndexOf("/") + 1).replace(/^file:/, ""));
    write(`${this.name}-sensor`, hello.sensor.name);
    byId(`${this.name}-file`).title = address;
    this.send({ do: "watch", taxels: [], figures: true });
  }

  /** @param {Wire.State} state */
  takeState(state) {
    this.state = state;
    this.map.takeBadLines(state.bad_lines);
    const { state: how, text } = state.device;
    write(`status-${this.name}`, `${this.name.toUpperCase()}: ${how === "paused" ? text.replace(/^playing/, "paused:") : text}`);
  }

  /** @param {ArrayBuffer} message */
  takeFrame(message) {
    const frame = frameOf(message);
    if (!frame) return;
    this.connection.got(frame.sequence);
    const newtons = isNewtons(frame);
    this.siemens = newtons ? NaN : frame.compensated.reduce((most, value) => Math.max(most, value), 0);
    if (!newtons) frame.total = frame.peak = NaN;
    this.frame = frame;
    this.shown.newtons = newtons;
    this.shown.frameAt = performance.now();
    this.onNews();
  }

  /** The highest pressure of the whole recording, kPa; of the frames that came so far where that is not known. */
  get highest() {
    const known = this.curve ? this.curve.peak_kilopascals.filter((value) => value !== null) : [];
    return known.reduce((highest, value) => Math.max(highest, value), 0);
  }

  draw() {
    if (this.frame) this.map.draw(this.frame);
    byId(`${this.name}-tile`).classList.toggle("ended", this.isAtEnd && this.duration > 0);
  }
}
