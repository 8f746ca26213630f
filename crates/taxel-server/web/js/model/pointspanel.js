// The panel of the measured points: picking or dropping a file, and saying what became of it.

import { POINT_UNITS, PointsError, readPoints } from "./points.js";
import { MOST_OTHERS } from "./settings.js";

const byId = (id) => document.getElementById(id);

export class PointsPanel {
  constructor(settings, onPoints) {
    this.settings = settings;
    this.onPoints = onPoints;
    this.measured = [];
    for (const { key, text } of POINT_UNITS) byId("unit-select").add(new Option(text, key));
    byId("unit-select").addEventListener("change", (event) => settings.setView("unit", event.target.value));
    byId("counting-select").addEventListener("change", (event) => settings.setView("nCounts", event.target.value));
    byId("points-button").addEventListener("click", () => byId("points-input").click());
    byId("points-input").addEventListener("change", (event) => {
      this.take(event.target.files[0]);
      // The same file, mended, may be picked again.
      event.target.value = "";
    });
    byId("points-clear").addEventListener("click", () => {
      this.put([], "");
      byId("points-button").focus();
    });
    this.startDrop();
  }

  startDrop() {
    const here = byId("drop-here");
    let depth = 0;
    const hasFile = (event) => event.dataTransfer && [...event.dataTransfer.types].includes("Files");
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
      this.take(event.dataTransfer.files[0]);
    });
  }

  // A file with broken lines is refused as a whole, and what was shown before stays.
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

  put(measured, name) {
    this.measured = measured;
    byId("points-error").hidden = true;
    byId("points-error").textContent = "";
    byId("points-empty").hidden = measured.length > 0;
    byId("points-clear").hidden = measured.length === 0;
    byId("points-file").hidden = measured.length === 0;
    byId("points-file").textContent = name;
    byId("points-button").textContent = measured.length > 0 ? "Another file" : "Choose a file";
    const furthest = Math.min(MOST_OTHERS, measured.reduce((most, { n }) => Math.max(most, n + this.offset), 0));
    if (furthest > this.settings.view.last) this.settings.setView("last", furthest);
    this.onPoints();
  }

  get offset() {
    return this.settings.view.nCounts === "pressed" ? -1 : 0;
  }

  // `why` in words where no points can be drawn in this unit; `full`: readings at the converter’s end.
  write(why, groups, beyond, full) {
    byId("unit-select").value = this.settings.view.unit;
    byId("counting-select").value = this.settings.view.nCounts;
    const count = this.measured.length;
    const parts = [];
    if (count > 0 && why) parts.push(`Not shown: ${why}.`);
    else if (count > 0) parts.push(`${plural(count, "reading")} at ${plural(groups, "value")} of N; squares are means with their 95 % interval.`);
    if (beyond > 0 && !why) parts.push(`${plural(beyond, "reading")} beyond the shown N.`);
    if (full > 0) parts.push(`${plural(full, "reading")} at the converter’s end, so at least that.`);
    byId("points-note").textContent = parts.join(" ");
  }
}

const plural = (count, word) => `${count} ${word}${count === 1 ? "" : "s"}`;
