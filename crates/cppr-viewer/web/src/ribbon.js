// A line that keeps its width on the screen: a strip of triangles that faces the camera, laid out for every picture.
// (three.js draws such lines as instances, each of which costs software renderers as much as a whole mesh.)

import { BufferAttribute, BufferGeometry, DoubleSide, DynamicDrawUsage, Mesh, MeshBasicMaterial, Vector3 } from "three";

const [here, way, across, sight] = [new Vector3(), new Vector3(), new Vector3(), new Vector3()];

export class Ribbon extends Mesh {
  /** Three numbers for each point (mm). */
  points = [];
  /** Points at which it has no width: between two of them it is not seen. */
  gaps = new Set();

  /** `width` in px. */
  constructor(width) {
    super(new BufferGeometry(), new MeshBasicMaterial({ side: DoubleSide }));
    this.width = width;
    this.frustumCulled = false;
    this.visible = false;
  }

  /** Vertices for so many points. */
  #room(points) {
    const place = this.geometry.getAttribute("position");
    if (place && place.count >= 2 * points) return place.array;
    const count = Math.max(points, place?.count ?? 0);
    const index = [];
    for (let i = 0; i < count - 1; i++) index.push(2 * i, 2 * i + 1, 2 * i + 2, 2 * i + 2, 2 * i + 1, 2 * i + 3);
    this.geometry.dispose();
    this.geometry = new BufferGeometry();
    this.geometry.setIndex(index);
    this.geometry.setAttribute("position", new BufferAttribute(new Float32Array(6 * count), 3).setUsage(DynamicDrawUsage));
    return this.geometry.getAttribute("position").array;
  }

  /** Lays it out for a camera with so many pixels from top to bottom. */
  face(camera, height) {
    const { points } = this;
    const count = points.length / 3;
    if (!this.visible || count < 2) return;
    const out = this.#room(count);
    const pixel = (2 * Math.tan((camera.fov * Math.PI) / 360)) / (camera.zoom * height);
    camera.getWorldDirection(sight);
    for (let i = 0; i < count; i++) {
      here.fromArray(points, 3 * i);
      way.fromArray(points, 3 * Math.min(i + 1, count - 1));
      way.x -= points[3 * Math.max(i - 1, 0)];
      way.y -= points[3 * Math.max(i - 1, 0) + 1];
      way.z -= points[3 * Math.max(i - 1, 0) + 2];
      const eye = here.clone().sub(camera.position);
      way.cross(eye);
      // Where it runs along the line of sight it has no direction on the screen: it keeps the last one.
      if (way.lengthSq() > 0) across.copy(way).normalize();
      const half = this.gaps.has(i) ? 0 : 0.5 * this.width * pixel * eye.dot(sight);
      out.set([here.x + half * across.x, here.y + half * across.y, here.z + half * across.z], 6 * i);
      out.set([here.x - half * across.x, here.y - half * across.y, here.z - half * across.z], 6 * i + 3);
    }
    this.geometry.getAttribute("position").needsUpdate = true;
    this.geometry.setDrawRange(0, 6 * (count - 1));
  }
}
