// The axes of the base frame in a corner, as the camera sees them.

import { Vector3 } from "three";
import { shape } from "./dom.js";

const AXES = [["X", [1, 0, 0]], ["Y", [0, 1, 0]], ["Z", [0, 0, 1]]];
/** Length of an axis, and how far out its name stands. */
const [LENGTH, NAME] = [27, 36];

export class Triad {
  constructor() {
    this.node = shape("svg", { viewBox: "-44 -44 88 88", class: "triad", role: "img", "aria-label": "Axes of the base frame" });
    this.axes = AXES.map(([name, way], i) => {
      const line = shape("path", {});
      const text = shape("text", { "text-anchor": "middle", dy: "0.35em" }, name);
      return { way: new Vector3(...way), line, text, group: shape("g", { class: `axis${i}` }, line, text) };
    });
    this.node.append(...this.axes.map((a) => a.group));
  }

  /** Turns with the camera. */
  face(camera) {
    const q = camera.quaternion;
    if (this.seen?.equals(q)) return;
    this.seen = q.clone();
    const back = q.clone().conjugate();
    const seen = this.axes.map((axis) => ({ ...axis, v: axis.way.clone().applyQuaternion(back) }));
    for (const { v, line, text } of seen) {
      const [x, y] = [LENGTH * v.x, -LENGTH * v.y];
      const length = Math.hypot(x, y);
      // An axis along the line of sight is a dot.
      const head = Math.min(7, length);
      const [ux, uy] = length > 0 ? [x / length, y / length] : [0, 0];
      const [bx, by] = [x - head * ux, y - head * uy];
      const wing = 0.4 * head;
      line.setAttribute("d", `M0 0L${bx} ${by}M${x} ${y}L${bx - wing * uy} ${by + wing * ux}L${bx + wing * uy} ${by - wing * ux}Z`);
      const beside = length < 6 ? [9, -9] : [ux * (NAME - LENGTH), uy * (NAME - LENGTH)];
      text.setAttribute("x", x + beside[0]);
      text.setAttribute("y", y + beside[1]);
    }
    // What points at the reader covers the rest.
    seen.sort((a, b) => a.v.z - b.v.z);
    this.node.append(...seen.map((a) => a.group));
  }
}
