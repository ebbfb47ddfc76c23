// Plays a motion: from a first state, at rest unless another is chosen, to what is asked, and back where it is looped.

import { button, el, tick } from "./dom.js";

/** One way takes so long (ms). */
const DURATION = 4000;

/** What is driven or acts; where it acts and everything else stays. */
const GROWS = /^(pull|rotate|tension|torque|force|moment|gravity)_/;

/** Between two scenarios: what the first has not grows from zero, what does not grow is that of the second. */
export function between(a, b, t, grows = false) {
  if (typeof b === "number") return grows ? (a ?? 0) + (b - (a ?? 0)) * t : b;
  if (Array.isArray(b)) return b.map((v, i) => between(a?.[i], v, t, grows));
  if (b === null || typeof b !== "object") return b;
  return Object.fromEntries(Object.entries(b).map(([key, v]) => [key, between(a?.[key], v, t, GROWS.test(key))]));
}

export class Player {
  /** 0 at the first state, 1 at the last. */
  part = 1;
  #way = 1;
  #frame = null;
  #last = 0;

  /** `go(part)` shows a part of the motion, `rest()` ends it; `mark()`, where there is one, makes the present state the first. */
  constructor({ go, rest, mark }) {
    this.go = go;
    this.rest = rest;
    this.play = button("▶", "Play the motion (Space)", () => (this.playing ? this.pause() : this.start()));
    this.bar = el("input", { type: "range", min: 0, max: 1, step: "any", value: 1, "aria-label": "Part of the motion" });
    this.bar.addEventListener("input", () => {
      this.#halt();
      this.#at(Number(this.bar.value));
    });
    this.bar.addEventListener("change", () => this.rest());
    this.loop = tick("loop", false, () => {}, "There and back again, until it is paused");
    const first = mark ? [button("Start here", "The motion begins at the present state instead of at rest", mark)] : [];
    this.node = el("div", { className: "player", role: "group", "aria-label": "Motion" }, this.play, this.bar, this.loop.node, ...first);
  }

  get playing() {
    return this.#frame !== null;
  }

  start() {
    if (this.part >= 1) this.#at(0);
    this.#way = 1;
    this.#last = performance.now();
    this.#frame = requestAnimationFrame((now) => this.#step(now));
    this.#show();
  }

  pause() {
    if (!this.playing) return;
    this.#halt();
    this.rest();
  }

  /** Something else moved the robot: that is the end of the motion now. */
  interrupt() {
    this.#halt();
    this.part = 1;
    this.bar.value = 1;
  }

  #halt() {
    cancelAnimationFrame(this.#frame);
    this.#frame = null;
    this.#show();
  }

  #show() {
    this.play.textContent = this.playing ? "❚❚" : "▶";
  }

  #at(part) {
    this.part = part;
    this.bar.value = part;
    this.go(part);
  }

  #step(now) {
    const next = this.part + (this.#way * Math.min(now - this.#last, 100)) / DURATION;
    this.#last = now;
    this.#at(Math.min(1, Math.max(0, next)));
    if (next >= 1 || next <= 0) {
      if (!this.loop.box.checked) return this.pause();
      this.#way = next >= 1 ? -1 : 1;
    }
    this.#frame = requestAnimationFrame((time) => this.#step(time));
  }
}
