// The notched tubes: the body of each at rest goes to the graphics card once and is bent there, section by section,
// by frames over its rest abscissa.

import { BufferAttribute, BufferGeometry, Color, DataTexture, FloatType, Mesh, NearestFilter, RGBAFormat, ShaderMaterial } from "three";
import { bodyColour, rampTexture } from "./colour.js";
import { NODES } from "./pose.js";
import { AMBIENT, GROUND, KEY, SKY } from "./light.js";

const linear = (colour, intensity) => `vec3(${new Color(colour).multiplyScalar(intensity).toArray().map((v) => v.toFixed(5))})`;

// Light, and the colour of a plain body as the screen has it, are worked out at the vertices: bodies are fine enough for that,
// and a renderer without a graphics card spends twice as long on a picture that is lit at every pixel.
const VERTEX = `
uniform sampler2D frames;
uniform vec2 extent;
uniform int mode;
uniform vec2 range;
uniform vec3 key;
uniform vec3 colour;
varying float vValue;
varying float vKept;
varying vec3 vLight;
vec3 encoded(vec3 c) { return mix(1.055 * pow(c, vec3(1.0 / 2.4)) - 0.055, 12.92 * c, vec3(lessThanEqual(c, vec3(0.0031308)))); }
vec3 turn(vec4 q, vec3 v) { return v + 2.0 * cross(q.xyz, cross(q.xyz, v) + q.w * v); }
void main() {
  float place = clamp((position.x - extent.x) / (extent.y - extent.x), 0.0, 1.0) * float(${NODES - 1});
  int left = min(int(place), ${NODES - 2});
  float part = place - float(left);
  vec4 spine = mix(texelFetch(frames, ivec2(left, 0), 0), texelFetch(frames, ivec2(left + 1, 0), 0), part);
  vec4 turning = normalize(mix(texelFetch(frames, ivec2(left, 1), 0), texelFetch(frames, ivec2(left + 1, 1), 0), part));
  float value = spine.w;
  vKept = 1.0;
  if (mode == 2) {
    vec4 bending = mix(texelFetch(frames, ivec2(left, 2), 0), texelFetch(frames, ivec2(left + 1, 2), 0), part);
    vec4 section = mix(texelFetch(frames, ivec2(left, 3), 0), texelFetch(frames, ivec2(left + 1, 3), 0), part);
    vec2 own = vec2(dot(position.yz, section.xy), dot(position.yz, vec2(-section.y, section.x)));
    value = bending.x + 1e-3 * (bending.y * own.y - bending.z * own.x);
    // Teeth, beyond the floor of the notches, are not strained.
    vKept = own.x - section.z + 0.02;
  }
  vValue = (value - range.x) / (range.y - range.x);
  vec3 across = turn(turning, normal);
  vec3 sky = mix(${linear(GROUND, SKY.intensity)}, ${linear(SKY.colour, SKY.intensity)}, 0.5 + 0.5 * across.y);
  vLight = (${linear("#ffffff", AMBIENT)} + sky + ${KEY.toFixed(5)} * max(0.0, dot(across, key))) / ${Math.PI};
  if (mode == 0) vLight = encoded(colour * vLight);
  vec3 there = spine.xyz + turn(turning, vec3(0.0, position.yz));
  gl_Position = projectionMatrix * modelViewMatrix * vec4(there, 1.0);
}
`;
const FRAGMENT = `
uniform sampler2D ramp;
uniform int mode;
uniform vec3 colour;
uniform float opacity;
varying float vValue;
varying float vKept;
varying vec3 vLight;
void main() {
  if (mode == 0) {
    gl_FragColor = vec4(vLight, opacity);
  } else {
    vec3 own = vKept >= 0.0 ? texture2D(ramp, vec2(clamp(vValue, 0.0, 1.0), 0.5)).rgb : colour;
    gl_FragColor = sRGBTransferOETF(vec4(own * vLight, opacity));
  }
}
`;

const ramps = [rampTexture(false), rampTexture(true)];

/** One tube on the screen. */
export class Tube {
  /** @type {BufferGeometry | null} */ fine = null;
  /** @type {BufferGeometry | null} */ coarse = null;

  /** `key`: the direction towards the light, kept up to date by the stage. */
  constructor(number, description, key) {
    this.number = number;
    this.description = description;
    this.data = new Float32Array(16 * NODES);
    this.texture = new DataTexture(this.data, NODES, 4, RGBAFormat, FloatType);
    this.texture.minFilter = this.texture.magFilter = NearestFilter;
    this.uniforms = {
      frames: { value: this.texture },
      extent: { value: [0, 1] },
      mode: { value: 0 },
      range: { value: [0, 1] },
      ramp: { value: ramps[0] },
      key: { value: key },
      colour: { value: new Color() },
      opacity: { value: 1 },
    };
    const material = new ShaderMaterial({ uniforms: this.uniforms, vertexShader: VERTEX, fragmentShader: FRAGMENT });
    this.mesh = new Mesh(new BufferGeometry(), material);
    this.mesh.frustumCulled = false;
    this.mesh.visible = false;
  }

  get colour() {
    return this.uniforms.colour.value;
  }

  /** Takes the body at rest, the fine or the coarse one: positions and normals (mm), triangles. */
  body({ coarse, vertices, triangles, floats }) {
    const geometry = new BufferGeometry();
    geometry.setAttribute("position", new BufferAttribute(floats.slice(0, 3 * vertices), 3));
    geometry.setAttribute("normal", new BufferAttribute(floats.slice(3 * vertices, 6 * vertices), 3));
    const indices = floats.slice(6 * vertices, 6 * vertices + 3 * triangles);
    geometry.setIndex(new BufferAttribute(new Uint32Array(indices.buffer), 1));
    geometry.computeBoundingBox();
    this.uniforms.extent.value = [geometry.boundingBox.min.x, geometry.boundingBox.max.x];
    const of = coarse ? "coarse" : "fine";
    this[of]?.dispose();
    this[of] = geometry;
    this.mesh.visible = true;
  }

  /** Chooses the body that is drawn. */
  detail(fine) {
    this.mesh.geometry = (fine ? this.fine : this.coarse) ?? this.fine ?? this.mesh.geometry;
  }

  /** Bends it. */
  bend(pose, value) {
    const [from, to] = this.uniforms.extent.value;
    pose.texels(this.number, from, to, this.description, value, this.data);
    this.texture.needsUpdate = true;
  }

  /** Colours it: a plain body, or by a value between two bounds. */
  paint({ theme, mode, signed, range, opacity, dimmed }) {
    const { material } = this.mesh;
    // Beside the colours of values a tube has none of its own.
    this.colour.set(mode > 0 ? (theme === "dark" ? "#4a4f55" : "#c4c4bf") : bodyColour(this.number, theme));
    if (dimmed) this.colour.lerp(new Color(theme === "dark" ? "#2a2d31" : "#d8d8d4"), 0.75);
    const shown = dimmed ? 0.35 : opacity;
    this.uniforms.opacity.value = shown;
    material.transparent = shown < 1;
    material.depthWrite = shown > 0.5;
    this.mesh.renderOrder = material.transparent ? 2 - this.number * 0.01 : 0;
    this.uniforms.mode.value = dimmed ? 0 : mode;
    this.uniforms.range.value = range;
    this.uniforms.ramp.value = ramps[signed ? 1 : 0];
  }

  dispose() {
    for (const body of [this.fine, this.coarse]) body?.dispose();
    this.mesh.material.dispose();
    this.texture.dispose();
  }
}
