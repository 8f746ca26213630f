// Pause, scrub and back to live over the buffered frames; and the player of a file source.

import { blankFrame } from "./wire.js";
import { buttonById, byId, inputById, onClick, selectById, write } from "./dom.js";
import { clockText, durationText, fixed } from "./units.js";

const SPEEDS = [0.1, 0.25, 0.5, 1, 2, 4, 10];
const SEEKS_PER_SECOND = 10;

export class Playback {
  /**
   * @param {object} parts
   * @param {import("./view.js").View} parts.view
   * @param {import("./history.js").History} parts.history
   * @param {import("./requests.js").Requests} parts.requests
   * @param {(frame: Page.Frame) => void} parts.makeRoom on the scale, for a frame of before
   */
  constructor({ view, history, requests, makeRoom }) {
    this.view = view;
    this.history = history;
    this.requests = requests;
    this.makeRoom = makeRoom;
    this.index = 0;
    this.frame = blankFrame(0, 0);
    /** @type {Wire.Player | null} */
    this.player = null;
    this.seeking = false;
    this.scrub = inputById("scrub");
    this.marks = byId("scrub-events");
    onClick("pause-button", () => this.toggle());
    onClick("live-button", () => this.live());
    this.scrub.addEventListener("input", () => this.scrubbed());
    onClick("file-play-button", () => {
      this.live();
      requests.send({ do: this.player && this.player.playing ? "pause" : "play" });
    });
    this.startFile();
    view.on(["hello"], () => this.reset());
    view.on(["state"], () => this.takePlayer());
  }

  reset() {
    const { hello } = this.view.now;
    if (!hello) return;
    this.frame = blankFrame(hello.sensor.rows, hello.sensor.columns);
    this.player = null;
    byId("file-row").hidden = hello.source.type !== "file";
    this.write();
  }

  toggle() {
    if (this.view.now.paused) this.live();
    else this.pause();
  }

  pause() {
    const { buffer } = this.history;
    if (this.view.now.paused || buffer.length === 0) return;
    this.view.setPaused(true);
    this.show(buffer.length - 1);
  }

  live() {
    if (!this.view.now.paused) return;
    // The way back goes with the pause: whoever has the focus there keeps a place.
    if (document.activeElement === byId("live-button")) byId("pause-button").focus();
    this.view.setPaused(false);
    this.write();
  }

  /** @param {number} index of a buffered frame; 0 is the oldest */
  show(index) {
    const { buffer } = this.history;
    this.index = Math.max(0, Math.min(index, buffer.length - 1));
    buffer.read(this.index, this.frame);
    this.makeRoom(this.frame);
    this.view.show(this.frame);
    this.write();
  }

  /** @param {number} frames */
  step(frames) {
    if (this.view.now.paused) this.show(this.index + frames);
  }

  /** @param {number} host */
  goTo(host) {
    const { buffer } = this.history;
    if (buffer.length === 0) return;
    this.pause();
    this.show(buffer.indexAt(host));
  }

  /** @param {number} secs since the file's first frame */
  seek(secs) {
    this.live();
    this.requests.send({ do: "seek", secs });
  }

  scrubbed() {
    const { buffer } = this.history;
    if (buffer.length === 0) return;
    const { last } = this.history.reach;
    const back = Number(this.scrub.value);
    this.pause();
    this.show(buffer.indexAt(last + back + 1e-6));
  }

  // The time line: how far back it reaches, where the shown frame is, and the events on it.
  write() {
    const { buffer } = this.history;
    const { paused } = this.view.now;
    write("pause-button", paused ? "Resume" : "Pause");
    buttonById("live-button").disabled = !paused;
    byId("live-button").classList.toggle("on", !paused && buffer.length > 0);
    if (buffer.length === 0) {
      this.scrub.disabled = true;
      byId("scrub-time").textContent = "no frames yet";
      this.marks.textContent = "";
      return;
    }
    this.scrub.disabled = false;
    const { last, seconds: reach } = this.history.reach;
    const back = paused ? this.frame.host - last : 0;
    this.scrub.min = String(-reach);
    this.scrub.step = "any";
    this.scrub.value = String(back);
    this.scrub.style.setProperty("--share", `${(1 + back / reach) * 100}%`);
    const shown = paused ? this.frame.host : last;
    byId("scrub-time").textContent = `${fixed(back, 1)} s of ${fixed(reach, 0)} s, ${clockText(shown)}`;
    this.scrub.setAttribute("aria-valuetext", `${fixed(back, 1)} seconds from the newest frame`);
    this.writeEvents(last, reach);
  }

  /**
   * @param {number} last
   * @param {number} reach
   */
  writeEvents(last, reach) {
    const places = this.history.events.map((event) => 1 + (event.time - last) / reach).filter((share) => share >= 0 && share <= 1);
    while (this.marks.children.length > places.length) this.marks.lastChild?.remove();
    while (this.marks.children.length < places.length) this.marks.append(document.createElement("i"));
    places.forEach((share, i) => {
      /** @type {HTMLElement} */ (this.marks.children[i]).style.left = `${share * 100}%`;
    });
  }

  startFile() {
    const speed = selectById("file-speed");
    for (const factor of SPEEDS) speed.add(new Option(`${factor}×`, String(factor)));
    speed.value = "1";
    speed.addEventListener("change", () => this.requests.send({ do: "speed", factor: Number(speed.value) }));
    const seek = inputById("file-seek");
    /** @type {ReturnType<typeof setTimeout> | undefined} */
    let timer;
    const send = () => {
      clearTimeout(timer);
      timer = undefined;
      this.requests.send({ do: "seek", secs: Number(seek.value) });
    };
    seek.addEventListener("input", () => {
      this.seeking = true;
      // A paused view would not follow the seek.
      this.live();
      this.writePosition(Number(seek.value));
      if (!timer) timer = setTimeout(send, 1000 / SEEKS_PER_SECOND);
    });
    // At once, before the next state puts the slider back to where the file is.
    seek.addEventListener("change", () => {
      send();
      this.seeking = false;
    });
  }

  takePlayer() {
    const { state } = this.view.now;
    const player = state ? state.player : null;
    this.player = player;
    if (!player) return;
    const play = byId("file-play-button");
    play.textContent = player.playing ? "Pause file" : "Play file";
    const speed = selectById("file-speed");
    if (document.activeElement !== speed) {
      if (![...speed.options].some((option) => Number(option.value) === player.speed)) speed.add(new Option(`${player.speed}×`, String(player.speed)));
      speed.value = String(player.speed);
    }
    const seek = inputById("file-seek");
    seek.max = String(player.duration_secs);
    if (!this.seeking) {
      seek.value = String(player.position_secs);
      this.writePosition(player.position_secs);
    }
  }

  /** @param {number} seconds */
  writePosition(seconds) {
    const { duration_secs: duration, frame, frames } = this.player || { duration_secs: NaN, frame: 0, frames: 0 };
    byId("file-seek").style.setProperty("--share", `${(100 * seconds) / duration}%`);
    byId("file-position").textContent = `${durationText(seconds)} / ${durationText(duration)}, frame ${frame} of ${frames}`;
  }
}
