// By which value the tubes are coloured, and the legend.

import { nice, ramp } from "./colour.js";
import { el, show } from "./dom.js";

const magnitude = (pose, t) => (s) => Math.hypot(pose.at(s, t, "curvature_y"), pose.at(s, t, "curvature_z"));

/** Part of the notches' length that bending has taken up along a tube, between the notches that are known. */
function closure(pose, t) {
  const known = (pose.limits ?? []).filter((l) => l.tube === t + 1 && l.closure !== null);
  return (s) => {
    const x = pose.at(s, t, "abscissa");
    const next = known.findIndex((l) => l.x_mm >= x);
    if (next <= 0) return known.at(next)?.closure ?? 0;
    const [a, b] = [known[next - 1], known[next]];
    return a.closure + ((b.closure - a.closure) * (x - a.x_mm)) / (b.x_mm - a.x_mm);
  };
}

/** Largest strain of the notches, wherever along the tube. */
function extremeStrain(pose, t) {
  const most = Math.max(0, ...pose.limits.filter((l) => l.tube === t + 1).map((l) => Math.abs(l.strain)));
  return () => most;
}

/** mode: what the shader does: 0 nothing, 1 a value per section, 2 strain at every point. */
export const COLOURINGS = {
  tube: { label: "tube", mode: 0 },
  curvature: { label: "curvature", mode: 1, unit: "1/m", title: "Curvature", value: magnitude },
  strain: { label: "strain", mode: 2, signed: true, unit: "%", factor: 100, title: "Strain in the notches, teeth rigid", value: extremeStrain },
  closure: { label: "notch closure", mode: 1, unit: "%", factor: 100, title: "Closure of the notches, 100 % where teeth touch", value: closure },
};

/** Those that only notches have. */
export const OF_NOTCHES = ["strain", "closure"];

const largest = (pose, t, value) => {
  let most = 0;
  for (let s = 0; s < pose.sections; s++) most = Math.max(most, value(s));
  return most;
};

/** Bounds of the colours for a pose. */
export function range(name, pose, tubes) {
  const { mode, signed, value, factor = 1 } = COLOURINGS[name];
  if (mode === 0) return [0, 1];
  const most = nice(factor * Math.max(...tubes.map((tube, t) => largest(pose, t, value(pose, t, tube))), 1e-6)) / factor;
  return signed ? [-most, most] : [0, most];
}

/** The value that the shader is given by section. */
export const sectionValue = (name, pose, t, tube) => (COLOURINGS[name].mode === 1 ? COLOURINGS[name].value(pose, t, tube) : () => 0);

export class Legend {
  constructor() {
    this.title = el("span");
    this.bar = el("div", { className: "ramp" });
    this.ticks = el("div", { className: "ticks" });
    this.node = el("div", { className: "legend", hidden: true }, this.title, this.bar, this.ticks);
  }

  set(name, [low, high]) {
    const { mode, signed, title, unit, factor = 1 } = COLOURINGS[name];
    this.node.hidden = mode === 0;
    if (mode === 0) return;
    this.title.textContent = `${title} (${unit})`;
    this.bar.style.background = `linear-gradient(to right, ${ramp(signed).join(", ")})`;
    const digits = Math.max(0, 2 - Math.floor(Math.log10(factor * (high - low))));
    const values = signed ? [low, 0, high] : [low, (low + high) / 2, high];
    this.ticks.replaceChildren(...values.map((v) => el("span", {}, show(factor * v, digits))));
  }
}
