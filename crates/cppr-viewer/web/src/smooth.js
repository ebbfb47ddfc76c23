// Smooth edges: a picture of four samples a pixel, drawn aside and copied to the screen. The screen itself has one, so
// that a slow renderer can do without while the robot moves.

import { Mesh, OrthographicCamera, PlaneGeometry, SRGBColorSpace, ShaderMaterial, Vector2, WebGLRenderTarget } from "three";

export class Smooth {
  constructor(renderer) {
    this.renderer = renderer;
    this.target = new WebGLRenderTarget(1, 1, { samples: 4, colorSpace: SRGBColorSpace });
    // Stored as the screen has it, so that transparent things are mixed in the same colours in both. three.js writes
    // the colours of the screen into no other target than those of headsets.
    this.target.texture.internalFormat = "RGBA8";
    this.target.isXRRenderTarget = true;
    this.camera = new OrthographicCamera(-1, 1, 1, -1, 0, 1);
    this.copy = new Mesh(
      new PlaneGeometry(2, 2),
      new ShaderMaterial({
        uniforms: { picture: { value: this.target.texture } },
        vertexShader: "void main() { gl_Position = vec4(position.xy, 0.0, 1.0); }",
        fragmentShader: "uniform sampler2D picture; void main() { gl_FragColor = texelFetch(picture, ivec2(gl_FragCoord.xy), 0); }",
        depthTest: false,
        depthWrite: false,
      }),
    );
    this.copy.frustumCulled = false;
  }

  render(scene, camera) {
    const { renderer, target } = this;
    const { x, y } = renderer.getDrawingBufferSize(new Vector2());
    target.setSize(x, y);
    renderer.setRenderTarget(target);
    renderer.render(scene, camera);
    renderer.setRenderTarget(null);
    renderer.render(this.copy, this.camera);
  }
}
