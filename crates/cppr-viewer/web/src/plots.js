// Fields along the length, one line per tube; of the contact force one per pair of tubes.

import { nice } from "./colour.js";
import { el, select, shape, show } from "./dom.js";

/** How hard the tubes press on each other. It comes where nothing has changed for a while; until then the last one is dimmed. */
const CONTACT = "contact";
const QUANTITIES = [
  ["curvature_z", "Curvature κ_Z (1/m)"],
  ["curvature_y", "Curvature κ_Y (1/m)"],
  ["twist", "Twist Δτ (rad/m)"],
  ["moment_z", "Bending moment M_Z (N mm)"],
  ["moment_y", "Bending moment M_Y (N mm)"],
  ["torque", "Torque (N mm)"],
  ["axial_force", "Axial force (N)"],
  ["tension", "Tension (N)"],
  ["stretch", "Stretch (–)"],
  [CONTACT, "Contact force (N/mm)"],
];
const FIRST = ["curvature_z", "moment_z", "axial_force"];
/** Where moments and axial forces are not known. */
const FIRST_OF_BUNDLE = ["curvature_z", "tension", "torque"];
/** Units of the drawing; its height follows the room that there is. */
const [W, LEFT, BOTTOM, TOP] = [320, 44, 20, 8];
const DASHES = ["", "6 3", "8 3 2 3", "12 3", "2 3", "8 3 2 3 2 3"];

class Plot {
  constructor(column, pressed, { hover }) {
    this.column = column;
    this.pressed = pressed;
    this.svg = shape("svg", { role: "img" });
    this.value = el("span", { className: "values" });
    this.pick = el("span");
    this.node = el("figure", {}, el("figcaption", {}, this.pick, this.value), this.svg);
    new ResizeObserver(([{ contentRect: { width, height } }]) => {
      if (width === 0 || height === 0) return;
      this.height = (W * height) / width;
      this.svg.setAttribute("viewBox", `0 0 ${W} ${this.height}`);
      this.draw();
    }).observe(this.svg);
    this.svg.addEventListener("pointermove", (e) => {
      if (!this.shown) return;
      const box = this.svg.getBoundingClientRect();
      const part = (((e.clientX - box.left) / box.width) * W - LEFT) / (W - LEFT - 6);
      hover(Math.round(Math.min(1, Math.max(0, part)) * (this.shown.sections - 1)));
    });
    this.svg.addEventListener("pointerleave", () => hover(null));
  }

  /** Offers what there is. */
  begin(columns, first) {
    this.pose = null;
    this.column = first;
    const there = QUANTITIES.filter(([column]) => columns.includes(column));
    const pick = select("Plotted quantity", there, first, (v) => {
      this.column = v;
      this.draw();
    });
    this.pick.replaceChildren(pick);
  }

  /** The pose that is drawn. */
  get shown() {
    return this.column === CONTACT ? this.pressed.pose : this.pose;
  }

  /** Where a section is on the axis (mm). */
  place(section) {
    return this.column === CONTACT ? this.shown.run(section) : this.shown.place(section);
  }

  /** Tube, values and their places (mm). The line of a pair is that of its inner tube. */
  lines() {
    if (this.column === CONTACT) return this.pressed.pairs;
    const { shown } = this;
    const places = Array.from({ length: shown.sections }, (_, s) => shown.place(s));
    return Array.from({ length: shown.tubes }, (_, tube) => ({ tube, values: shown.along(tube, this.column).slice(0, shown.ends[tube] + 1), places }));
  }

  draw(pose = this.pose) {
    this.pose = pose;
    const H = this.height;
    this.node.classList.toggle("stale", this.column === CONTACT && this.pressed.stale);
    if (!this.shown || !H) {
      this.svg.replaceChildren();
      return;
    }
    const lines = this.lines();
    const most = Math.max(...lines.map((l) => l.values.reduce((m, v) => Math.max(m, v), 0)));
    const least = Math.min(...lines.map((l) => l.values.reduce((m, v) => Math.min(m, v), 0)));
    // What is only rounding is drawn as zero.
    const span = Math.max(most - least, 1e-3);
    // A number needs some room above the next.
    const step = nice(span / Math.max(2, Math.min(5, (H - BOTTOM - TOP) / 20)));
    // A curve that touches an end of the axis gets a step of room, but not one that only begins at zero.
    const one = Math.min(most, -least) < 1e-6 * span && most - least > 1e-3;
    const [below, above] = [one && -least < most, one && -least > most].map((bare) => (bare ? -1e-3 : 1e-3));
    const [low, high] = [Math.floor(least / step - below) * step, Math.ceil(most / step + above) * step];
    const length = this.place(this.shown.sections - 1);
    const px = (x) => LEFT + (x / length) * (W - LEFT - 6);
    const py = (y) => H - BOTTOM - ((y - low) / (high - low)) * (H - BOTTOM - TOP);
    const grid = [];
    const digits = Math.max(0, -Math.floor(Math.log10(step)));
    const every = Math.ceil((high - low) / step / 4);
    for (let i = Math.ceil(low / step); i * step <= high * (1 + 1e-9) + 1e-12; i++) {
      const y = py(i * step);
      grid.push(shape("line", { x1: LEFT, x2: W - 6, y1: y, y2: y, class: i === 0 ? "axis" : "grid" }));
      if (i % every === 0) grid.push(shape("text", { x: LEFT - 5, y: y + 3.5, "text-anchor": "end" }, show(i * step, digits)));
    }
    const xstep = nice(length / 5);
    for (let x = 0; x <= length * 1.0001; x += xstep) {
      grid.push(shape("text", { x: px(x), y: H - 6, "text-anchor": x === 0 ? "start" : x > 0.97 * length ? "end" : "middle" }, x === 0 ? "X = 0" : x + xstep > length * 1.0001 ? `${Math.round(x)} mm` : `${Math.round(x)}`));
    }
    const paths = lines.map(({ tube, values, places }) => {
      let d = "";
      values.forEach((v, s) => (d += `${s ? "L" : "M"}${px(places[s]).toFixed(1)} ${py(v).toFixed(1)}`));
      return shape("path", { d, class: `line tube${tube}`, "stroke-dasharray": DASHES[tube % 6] });
    });
    this.cursor = shape("line", { y1: TOP, y2: H - BOTTOM, class: "cursor", visibility: "hidden" });
    this.svg.replaceChildren(...grid, ...paths, this.cursor);
    this.px = px;
  }

  mark(section) {
    if (!this.cursor || !this.shown) return;
    this.cursor.setAttribute("visibility", section === null ? "hidden" : "visible");
    if (section === null) {
      this.value.textContent = "";
      return;
    }
    const place = this.place(section);
    const x = this.px(place);
    this.cursor.setAttribute("x1", x);
    this.cursor.setAttribute("x2", x);
    const values = this.lines().map(({ values, places }) => show(values[places.findIndex((x) => x >= place - 1e-6)] ?? NaN));
    this.value.textContent = `X = ${show(place, 0)} mm: ${values.join(", ")}`;
  }
}

/** Three plots; `hover(section)` while the pointer is over one. */
export class Plots {
  /** Contact forces, and the pose that they are of. */
  pressed = { pairs: [], pose: null, stale: false };

  constructor(hover) {
    this.plots = FIRST.map((column) => new Plot(column, this.pressed, {
      hover: (section) => {
        this.plots.forEach((p) => p.mark(section));
        hover(section);
      },
    }));
    this.key = el("p", { className: "key" });
    this.node = el("section", { className: "plots", "aria-label": "Fields along the length" }, this.key, ...this.plots.map((p) => p.node));
  }

  /** `live`: contact forces are told. */
  begin({ tubes, columns: own, bundle }, live) {
    const first = bundle ? FIRST_OF_BUNDLE : FIRST;
    const columns = live && tubes.length > 1 ? [...own, CONTACT] : own;
    Object.assign(this.pressed, { pairs: [], pose: null });
    this.plots.forEach((plot, i) => plot.begin(columns, columns.includes(plot.column) ? plot.column : first[i]));
    const sample = (t) => shape("svg", { viewBox: "0 0 26 8" }, shape("path", { d: "M1 4H25", class: `line tube${t}`, "stroke-dasharray": DASHES[t % 6] }));
    this.key.replaceChildren(...tubes.map((_, t) => el("span", {}, sample(t), t > 0 ? `${t + 1}` : bundle ? "Tube 1" : "Tube 1, the leader")));
  }

  pose(pose) {
    this.plots.forEach((p) => (p.column === CONTACT ? (p.pose = pose) : p.draw(pose)));
  }

  /** The pose is another than that of the contact forces. */
  stale() {
    this.pressed.stale = true;
    this.#redraw();
  }

  /** Contact forces of a pose, in SI units. */
  press(contact, pose) {
    const pairs = (contact?.pairs ?? []).map(({ inner, length_m: lengths, force_N_m: forces }) => ({
      tube: inner - 1,
      places: lengths.map((x) => 1e3 * x),
      values: forces.map((force) => 1e-3 * Math.hypot(...force)),
    }));
    Object.assign(this.pressed, { pairs, pose: pairs.length > 0 ? pose : null, stale: false });
    this.#redraw();
  }

  #redraw() {
    this.plots.filter((p) => p.column === CONTACT).forEach((p) => p.draw());
  }
}
