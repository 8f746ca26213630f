// What is wrong with a guided task: a card where there is nothing to work with, and lines above the task where there is.

import { byId, inputById, write } from "./dom.js";

/** @typedef {{ title: string, text: string, spinner?: boolean, token?: boolean, link?: boolean }} Card */

/**
 * What the task is.
 * @typedef {object} Subject
 * @property {(state: Wire.State) => { trouble: string, isAtWork: boolean } | null} of how it stands; null where there is none
 * @property {string[]} parts ids of what is hidden as long as there is none
 * @property {{ title: string, text: string }} missing said where there is none
 * @property {string} lost said while the connection is lost
 * @property {string} connecting what the server is asked for
 * @property {string} noFrames said while the sensor says nothing
 */

/** Frames that are older than this say nothing about the sensor now, ms. */
export const STALE_MS = 1500;

/** @type {Partial<Record<Wire.DeviceState, string>>} */
const DEVICE = {
  waiting: "The sensor does not answer yet", lost: "The sensor is lost", ended: "The source has ended", paused: "The source is paused",
};

export class Banners {
  /**
   * @param {import("./connection.js").Connection} connection
   * @param {Subject} subject
   */
  constructor(connection, subject) {
    this.connection = connection;
    this.subject = subject;
    byId("token-form").addEventListener("submit", (event) => {
      event.preventDefault();
      connection.connectWith(inputById("token-input").value.trim());
    });
  }

  /**
   * @param {Wire.State | null} state
   * @param {number} frameAge ms
   */
  show(state, frameAge) {
    const card = this.blocked(state);
    const { subject } = this;
    const { open } = this.connection;
    const task = state && subject.of(state);
    byId("blocked").hidden = !card;
    for (const id of subject.parts) byId(id).hidden = Boolean(card);
    if (card) this.showCard(card);
    tell("connection-alert", card || open ? "" : subject.lost);
    tell("device-alert", !card && open && task?.isAtWork ? deviceText(state, frameAge, subject.noFrames) : "");
    tell("trouble", card ? "" : task?.trouble ?? "");
    return card === null;
  }

  /** @param {Card} card */
  showCard(card) {
    write("blocked-title", card.title);
    write("blocked-text", card.text);
    byId("blocked-spinner").hidden = !card.spinner;
    byId("blocked-link").hidden = !card.link;
    byId("token-form").hidden = !card.token;
  }

  /**
   * @param {Wire.State | null} state
   * @returns {Card | null}
   */
  blocked(state) {
    const { connection, subject } = this;
    if (connection.status === "refused") {
      return {
        title: connection.token ? "The token is wrong" : "A token is needed",
        text: "The server shows its data only to those who know its token. It prints the address with the token when it starts; open that one, or enter the token here.",
        token: true,
      };
    }
    if (state && !subject.of(state)) return { ...subject.missing, link: true };
    if (state) return null;
    if (connection.status === "waiting") return { title: "The server does not answer", text: "Trying again. This page goes on by itself as soon as the server is there.", spinner: true };
    return { title: "Connecting", text: `Asking ${location.host} for ${subject.connecting}.`, spinner: true };
  }
}

/**
 * @param {Wire.State | null} state
 * @param {number} frameAge ms
 * @param {string} noFrames
 */
function deviceText(state, frameAge, noFrames) {
  if (!state) return "";
  const { device } = state;
  const name = DEVICE[device.state];
  if (name) return device.text ? `${name}: ${device.text}` : `${name}.`;
  return frameAge > STALE_MS ? noFrames : "";
}

/**
 * @param {string} id
 * @param {string} text
 */
function tell(id, text) {
  write(id, text);
  byId(id).hidden = text === "";
}
