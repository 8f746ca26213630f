// A question: whether a guided task is to end.

import { byId, dialogById, onClick, openDialog, write } from "./dom.js";

export class FinishDialog {
  /** @param {() => void} finish */
  constructor(finish) {
    this.dialog = dialogById("finish-dialog");
    onClick("finish-cancel", () => this.dialog.close());
    byId("finish-form").addEventListener("submit", (event) => {
      event.preventDefault();
      this.dialog.close();
      finish();
    });
  }

  /** @param {string} text what ending it means */
  open(text) {
    write("finish-text", text);
    openDialog(this.dialog);
  }

  close() {
    if (this.dialog.open) this.dialog.close();
  }
}
