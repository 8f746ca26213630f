// The panel of the measured points: picking or dropping a file, and saying what became of it.

import { POINT_UNITS, PointsError, readPoints } from "./points.js";
import { byId, inputById, onClick, selectById } from "../dom.js";
import { MAX_OTHERS } from "./settings.js";

export class PointsPanel {
  /**
   * @param {import("./settings.js").Settings} settings
   * @param {() => void} onPoints
   */
  constructor(settings, onPoints) {
    this.settings = settings;
    this.onPoints = onPoints;
    /** @type {Model.Point[]} */
    this.measured = [];
    const unit = selectById("unit-select");
    for (const { key, text } of POINT_UNITS) unit.add(new Option(text, key));
    unit.addEventListener("change", () => settings.setView("unit", unit.value));
    const counting = selectById("counting-select");
    counting.addEventListener("change", () => settings.setView("nCounts", counting.value === "pressed" ? "pressed" : "others"));
    const input = inputById("points-input");
    onClick("points-button", () => input.click());
    input.addEventListener("change", () => {
      this.take(input.files?.[0]);
      // The same file, mended, may be picked again.
      input.value = "";
    });
    onClick("points-clear", () => {
      this.put([], "");
      byId("points-button").focus();
    });
    this.startDrop();
  }

  startDrop() {
    const here = byId("drop-here");
    let depth = 0;
    /** @param {DragEvent} event */
    const hasFile = (event) => event.dataTransfer !== null && [...event.dataTransfer.types].includes("Files");
    /**
     * @param {DragEvent} event
     * @param {number} step
     */
    const track = (event, step) => {
      if (!hasFile(event)) return;
      event.preventDefault();
      depth = Math.max(0, depth + step);
      here.hidden = depth === 0;
    };
    document.addEventListener("dragenter", (event) => track(event, 1));
    document.addEventListener("dragleave", (event) => track(event, -1));
    document.addEventListener("dragover", (event) => track(event, 0));
    document.addEventListener("drop", (event) => {
      if (!hasFile(event)) return;
      event.preventDefault();
      depth = 0;
      here.hidden = true;
      this.take(event.dataTransfer?.files[0]);
    });
  }

  /**
   * A file with broken lines is refused as a whole, and what was shown before stays.
   * @param {File | undefined} file
   */
  async take(file) {
    if (!file) return;
    try {
      this.put(readPoints(await file.text()), file.name);
    } catch (error) {
      const reason = error instanceof PointsError ? error.message : "the file cannot be read";
      byId("points-error").textContent = `${file.name} is not taken over.\n${reason}`;
      byId("points-error").hidden = false;
    }
  }

  /**
   * @param {Model.Point[]} measured
   * @param {string} name of the file
   */
  put(measured, name) {
    this.measured = measured;
    byId("points-error").hidden = true;
    byId("points-error").textContent = "";
    byId("points-empty").hidden = measured.length > 0;
    byId("points-clear").hidden = measured.length === 0;
    byId("points-file").hidden = measured.length === 0;
    byId("points-file").textContent = name;
    byId("points-button").textContent = measured.length > 0 ? "Another file" : "Choose a file";
    const furthest = Math.min(MAX_OTHERS, measured.reduce((most, { n }) => Math.max(most, n + this.offset), 0));
    if (furthest > this.settings.view.last) this.settings.setView("last", furthest);
    this.onPoints();
  }

  get offset() {
    return this.settings.view.nCounts === "pressed" ? -1 : 0;
  }

  /**
   * @param {string} why no points can be drawn in this unit, or nothing
   * @param {number} groups
   * @param {number} beyond
   * @param {number} full readings at the converter’s end
   */
  write(why, groups, beyond, full) {
    selectById("unit-select").value = this.settings.view.unit;
    selectById("counting-select").value = this.settings.view.nCounts;
    const count = this.measured.length;
    const parts = [];
    if (count > 0 && why) parts.push(`Not shown: ${why}.`);
    else if (count > 0) parts.push(`${plural(count, "reading")} at ${plural(groups, "value")} of N; squares are means with their 95 % interval.`);
    if (beyond > 0 && !why) parts.push(`${plural(beyond, "reading")} beyond the shown N.`);
    if (full > 0) parts.push(`${plural(full, "reading")} at the converter’s end, so at least that.`);
    byId("points-note").textContent = parts.join(" ");
  }
}

/**
 * @param {number} count
 * @param {string} word
 */
const plural = (count, word) => `${count} ${word}${count === 1 ? "" : "s"}`;
