// The status line, the device's state, and the recording.

import { fixed, bytesText, durationText, clockText } from "./units.js";
import { isTared } from "./wire.js";

const byId = (id) => document.getElementById(id);
const STATES = { live: "live", waiting: "waiting", lost: "lost", ended: "ended", paused: "paused" };
const grouped = new Intl.NumberFormat("en-US");

export class Status {
  constructor(app) {
    this.app = app;
    this.dismissed = null;
    byId("record-alarm-dismiss").addEventListener("click", () => {
      this.dismissed = app.state && app.state.recording ? app.state.recording.error : null;
      byId("record-alarm").hidden = true;
    });
  }

  takeHello() {
    const { sensor, source, hello } = this.app;
    byId("sensor-name").textContent = sensor.name;
    byId("source-address").textContent = `${source.address}, ${sensor.rows} × ${sensor.columns}`;
    byId("source-address").title = source.address;
    byId("status-program").textContent = hello.program;
    document.title = `${sensor.name} – Taxel`;
  }

  takeState() {
    const { state } = this.app;
    this.writeDevice();
    for (const name of ["frames", "lost", "corrupt", "repeated", "skipped"]) {
      write(`status-${name}`, grouped.format(state[name]));
      if (name !== "frames") byId(`status-${name}`).classList.toggle("bad", state[name] > 0 && (name === "lost" || name === "corrupt"));
    }
    const { median, p99 } = state.latency_ms || {};
    write("status-latency", `${milliseconds(median)} / ${milliseconds(p99)} ms`);
    write("status-clients", String(state.clients));
    const { tare } = state;
    write("status-tare", tare && tare.on ? `on${Number.isFinite(tare.host_secs) ? ` since ${clockText(tare.host_secs).slice(0, 8)}` : ""}` : "off");
    byId("untare-button").hidden = !(tare && tare.on);
    this.writeRecording(state.recording);
  }

  writeDevice() {
    const { state, connection } = this.app;
    const chip = byId("device-chip");
    if (!connection.open || !state) {
      chip.dataset.state = connection.open ? "waiting" : "lost";
      write("device-text", connection.open ? "connected" : connection.status === "connecting" ? "connecting" : "offline");
      return;
    }
    const name = STATES[state.device.state] || state.device.state;
    chip.dataset.state = state.device.state;
    chip.title = state.device.text || "";
    write("device-text", name);
  }

  writeRecording(recording) {
    const error = recording ? recording.error : null;
    const running = Boolean(recording) && !error;
    byId("record-idle").hidden = running;
    byId("record-running").hidden = !running;
    document.body.classList.toggle("recording", running);
    if (running) {
      write("record-info", `${durationText(recording.secs)}, ${bytesText(recording.bytes)}`);
      byId("record-info").title = `${recording.name}, ${grouped.format(recording.frames)} frames`;
      this.dismissed = null;
      byId("record-name").value = "";
    }
    byId("record-alarm").hidden = !error || error === this.dismissed;
    if (error) write("record-alarm-text", `${recording.name}: ${error}`);
  }

  // Several times a second; what depends on the page's own clock.
  update() {
    const { app } = this;
    const { live } = app;
    this.writeDevice();
    if (!live) return;
    write("status-fps", app.connection.open && app.state ? fixed(app.state.frames_per_second, 1) : "–");
    const since = performance.now() - app.frameAt;
    const age = (Number.isFinite(live.age) ? live.age : 0) + (since > 250 ? since : 0);
    write("status-age", age >= 1000 ? `${fixed(age / 1000, 1)} s` : `${fixed(age, 1)} ms`);
    byId("status-age").classList.toggle("bad", age >= 1000);
    write("status-draw", `${fixed(app.timing.mean, 1)} ms`);
    if (isTared(live) && !app.state) write("status-tare", "on");
  }
}

function write(id, text) {
  const element = byId(id);
  if (element.textContent !== text) element.textContent = text;
}

const milliseconds = (value) => (Number.isFinite(value) ? fixed(value, 1) : "–");
