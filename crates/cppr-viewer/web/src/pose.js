// One pose: values along every tube at the sections that were sent, and between them.

/** Nodes along a tube's rest abscissa that the drawing interpolates between. */
export const NODES = 128;

export class Pose {
  /** @param {any} message head and floats, @param {string[]} columns */
  constructor(message, columns) {
    Object.assign(this, message);
    this.columns = columns;
    this.index = Object.fromEntries(columns.map((name, i) => [name, i]));
    // The tube that goes on to the tip, and the last section of each.
    this.spine ??= 0;
    this.ends ??= Array(this.tubes).fill(this.sections - 1);
  }

  /** Where a section is along the robot (mm): by the leader's label, or where tubes end apart by the length of the centreline. */
  place(s) {
    return this.along_mm?.[s] ?? this.at(s, 0, "abscissa");
  }

  #runs = null;

  /** Length of the centreline up to a section (mm). */
  run(s) {
    if (this.along_mm) return this.along_mm[s];
    if (!this.#runs) {
      const points = this.points(0, "x");
      const step = (i) => Math.hypot(...[0, 1, 2].map((k) => points[3 * i + k] - points[3 * i - 3 + k]));
      this.#runs = [0];
      for (let i = 1; i < this.sections; i++) this.#runs.push(this.#runs[i - 1] + step(i));
    }
    return this.#runs[s];
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
    if (this.index.stretch === undefined) return [0, 0, 0];
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
    const { floats, index, sections } = this;
    const [width, start] = [this.tubes * this.columns.length, t * this.columns.length];
    const first = floats[start + index.abscissa];
    const last = tube.depth_mm.length - 1;
    // Between sections s and s + 1 at part w; what belongs to a section is worked out once.
    let [s, w, a, b] = [0, 0, start, start + width];
    let [values, bends] = [[value(0), value(1)], [this.bending(0, t, tube), this.bending(1, t, tube)]];
    const mix = (column) => floats[a + column] + w * (floats[b + column] - floats[a + column]);
    for (let i = 0; i < NODES; i++) {
      const x = from + ((to - from) * i) / (NODES - 1);
      const below = x <= first;
      const before = s;
      while (s < sections - 2 && floats[start + (s + 1) * width + index.abscissa] < x) s++;
      if (s !== before) {
        [a, b] = [start + s * width, start + (s + 1) * width];
        values = [value(s), value(s + 1)];
        bends = [this.bending(s, t, tube), this.bending(s + 1, t, tube)];
      }
      const left = floats[a + index.abscissa];
      w = below ? 0 : Math.min(1, (x - left) / Math.max(1e-9, floats[b + index.abscissa] - left));
      let at = 4 * i;
      out[at] = below ? x - first : mix(index.x);
      out[at + 1] = below ? 0 : mix(index.y);
      out[at + 2] = below ? 0 : mix(index.z);
      out[at + 3] = below ? 0 : values[0] + w * (values[1] - values[0]);
      at += row;
      let [sign, norm] = [0, 0];
      for (let j = 0; j < 4; j++) sign += floats[a + index.qx + j] * floats[b + index.qx + j];
      for (let j = 0; j < 4; j++) {
        const q = (1 - w) * floats[a + index.qx + j] + w * (sign < 0 ? -1 : 1) * floats[b + index.qx + j];
        out[at + j] = q;
        norm += q * q;
      }
      for (let j = 0; j < 4; j++) out[at + j] /= Math.sqrt(norm);
      // Neighbours on one side of the sphere, so that they can be interpolated.
      let dot = 0;
      for (let j = 0; i > 0 && j < 4; j++) dot += out[at + j] * out[at + j - 4];
      for (let j = 0; dot < 0 && j < 4; j++) out[at + j] *= -1;
      at += row;
      for (let j = 0; j < 3; j++) out[at + j] = below ? 0 : bends[0][j] + w * (bends[1][j] - bends[0][j]);
      out[at + 3] = 0;
      at += row;
      const phi = mix(index.direction);
      const depth = tube.depth_mm[Math.round((Math.min(Math.max(x, 0), to) / to) * last)] ?? 0;
      out[at] = Math.cos(phi);
      out[at + 1] = Math.sin(phi);
      out[at + 2] = depth > 0 ? depth - tube.outer_mm : -1e6;
      out[at + 3] = 0;
    }
  }
}
