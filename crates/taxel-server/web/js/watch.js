// Tells the server what this page looks at: how many frames a second it can use, of which taxels it wants details, and
// whether anybody reads what the figures are uncertain by.

const SHOWN_PER_SECOND = 60;
const HIDDEN_PER_SECOND = 5;
const MAX_WATCHED = 16;

export class Watch {
  /**
   * @param {object} parts
   * @param {import("./view.js").View} parts.view
   * @param {import("./selection.js").Selection} parts.selection
   * @param {import("./connection.js").Connection} parts.connection
   */
  constructor({ view, selection, connection }) {
    this.view = view;
    this.selection = selection;
    this.connection = connection;
    this.told = "";
    view.on(["hello"], () => {
      this.told = "";
      this.sendRate();
      this.sendWatched();
    });
    view.on(["picked", "newtons"], () => this.sendWatched());
    selection.onChange(() => this.sendWatched());
    document.addEventListener("visibilitychange", () => {
      this.sendRate();
      this.sendWatched();
    });
  }

  sendRate() {
    if (this.view.now.hello) this.connection.send({ do: "rate", frames_per_second: document.hidden ? HIDDEN_PER_SECOND : SHOWN_PER_SECOND });
  }

  sendWatched() {
    const { picked, newtons } = this.view.now;
    const all = [...(picked ? [picked] : []), ...this.selection.pins];
    const taxels = all.slice(0, MAX_WATCHED).map(({ row, column }) => /** @type {[number, number]} */ ([row, column]));
    const figures = newtons && !document.hidden;
    const key = JSON.stringify([taxels, figures]);
    if (key !== this.told && this.connection.send({ do: "watch", taxels, figures })) this.told = key;
  }
}
