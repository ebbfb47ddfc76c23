// A page that was saved: poses computed beforehand, one slider for each quantity that was swept.

import { decimals, el, show } from "./dom.js";
import { decode } from "./source.js";

function buffer(base64) {
  const text = atob(base64);
  return Uint8Array.from(text, (c) => c.charCodeAt(0)).buffer;
}

export class Saved extends EventTarget {
  live = false;
  times = [];

  /** `text`: JSON with the axes that were swept, the messages that describe the robot, and one for every pose. */
  constructor(text) {
    super();
    this.data = JSON.parse(text);
    this.at = this.data.axes.map((axis) => axis.start);
  }

  connect() {
    const say = (detail) => this.dispatchEvent(new CustomEvent("message", { detail }));
    const read = (message) => (typeof message === "string" ? decode(buffer(message)) : message);
    for (const message of this.data.messages) say(read(message));
    say({ kind: "start", scenario: this.data.scenario });
    this.#say = (index) => say(read(this.data.poses[index]));
    this.#show();
  }
  #say = null;

  // Nothing is solved here.
  solve() {}
  send() {}

  #show() {
    const index = this.data.axes.reduce((i, axis, k) => i * axis.values.length + this.at[k], 0);
    this.#say(index);
  }

  /** Part of the first sweep. */
  play(part) {
    const [slider] = this.sliders;
    slider.value = Math.round(part * (this.data.axes[0].values.length - 1));
    slider.dispatchEvent(new Event("input"));
  }

  /** One slider for each axis. */
  panel() {
    this.sliders = [];
    const rows = this.data.axes.map((axis, k) => {
      const digits = decimals(Math.max(...axis.values.map(Math.abs)));
      const out = el("output");
      const tell = () => (out.textContent = `${show(axis.values[this.at[k]], digits)} ${axis.unit}`);
      const slider = el("input", { type: "range", min: 0, max: axis.values.length - 1, step: 1, value: this.at[k], "aria-label": axis.name });
      slider.addEventListener("input", () => {
        this.at[k] = Number(slider.value);
        tell();
        this.#show();
      });
      tell();
      this.sliders.push(slider);
      return el("div", { className: "value" }, el("label", {}, axis.name), slider, out);
    });
    const node = el("fieldset", {}, el("legend", {}, "Sweep"), ...rows, el("p", { className: "note" }, this.data.text));
    return { nodes: [node], show: () => {} };
  }
}
