// One player for two recordings: both at the same second, the shorter one waiting at its end.

import { buttonById, byId, inputById, selectById, write } from "../dom.js";
import { durationText } from "../units.js";

const SPEEDS = [0.1, 0.25, 0.5, 1, 2, 4, 10];
const SEEKS_PER_SECOND = 10;
/** For so long after a wish the two are held to it, ms; later on other pages may have wishes of their own. */
const HELD_MS = 3000;
/** Seconds by which a key moves. */
const STEP = 1;

export class Player {
  /** @param {import("./side.js").Side[]} sides */
  constructor(sides) {
    this.sides = sides;
    /** What was wished for last. @type {{ playing: boolean, secs: number, at: number } | null} */
    this.wish = null;
    this.isSeeking = false;
    this.seekBar = inputById("seek");
    this.speed = selectById("speed");
    for (const factor of SPEEDS) this.speed.add(new Option(`${factor}×`, String(factor)));
    this.speed.value = "1";
    this.speed.addEventListener("change", () => this.sides.forEach((side) => side.send({ do: "speed", factor: Number(this.speed.value) })));
    byId("play").addEventListener("click", () => this.toggle());
    this.listenToBar();
    document.addEventListener("keydown", (event) => this.key(event));
  }

  listenToBar() {
    /** @type {ReturnType<typeof setTimeout> | undefined} */
    let timer;
    const send = () => {
      clearTimeout(timer);
      timer = undefined;
      this.seek(Number(this.seekBar.value));
    };
    this.seekBar.addEventListener("input", () => {
      this.isSeeking = true;
      this.write();
      if (!timer) timer = setTimeout(send, 1000 / SEEKS_PER_SECOND);
    });
    this.seekBar.addEventListener("change", () => {
      send();
      this.isSeeking = false;
    });
  }

  /** @param {KeyboardEvent} event */
  key(event) {
    const { target } = event;
    if (event.ctrlKey || event.metaKey || event.altKey) return;
    if (target instanceof HTMLElement && target.closest("button, a, select, input")) return;
    if (event.key === " ") this.toggle();
    else if (event.key === "ArrowRight") this.seek(this.position + STEP);
    else if (event.key === "ArrowLeft") this.seek(this.position - STEP);
    else return;
    event.preventDefault();
  }

  get isPlaying() {
    return this.sides.some((side) => side.player !== null && side.player.playing);
  }

  /** Of the longer one. */
  get duration() {
    return Math.max(0, ...this.sides.map((side) => side.duration).filter(Number.isFinite));
  }

  /** Of the one that is further: the other has ended, or is a frame behind. */
  get position() {
    return Math.max(0, ...this.sides.map((side) => side.position).filter(Number.isFinite));
  }

  toggle() {
    if (this.isPlaying) this.pause();
    else this.play();
  }

  play() {
    const isOver = this.sides.every((side) => side.isAtEnd);
    const from = isOver ? 0 : this.position;
    this.wish = { playing: true, secs: from, at: performance.now() };
    for (const side of this.sides) {
      if (from >= side.duration) continue;
      side.send({ do: "seek", secs: from });
      side.send({ do: "play" });
    }
  }

  pause() {
    this.wish = { playing: false, secs: this.position, at: performance.now() };
    for (const side of this.sides) {
      if (side.player && side.player.playing) side.send({ do: "pause" });
    }
    this.goTo(this.wish.secs);
  }

  /** @param {number} secs */
  seek(secs) {
    const to = Math.min(Math.max(0, secs), this.duration);
    this.wish = { playing: this.isPlaying, secs: to, at: performance.now() };
    this.goTo(to);
  }

  /** @param {number} secs */
  goTo(secs) {
    for (const side of this.sides) {
      if (side.player) side.send({ do: "seek", secs: Math.min(secs, side.duration) });
    }
  }

  // One that had come to its end plays on when it is moved away from there, and one that was moved stays where it is: both are
  // held to what was wished for.
  hold() {
    const { wish } = this;
    if (!wish || performance.now() - wish.at > HELD_MS) return;
    for (const side of this.sides) {
      if (!side.player) continue;
      if (!wish.playing && side.player.playing) {
        side.send({ do: "pause" });
        side.send({ do: "seek", secs: Math.min(wish.secs, side.duration) });
      } else if (wish.playing && side.isHeld && !side.isAtEnd) side.send({ do: "play" });
    }
  }

  write() {
    const { duration, isPlaying } = this;
    buttonById("play").disabled = !(duration > 0);
    write("play", isPlaying ? "Pause" : "Play");
    this.seekBar.max = String(duration);
    if (!this.isSeeking) this.seekBar.value = String(this.position);
    const at = Number(this.seekBar.value);
    this.seekBar.style.setProperty("--share", `${duration > 0 ? (100 * at) / duration : 0}%`);
    const text = `${durationText(at)} / ${durationText(duration)}`;
    write("position", text);
    this.seekBar.setAttribute("aria-valuetext", text);
    const told = this.sides[0].player;
    if (told && document.activeElement !== this.speed && [...this.speed.options].some((option) => Number(option.value) === told.speed)) this.speed.value = String(told.speed);
  }
}
