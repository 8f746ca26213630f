// Saving the chart as a picture and the curves as a table.

import { fixed } from "../units.js";
import { contextOf } from "../dom.js";
import { colourOf, theme } from "../theme.js";
import { PARAMETERS } from "./settings.js";

const FONT = "system-ui, -apple-system, 'Segoe UI', Roboto, sans-serif";
/** @type {Record<string, string>} */
const UNITS = { Ω: "ohms", V: "volts" };

/**
 * @param {Blob | null} blob
 * @param {string} name
 */
function save(blob, name) {
  if (!blob) throw new Error("the browser makes no picture of that size");
  const link = document.createElement("a");
  link.href = URL.createObjectURL(blob);
  link.download = name;
  link.click();
  setTimeout(() => URL.revokeObjectURL(link.href), 10000);
  return name;
}

/** @param {Model.Parameter} parameter */
const symbolOf = ({ symbol, below }) => (below ? `${symbol}_${below}` : symbol);

/**
 * The chart, under it every setting with all its numbers: a picture outlives the page that made it.
 * @param {import("uplot")} plot
 * @param {Model.Setting[]} list
 * @param {boolean} hasPoints
 * @returns {Promise<string>} the name of the file
 */
export function savePicture(plot, list, hasPoints) {
  const ratio = window.devicePixelRatio || 1;
  const source = plot.ctx.canvas;
  const pad = 18, head = 50, line = 20;
  const width = Math.max(720, source.width / ratio + 2 * pad);
  const height = source.height / ratio + head + pad + (list.length + 1) * line + pad;
  const canvas = Object.assign(document.createElement("canvas"), { width: Math.round(width * ratio), height: Math.round(height * ratio) });
  const g = contextOf(canvas);
  g.scale(ratio, ratio);
  g.fillStyle = theme.panel;
  g.fillRect(0, 0, width, height);
  g.fillStyle = theme.ink;
  g.font = `600 16px ${FONT}`;
  g.fillText("One taxel read while N others in its row are pressed", pad, pad + 14);
  g.fillStyle = theme.ink2;
  g.font = `12px ${FONT}`;
  const key = `solid: full circuit   dashed: the paper's equation 6${hasPoints ? "   circles: measured; squares: mean, 95 % interval" : ""}`;
  g.fillText(key, pad, pad + 34, width - 2 * pad);
  g.drawImage(source, pad, head, source.width / ratio, source.height / ratio);
  g.font = `600 12px ${FONT}`;
  const names = pad + 30 + Math.min(260, Math.max(...list.map(({ name }) => g.measureText(name).width))) + 20;
  let y = head + source.height / ratio + pad + 6;
  for (const setting of list) {
    g.fillStyle = colourOf(`setting-${setting.colour}`);
    g.fillRect(pad, y - 5, 22, 3);
    g.fillStyle = theme.ink;
    g.font = `600 12px ${FONT}`;
    g.fillText(setting.name, pad + 30, y, 260);
    g.fillStyle = theme.ink2;
    g.font = `12px ${FONT}`;
    const facts = PARAMETERS.map((parameter) => `${symbolOf(parameter)} ${setting[parameter.key]}${parameter.unit ? ` ${parameter.unit}` : ""}`);
    g.fillText(facts.join(" · "), names, y, width - pad - names);
    y += line;
  }
  return new Promise((resolve) => canvas.toBlob((blob) => resolve(blob), "image/png")).then((blob) => save(blob, "taxel_model.png"));
}

/** @param {string} text */
const quoted = (text) => (/[",\n]/.test(text) ? `"${text.replace(/"/g, '""')}"` : text);

/**
 * A line a setting and N, with all parameters, so that the file explains itself.
 * @param {Model.Curves[]} curves
 * @param {Model.Setting[]} list
 * @param {number} last
 */
export function curvesText(curves, list, last) {
  const names = PARAMETERS.map((parameter) => symbolOf(parameter) + (parameter.unit ? `_${UNITS[parameter.unit]}` : ""));
  const models = ["circuit", "paper"].flatMap((model) => [`v_out_${model}_volts`, `counts_${model}`, `drop_${model}_percent`, `saturates_${model}`]);
  const lines = [["setting", ...names, "n", ...models].join(",")];
  list.forEach((setting, i) => {
    for (let n = 0; n <= last; n += 1) {
      const cells = [quoted(setting.name), ...PARAMETERS.map(({ key }) => setting[key]), n];
      for (const curve of [curves[i].circuit, curves[i].paper]) {
        cells.push(curve.volts[n], fixed(curve.counts[n], 1).replace("−", "-"), curve.drop[n], curve.saturates[n] ? 1 : 0);
      }
      lines.push(cells.join(","));
    }
  });
  return `${lines.join("\n")}\n`;
}

/** @param {string} text */
export const saveTable = (text) => save(new Blob([text], { type: "text/csv" }), "taxel_model.csv");
