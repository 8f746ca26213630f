// What is wrong: a card where there is nothing to work with, and lines above the session where there is.

import { byId, inputById, write } from "../dom.js";

/** @typedef {{ title: string, text: string, spinner?: boolean, token?: boolean, link?: boolean }} Card */

/** Frames that are older than this say nothing about the hand now, ms. */
export const STALE_MS = 1500;

/** @type {Partial<Record<Wire.DeviceState, string>>} */
const DEVICE = {
  waiting: "The sensor does not answer yet", lost: "The sensor is lost", ended: "The source has ended", paused: "The source is paused",
};

export class Banners {
  /** @param {import("../connection.js").Connection} connection */
  constructor(connection) {
    this.connection = connection;
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
    const { open } = this.connection;
    const grip = state?.grip ?? null;
    byId("blocked").hidden = !card;
    for (const id of ["work", "side", "steps-nav"]) byId(id).hidden = Boolean(card);
    if (card) this.showCard(card);
    tell("connection-alert", card || open ? "" : "Connection lost. The session goes on where it was; trying again.");
    const isAtWork = grip !== null && !["finishing", "done"].includes(grip.phase);
    tell("device-alert", !card && open && isAtWork ? deviceText(state, frameAge) : "");
    tell("trouble", card ? "" : grip?.trouble ?? "");
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
    const { connection } = this;
    if (connection.status === "refused") {
      return {
        title: connection.token ? "The token is wrong" : "A token is needed",
        text: "The server shows its data only to those who know its token. It prints the address with the token when it starts; open that one, or enter the token here.",
        token: true,
      };
    }
    if (state && !state.grip) {
      return { title: "This is not a grip session", text: "Start one with “taxel grip”. This server shows its sensor in the live view.", link: true };
    }
    if (state) return null;
    if (connection.status === "waiting") return { title: "The server does not answer", text: "Trying again. This page goes on by itself as soon as the server is there.", spinner: true };
    return { title: "Connecting", text: `Asking ${location.host} for the session.`, spinner: true };
  }
}

/**
 * @param {Wire.State | null} state
 * @param {number} frameAge ms
 */
function deviceText(state, frameAge) {
  if (!state) return "";
  const { device } = state;
  const name = DEVICE[device.state];
  if (name) return device.text ? `${name}: ${device.text}` : `${name}.`;
  return frameAge > STALE_MS ? "No frames arrive: the force at this moment is not known." : "";
}

/**
 * @param {string} id
 * @param {string} text
 */
function tell(id, text) {
  write(id, text);
  byId(id).hidden = text === "";
}
