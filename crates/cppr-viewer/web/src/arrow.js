// What is dragged at the tip: the head of the arrow that is the force on it, or, where the tip itself is moved, the tip. Without a
// force the handle waits at the tip.

import { ConeGeometry, CylinderGeometry, Group, Mesh, MeshBasicMaterial, Plane, Raycaster, RingGeometry, Vector2, Vector3 } from "three";

/** Length of the arrow of the full force, as a part of the robot's. */
const REACH = 0.4;

export class Arrow {
  /** Is the tip moved, and not the force? */
  moves = false;

  /** `pull(force)` or `reach(place)` while it is dragged, `done()` after; one that is not `live` only shows the force. */
  constructor(stage, { live, pull, reach, done }) {
    this.stage = stage;
    this.live = live;
    this.pull = pull;
    this.reach = reach;
    this.done = done;
    this.force = [0, 0, 0];
    this.group = new Group();
    this.shaft = new Mesh(new CylinderGeometry(1, 1, 1, 16), new MeshBasicMaterial());
    this.head = new Mesh(new ConeGeometry(1, 1, 24), new MeshBasicMaterial());
    this.handle = new Mesh(new RingGeometry(0.72, 1, 40), new MeshBasicMaterial({ side: 2, transparent: true, opacity: 0.8, depthTest: false }));
    this.handle.renderOrder = 9;
    this.group.add(this.shaft, this.head, this.handle);
    const { canvas } = stage;
    canvas.addEventListener("pointerdown", (e) => this.#down(e), { capture: true });
    canvas.addEventListener("pointermove", (e) => this.#hover(e));
  }

  begin(full) {
    this.full = full;
    this.stage.robot.add(this.group);
  }

  get scale() {
    return (REACH * this.stage.length) / this.full;
  }

  /** Where the head of the arrow is (mm). */
  end() {
    const tip = new Vector3(...(this.stage.pose?.tip_mm ?? [0, 0, 0]));
    return tip.addScaledVector(new Vector3(...this.force), this.scale);
  }

  /** Where the handle is (mm). */
  grip() {
    return this.moves ? new Vector3(...(this.stage.pose?.tip_mm ?? [0, 0, 0])) : this.end();
  }

  update(force, colour) {
    this.force = force;
    const { stage } = this;
    const radius = 0.006 * stage.length;
    const tip = new Vector3(...(stage.pose?.tip_mm ?? [0, 0, 0]));
    const way = this.end().sub(tip);
    const length = way.length();
    const there = length > 1e-6 * stage.length;
    this.group.visible = stage.pose !== null;
    this.handle.visible = this.live;
    for (const part of [this.shaft, this.head]) {
      part.visible = there;
      part.material.color.set(colour);
      if (there) part.quaternion.setFromUnitVectors(new Vector3(0, 1, 0), way.clone().normalize());
    }
    if (there) {
      const head = Math.min(6 * radius, length);
      this.shaft.scale.set(radius, Math.max(length - head, 1e-3), radius);
      this.shaft.position.copy(tip).addScaledVector(way, (0.5 * (length - head)) / length);
      this.head.scale.set(2.6 * radius, head, 2.6 * radius);
      this.head.position.copy(tip).addScaledVector(way, (length - 0.5 * head) / length);
    }
    this.handle.material.color.set(colour);
    this.handle.scale.setScalar(4 * radius);
    this.handle.position.copy(this.grip());
    this.handle.quaternion.copy(stage.camera.quaternion);
    stage.draw();
  }

  /** The handle faces the camera. */
  face() {
    this.handle.quaternion.copy(this.stage.camera.quaternion);
  }

  #ray(event) {
    const box = this.stage.canvas.getBoundingClientRect();
    const at = new Vector2(((event.clientX - box.left) / box.width) * 2 - 1, 1 - ((event.clientY - box.top) / box.height) * 2);
    const caster = new Raycaster();
    caster.setFromCamera(at, this.stage.camera);
    return caster;
  }

  /** Where the handle is on the screen (px). */
  screen() {
    const box = this.stage.canvas.getBoundingClientRect();
    const p = this.grip().project(this.stage.camera);
    return [box.left + ((p.x + 1) / 2) * box.width, box.top + ((1 - p.y) / 2) * box.height];
  }

  #near(event) {
    if (!this.group.visible || !this.live) return false;
    const [x, y] = this.screen();
    return Math.hypot(event.clientX - x, event.clientY - y) < 18;
  }

  #hover(event) {
    if (event.buttons === 0) this.stage.canvas.style.cursor = this.#near(event) ? "grab" : "";
  }

  #down(event) {
    if (event.button !== 0 || !this.#near(event)) return;
    event.stopImmediatePropagation();
    const { canvas, camera, controls } = this.stage;
    controls.enabled = false;
    canvas.setPointerCapture(event.pointerId);
    canvas.style.cursor = "grabbing";
    const plane = new Plane().setFromNormalAndCoplanarPoint(camera.getWorldDirection(new Vector3()), this.grip());
    const drag = (e) => {
      const point = this.#ray(e).ray.intersectPlane(plane, new Vector3());
      if (!point) return;
      if (this.moves) {
        this.reach(point.toArray());
        return;
      }
      const tip = new Vector3(...this.stage.pose.tip_mm);
      const force = point.sub(tip).divideScalar(this.scale);
      // Close to the tip no force is meant.
      const digits = 10 ** Math.ceil(2 - Math.log10(this.full));
      const clean = (v) => Math.round(v * digits) / digits;
      this.pull(force.length() < 0.05 * this.full ? [0, 0, 0] : force.toArray().map(clean));
    };
    const up = () => {
      canvas.removeEventListener("pointermove", drag);
      canvas.style.cursor = "";
      controls.enabled = true;
      this.done();
    };
    canvas.addEventListener("pointermove", drag);
    canvas.addEventListener("pointerup", up, { once: true });
    canvas.addEventListener("pointercancel", up, { once: true });
  }
}
