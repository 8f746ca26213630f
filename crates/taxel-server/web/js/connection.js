// The WebSocket: connects, reconnects for ever, numbers the commands and matches their answers.

const FIRST_WAIT_MS = 500;
const MAX_WAIT_MS = 5000;
// The server says something twice a second: silence means that the line is dead, though nobody closed it.
const SILENCE_MS = 6000;
const CLOSED_TOKEN = 4401;
const TOKEN_KEY = "taxel.token";

// A token in the address would stay in the history and in shared links: it moves to the tab's storage.
export function takeToken() {
  const address = new URL(location.href);
  const given = address.searchParams.get("token");
  if (given !== null) {
    address.searchParams.delete("token");
    history.replaceState(null, "", address.pathname + address.search + address.hash);
    storeToken(given);
    return given;
  }
  try {
    return sessionStorage.getItem(TOKEN_KEY) || "";
  } catch (_) {
    return "";
  }
}

/** @param {string} token */
function storeToken(token) {
  try {
    sessionStorage.setItem(TOKEN_KEY, token);
  } catch (_) {
    // Without storage the token lives as long as the page.
  }
}

/** @typedef {"connecting" | "open" | "waiting" | "refused"} Status */

export class Connection {
  /**
   * @param {object} handlers
   * @param {(message: Wire.Message) => void} handlers.onText
   * @param {(message: ArrayBuffer) => void} handlers.onFrame
   * @param {() => void} handlers.onStatus
   * @param {string} path where the server speaks
   */
  constructor(handlers, path = "/live") {
    this.handlers = handlers;
    this.path = path;
    this.token = takeToken();
    /** @type {Status} */
    this.status = "connecting";
    this.everOpen = false;
    this.nextTryAt = 0;
    this.wait = FIRST_WAIT_MS;
    this.lastId = 0;
    /** @type {Map<number, Page.Answering>} */
    this.pending = new Map();
    /** @type {WebSocket | null} */
    this.socket = null;
    /** @type {ReturnType<typeof setTimeout> | undefined} */
    this.timer = undefined;
    this.heardAt = 0;
  }

  get open() {
    return this.status === "open";
  }

  connect() {
    clearTimeout(this.timer);
    this.heardAt = performance.now();
    this.setStatus("connecting");
    const scheme = location.protocol === "https:" ? "wss:" : "ws:";
    const query = this.token ? `?token=${encodeURIComponent(this.token)}` : "";
    const socket = new WebSocket(`${scheme}//${location.host}${this.path}${query}`);
    socket.binaryType = "arraybuffer";
    this.socket = socket;
    socket.onopen = () => {
      this.heardAt = performance.now();
      this.everOpen = true;
      this.setStatus("open");
    };
    socket.onmessage = (message) => {
      if (socket !== this.socket) return;
      this.heardAt = performance.now();
      if (typeof message.data === "string") this.takeText(message.data);
      else this.handlers.onFrame(message.data);
    };
    socket.onclose = (closing) => {
      if (socket === this.socket) this.lose(closing.code);
    };
  }

  // Called now and then. A connection that is being made through a network that is down is given up as well: the system
  // tries less and less often, and would see a minute late that the network is back.
  check() {
    if ((!this.open && this.status !== "connecting") || performance.now() - this.heardAt < SILENCE_MS) return;
    const { socket } = this;
    this.lose(0);
    socket?.close();
  }

  /** @param {string} token */
  connectWith(token) {
    this.token = token;
    storeToken(token);
    this.wait = FIRST_WAIT_MS;
    this.connect();
  }

  /** @param {number} code */
  lose(code) {
    this.socket = null;
    for (const answer of this.pending.values()) answer(false, "the connection was lost");
    this.pending.clear();
    if (code === CLOSED_TOKEN) {
      this.setStatus("refused");
      return;
    }
    this.nextTryAt = performance.now() + this.wait;
    this.timer = setTimeout(() => this.connect(), this.wait);
    this.wait = Math.min(this.wait * 1.6, MAX_WAIT_MS);
    this.setStatus("waiting");
  }

  /** @param {string} text */
  takeText(text) {
    /** @type {Wire.Message} */
    let message;
    try {
      message = JSON.parse(text);
    } catch (_) {
      console.warn("a text message is not JSON");
      return;
    }
    // The back-off starts over only when the server speaks: one that accepts and closes at once is not up.
    if (message.kind === "hello") this.wait = FIRST_WAIT_MS;
    if (message.kind === "answer") {
      const answer = this.pending.get(message.to);
      this.pending.delete(message.to);
      if (answer) answer(message.ok, message.text || "");
      return;
    }
    this.handlers.onText(message);
  }

  /**
   * Returns false if there is no connection. `answer` is called once.
   * @param {Wire.Request} request
   * @param {Page.Answering} [answer]
   */
  send(request, answer) {
    if (!this.socket || this.socket.readyState !== WebSocket.OPEN) return false;
    const id = ++this.lastId;
    this.socket.send(JSON.stringify({ id, ...request }));
    if (answer) this.pending.set(id, answer);
    return true;
  }

  /** @param {number} sequence */
  got(sequence) {
    if (this.socket && this.socket.readyState === WebSocket.OPEN) {
      this.socket.send(`{"do":"got","sequence":${sequence}}`);
    }
  }

  /** @param {Status} status */
  setStatus(status) {
    this.status = status;
    this.handlers.onStatus();
  }
}
