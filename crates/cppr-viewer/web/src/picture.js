// The picture as a file: pixels, or the same view as vector graphics.

import { Color, Vector3 } from "three";
import { NODES } from "./pose.js";

/** The view as a PNG of twice the resolution of the screen. */
export function png(stage) {
  const { renderer } = stage;
  const ratio = renderer.getPixelRatio();
  renderer.setPixelRatio(2 * Math.max(1, ratio));
  stage.drawNow();
  return new Promise((resolve) => {
    renderer.domElement.toBlob((blob) => {
      renderer.setPixelRatio(ratio);
      stage.drawNow();
      resolve(blob);
    }, "image/png");
  });
}

/** Vertices of a tube as it is bent (mm), as the shader does it. */
function bent(tube) {
  const rest = tube.fine.getAttribute("position").array;
  const [from, to] = tube.uniforms.extent.value;
  const out = new Float32Array(rest.length);
  const row = 4 * NODES;
  const v = new Vector3();
  const q = { x: 0, y: 0, z: 0, w: 1 };
  for (let i = 0; i < rest.length; i += 3) {
    const place = Math.min(1, Math.max(0, (rest[i] - from) / (to - from))) * (NODES - 1);
    const left = Math.min(Math.floor(place), NODES - 2);
    const part = place - left;
    const mix = (at) => tube.data[at] + part * (tube.data[at + 4] - tube.data[at]);
    const base = row + 4 * left;
    [q.x, q.y, q.z, q.w] = [mix(base), mix(base + 1), mix(base + 2), mix(base + 3)];
    v.set(0, rest[i + 1], rest[i + 2]).applyQuaternion(q);
    out[i] = mix(4 * left) + v.x;
    out[i + 1] = mix(4 * left + 1) + v.y;
    out[i + 2] = mix(4 * left + 2) + v.z;
  }
  return out;
}

/** The view as SVG: triangles that face the camera from back to front, lines on top. */
export function svg(stage) {
  const { camera, canvas } = stage;
  const [w, h] = [canvas.clientWidth, canvas.clientHeight];
  camera.updateMatrixWorld();
  const point = new Vector3();
  const project = (x, y, z) => {
    point.set(x, y, z).project(camera);
    return [((point.x + 1) / 2) * w, ((1 - point.y) / 2) * h, point.z];
  };
  const light = stage.towardsKey;
  const faces = [];
  for (const tube of stage.tubes.filter((t) => t.mesh.visible)) {
    const positions = bent(tube);
    const screen = [];
    for (let i = 0; i < positions.length; i += 3) screen.push(project(positions[i], positions[i + 1], positions[i + 2]));
    const index = tube.fine.index.array;
    const base = tube.colour;
    for (let i = 0; i < index.length; i += 3) {
      const [a, b, c] = [index[i], index[i + 1], index[i + 2]];
      const [p, q, r] = [screen[a], screen[b], screen[c]];
      if ((q[0] - p[0]) * (r[1] - p[1]) - (q[1] - p[1]) * (r[0] - p[0]) >= 0) continue;
      const corner = (k) => new Vector3().fromArray(positions, 3 * k);
      const [pa, pb, pc] = [corner(a), corner(b), corner(c)];
      const normal = pb.sub(pa).cross(pc.sub(pa)).normalize();
      const level = Math.round((0.42 + 0.5 * Math.max(0, normal.dot(light))) * 24) / 24;
      faces.push({ depth: p[2] + q[2] + r[2], colour: `#${base.clone().multiplyScalar(level * 1.5).getHexString()}`, p, q, r });
    }
  }
  faces.sort((a, b) => b.depth - a.depth);
  let [body, colour, path] = ["", "", ""];
  const flush = () => path && (body += `<path fill="${colour}" stroke="${colour}" d="${path}"/>\n`);
  const n = (v) => Number(v.toFixed(1));
  for (const face of faces) {
    if (face.colour !== colour) {
      flush();
      [colour, path] = [face.colour, ""];
    }
    const { p, q, r } = face;
    path += `M${n(p[0])} ${n(p[1])}L${n(q[0])} ${n(q[1])} ${n(r[0])} ${n(r[1])}z`;
  }
  flush();
  for (const line of [stage.trace, ...stage.centroids, stage.centre].filter((l) => l.visible)) {
    const ends = Array.from({ length: line.points.length / 3 }, (_, i) => project(...line.points.slice(3 * i, 3 * i + 3)));
    const letter = (i) => (i === 0 || (line.gaps.has(i) && line.gaps.has(i - 1)) ? "M" : "L");
    const way = ends.map(([x, y], i) => `${letter(i)}${n(x)} ${n(y)}`).join("");
    body += `<path fill="none" stroke="#${line.material.color.getHexString()}" stroke-width="${line.width}" d="${way}"/>\n`;
  }
  const [x, y] = project(...stage.pose.tip_mm);
  body += `<circle cx="${n(x)}" cy="${n(y)}" r="4" fill="#${stage.tip.material.color.getHexString()}"/>\n`;
  const back = new Color(stage.scene.background).getHexString();
  return `<svg xmlns="http://www.w3.org/2000/svg" width="${w}" height="${h}" viewBox="0 0 ${w} ${h}" stroke-linejoin="round" stroke-width="0.4">
<rect width="100%" height="100%" fill="#${back}"/>\n${body}</svg>\n`;
}
