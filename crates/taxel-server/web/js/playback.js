// Pause, scrub and back to live over the buffered frames; and the player of a file source.

import { blankFrame } from "./wire.js";
import { clockText, durationText, fixed } from "./units.js";

const SPEEDS = [0.1, 0.25, 0.5, 1, 2, 4, 10];
const SEEKS_PER_SECOND = 10;
const MOST_EVENTS = 200;

const byId = (id) => document.getElementById(id);

export class Playback {
  constructor(app) {
    this.app = app;
    this.index = 0;
    this.events = [];
    this.frame = null;
    this.player = null;
    this.seeking = false;
    this.scrub = byId("scrub");
    this.marks = byId("scrub-events");
    byId("pause-button").addEventListener("click", () => this.toggle());
    byId("live-button").addEventListener("click", () => this.live());
    this.scrub.addEventListener("input", () => this.scrubbed());
    byId("file-play-button").addEventListener("click", () => {
      this.live();
      app.command({ do: this.player && this.player.playing ? "pause" : "play" });
    });
    this.startFile();
  }

  reset() {
    const { rows, columns } = this.app.sensor;
    this.frame = blankFrame(rows, columns);
    this.events = [];
    this.player = null;
    byId("file-row").hidden = this.app.source.type !== "file";
    this.write();
  }

  addEvent(event) {
    this.events.push({ time: event.host_secs, text: event.text });
    if (this.events.length > MOST_EVENTS) this.events.shift();
  }

  toggle() {
    if (this.app.paused) this.live();
    else this.pause();
  }

  pause() {
    const { app } = this;
    if (app.paused || app.buffer.length === 0) return;
    app.setPaused(true);
    this.show(app.buffer.length - 1);
  }

  live() {
    if (!this.app.paused) return;
    this.app.setPaused(false);
    this.write();
  }

  // Shows a buffered frame; 0 is the oldest.
  show(index) {
    const { app } = this;
    this.index = Math.max(0, Math.min(index, app.buffer.length - 1));
    app.buffer.read(this.index, this.frame);
    app.stage.makeRoom(this.frame);
    app.show(this.frame);
    this.write();
  }

  step(frames) {
    if (this.app.paused) this.show(this.index + frames);
  }

  goTo(host) {
    if (this.app.buffer.length === 0) return;
    this.pause();
    this.show(this.app.buffer.indexAt(host));
  }

  scrubbed() {
    const { buffer } = this.app;
    if (buffer.length === 0) return;
    const last = buffer.at(buffer.length - 1).host;
    const back = Number(this.scrub.value);
    this.pause();
    this.show(buffer.indexAt(last + back + 1e-6));
  }

  // The time line: how far back it reaches, where the shown frame is, and the events on it.
  write() {
    const { app } = this;
    const { buffer, paused } = app;
    byId("pause-button").textContent = paused ? "Resume" : "Pause";
    byId("pause-button").setAttribute("aria-pressed", String(paused));
    byId("live-button").disabled = !paused;
    byId("live-button").classList.toggle("on", !paused && buffer.length > 0);
    if (buffer.length === 0) {
      this.scrub.disabled = true;
      byId("scrub-time").textContent = "no frames yet";
      this.marks.textContent = "";
      return;
    }
    this.scrub.disabled = false;
    const last = buffer.at(buffer.length - 1).host;
    const reach = Math.max(last - buffer.at(0).host, 1e-3);
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

  writeEvents(last, reach) {
    const places = this.events.map((event) => 1 + (event.time - last) / reach).filter((share) => share >= 0 && share <= 1);
    while (this.marks.children.length > places.length) this.marks.lastChild.remove();
    while (this.marks.children.length < places.length) this.marks.append(document.createElement("i"));
    places.forEach((share, i) => {
      this.marks.children[i].style.left = `${share * 100}%`;
    });
  }

  startFile() {
    const speed = byId("file-speed");
    for (const factor of SPEEDS) speed.add(new Option(`${factor}×`, String(factor)));
    speed.value = "1";
    speed.addEventListener("change", () => this.app.command({ do: "speed", factor: Number(speed.value) }));
    const seek = byId("file-seek");
    let timer = 0;
    const send = () => {
      clearTimeout(timer);
      timer = 0;
      this.app.command({ do: "seek", secs: Number(seek.value) });
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

  takePlayer(player) {
    this.player = player;
    if (!player) return;
    const play = byId("file-play-button");
    play.textContent = player.playing ? "Pause file" : "Play file";
    const speed = byId("file-speed");
    if (document.activeElement !== speed) {
      if (![...speed.options].some((option) => Number(option.value) === player.speed)) speed.add(new Option(`${player.speed}×`, String(player.speed)));
      speed.value = String(player.speed);
    }
    const seek = byId("file-seek");
    seek.max = String(player.duration_secs);
    if (!this.seeking) {
      seek.value = String(player.position_secs);
      this.writePosition(player.position_secs);
    }
  }

  writePosition(seconds) {
    const { duration_secs: duration, frame, frames } = this.player || { duration_secs: NaN, frame: 0, frames: 0 };
    byId("file-seek").style.setProperty("--share", `${(100 * seconds) / duration}%`);
    byId("file-position").textContent = `${durationText(seconds)} / ${durationText(duration)}, frame ${frame} of ${frames}`;
  }
}
