// The notched tubes: the body of each at rest goes to the graphics card once and is bent there, section by section,
// by frames over its rest abscissa.

import {
  BufferAttribute, BufferGeometry, Color, DataTexture, FloatType, Mesh, MeshLambertMaterial, NearestFilter, RGBAFormat,
} from "three";
import { bodyColour, rampTexture } from "./colour.js";
import { NODES } from "./pose.js";

const DECLARATIONS = `
uniform sampler2D frames;
uniform vec2 extent;
uniform int mode;
uniform vec2 range;
varying float vValue;
varying float vKept;
vec3 turn(vec4 q, vec3 v) { return v + 2.0 * cross(q.xyz, cross(q.xyz, v) + q.w * v); }
`;
const NORMAL = `
float place = clamp((position.x - extent.x) / (extent.y - extent.x), 0.0, 1.0) * float(${NODES - 1});
int left = min(int(place), ${NODES - 2});
float part = place - float(left);
vec4 spine = mix(texelFetch(frames, ivec2(left, 0), 0), texelFetch(frames, ivec2(left + 1, 0), 0), part);
vec4 turning = normalize(mix(texelFetch(frames, ivec2(left, 1), 0), texelFetch(frames, ivec2(left + 1, 1), 0), part));
vec4 bending = mix(texelFetch(frames, ivec2(left, 2), 0), texelFetch(frames, ivec2(left + 1, 2), 0), part);
vec4 section = mix(texelFetch(frames, ivec2(left, 3), 0), texelFetch(frames, ivec2(left + 1, 3), 0), part);
vec2 own = vec2(dot(position.yz, section.xy), dot(position.yz, vec2(-section.y, section.x)));
float value = mode == 1 ? spine.w : bending.x + 1e-3 * (bending.y * own.y - bending.z * own.x);
// Teeth, beyond the floor of the notches, are not strained.
vKept = mode == 1 ? 1.0 : own.x - section.z + 0.02;
vValue = (value - range.x) / (range.y - range.x);
vec3 objectNormal = turn(turning, normal);
`;
const POSITION = "vec3 transformed = spine.xyz + turn(turning, vec3(0.0, position.yz));";
const COLOUR = "if (mode > 0 && vKept >= 0.0) diffuseColor.rgb = texture2D(ramp, vec2(clamp(vValue, 0.0, 1.0), 0.5)).rgb;";

const ramps = [rampTexture(false), rampTexture(true)];

/** One tube on the screen. */
export class Tube {
  constructor(number, description) {
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
    };
    const material = new MeshLambertMaterial();
    material.onBeforeCompile = (shader) => {
      Object.assign(shader.uniforms, this.uniforms);
      shader.vertexShader = DECLARATIONS + shader.vertexShader
        .replace("#include <beginnormal_vertex>", NORMAL)
        .replace("#include <begin_vertex>", POSITION);
      shader.fragmentShader = `uniform sampler2D ramp;\nuniform int mode;\nvarying float vValue;\nvarying float vKept;\n${shader.fragmentShader}`
        .replace("#include <color_fragment>", COLOUR);
    };
    this.mesh = new Mesh(new BufferGeometry(), material);
    this.mesh.frustumCulled = false;
    this.mesh.visible = false;
  }

  /** Takes the body at rest: positions and normals (mm), triangles. */
  body({ vertices, triangles, floats }) {
    const geometry = new BufferGeometry();
    geometry.setAttribute("position", new BufferAttribute(floats.slice(0, 3 * vertices), 3));
    geometry.setAttribute("normal", new BufferAttribute(floats.slice(3 * vertices, 6 * vertices), 3));
    const indices = floats.slice(6 * vertices, 6 * vertices + 3 * triangles);
    geometry.setIndex(new BufferAttribute(new Uint32Array(indices.buffer), 1));
    geometry.computeBoundingBox();
    this.uniforms.extent.value = [geometry.boundingBox.min.x, geometry.boundingBox.max.x];
    this.mesh.geometry.dispose();
    this.mesh.geometry = geometry;
    this.mesh.visible = true;
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
    material.color = new Color(mode > 0 ? (theme === "dark" ? "#4a4f55" : "#c4c4bf") : bodyColour(this.number, theme));
    if (dimmed) material.color.lerp(new Color(theme === "dark" ? "#2a2d31" : "#d8d8d4"), 0.75);
    material.opacity = dimmed ? 0.35 : opacity;
    material.transparent = material.opacity < 1;
    material.depthWrite = material.opacity > 0.5;
    this.mesh.renderOrder = material.transparent ? 2 - this.number * 0.01 : 0;
    this.uniforms.mode.value = dimmed ? 0 : mode;
    this.uniforms.range.value = range;
    this.uniforms.ramp.value = ramps[signed ? 1 : 0];
    material.needsUpdate = true;
  }

  dispose() {
    this.mesh.geometry.dispose();
    this.mesh.material.dispose();
    this.texture.dispose();
  }
}
