// Links to the files that a guided task has written.

import { byId, made } from "./dom.js";

/**
 * @param {{ name: string, text: string }[]} files the first one is what people want first
 * @param {string} token what the server wants to be told with each address; empty where it wants nothing
 */
export function showFiles(files, token) {
  byId("files").replaceChildren(...files.map(({ name, text }, i) => {
    const item = document.createElement("li");
    item.append(link(name, text, token, i === 0));
    return item;
  }));
}

/**
 * @param {string} name
 * @param {string} text
 * @param {string} token
 * @param {boolean} isFirst
 */
function link(name, text, token, isFirst) {
  const link = document.createElement("a");
  link.href = `/results/${encodeURIComponent(name)}${token ? `?token=${encodeURIComponent(token)}` : ""}`;
  link.target = "_blank";
  link.rel = "noopener";
  link.className = isFirst ? "button first" : "button";
  link.append(made("span", text, "file-text"), made("span", name, "file-name"), made("span", " (opens in a new tab)", "sr"));
  return link;
}
