// Beeps, for those who look at the sensor and not at the screen.

import { buttonById } from "./dom.js";

const KEY = "taxel.muted";
const LOUDNESS = 0.25;
const FADE_SECS = 0.012;

/** Hertz and seconds, one after the other. @typedef {[number, number][]} Beep */

/** Who turns the sound on hears that it is on. @type {Beep} */
const ON = [[660, 0.09]];

export class Sound {
  constructor() {
    /** @type {AudioContext | null} */
    this.context = null;
    this.muted = read();
    this.button = buttonById("mute");
    this.button.addEventListener("click", () => this.mute(!this.muted));
    // Browsers let a page sound only after the user did something on it.
    const wake = () => this.wake();
    for (const event of ["pointerdown", "keydown"]) document.addEventListener(event, wake, true);
    this.show();
  }

  wake() {
    if (this.muted || typeof AudioContext === "undefined") return;
    this.context ??= new AudioContext();
    if (this.context.state === "suspended") this.context.resume().catch(() => {});
  }

  /** @param {boolean} muted */
  mute(muted) {
    this.muted = muted;
    try {
      localStorage.setItem(KEY, muted ? "1" : "0");
    } catch (_) {
      // The choice then lasts as long as the page.
    }
    this.show();
    this.wake();
    this.play(ON);
  }

  show() {
    this.button.setAttribute("aria-pressed", String(this.muted));
  }

  /** @param {Beep} tones */
  play(tones) {
    const { context } = this;
    if (this.muted || !context || context.state !== "running") return;
    let at = context.currentTime;
    for (const [hertz, secs] of tones) {
      beep(context, hertz, at, secs);
      at += secs + 0.03;
    }
  }
}

/**
 * @param {AudioContext} context
 * @param {number} hertz
 * @param {number} at
 * @param {number} secs
 */
function beep(context, hertz, at, secs) {
  const tone = context.createOscillator();
  const gain = context.createGain();
  tone.frequency.value = hertz;
  // A tone that begins or ends at once clicks.
  gain.gain.setValueAtTime(0, at);
  gain.gain.linearRampToValueAtTime(LOUDNESS, at + FADE_SECS);
  gain.gain.setValueAtTime(LOUDNESS, at + secs - FADE_SECS);
  gain.gain.linearRampToValueAtTime(0, at + secs);
  tone.connect(gain).connect(context.destination);
  tone.start(at);
  tone.stop(at + secs);
}

function read() {
  try {
    return localStorage.getItem(KEY) === "1";
  } catch (_) {
    return false;
  }
}
