// What is wrong when nothing arrives: a card over the maps, or a note at their top if they still say something.

import { byId, inputById, onClick, write } from "./dom.js";
import { fixed } from "./units.js";

/** @typedef {{ title: string, text: string, spinner?: boolean, retry?: boolean, token?: boolean }} Card */

const STALE_SECONDS = 1;
const PATIENCE_SECONDS = 1.5;

/** @type {Partial<Record<Wire.DeviceState, { title: string, spinner: boolean }>>} */
const DEVICE = {
  waiting: { title: "Waiting for the sensor", spinner: true },
  lost: { title: "The sensor is lost", spinner: true },
  ended: { title: "The source has ended", spinner: false },
  paused: { title: "Paused", spinner: false },
};

export class Overlay {
  /**
   * @param {import("./view.js").View} view
   * @param {import("./connection.js").Connection} connection
   */
  constructor(view, connection) {
    this.view = view;
    this.connection = connection;
    this.key = "";
    this.stale = false;
    byId("token-form").addEventListener("submit", (event) => {
      event.preventDefault();
      connection.connectWith(inputById("token-input").value.trim());
    });
    onClick("overlay-retry", () => connection.connect());
    view.on(["connection", "paused"], () => this.update());
  }

  update() {
    const { paused, shown } = this.view.now;
    const said = this.blocked();
    this.stale = false;
    const note = said ? null : this.noted();
    byId("overlay").hidden = !said;
    byId("note").hidden = !note;
    if (note) write("note", note);
    // Where the maps still show what is, the note keeps out of their way.
    byId("note").classList.toggle("low", !this.stale);
    byId("paused-chip").hidden = !paused;
    write("paused-chip", this.view.isOpen ? "view paused, new frames are not kept" : "view paused, the server is gone");
    document.body.classList.toggle("paused", paused);
    document.body.classList.toggle("stale", Boolean(said) || this.stale);
    if (!said) {
      this.key = "";
      return;
    }
    const key = JSON.stringify(said);
    if (key === this.key) return;
    this.key = key;
    byId("overlay-title").textContent = said.title;
    byId("overlay-text").textContent = said.text;
    byId("overlay-spinner").hidden = !said.spinner;
    byId("overlay-retry").hidden = !said.retry;
    byId("token-form").hidden = !said.token;
    byId("overlay").classList.toggle("opaque", !shown);
  }

  /**
   * A card: there is nothing to look at, or what is seen is not what the sensor feels now.
   * @returns {Card | null}
   */
  blocked() {
    const { connection } = this;
    const { state, shown, paused, waitsSince } = this.view.now;
    if (connection.status === "refused") {
      return {
        title: connection.token ? "The token is wrong" : "A token is needed",
        text: "The server shows its data only to those who know its token. It prints the address with the token when it starts; open that one, or enter the token here.",
        token: true,
      };
    }
    // While the view is paused the buffered frames are what the user looks at: a chip in the header says so.
    if (paused && shown) return null;
    if (connection.status === "waiting") {
      const seconds = Math.max(0, (connection.nextTryAt - performance.now()) / 1000);
      return {
        title: connection.everOpen ? "The server is gone" : "The server does not answer",
        text: `Trying again in ${fixed(seconds, 1)} s. This page goes on by itself as soon as the server is back.`,
        spinner: true, retry: true,
      };
    }
    if (connection.status === "connecting") {
      return { title: "Connecting", text: `Opening the live stream from ${location.host}.`, spinner: true };
    }
    const device = state && DEVICE[state.device.state];
    if (device && (!shown || state.device.state === "waiting" || state.device.state === "lost")) {
      return { ...device, text: state.device.text || "" };
    }
    if (!shown) {
      const waited = (performance.now() - waitsSince) / 1000;
      const text = waited > PATIENCE_SECONDS ? `The server answers, but no frame for ${fixed(waited, 0)} s.` : "The server answers; waiting for the first frame.";
      return { title: "No frame yet", text, spinner: true };
    }
    return null;
  }

  noted() {
    const { state, paused, shown, frameAt } = this.view.now;
    if (paused) return null;
    const device = state && DEVICE[state.device.state];
    if (device && state.device.state === "paused") return device.title;
    if (device) return state.device.text ? `${device.title}: ${state.device.text}` : device.title;
    if (state && state.player && !state.player.playing) return "The file is paused";
    const age = (performance.now() - frameAt) / 1000;
    if (shown && age > STALE_SECONDS) {
      this.stale = true;
      return `No frame for ${fixed(age, 0)} s. What is shown is old.`;
    }
    return null;
  }
}
