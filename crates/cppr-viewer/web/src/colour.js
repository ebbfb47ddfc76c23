// Colours of tubes and of values. Tubes and the ramp are those of the printed figures: they differ in
// lightness too, so that they are told apart in grey.

import { Color, DataTexture, LinearFilter, RGBAFormat, SRGBColorSpace } from "three";

const TUBES = {
  light: ["#0b3c6f", "#d9541e", "#4bbdae", "#8b2f7f", "#d0a200", "#5a5a5a"],
  dark: ["#6ea8e6", "#f08a55", "#63d2c2", "#cf7fc4", "#e3bf3c", "#b0b0b0"],
};
/** Bodies are paler than lines: shading needs room. */
const BODIES = {
  light: ["#8fabcd", "#eda27c", "#8ad3c8", "#c48dbc", "#e3c96b", "#a4a4a4"],
  dark: ["#6c8fbd", "#d9825a", "#57b3a6", "#ac70a3", "#c9a940", "#8c8c8c"],
};

export const lineColour = (tube, theme) => TUBES[theme][tube % 6];
export const bodyColour = (tube, theme) => BODIES[theme][tube % 6];

/** Part of the cividis map, for magnitudes. */
const RAMP = ["#00224e", "#35456c", "#666970", "#948e77", "#b5a56c", "#d9bf55", "#fee838"];
/** Blue over grey to red, for signed values. */
const BOTH = ["#1f4e9c", "#5b86c2", "#a9bddb", "#e4e4e2", "#e0b3a3", "#c96f54", "#9c2f1f"];

export const ramp = (signed) => (signed ? BOTH : RAMP);

/** The ramp as a texture. */
export function rampTexture(signed) {
  const stops = ramp(signed).map((c) => new Color(c).convertLinearToSRGB());
  const data = new Uint8Array(256 * 4);
  for (let i = 0; i < 256; i++) {
    const at = (i / 255) * (stops.length - 1);
    const left = Math.min(Math.floor(at), stops.length - 2);
    const c = stops[left].clone().lerp(stops[left + 1], at - left);
    data.set([255 * c.r, 255 * c.g, 255 * c.b, 255], 4 * i);
  }
  const texture = new DataTexture(data, 256, 1, RGBAFormat);
  texture.magFilter = LinearFilter;
  texture.minFilter = LinearFilter;
  texture.colorSpace = SRGBColorSpace;
  texture.needsUpdate = true;
  return texture;
}

/** The next of 1, 2, 5, 10 … times a power of ten. */
export function nice(value) {
  if (!(value > 0)) return 1;
  const unit = 10 ** Math.floor(Math.log10(value));
  return [1, 2, 5, 10].find((s) => s * unit >= value * (1 - 1e-9)) * unit;
}
