// What the page asks of the server, and what becomes of it.

import { toast } from "./toast.js";

const NOT_CONNECTED = "Not connected: nothing was sent";

export class Requests {
  /** @param {import("./connection.js").Connection} connection */
  constructor(connection) {
    this.connection = connection;
  }

  /**
   * A refusal is always shown; a success if it is given in words.
   * @param {Wire.Request} request
   * @param {string} [success]
   */
  send(request, success) {
    this.ask(request, (ok, text) => {
      if (!ok) toast(text || `The server refuses: ${request.do}`, "bad");
      else if (success) toast(text || success);
    });
  }

  /**
   * The caller takes the answer.
   * @param {Wire.Request} request
   * @param {Page.Answering} answer
   */
  ask(request, answer) {
    if (!this.connection.send(request, answer)) toast(NOT_CONNECTED, "bad");
  }
}
