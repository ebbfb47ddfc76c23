// Numbers of the pose: status, tip, actuators, margins.

import { el, show } from "./dom.js";

/** From here on a limit is near. */
const NEAR = 0.85;

export class Readout {
  constructor() {
    this.status = el("p", { className: "status", role: "status" }, "connecting …");
    this.advice = el("p", { className: "advice", hidden: true });
    this.table = el("table", { className: "readout" });
    this.rubbed = el("table", { className: "readout rubbed", hidden: true });
    this.note = el("p", { className: "note" });
    this.node = el("section", { "aria-label": "Readout" }, this.status, this.advice, this.table, this.rubbed, this.note);
  }

  say(kind, text) {
    this.status.className = `status ${kind}`;
    if (this.status.textContent !== text) this.status.textContent = text;
    this.advise("");
  }

  /** A sentence below the status; none where it is empty. */
  advise(text) {
    this.advice.hidden = text === "";
    if (this.advice.textContent !== text) this.advice.textContent = text;
  }

  #error = el("td", { colSpan: 3 });

  /** Error of the pose that is shown, with what to do where it is large. */
  error({ error_mm: error, advice }) {
    this.#error.textContent = error === null ? "not known" : millimetres(error);
    if (advice) this.advise([this.advice.textContent, advice].filter(Boolean).join(" "));
  }

  /** Between which poses friction leaves the one that is shown, in SI units; dimmed as soon as that is another. */
  rubs({ friction, problem }, coefficient, pose, scenario) {
    this.rubbed.hidden = !friction && !(problem && coefficient > 0);
    this.rubbed.classList.remove("stale");
    if (this.rubbed.hidden) return;
    if (!friction) {
      this.rubbed.replaceChildren(this.#row("Friction", [el("td", { colSpan: 2 }, el("small", {}, problem))]));
      return;
    }
    const sides = [friction.loading, friction.unloading];
    const row = (name, value, digits, unit, title = "") => this.#row(name, sides.map((side) => `${show(value(side), digits)} ${unit}`), title);
    const rows = [el("tr", { className: "head", title: "As if all motors had been driven on to this command, or driven back to it, with everything slipping" }, el("th", {}, `Friction ${friction.coefficient}`), ...["driven on", "driven back"].map((a) => el("th", { scope: "col" }, a)))];
    ["X", "Y", "Z"].forEach((axis, i) => rows.push(row(`Tip ${axis}`, (side) => 1e3 * side.tip_position_m[i], 2, "mm")));
    for (const { tube } of pose.actuators) {
      const own = (side) => side.actuators.find((a) => a.tube === tube);
      const asked = scenario.actuator.find((a) => a.tube === tube) ?? {};
      const name = (text) => [el("i", { className: `swatch tube${tube - 1}` }), `${text} ${tube}`];
      rows.push(asked.tension_N === undefined ? row(name("Pull"), (side) => own(side).tension_N, 3, "N") : row(name("Pull"), (side) => 1e3 * own(side).pull_m, 3, "mm"));
      const turns = sides.some((side) => Math.abs(own(side).torque_Nm) > 1e-9 || Math.abs(own(side).rotation_rad) > 1e-9);
      if (turns) rows.push(asked.torque_Nmm === undefined ? row(name("Turn"), (side) => 1e3 * own(side).torque_Nm, 2, "N mm") : row(name("Turn"), (side) => (180 / Math.PI) * own(side).rotation_rad, 2, "°"));
    }
    this.rubbed.replaceChildren(...rows);
  }

  #row(name, cells, title = "") {
    return el("tr", { title }, el("th", { scope: "row" }, ...[name].flat()), ...cells.map((c) => (c instanceof Node ? c : el("td", {}, c))));
  }

  /** `scenario` tells which of two conjugate quantities was prescribed. */
  pose(pose, scenario) {
    const stable = pose.status === "converged";
    this.say(stable && !pose.exceeded ? "good" : "warn", stable && pose.exceeded ? "converged, stable, beyond a limit" : pose.text);
    this.advise(pose.exceeded ? `${pose.exceeded}.` : "");
    const [x, y, z] = pose.tip_mm.map((v) => show(v, 2));
    const rows = [
      el("tr", { className: "head" }, el("th", {}), ...["X", "Y", "Z"].map((a) => el("th", { scope: "col" }, a))),
      this.#row("Tip (mm)", [x, y, z], "Centre of the tip section, base frame"),
      this.#row("Direction", pose.direction.map((v) => show(v, 4)), "Of the axis at the tip, base frame"),
      this.#row("Bend", [el("td", { colSpan: 3 }, `${show(pose.bend_deg, 2)}°`)], "Angle between the tip and +X"),
    ];
    for (const a of pose.actuators) {
      const asked = scenario.actuator.find((b) => b.tube === a.tube) ?? {};
      const cell = (text, set, width) => el("td", { className: set === undefined ? "" : "set", colSpan: width }, text);
      const pair = (motion, a, effort, b) => [cell(motion, a, 1), cell(effort, b, 2)];
      const name = (text) => [el("i", { className: `swatch tube${a.tube - 1}` }), text];
      rows.push(
        el("tr", { className: "first" }, el("th", { scope: "row" }, ...name(`Pull ${a.tube}`)), ...pair(`${show(a.pull_mm)} mm`, asked.pull_mm, `${show(a.tension_N)} N`, asked.tension_N)),
        el("tr", {}, el("th", { scope: "row" }, ...name(`Turn ${a.tube}`)), ...pair(`${show(a.rotate_deg, 2)}°`, asked.rotate_deg, `${show(a.torque_Nmm, 2)} N mm`, asked.torque_Nmm)),
      );
    }
    // Modes are judged where nothing has changed for a while, the integration with every pose.
    const modes = pose.margin !== undefined;
    const error = this.#row("Error", [this.#error], modes ? "What the modes put the tip off by, against the robot integrated without modes" : "How far the tip moves when every step of the integration is halved");
    error.className = "first";
    this.#error.textContent = pose.error_mm === null ? (modes ? "…" : "not known") : millimetres(pose.error_mm);
    rows.push(error);
    if (!modes) {
      this.table.replaceChildren(...rows, ...limits(pose));
      return;
    }
    const margin = pose.margin === null ? ["not known (printed)"] : [bar(pose.margin), show(pose.margin)];
    rows.push(this.#row("Stability", [el("td", { colSpan: 3 }, ...margin)], "Margin: 1 at rest, 0 where the robot snaps"), ...limits(pose));
    rows.push(this.#row("Energy", [el("td", { colSpan: 3 }, `${show(pose.energy_mJ)} mJ`)], "Elastic energy of all tubes"));
    this.table.replaceChildren(...rows);
  }
}

const millimetres = (error) => `${error.toExponential(0)} mm`;

/** Less than that is rounding: the first of notches that are strained alike is named, as the program does. */
const EVEN = 1e-9;

/** Strain and closure of each tube where they are greatest, against what is allowed. */
function limits(pose) {
  const greatest = (tube, key) =>
    pose.limits.filter((l) => l.tube === tube && l[key] !== null).reduce((most, l) => (most && most[key] + EVEN >= l[key] ? most : l), null);
  const part = (limit, key) => {
    if (!limit) return el("span", {}, "–");
    const place = limit.notch === null ? `${show(limit.x_mm, 0)} mm` : `notch ${limit.notch}`;
    return el("span", { className: limit[key] > NEAR ? "low" : "", title: `At x = ${show(limit.x_mm, 1)} mm` }, `${show(100 * limit[key], 0)} %`, el("small", {}, ` ${place}`));
  };
  const row = (className, name, title, ...parts) => el("tr", { className: `limits ${className}`, title }, el("th", { scope: "row" }, ...name), el("td", { colSpan: 3 }, el("div", {}, ...parts)));
  const rows = [...new Set(pose.limits.map((l) => l.tube))].flatMap((tube) => {
    const [strained, closed] = [greatest(tube, "strain_use"), greatest(tube, "closure")];
    if (!strained && !closed) return [];
    return [row("", [el("i", { className: `swatch tube${tube - 1}` }), `Tube ${tube}`], "", part(strained, "strain_use"), part(closed, "closure"))];
  });
  const words = "Where it is greatest: strain over what the material may bear; part of a notch's length that bending has taken up, 100 % where its teeth touch";
  return rows.length === 0 ? [] : [row("first", ["Of limits"], words, el("span", {}, "strain"), el("span", {}, "closure")), ...rows];
}

function bar(part) {
  const fill = el("i");
  fill.style.width = `${100 * Math.min(1, Math.max(0, part))}%`;
  return el("span", { className: `bar ${part < 0.15 ? "low" : ""}`, "aria-hidden": "true" }, fill);
}
