// By which value the tubes are coloured, and the legend.

import { nice, ramp } from "./colour.js";
import { el, show } from "./dom.js";

const magnitude = (pose, t) => (s) => Math.hypot(pose.at(s, t, "curvature_y"), pose.at(s, t, "curvature_z"));

/** A value of the notches and sections that are judged, between them along a tube; 0 where an uncut section has none. */
const between = (value) => (pose, t) => {
  const known = pose.limits.filter((l) => l.tube === t + 1).map((l) => [l.x_mm, value(l) ?? 0]);
  return (s) => {
    const x = pose.at(s, t, "abscissa");
    const next = known.findIndex((l) => l[0] >= x);
    if (next <= 0) return known.at(next)?.[1] ?? 0;
    const [a, b] = [known[next - 1], known[next]];
    return a[1] + ((b[1] - a[1]) * (x - a[0])) / (b[0] - a[0]);
  };
};

/** Largest strain of the notches, wherever along the tube. */
function extremeStrain(pose, t) {
  const most = Math.max(0, ...pose.limits.filter((l) => l.tube === t + 1).map((l) => Math.abs(l.strain)));
  return () => most;
}

/** What there is to colour by; mode: what the shader does: 0 nothing, 1 a value per section, 2 strain at every point. */
export const COLOURINGS = {
  tube: { label: "tube", mode: 0 },
  curvature: { label: "curvature", mode: 1, unit: "1/m", title: "Curvature", value: magnitude },
  strain: { label: "strain", mode: 2, signed: true, unit: "%", factor: 100, title: "Strain in the notches, teeth rigid", value: extremeStrain },
  closure: { label: "notch closure", mode: 1, unit: "%", factor: 100, title: "Closure of the notches, 100 % where teeth touch", value: between((l) => l.closure) },
};

/** Of robots with parts and joints, where the strain at every point is not known, but its greatest in every notch. */
export const COLOURINGS_OF_BUNDLES = {
  ...COLOURINGS,
  strain: { label: "strain", mode: 1, unit: "%", factor: 100, title: "Greatest strain in every notch, teeth rigid", value: between((l) => Math.abs(l.strain)) },
};

const largest = (pose, t, value) => {
  let most = 0;
  for (let s = 0; s < pose.sections; s++) most = Math.max(most, value(s));
  return most;
};

/** Bounds of the colours for a pose. */
export function range({ mode, signed, value, factor = 1 }, pose, tubes) {
  if (mode === 0) return [0, 1];
  const most = nice(factor * Math.max(...tubes.map((_, t) => largest(pose, t, value(pose, t))), 1e-6)) / factor;
  return signed ? [-most, most] : [0, most];
}

/** The value that the shader is given by section. */
export const sectionValue = ({ mode, value }, pose, t) => (mode === 1 ? value(pose, t) : () => 0);

export class Legend {
  constructor() {
    this.title = el("span");
    this.bar = el("div", { className: "ramp" });
    this.ticks = el("div", { className: "ticks" });
    this.node = el("div", { className: "legend", hidden: true }, this.title, this.bar, this.ticks);
  }

  set({ mode, signed, title, unit, factor = 1 }, [low, high]) {
    this.node.hidden = mode === 0;
    if (mode === 0) return;
    this.title.textContent = `${title} (${unit})`;
    this.bar.style.background = `linear-gradient(to right, ${ramp(signed).join(", ")})`;
    const digits = Math.max(0, 2 - Math.floor(Math.log10(factor * (high - low))));
    const values = signed ? [low, 0, high] : [low, (low + high) / 2, high];
    this.ticks.replaceChildren(...values.map((v) => el("span", {}, show(factor * v, digits))));
  }
}
