// Numbers of the pose: status, tip, actuators, margins.

import { el, show } from "./dom.js";

export class Readout {
  constructor() {
    this.status = el("p", { className: "status", role: "status" }, "connecting …");
    this.table = el("table", { className: "readout" });
    this.note = el("p", { className: "note" });
    this.node = el("section", { "aria-label": "Readout" }, this.status, this.table, this.note);
  }

  say(kind, text) {
    this.status.className = `status ${kind}`;
    if (this.status.textContent !== text) this.status.textContent = text;
  }

  #row(name, cells, title = "") {
    return el("tr", { title }, el("th", { scope: "row" }, name), ...cells.map((c) => (c instanceof Node ? c : el("td", {}, c))));
  }

  /** `scenario` tells which of two conjugate quantities was prescribed. */
  pose(pose, scenario) {
    this.say(pose.status === "converged" ? "good" : "warn", pose.text);
    const [x, y, z] = pose.tip_mm.map((v) => show(v, 2));
    const rows = [
      el("tr", { className: "head" }, el("th", {}), ...["X", "Y", "Z"].map((a) => el("th", { scope: "col" }, a))),
      this.#row("Tip (mm)", [x, y, z], "Centre of the tip section, base frame"),
      this.#row("Axis", pose.direction.map((v) => show(v, 4)), "Direction of the axis at the tip"),
      this.#row("Bend", [el("td", { colSpan: 3 }, `${show(pose.bend_deg, 2)}°`)], "Angle between the tip and +X"),
    ];
    for (const a of pose.actuators) {
      const asked = scenario.actuator.find((b) => b.tube === a.tube) ?? {};
      const cell = (text, set, width) => el("td", { className: set === undefined ? "" : "set", colSpan: width }, text);
      const pair = (motion, a, effort, b) => [cell(motion, a, 1), cell(effort, b, 2)];
      rows.push(
        el("tr", { className: "head" }, el("th", { colSpan: 4, scope: "rowgroup" }, el("i", { className: `swatch tube${a.tube - 1}` }), `Tube ${a.tube}`)),
        this.#row("Pull", pair(`${show(a.pull_mm)} mm`, asked.pull_mm, `${show(a.tension_N)} N`, asked.tension_N)),
        this.#row("Turn", pair(`${show(a.rotate_deg, 2)}°`, asked.rotate_deg, `${show(a.torque_Nmm, 2)} N mm`, asked.torque_Nmm)),
      );
    }
    rows.push(el("tr", { className: "head" }, el("th", { colSpan: 4 }, "Limits")));
    rows.push(this.#row("Stability", [el("td", { colSpan: 3 }, bar(pose.margin), pose.margin === null ? "not known (printed)" : show(pose.margin))], "1 at rest, 0 where the robot snaps"));
    for (const limit of worst(pose)) {
      rows.push(this.#row(`Notches ${limit.tube}`, [el("td", { colSpan: 3, className: limit.closure > 0.85 ? "low" : "" }, `${show(100 * limit.closure, 1)} % at ${show(limit.x_mm, 0)} mm`)], "Closure: part of the notch's length that bending has taken up where teeth are nearest; they touch at 100 %"));
    }
    rows.push(this.#row("Energy", [el("td", { colSpan: 3 }, `${show(pose.energy_mJ)} mJ`)]));
    this.table.replaceChildren(...rows);
  }
}

/** The notch of each tube that is nearest to closing. */
function worst(pose) {
  const by = new Map();
  for (const limit of pose.limits ?? []) {
    if (limit.closure !== null && limit.closure > (by.get(limit.tube)?.closure ?? -Infinity)) by.set(limit.tube, limit);
  }
  return [...by.values()];
}

function bar(part) {
  const fill = el("i");
  fill.style.width = `${100 * Math.min(1, Math.max(0, part ?? 0))}%`;
  return el("span", { className: `bar ${part !== null && part < 0.15 ? "low" : ""}`, "aria-hidden": "true" }, fill);
}
