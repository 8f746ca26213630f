// The status line, the device's state, and the recording.

import { fixed, bytesText, durationText, clockText } from "./units.js";
import { byId, inputById, onClick, write } from "./dom.js";
import { isTared } from "./wire.js";

/** @type {("frames" | "lost" | "corrupt" | "repeated" | "skipped")[]} */
const TALLIES = ["frames", "lost", "corrupt", "repeated", "skipped"];

const grouped = new Intl.NumberFormat("en-US");

export class Status {
  /**
   * @param {import("./view.js").View} view
   * @param {{ mean: number }} timing how long a frame takes to draw, ms
   */
  constructor(view, timing) {
    this.view = view;
    this.timing = timing;
    /** @type {string | null} the failure of a recording that the user has seen */
    this.dismissed = null;
    onClick("record-alarm-dismiss", () => {
      const { state } = view.now;
      this.dismissed = state && state.recording ? state.recording.error : null;
      byId("record-alarm").hidden = true;
      byId("record-button").focus();
    });
    view.on(["hello"], () => this.takeHello());
    view.on(["state"], () => this.takeState());
    view.on(["connection"], () => this.writeDevice());
  }

  takeHello() {
    const { hello } = this.view.now;
    if (!hello) return;
    const { sensor, source } = hello;
    byId("sensor-name").textContent = sensor.name;
    byId("source-address").textContent = `${source.address}, ${sensor.rows} × ${sensor.columns}`;
    byId("source-address").title = source.address;
    byId("status-program").textContent = hello.program;
    byId("status-calibration").textContent = sensor.calibration ?? "";
    byId("status-calibration").hidden = !sensor.calibration;
    document.title = `${sensor.name} – Taxel`;
  }

  takeState() {
    const { state } = this.view.now;
    this.writeDevice();
    if (!state) return;
    for (const name of TALLIES) {
      write(`status-${name}`, grouped.format(state[name]));
      if (name !== "frames") byId(`status-${name}`).classList.toggle("bad", state[name] > 0 && (name === "lost" || name === "corrupt"));
    }
    const { median, p99 } = state.latency_ms;
    write("status-latency", `${milliseconds(median)} / ${milliseconds(p99)} ms`);
    write("status-clients", String(state.clients));
    const { tare } = state;
    write("status-tare", tare.on ? `on since ${clockText(tare.host_secs).slice(0, 8)}` : "off");
    byId("untare-button").hidden = !(tare.on);
    this.writeRecording(state.recording);
  }

  writeDevice() {
    const { state, connection } = this.view.now;
    const chip = byId("device-chip");
    if (connection !== "open" || !state) {
      chip.dataset.state = connection === "open" ? "waiting" : "lost";
      write("device-text", connection === "open" ? "connected" : connection === "connecting" ? "connecting" : "offline");
      return;
    }
    chip.dataset.state = state.device.state;
    chip.title = state.device.text || "";
    write("device-text", state.device.state);
  }

  /** @param {Wire.Recording | null} recording */
  writeRecording(recording) {
    const error = recording ? recording.error : null;
    const running = recording !== null && !error;
    this.swapRecording(running);
    document.body.classList.toggle("recording", running);
    if (running) {
      write("record-info", `${durationText(recording.secs)}, ${bytesText(recording.bytes)}`);
      byId("record-info").title = `${recording.name}, ${grouped.format(recording.frames)} frames`;
      this.dismissed = null;
      inputById("record-name").value = "";
    }
    byId("record-alarm").hidden = !error || error === this.dismissed;
    if (recording && error) write("record-alarm-text", `${recording.name}: ${error}`);
  }

  /**
   * The button that ends a recording comes for the one that begins it, with the focus if that had it.
   * @param {boolean} running
   */
  swapRecording(running) {
    const [there, gone] = [byId(running ? "record-running" : "record-idle"), byId(running ? "record-idle" : "record-running")];
    const hadFocus = gone.contains(document.activeElement);
    there.hidden = false;
    if (hadFocus) byId(running ? "stop-button" : "record-button").focus();
    gone.hidden = true;
  }

  // Several times a second; what depends on the page's own clock.
  update() {
    const { live, state, frameAt } = this.view.now;
    this.writeDevice();
    if (!live) return;
    write("status-fps", this.view.isOpen && state ? fixed(state.frames_per_second, 1) : "–");
    const since = performance.now() - frameAt;
    const age = (Number.isFinite(live.age) ? live.age : 0) + (since > 250 ? since : 0);
    write("status-age", age >= 1000 ? `${fixed(age / 1000, 1)} s` : `${fixed(age, 1)} ms`);
    byId("status-age").classList.toggle("bad", age >= 1000);
    write("status-draw", `${fixed(this.timing.mean, 1)} ms`);
    if (isTared(live) && !state) write("status-tare", "on");
  }
}

/** @param {number} value */
const milliseconds = (value) => (Number.isFinite(value) ? fixed(value, 1) : "–");
