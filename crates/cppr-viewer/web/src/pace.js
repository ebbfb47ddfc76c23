// How good the pictures may be while the robot moves: as good as at rest where the graphics card draws those fast enough, else
// without smooth edges.

/** A smooth picture may take that long (ms), so that sixty a second leave the machine time for everything else. */
const FAST = 8;
/** Pictures that are looked at. */
const WINDOW = 5;

export class Pace {
  #times = [];
  #fence = null;

  constructor(gl) {
    this.gl = gl;
  }

  /** Does the graphics card draw smooth pictures at the rate of the screen? */
  get fast() {
    return this.#times.toSorted((a, b) => a - b)[(this.#times.length - 1) >> 1] < FAST;
  }

  /** Notes how long the picture takes that was just sent to the graphics card. */
  watch() {
    const { gl } = this;
    if (this.#fence) return;
    const begin = performance.now();
    this.#fence = gl.fenceSync(gl.SYNC_GPU_COMMANDS_COMPLETE, 0);
    gl.flush();
    const look = () => {
      const time = performance.now() - begin;
      if (gl.getSyncParameter(this.#fence, gl.SYNC_STATUS) !== gl.SIGNALED && time < 1000) {
        setTimeout(look, 1);
        return;
      }
      gl.deleteSync(this.#fence);
      this.#fence = null;
      this.#times.push(time);
      if (this.#times.length > WINDOW) this.#times.shift();
    };
    setTimeout(look, 1);
  }
}
