// The header and the tool bar: buttons and lists, and what they ask of the server or change in the view.

import { COLOUR_MAPS } from "./colour.js";
import { Orientation } from "./orientation.js";
import { UNITS, MICROSIEMENS, significant } from "./units.js";
import { savePicture, saveTable } from "./export.js";
import { toggleTheme } from "./theme.js";
import { toast } from "./toast.js";
import { fillKeyList } from "./keys.js";

const byId = (id) => document.getElementById(id);
const onClick = (id, action) => byId(id).addEventListener("click", action);

const TOGGLES = { "difference-button": "difference", "smooth-button": "smooth", "surface-button": "surface", "marks-button": "marks", "cop-button": "cop" };
const COLOUR_NAMES = { inferno: "inferno", viridis: "viridis", magma: "magma", greys: "greys" };

export class Controls {
  constructor(app) {
    this.app = app;
    this.startServer();
    this.startView();
    this.startDialogs();
    this.letGoAfterPointer();
    this.write();
  }

  startServer() {
    const { app } = this;
    onClick("tare-button", () => this.tare());
    onClick("untare-button", () => app.command({ do: "untare" }, "Tare cleared"));
    onClick("record-button", () => this.record());
    onClick("stop-button", () => this.stop());
    onClick("event-button", () => this.askEvent());
    byId("record-name").addEventListener("keydown", (event) => {
      if (event.key === "Enter") this.record();
    });
    byId("method-select").addEventListener("change", (event) => app.command({ do: "method", name: event.target.value }));
  }

  startView() {
    const { app } = this;
    const { settings } = app;
    for (const [id, name] of Object.entries(TOGGLES)) onClick(id, () => settings.toggle(name));
    for (const button of document.querySelectorAll("[data-layout]")) button.addEventListener("click", () => settings.set("layout", button.dataset.layout));
    for (const button of document.querySelectorAll("[data-tool]")) button.addEventListener("click", () => settings.set("tool", button.dataset.tool));
    onClick("rotate-button", () => settings.setOrientation(settings.orientation.rotate()));
    onClick("mirror-x-button", () => this.mirror("mirrorX"));
    onClick("mirror-y-button", () => this.mirror("mirrorY"));
    for (const name of COLOUR_MAPS) byId("colour-select").add(new Option(COLOUR_NAMES[name], name));
    for (const [id, name] of [["unit-select", "unit"], ["colour-select", "colours"], ["measure-select", "measure"], ["window-select", "window"]]) {
      byId(id).addEventListener("change", (event) => settings.set(name, name === "window" ? Number(event.target.value) : event.target.value));
    }
    byId("scale-select").addEventListener("change", (event) => this.setScale(event.target.value));
    byId("scale-fixed").addEventListener("change", (event) => {
      const value = Number(event.target.value);
      if (value > 0) settings.set("scaleFixed", value);
      else this.write();
    });
    onClick("png-button", () => this.save(savePicture));
    onClick("csv-button", () => this.save(saveTable));
    onClick("theme-button", () => toggleTheme(() => app.themeChanged()));
  }

  startDialogs() {
    fillKeyList(byId("keys-list"));
    onClick("help-button", () => byId("keys-dialog").showModal());
    onClick("event-cancel", () => byId("event-dialog").close());
    onClick("tare-cancel", () => byId("tare-dialog").close());
    byId("tare-form").addEventListener("submit", () => this.app.command({ do: "tare", force: true }, "Tared"));
    byId("event-form").addEventListener("submit", () => {
      const text = byId("event-text").value.trim() || "event";
      this.app.command({ do: "event", text }, `Marked: ${text}`);
    });
  }

  // After a click with the pointer the keys belong to the view again, not to the button last pressed.
  letGoAfterPointer() {
    let pointerAt = -Infinity;
    document.addEventListener("pointerdown", () => { pointerAt = performance.now(); }, true);
    document.addEventListener("click", (event) => {
      const button = event.target.closest("button");
      if (button && event.detail > 0) button.blur();
    });
    document.addEventListener("change", (event) => {
      if (event.target.tagName === "SELECT" && performance.now() - pointerAt < 5000) event.target.blur();
      // A check box that keeps the focus would take the space bar.
      if (event.target.type === "checkbox" && !event.target.matches(":focus-visible")) event.target.blur();
      if (event.target.type === "range" && performance.now() - pointerAt < 60000 && !event.target.matches(":focus-visible")) event.target.blur();
    });
  }

  // Under load the server refuses and says how much stands there: then the user decides.
  tare() {
    this.app.ask({ do: "tare" }, (ok, text) => {
      if (ok) {
        toast(text || "Tared");
        return;
      }
      byId("tare-text").textContent = text;
      byId("tare-dialog").showModal();
    });
  }

  recording() {
    const { state } = this.app;
    return Boolean(state && state.recording && !state.recording.error);
  }

  record() {
    const name = byId("record-name").value.trim();
    this.app.command(name ? { do: "record", name } : { do: "record" }, "Recording");
    byId("record-name").blur();
  }

  stop() {
    this.app.command({ do: "stop" }, "Recording stopped");
  }

  toggleRecording() {
    if (this.recording()) this.stop();
    else if (!byId("record-button").disabled) this.record();
    else toast("This server does not record", "bad");
  }

  askEvent() {
    byId("event-text").value = "";
    byId("event-dialog").showModal();
    byId("event-text").focus();
  }

  mirror(axis) {
    const { settings } = this.app;
    settings.setOrientation(new Orientation({ ...settings.orientation, [axis]: !settings.orientation[axis] }));
  }

  // A fixed scale starts where the moving one stands.
  setScale(mode) {
    const { settings, stage } = this.app;
    if (mode === "fixed") settings.set("scaleFixed", Number(stage.scale.top.toPrecision(6)));
    if (mode === "hold") stage.scale.restartPeak();
    settings.set("scaleMode", mode);
  }

  nextMethod() {
    const { methods, method } = this.app;
    if (methods.length < 2) return;
    this.app.command({ do: "method", name: methods[(methods.indexOf(method) + 1) % methods.length] });
  }

  nextUnit() {
    const { settings, newtons } = this.app;
    if (!newtons) return;
    const at = UNITS.findIndex((unit) => unit.key === settings.values.unit);
    settings.set("unit", UNITS[(at + 1) % UNITS.length].key);
  }

  async save(how) {
    if (!this.app.shown) {
      toast("There is no frame to save", "bad");
      return;
    }
    try {
      toast(`Saved ${await how(this.app)}`);
    } catch (error) {
      toast(`Not saved: ${error.message}`, "bad");
    }
  }

  takeHello() {
    const { hello, methods, newtons } = this.app;
    const method = byId("method-select");
    method.replaceChildren(...methods.map((name) => new Option(name, name)));
    method.disabled = methods.length < 2;
    const unit = byId("unit-select");
    unit.replaceChildren(...(newtons ? UNITS : [MICROSIEMENS]).map(({ text, key }) => new Option(text, key)));
    unit.disabled = !newtons;
    byId("record-button").disabled = !hello.can_record;
    byId("record-name").disabled = !hello.can_record;
    byId("record-button").title = hello.can_record ? "Record (r)" : "This server does not record";
    this.write();
  }

  takeState() {
    const select = byId("method-select");
    if (document.activeElement !== select) select.value = this.app.method;
  }

  setSurfaceMissing() {
    byId("surface-button").disabled = true;
    byId("surface-button").textContent = "3D: no WebGL";
    byId("surface-button").title = "This browser offers no WebGL 2, which the 3D surface needs";
  }

  // Puts every control into the state of the settings.
  write() {
    const { settings, unit } = this.app;
    const { values } = settings;
    for (const [id, name] of Object.entries(TOGGLES)) byId(id).setAttribute("aria-pressed", String(values[name]));
    for (const button of document.querySelectorAll("[data-layout]")) button.setAttribute("aria-pressed", String(button.dataset.layout === values.layout));
    for (const button of document.querySelectorAll("[data-tool]")) button.setAttribute("aria-pressed", String(button.dataset.tool === values.tool));
    byId("mirror-x-button").setAttribute("aria-pressed", String(values.mirrorX));
    byId("mirror-y-button").setAttribute("aria-pressed", String(values.mirrorY));
    byId("unit-select").value = unit.key;
    byId("colour-select").value = values.colours;
    byId("scale-select").value = values.scaleMode;
    byId("measure-select").value = values.measure;
    byId("window-select").value = String(values.window);
    byId("scale-fixed-field").hidden = values.scaleMode !== "fixed";
    if (document.activeElement !== byId("scale-fixed")) byId("scale-fixed").value = String(Number(significant(values.scaleFixed, 4)));
    byId("scale-fixed-unit").textContent = unit.text;
    document.body.dataset.tool = values.surface ? "turn" : values.tool;
  }
}
