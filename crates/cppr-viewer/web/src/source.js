// Where poses come from: a server that solves, or the poses that were saved with the page.

import { trimmed } from "./store.js";

/** Splits a binary message into its JSON head and floats. */
export function decode(buffer) {
  const length = new DataView(buffer).getUint32(0, true);
  const head = JSON.parse(new TextDecoder().decode(new Uint8Array(buffer, 4, length)));
  return { ...head, floats: new Float32Array(buffer, 4 + length) };
}

/** The connection to the server that gave the page. */
export function dialServer() {
  return new WebSocket(new URL("live", location.href.replace(/^http/, "ws")));
}
dialServer.lost = "The connection to the program is lost. If it was ended, start it again.";

/**
 * Who solves: a server, or a worker of the page. `dial` makes the connection, a WebSocket or what behaves like one. One request is
 * under way at a time; what changes meanwhile goes out with the answer, so that the newest state is always the next to be solved.
 * Dispatches `message` events with decoded messages, `open` and `lost`.
 */
export class Live extends EventTarget {
  live = true;
  /** Round trips of the last requests (ms), for measurements. */
  times = [];
  #dial;
  #socket = null;
  #id = 0;
  #under = null;
  #wanted = null;
  #wait = 250;
  #file = null;

  constructor(dial) {
    super();
    this.#dial = dial;
  }

  /** What it means when the connection is lost. */
  get lost() {
    return this.#dial.lost;
  }

  /** The robot file that was given to the page; null for the first one. */
  get file() {
    return this.#file;
  }

  /** `file`: begin with this robot. */
  connect(file = this.#file) {
    this.#file = file;
    const socket = this.#dial();
    socket.binaryType = "arraybuffer";
    socket.onopen = () => {
      this.#wait = 250;
      // Nothing is asked before the robot is known.
      this.#under = { id: 0, since: performance.now() };
      this.dispatchEvent(new Event("open"));
      this.send({ robot: this.#file });
    };
    socket.onmessage = ({ data }) => this.#take(typeof data === "string" ? JSON.parse(data) : decode(data));
    socket.onclose = () => {
      this.#socket = null;
      this.dispatchEvent(new Event("lost"));
      setTimeout(() => this.connect(), this.#wait);
      this.#wait = Math.min(2 * this.#wait, 4000);
    };
    this.#socket = socket;
  }

  /** True where every request is answered. */
  get idle() {
    return this.#socket?.readyState === WebSocket.OPEN && !this.#under && !this.#wanted;
  }

  /** Cuts the connection, as a sleeping laptop does. */
  drop() {
    this.#socket?.close();
  }

  send(message) {
    if (this.#socket?.readyState === WebSocket.OPEN) this.#socket.send(JSON.stringify(message));
  }

  /** Another robot file; sent again after a lost connection. */
  robot(file) {
    this.send({ robot: file });
    this.#offered = file;
  }
  #offered = null;

  /** Asks for the shape; of several that wait the newest is asked for. `how`: what else the request says (see `Solve` of the server). */
  solve(scenario, how = {}) {
    this.#wanted = { scenario, how: { ...how, from_rest: (how.from_rest ?? false) || (this.#wanted?.how.from_rest ?? false) } };
    if (!this.#under) this.#next();
  }

  #next() {
    if (!this.#wanted || this.#socket?.readyState !== WebSocket.OPEN) return;
    const { scenario, how } = this.#wanted;
    this.#wanted = null;
    this.#under = { id: ++this.#id, since: performance.now() };
    this.send({ solve: { id: this.#id, scenario: trimmed(scenario), ...how } });
  }

  #take(message) {
    if (message.kind === "robot") {
      this.#file = this.#offered ?? this.#file;
      this.#offered = null;
      if (this.#under?.id === 0) this.#under = null;
    }
    if (message.kind === "bad_file") {
      this.#offered = null;
      // Where there is no robot yet, the first one is shown instead.
      if (this.#under?.id === 0) {
        this.#file = null;
        this.send({ robot: null });
      }
    }
    // What was not understood is not answered either.
    if (message.kind === "problem" && this.#under?.id) this.#under = null;
    if (message.id !== undefined && message.id === this.#under?.id) {
      this.times.push(performance.now() - this.#under.since);
      if (this.times.length > 4096) this.times.splice(0, 2048);
      this.#under = null;
      // Solved while this shape is drawn.
      this.#next();
    }
    this.dispatchEvent(new CustomEvent("message", { detail: message }));
    if (!this.#under) this.#next();
  }
}
