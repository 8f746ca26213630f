// The header and the tool bar: buttons and lists, and what they ask of the server or change in the view.

import { COLOUR_MAPS } from "./colour.js";
import { Orientation } from "./orientation.js";
import { UNITS, significant } from "./units.js";
import { toggleTheme } from "./theme.js";
import { toast } from "./toast.js";
import { fillKeyList } from "./keys.js";
import { all, buttonById, byId, dialogById, inputById, onClick, openDialog, selectById, write } from "./dom.js";

/** @type {Record<string, import("./settings.js").Flag>} */
const TOGGLES = {
  "difference-button": "difference", "smooth-button": "smooth", "surface-button": "surface", "marks-button": "marks", "cop-button": "cop",
};

export class Controls {
  /**
   * @param {object} parts
   * @param {import("./view.js").View} parts.view
   * @param {import("./settings.js").Settings} parts.settings
   * @param {import("./requests.js").Requests} parts.requests
   * @param {import("./scale.js").Scale} parts.scale
   * @param {() => Promise<string>} parts.savePicture gives the name of the file
   * @param {() => Promise<string>} parts.saveTable gives the name of the file
   * @param {() => Promise<string>} parts.saveRegions gives the name of the file
   * @param {() => void} parts.onTheme
   */
  constructor({ view, settings, requests, scale, savePicture, saveTable, saveRegions, onTheme }) {
    this.view = view;
    this.settings = settings;
    this.requests = requests;
    this.scale = scale;
    this.startServer();
    this.startView();
    this.startDialogs();
    onClick("png-button", () => this.save(savePicture));
    onClick("csv-button", () => this.save(saveTable));
    onClick("save-regions", () => this.save(saveRegions));
    onClick("theme-button", () => toggleTheme(onTheme));
    this.write();
    view.on(["hello", "newtons"], () => this.takeHello());
    view.on(["state"], () => this.takeState());
    settings.onChange(() => this.write());
  }

  startServer() {
    const { requests } = this;
    onClick("tare-button", () => this.tare());
    onClick("untare-button", () => requests.send({ do: "untare" }, "Tare cleared"));
    onClick("record-button", () => this.record());
    onClick("stop-button", () => this.stop());
    onClick("event-button", () => this.askEvent());
    byId("record-name").addEventListener("keydown", (event) => {
      if (event.key === "Enter") this.record();
    });
    const method = selectById("method-select");
    method.addEventListener("change", () => requests.send({ do: "method", name: method.value }));
  }

  startView() {
    const { settings } = this;
    for (const [id, name] of Object.entries(TOGGLES)) onClick(id, () => settings.toggle(name));
    for (const button of all("button[data-layout]")) {
      button.addEventListener("click", () => settings.set("layout", /** @type {import("./settings.js").Layout} */ (button.dataset.layout)));
    }
    for (const button of all("button[data-tool]")) {
      button.addEventListener("click", () => settings.set("tool", /** @type {import("./settings.js").Tool} */ (button.dataset.tool)));
    }
    onClick("rotate-button", () => settings.setOrientation(settings.orientation.rotate()));
    onClick("mirror-x-button", () => this.mirror("mirrorX"));
    onClick("mirror-y-button", () => this.mirror("mirrorY"));
    for (const name of COLOUR_MAPS) selectById("colour-select").add(new Option(name, name));
    onChoice("unit-select", (value) => settings.set("unit", value));
    onChoice("colour-select", (value) => settings.set("colours", value));
    onChoice("measure-select", (value) => settings.set("measure", /** @type {keyof Page.Measures} */ (value)));
    onChoice("window-select", (value) => settings.set(this.view.isFile ? "fileWindow" : "window", Number(value)));
    onChoice("scale-select", (value) => this.setScale(/** @type {import("./settings.js").ScaleMode} */ (value)));
    const fixed = inputById("scale-fixed");
    fixed.addEventListener("change", () => {
      const value = Number(fixed.value);
      if (value > 0) settings.set("scaleFixed", value);
      else this.write();
    });
  }

  startDialogs() {
    fillKeyList(byId("keys-list"));
    onClick("help-button", () => openDialog(dialogById("keys-dialog")));
    const letters = inputById("letters-switch");
    letters.addEventListener("change", () => this.settings.set("letters", letters.checked));
    onClick("event-cancel", () => dialogById("event-dialog").close());
    onClick("tare-cancel", () => dialogById("tare-dialog").close());
    byId("tare-form").addEventListener("submit", () => this.requests.send({ do: "tare", force: true }, "Tared"));
    byId("event-form").addEventListener("submit", () => {
      const text = inputById("event-text").value.trim() || "event";
      this.requests.send({ do: "event", text }, `Marked: ${text}`);
    });
  }

  // Under load the server refuses and says how much stands there: then the user decides.
  tare() {
    this.requests.ask({ do: "tare" }, (ok, text) => {
      if (ok) {
        toast(text || "Tared");
        return;
      }
      byId("tare-text").textContent = text;
      openDialog(dialogById("tare-dialog"));
    });
  }

  recording() {
    const { state } = this.view.now;
    return Boolean(state && state.recording && !state.recording.error);
  }

  record() {
    const name = inputById("record-name").value.trim();
    this.requests.send(name ? { do: "record", name } : { do: "record" }, "Recording");
  }

  stop() {
    this.requests.send({ do: "stop" }, "Recording stopped");
  }

  toggleRecording() {
    if (this.recording()) this.stop();
    else if (!buttonById("record-button").disabled) this.record();
    else toast("This server does not record", "bad");
  }

  askEvent() {
    inputById("event-text").value = "";
    openDialog(dialogById("event-dialog"));
    byId("event-text").focus();
  }

  /** @param {"mirrorX" | "mirrorY"} axis */
  mirror(axis) {
    const { settings } = this;
    settings.setOrientation(new Orientation({ ...settings.orientation, [axis]: !settings.orientation[axis] }));
  }

  /**
   * A fixed scale starts where the moving one stands.
   * @param {import("./settings.js").ScaleMode} mode
   */
  setScale(mode) {
    const { settings, scale } = this;
    if (mode === "fixed") settings.set("scaleFixed", Number(scale.top.toPrecision(6)));
    if (mode === "hold") scale.restartPeak();
    settings.set("scaleMode", mode);
  }

  nextMethod() {
    const { methods, method } = this.view;
    if (methods.length < 2) return;
    this.requests.send({ do: "method", name: methods[(methods.indexOf(method) + 1) % methods.length] });
  }

  nextUnit() {
    const { settings } = this;
    if (!this.view.now.newtons) return;
    const at = UNITS.findIndex((unit) => unit.key === settings.values.unit);
    settings.set("unit", UNITS[(at + 1) % UNITS.length].key);
  }

  /** @param {() => Promise<string>} how */
  async save(how) {
    if (!this.view.now.shown) {
      toast("There is no frame to save", "bad");
      return;
    }
    try {
      toast(`Saved ${await how()}`);
    } catch (error) {
      toast(`Not saved: ${error instanceof Error ? error.message : error}`, "bad");
    }
  }

  takeHello() {
    const { hello, newtons } = this.view.now;
    const { methods } = this.view;
    if (!hello) return;
    const method = selectById("method-select");
    method.replaceChildren(...methods.map((name) => new Option(name, name)));
    method.disabled = methods.length < 2;
    const unit = selectById("unit-select");
    unit.replaceChildren(...(newtons ? UNITS : [this.view.unit]).map(({ text, key }) => new Option(text, key)));
    unit.disabled = !newtons;
    buttonById("record-button").disabled = !hello.can_record;
    inputById("record-name").disabled = !hello.can_record;
    const { exported } = hello.sensor;
    for (const id of ["layout-buttons", "difference-button", "maps-divider"]) byId(id).hidden = exported !== null;
    byId("compensated-canvas").setAttribute("aria-label", exported ? "Map of the loads as another program has exported them" : "Map of the compensated loads");
    byId("frame-exported").hidden = exported === null;
    byId("frame-exported").textContent = exported ? exported.words : "";
    byId("record-button").title = hello.can_record ? "Record (r)" : "This server does not record";
    this.write();
  }

  takeState() {
    const select = selectById("method-select");
    if (document.activeElement !== select) select.value = this.view.method;
  }

  setSurfaceMissing() {
    buttonById("surface-button").disabled = true;
    byId("surface-button").textContent = "3D: no WebGL";
    byId("surface-button").title = "This browser offers no WebGL 2, which the 3D surface needs";
  }

  // Puts every control into the state of the settings.
  write() {
    const { unit } = this.view;
    const { values } = this.settings;
    for (const [id, name] of Object.entries(TOGGLES)) byId(id).setAttribute("aria-pressed", String(values[name]));
    for (const button of all("button[data-layout]")) button.setAttribute("aria-pressed", String(button.dataset.layout === values.layout));
    for (const button of all("button[data-tool]")) button.setAttribute("aria-pressed", String(button.dataset.tool === values.tool));
    byId("mirror-x-button").setAttribute("aria-pressed", String(values.mirrorX));
    byId("mirror-y-button").setAttribute("aria-pressed", String(values.mirrorY));
    selectById("unit-select").value = unit.key;
    selectById("colour-select").value = values.colours;
    selectById("scale-select").value = values.scaleMode;
    selectById("measure-select").value = values.measure;
    byId("window-all").hidden = !this.view.isFile;
    selectById("window-select").value = String(this.view.isFile ? values.fileWindow : values.window);
    byId("scale-fixed-field").hidden = values.scaleMode !== "fixed";
    const fixed = inputById("scale-fixed");
    if (document.activeElement !== fixed) fixed.value = String(Number(significant(values.scaleFixed, 4)));
    write("scale-fixed-unit", unit.text);
    inputById("letters-switch").checked = values.letters;
    document.body.dataset.tool = values.surface ? "turn" : values.tool;
  }
}

/**
 * @param {string} id of a list
 * @param {(value: string) => void} take
 */
function onChoice(id, take) {
  const list = selectById(id);
  list.addEventListener("change", () => take(list.value));
}
