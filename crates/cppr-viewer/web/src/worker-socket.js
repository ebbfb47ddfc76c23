// A page that solves by itself: the session of the server as a WebAssembly module in a worker, spoken to like a server.

const part = (id) => document.getElementById(id)?.textContent;

/** Robot files that came with the page, by name; null where a server solves. */
export const robots = JSON.parse(part("robots") ?? "null");
/** The one that is shown at first. */
export const shownFirst = robots && Object.keys(robots)[0];

let code = null;
let module = null;

class WorkerSocket {
  readyState = WebSocket.CONNECTING;
  onopen = null;
  onmessage = null;
  onclose = null;
  #worker;

  constructor() {
    // A page opened as a file may start no worker from another file, but one from itself.
    code ??= URL.createObjectURL(new Blob([part("worker")], { type: "text/javascript" }));
    module ??= Uint8Array.from(atob(part("kernel")), (c) => c.charCodeAt(0));
    this.#worker = new Worker(code);
    this.#worker.onmessage = ({ data }) => {
      if (data === "open") {
        this.readyState = WebSocket.OPEN;
        this.onopen?.();
      } else this.onmessage?.({ data });
    };
    this.#worker.onerror = (event) => {
      event.preventDefault();
      this.close();
    };
    this.#worker.postMessage({ module, robot: robots[shownFirst] });
  }

  send(text) {
    this.#worker.postMessage(text);
  }

  close() {
    if (this.readyState === WebSocket.CLOSED) return;
    this.#worker.terminate();
    this.readyState = WebSocket.CLOSED;
    setTimeout(() => this.onclose?.());
  }
}

export function dialWorker() {
  return new WorkerSocket();
}
dialWorker.lost = "The solver of this page stopped. It is started again.";
