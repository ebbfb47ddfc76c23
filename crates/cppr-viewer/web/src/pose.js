// One pose: values along every tube at the sections that were sent, and between them.

/** Nodes along a tube's rest abscissa that the drawing interpolates between. */
export const NODES = 128;

export class Pose {
  /** @param {any} message head and floats, @param {string[]} columns */
  constructor(message, columns) {
    Object.assign(this, message);
    this.columns = columns;
    this.index = Object.fromEntries(columns.map((name, i) => [name, i]));
  }

  /** One value of tube `t` at section `s`. */
  at(s, t, column) {
    return this.floats[(s * this.tubes + t) * this.columns.length + this.index[column]];
  }

  /** Values of a tube from the plate to the tip. */
  along(t, column) {
    return Float32Array.from({ length: this.sections }, (_, s) => this.at(s, t, column));
  }

  /** Points of a line: `x` the centreline, `centroid_x` a centroid line. */
  points(t, column) {
    const out = new Float32Array(3 * this.sections);
    const c = this.index[column];
    for (let s = 0; s < this.sections; s++) {
      const at = (s * this.tubes + t) * this.columns.length + c;
      out.set(this.floats.subarray(at, at + 3), 3 * s);
    }
    return out;
  }

  /**
   * What makes the strain of tube `t` inside its notches at section `s`: strain at the centre, and curvatures about
   * the section's axes. Teeth are rigid, so that the notches bend for them.
   */
  bending(s, t, tube) {
    const share = tube.notch_mm > 0 ? (tube.notch_mm + tube.tooth_mm) / tube.notch_mm : 1;
    const [ky, kz] = [share * this.at(s, t, "curvature_y"), share * this.at(s, t, "curvature_z")];
    // ε(Y, Z) = e − κ_Z (Y − D) + κ_Y Z, D of the section as it is cut.
    return [this.at(s, t, "stretch") + (kz * this.at(s, t, "offset") * 1e-3) / tube.offset_factor, ky, kz];
  }

  /**
   * Four rows of NODES texels for the shader, evenly along the tube's rest abscissa from `from` to `to` (mm): centre
   * and `value(s)`; rotation; bending; direction of the section and the floor of its notch. Below the plate a tube is straight.
   */
  texels(t, from, to, tube, value, out) {
    const row = 4 * NODES;
    const first = this.at(0, t, "abscissa");
    let s = 0;
    const last = tube.depth_mm.length - 1;
    const notch = (x, phi) => {
      const depth = tube.depth_mm[Math.round((Math.min(Math.max(x, 0), to) / to) * last)] ?? 0;
      return [Math.cos(phi), Math.sin(phi), depth > 0 ? depth - tube.outer_mm : -1e6, 0];
    };
    const rotation = (section) => ["qx", "qy", "qz", "qw"].map((c) => this.at(section, t, c));
    for (let i = 0; i < NODES; i++) {
      const x = from + ((to - from) * i) / (NODES - 1);
      if (x <= first) {
        out.set([x - first, 0, 0, 0], 4 * i);
        out.set(rotation(0), row + 4 * i);
        out.set([0, 0, 0, 0], 2 * row + 4 * i);
        out.set(notch(x, this.at(0, t, "direction")), 3 * row + 4 * i);
        continue;
      }
      while (s < this.sections - 2 && this.at(s + 1, t, "abscissa") < x) s++;
      const left = this.at(s, t, "abscissa");
      const w = Math.min(1, (x - left) / Math.max(1e-9, this.at(s + 1, t, "abscissa") - left));
      const mix = (a, b) => a + w * (b - a);
      const centre = ["x", "y", "z"].map((c) => mix(this.at(s, t, c), this.at(s + 1, t, c)));
      out.set([...centre, mix(value(s), value(s + 1))], 4 * i);
      const [a, b] = [rotation(s), rotation(s + 1)];
      const sign = Math.sign(a.reduce((sum, v, j) => sum + v * b[j], 0)) || 1;
      const q = a.map((v, j) => mix(v, sign * b[j]));
      const norm = Math.hypot(...q);
      out.set(q.map((v) => v / norm), row + 4 * i);
      const [c, d] = [this.bending(s, t, tube), this.bending(s + 1, t, tube)];
      out.set([...c.map((v, j) => mix(v, d[j])), 0], 2 * row + 4 * i);
      out.set(notch(x, mix(this.at(s, t, "direction"), this.at(s + 1, t, "direction"))), 3 * row + 4 * i);
    }
    // Neighbours on one side of the sphere, so that they can be interpolated.
    for (let i = 1; i < NODES; i++) {
      const [a, b] = [row + 4 * (i - 1), row + 4 * i];
      let dot = 0;
      for (let j = 0; j < 4; j++) dot += out[a + j] * out[b + j];
      if (dot < 0) for (let j = 0; j < 4; j++) out[b + j] *= -1;
    }
  }
}
