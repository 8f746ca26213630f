// Short messages at the corner: refusals, and what the user asked for and got.

import { byId } from "./dom.js";

const SHOWN_MS = { good: 3000, bad: 7000 };
const MAX_TOASTS = 4;

/**
 * @param {string} text
 * @param {"good" | "bad"} kind
 */
export function toast(text, kind = "good") {
  const box = byId("toasts");
  const element = document.createElement("div");
  element.className = `toast ${kind}`;
  element.textContent = text;
  box.append(element);
  while (box.children.length > MAX_TOASTS) box.firstChild?.remove();
  setTimeout(() => element.remove(), SHOWN_MS[kind]);
}
