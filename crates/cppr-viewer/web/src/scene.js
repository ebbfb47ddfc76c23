// The picture: camera and light, the tubes, and the lines drawn with them. Drawn when something changes, not in between, and at most
// once for every picture of the screen. Millimetres; +Z is up.

import {
  AmbientLight, Box3, BufferAttribute, BufferGeometry, Color, DirectionalLight, GridHelper, Group, HemisphereLight, LineBasicMaterial,
  LineSegments, Mesh, MeshBasicMaterial, MeshLambertMaterial, PerspectiveCamera, Points, PointsMaterial, RingGeometry, Scene,
  ShaderMaterial, SphereGeometry, TorusGeometry, Vector3, Vector4, WebGLRenderer,
} from "three";
import { OrbitControls } from "three/addons/controls/OrbitControls.js";
import { lineColour, nice } from "./colour.js";
import { AMBIENT, GROUND, KEY, SKY } from "./light.js";
import { Pace } from "./pace.js";
import { Ribbon } from "./ribbon.js";
import { Smooth } from "./smooth.js";
import { Triad } from "./triad.js";
import { Tube } from "./tubes.js";

/** Directions from which the camera looks, and what is up. */
export const VIEWS = {
  space: { from: [-0.45, -1, 0.75], label: "3D", title: "From the side and above" },
  plane: { from: [0, -0.001, 1], label: "X–Y", title: "Plane X–Y, seen from +Z" },
  side: { from: [0, -1, 0], label: "X–Z", title: "Plane X–Z, seen from −Y" },
  tip: { from: [1, 0, 0.001], label: "Y–Z", title: "Plane Y–Z, seen from +X, beyond the tip" },
};

const INK = { light: "#22262b", dark: "#e8eaed" };
const BACK = { light: "#f7f7f5", dark: "#15181b" };
const TRACE = { light: "#8e2a8b", dark: "#d58ad2" };

/** One colour as the screen has it, red to opacity: nothing is worked out at the many pixels of the grid. */
const flat = () =>
  new ShaderMaterial({
    uniforms: { colour: { value: new Vector4() } },
    vertexShader: "void main() { gl_Position = projectionMatrix * modelViewMatrix * vec4(position, 1.0); }",
    fragmentShader: "uniform vec4 colour; void main() { gl_FragColor = colour; }",
    transparent: true,
    depthWrite: false,
  });

/** Time for shapes that wait to be taken in (ms). */
const TAKE = 2;
/** After so long without a change the robot is at rest (ms). */
const REST = 250;
/** A view is seen while the camera is turned away from it by less (rad). */
const SAME_VIEW = 5e-3;
/** A tip that moves by more of the length at once has jumped: its trace has a gap there. */
const JUMP = 0.1;

export class Stage {
  tubes = [];
  /** All lines of constant width. */
  lines = [];
  show = { tubes: true, lines: true, frames: false, trace: false, cloud: true, grid: true, glass: false };
  theme = "light";
  /** Of the picture (px). */
  height = 1;
  /** Does the camera go with the tip? */
  following = false;
  /** Called where the camera moved. */
  turned = () => {};
  /** Places of the tip (mm); with a gap before and after where it jumped. */
  tracePoints = [];
  #fresh = true;
  #queued = false;
  /** Does a picture wait for the screen to take it? */
  #drawn = false;
  /** Of the pictures drawn for the screen. */
  #count = 0;
  #bent = true;
  #resting = null;

  constructor(host) {
    this.host = host;
    this.renderer = new WebGLRenderer({ antialias: false });
    this.renderer.setPixelRatio(Math.min(devicePixelRatio, 2));
    this.smooth = new Smooth(this.renderer);
    this.pace = new Pace(this.renderer.getContext());
    this.canvas = this.renderer.domElement;
    this.canvas.tabIndex = 0;
    this.canvas.setAttribute("aria-label", "The robot. Arrow keys turn it, plus and minus zoom.");
    this.triad = new Triad();
    host.append(this.canvas, this.triad.node);
    this.scene = new Scene();
    this.camera = new PerspectiveCamera(28, 1, 1, 1e5);
    this.camera.up.set(0, 0, 1);
    this.controls = new OrbitControls(this.camera, this.canvas);
    this.controls.addEventListener("change", () => {
      this.turned();
      this.draw();
    });
    this.controls.zoomToCursor = true;
    this.key = new DirectionalLight("#ffffff", KEY);
    this.towardsKey = new Vector3();
    this.scene.add(new HemisphereLight(SKY.colour, GROUND, SKY.intensity), new AmbientLight("#ffffff", AMBIENT), this.key, this.key.target);
    this.robot = new Group();
    this.scene.add(this.robot);
    this.canvas.addEventListener("keydown", (event) => this.#turn(event));
    new ResizeObserver(() => this.#resize()).observe(host);
  }

  /** Everything that belongs to one robot, empty yet. */
  begin(description) {
    for (const tube of this.tubes) tube.dispose();
    this.robot.clear();
    this.description = description;
    this.length = description.length_mm;
    const outer = Math.max(...description.tubes.map((t) => t.outer_mm ?? 0), 0.02 * this.length);
    this.outer = outer;
    this.tubes = description.tubes.map((t, i) => new Tube(i, t, this.towardsKey));
    this.centroids = description.tubes.map((t) => new Ribbon(t.outer_mm ? 2.2 : 5));
    this.centre = new Ribbon(1.4);
    this.trace = new Ribbon(2);
    this.lines = [...this.centroids, this.centre, this.trace];
    this.frames = new LineSegments(new BufferGeometry(), new LineBasicMaterial({ vertexColors: true }));
    this.frames.frustumCulled = false;
    this.cloud = new Points(new BufferGeometry(), new PointsMaterial({ size: 2.2, sizeAttenuation: false, transparent: true, opacity: 0.6 }));
    this.cloud.frustumCulled = false;
    this.mark = new Mesh(new RingGeometry(1.06 * outer, 1.22 * outer, 64), new MeshBasicMaterial({ side: 2, transparent: true, opacity: 0.85 }));
    this.mark.visible = false;
    this.tip = new Mesh(new SphereGeometry(0.16 * outer, 14, 9), new MeshBasicMaterial());
    this.joints = [];
    this.band = new TorusGeometry(1.06, 0.07, 10, 48);
    this.bandMaterial = new MeshBasicMaterial();
    this.plate = new Mesh(new RingGeometry(outer * 1.02, outer * 2.6, 96), new MeshLambertMaterial({ side: 2, transparent: true, opacity: 0.55, forceSinglePass: true }));
    this.plate.rotation.y = Math.PI / 2;
    const step = nice(this.length / 20);
    const cells = Math.ceil((2 * this.length) / step / 2) * 2;
    this.gridStep = step;
    this.grid = new GridHelper(cells * step, cells);
    this.grid.material.dispose();
    this.grid.material = flat();
    this.grid.rotation.x = Math.PI / 2;
    this.grid.position.set(0.5 * this.length, 0, -3 * outer);
    this.robot.add(
      ...this.tubes.map((t) => t.mesh), ...this.lines, this.frames, this.cloud, this.mark, this.tip,
      this.plate, this.grid,
    );
    this.clearTrace();
    this.pose = null;
    this.#bent = true;
    this.paint();
  }

  /** Bends the robot; `value(t)` gives the coloured value of tube t by section. */
  bend(pose, value) {
    if (this.following && this.pose) this.#shift(pose.tip_mm.map((v, i) => v - this.pose.tip_mm[i]));
    this.pose = pose;
    this.value = value;
    this.#bent = false;
    this.#lengthen(pose.tip_mm);
    this.#visible();
    this.draw();
  }

  /** Gives the pose to the graphics card, the newest only. */
  #shape() {
    const { pose } = this;
    this.#bent = true;
    this.tubes.forEach((tube, t) => tube.bend(pose, this.value(t)));
    this.centroids.forEach((line, t) => (line.points = pose.points(t, "centroid_x")));
    this.centre.points = pose.points(pose.spine, "x");
    this.#joints(pose);
    this.tip.position.set(...pose.tip_mm);
    if (this.show.trace) {
      this.trace.points = this.tracePoints.flatMap((p) => p.at);
      this.trace.gaps = new Set(this.tracePoints.flatMap((p, i) => (p.gap ? [i] : [])));
    }
    if (this.show.frames) this.#frames(pose);
  }

  /** A band around each joint, and its tubes. */
  #joints(pose) {
    const joints = pose.joints ?? [];
    while (this.joints.length > joints.length) this.robot.remove(this.joints.pop());
    while (this.joints.length < joints.length) {
      const band = new Mesh(this.band, this.bandMaterial);
      this.joints.push(band);
      this.robot.add(band);
    }
    joints.forEach(([section, tube], i) => {
      const { joints: bands } = this;
      bands[i].position.set(...["x", "y", "z"].map((c) => pose.at(section, tube, c)));
      bands[i].quaternion.set(...["qx", "qy", "qz", "qw"].map((c) => pose.at(section, tube, c)));
      // A ring lies across its own z; sections lie across x.
      bands[i].rotateY(Math.PI / 2);
      bands[i].scale.setScalar(this.description.tubes[tube].outer_mm ?? this.outer);
    });
  }

  /** The axes of some sections of the leader and of the followers. */
  #frames(pose) {
    const [positions, colours] = [[], []];
    const size = 0.06 * this.length;
    const axes = [[1, 0, 0], [0, 1, 0], [0, 0, 1]].map((a) => new Vector3(...a));
    const hues = [lineColour(1, this.theme), lineColour(2, this.theme), lineColour(0, this.theme)].map((c) => new Color(c));
    for (let s = 0; s < pose.sections; s += 12) {
      for (let t = 0; t < pose.tubes; t++) {
        if (s > pose.ends[t]) continue;
        const q = ["qx", "qy", "qz", "qw"].map((c) => pose.at(s, t, c));
        const at = new Vector3(pose.at(s, t, "centroid_x"), pose.at(s, t, "centroid_y"), pose.at(s, t, "centroid_z"));
        const phi = pose.at(s, t, "direction");
        axes.forEach((axis, i) => {
          const own = axis.clone().applyAxisAngle(axes[0], phi).applyQuaternion({ x: q[0], y: q[1], z: q[2], w: q[3] });
          const end = at.clone().addScaledVector(own, size * (t === 0 ? 1 : 0.7));
          positions.push(...at, ...end);
          colours.push(...hues[i], ...hues[i]);
        });
      }
    }
    this.frames.geometry.dispose();
    this.frames.geometry = new BufferGeometry();
    this.frames.geometry.setAttribute("position", new BufferAttribute(new Float32Array(positions), 3));
    this.frames.geometry.setAttribute("color", new BufferAttribute(new Float32Array(colours), 3));
  }

  /** Points that the tip can reach; null clears them. */
  addCloud(points) {
    const old = points ? (this.cloud.geometry.getAttribute("position")?.array ?? []) : [];
    const all = new Float32Array(old.length + (points?.length ?? 0));
    all.set(old);
    if (points) all.set(points, old.length);
    this.cloud.geometry.dispose();
    this.cloud.geometry = new BufferGeometry();
    this.cloud.geometry.setAttribute("position", new BufferAttribute(all, 3));
    this.draw();
  }

  /** The next shape begins a new trace. */
  clearTrace() {
    this.#fresh = true;
  }

  /** The trace goes on to here; where the tip has jumped, after a gap. */
  #lengthen(at) {
    if (this.#fresh) this.tracePoints = [];
    this.#fresh = false;
    const points = this.tracePoints;
    const last = points.at(-1);
    const way = last ? Math.hypot(...last.at.map((v, i) => v - at[i])) : Infinity;
    if (way <= 0.002 * this.length) return;
    if (last && way > JUMP * this.length) points.push({ at: last.at, gap: true }, { at, gap: true });
    points.push({ at, gap: false });
    if (points.length > 2000) points.splice(0, points.length - 2000);
  }

  /** Camera and what it looks at, moved together (mm). */
  #shift(way) {
    const { camera, controls } = this;
    const by = new Vector3(...way);
    controls.target.add(by);
    camera.position.add(by);
    controls.update();
  }

  /** Follows the tip from now on, or lets it go. */
  follow(wanted) {
    this.following = wanted;
    if (wanted && this.pose) this.#shift(new Vector3(...this.pose.tip_mm).sub(this.controls.target).toArray());
  }

  /** Comes near enough, from where it looks, that the robot as it is now fills the picture. */
  fit() {
    if (!this.pose) return;
    const { camera, controls, pose } = this;
    const points = pose.points(pose.spine, "x");
    const box = new Box3().setFromArray(points);
    box.expandByPoint(new Vector3(...pose.tip_mm)).expandByScalar(2.6 * this.outer);
    const middle = box.getCenter(new Vector3());
    const radius = 0.5 * box.getSize(new Vector3()).length();
    const from = camera.position.clone().sub(controls.target).normalize();
    const half = Math.tan((camera.fov * Math.PI) / 360);
    this.#stand(middle, from, radius / (half * Math.min(1, camera.aspect)));
  }

  /** Name of the view from which the camera looks; null where it is none of them. */
  get view() {
    const probe = new PerspectiveCamera();
    probe.up.copy(this.camera.up);
    const near = Object.keys(VIEWS).find((name) => {
      probe.position.set(...VIEWS[name].from);
      probe.lookAt(0, 0, 0);
      return probe.quaternion.angleTo(this.camera.quaternion) < SAME_VIEW;
    });
    return near ?? null;
  }

  #stand(target, from, distance) {
    const { camera, controls } = this;
    controls.target.copy(target);
    camera.position.copy(target).addScaledVector(from, distance);
    camera.near = distance / 100;
    camera.far = distance * 20;
    camera.updateProjectionMatrix();
    controls.update();
    this.turned();
    this.draw();
  }

  /** A ring around one section; null takes it away. */
  highlight(section) {
    this.mark.visible = section !== null && this.pose !== null;
    if (this.mark.visible) {
      const p = this.pose;
      this.mark.position.set(...["x", "y", "z"].map((c) => p.at(section, p.spine, c)));
      this.mark.quaternion.set(...["qx", "qy", "qz", "qw"].map((c) => p.at(section, p.spine, c)));
      // A ring lies across its own z; sections lie across x.
      this.mark.rotateY(Math.PI / 2);
    }
    this.draw();
  }

  /** Colours of the theme and of the values. */
  paint(options = this.painted ?? { mode: 0, signed: false, range: [0, 1], dimmed: false }) {
    this.painted = options;
    const ink = new Color(INK[this.theme]);
    this.scene.background = new Color(BACK[this.theme]);
    if (!this.description) return;
    const { dimmed } = options;
    this.tubes.forEach((tube, t) => {
      const glass = this.show.glass && t < this.tubes.length - 1;
      tube.paint({ ...options, theme: this.theme, opacity: glass ? 0.28 : 1 });
    });
    this.centroids.forEach((line, t) => {
      line.material.color = new Color(lineColour(t, this.theme));
      line.material.opacity = dimmed ? 0.25 : 1;
      line.material.transparent = dimmed;
    });
    this.centre.material.color = ink;
    this.centre.material.opacity = dimmed ? 0.25 : 1;
    this.centre.material.transparent = dimmed;
    this.trace.material.color = new Color(TRACE[this.theme]);
    this.cloud.material.color = new Color(lineColour(2, this.theme));
    this.mark.material.color = new Color(TRACE[this.theme]);
    this.tip.material.color = new Color(TRACE[this.theme]);
    this.bandMaterial.color = ink;
    this.plate.material.color = new Color(this.theme === "dark" ? "#59616a" : "#c9c9c4");
    this.grid.material.uniforms.colour.value.set(...(this.theme === "dark" ? [1, 1, 1, 0.1] : [0, 0, 0, 0.09]));
    this.#visible();
    this.draw();
  }

  #visible() {
    const { show, pose } = this;
    if (!this.description) return;
    this.tubes.forEach((t) => (t.mesh.visible = show.tubes && pose !== null && t.fine !== null));
    // Inside solid tubes lines show through, else they would not be seen at all.
    for (const line of [...this.centroids, this.centre]) {
      line.visible = pose !== null && show.lines;
      line.material.depthTest = !show.tubes;
      line.renderOrder = 5;
    }
    this.centroids.forEach((line, t) => {
      if (pose && !this.description.tubes[t].outer_mm) line.visible = true;
    });
    this.trace.visible = show.trace && this.tracePoints.length > 1;
    this.frames.visible = show.frames && pose !== null;
    this.cloud.visible = show.cloud;
    this.grid.visible = show.grid;
    this.tip.visible = pose !== null;
  }

  /** Looks from a direction at the whole robot. */
  look(name) {
    const from = new Vector3(...VIEWS[name].from).normalize();
    const reach = 0.56 * this.length;
    const aspect = this.camera.aspect;
    const half = Math.tan((this.camera.fov * Math.PI) / 360);
    const distance = (reach * 1.08) / (half * Math.min(1, aspect * 0.92));
    this.#stand(new Vector3((name === "tip" ? 0.3 : 0.46) * this.length, 0, 0), from, distance);
  }

  #turn(event) {
    const { camera, controls } = this;
    const offset = camera.position.clone().sub(controls.target);
    const across = new Vector3().crossVectors(offset, camera.up).normalize();
    const angle = 0.08;
    switch (event.key) {
      case "ArrowLeft": offset.applyAxisAngle(camera.up, -angle); break;
      case "ArrowRight": offset.applyAxisAngle(camera.up, angle); break;
      case "ArrowUp": offset.applyAxisAngle(across, -angle); break;
      case "ArrowDown": offset.applyAxisAngle(across, angle); break;
      case "+": case "=": offset.multiplyScalar(0.9); break;
      case "-": offset.multiplyScalar(1 / 0.9); break;
      default: return;
    }
    event.preventDefault();
    camera.position.copy(controls.target).add(offset);
    controls.update();
    this.draw();
  }

  #resize() {
    const { clientWidth: w, clientHeight: h } = this.host;
    if (w === 0 || h === 0) return;
    this.renderer.setSize(w, h);
    // Noted, because asking the canvas for it would lay out the page anew.
    this.height = h;
    this.camera.aspect = w / h;
    this.camera.updateProjectionMatrix();
    this.#drawMoving();
  }

  /** Draws at the end of the present task, or after the next picture of the screen where one is drawn for this. */
  draw() {
    if (this.#queued) return;
    this.#queued = true;
    if (!this.#drawn) queueMicrotask(() => this.#next());
  }

  #next() {
    if (!this.#queued) return;
    this.#drawMoving();
    this.#drawn = true;
    // The screen takes the picture at the end of its next frame: another one before that would be drawn for nothing. A renderer
    // without a graphics card keeps the page waiting for that; shapes that came meanwhile are taken in before the next picture,
    // unless the frame after it is there already.
    const own = ++this.#count;
    const open = () => {
      if (own !== this.#count || !this.#drawn) return;
      this.#drawn = false;
      this.#next();
    };
    requestAnimationFrame(() => {
      setTimeout(() => setTimeout(open, TAKE));
      requestAnimationFrame(open);
    });
  }

  #drawMoving() {
    const { fast } = this.pace;
    this.drawNow(fast);
    clearTimeout(this.#resting);
    this.#resting = fast ? null : setTimeout(() => this.drawNow(), REST);
  }

  /** Does a picture of the moving robot wait for a better one? */
  get moving() {
    return this.#queued || this.#resting !== null;
  }

  /** Draws at once, as good as can be or with plain edges. */
  drawNow(smooth = true) {
    this.#queued = false;
    if (!this.#bent) this.#shape();
    this.before?.();
    this.triad.face(this.camera);
    for (const tube of this.tubes) tube.detail(smooth);
    for (const line of this.lines) line.face(this.camera, this.height);
    this.key.position.copy(this.camera.position);
    this.key.position.addScaledVector(new Vector3(0.25, 0.3, 0.9), this.camera.position.distanceTo(this.controls.target));
    this.key.target.position.copy(this.controls.target);
    this.towardsKey.subVectors(this.key.position, this.key.target.position).normalize();
    if (smooth) {
      this.#resting = null;
      this.smooth.render(this.scene, this.camera);
      this.pace.watch();
    } else {
      this.renderer.render(this.scene, this.camera);
      // Drawn while the page does something else, not when the screen asks for it: some drivers begin at a fence only.
      const gl = this.renderer.getContext();
      gl.deleteSync(gl.fenceSync(gl.SYNC_GPU_COMMANDS_COMPLETE, 0));
      gl.flush();
    }
  }
}
