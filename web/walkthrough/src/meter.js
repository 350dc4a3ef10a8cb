// Clocks. Uploads: what the calls take that hand bytes to WebGL, and how many bytes. Shadow maps:
// what three.js' pass takes until the graphics processor is done with it. Figures: the middle and
// the 99th percentile of many.

// Counts what goes through gl.bufferData and gl.bufferSubData from now on.
export class UploadMeter {
  ms = 0;
  bytes = 0;
  constructor(gl) {
    for (const name of ['bufferData', 'bufferSubData']) {
      const original = gl[name].bind(gl);
      gl[name] = (...args) => {
        const start = performance.now();
        original(...args);
        this.ms += performance.now() - start;
        this.bytes += bytesOf(name, args);
      };
    }
  }
  reset() {
    this.ms = this.bytes = 0;
  }
}

function bytesOf(name, args) {
  const data = name === 'bufferData' ? args[1] : args[2];
  if (typeof data === 'number') return data;
  const length = args[4];
  return length > 0 ? length * (data.BYTES_PER_ELEMENT ?? 1) : data.byteLength;
}

// Times the next pass of renderer.shadowMap. Reading a pixel is what makes WebGL wait; what was
// drawn before is waited for before the clock starts.
export class MapMeter {
  ms = undefined;
  #due = false;
  constructor(renderer) {
    const gl = renderer.getContext(),
      pixel = new Uint8Array(4);
    const wait = () => gl.readPixels(0, 0, 1, 1, gl.RGBA, gl.UNSIGNED_BYTE, pixel);
    const { shadowMap } = renderer;
    const original = shadowMap.render.bind(shadowMap);
    shadowMap.render = (...args) => {
      if (!this.#due || args[0].length === 0) return original(...args);
      this.#due = false;
      wait();
      const start = performance.now();
      original(...args);
      wait();
      this.ms = performance.now() - start;
      return undefined;
    };
  }
  measureNext() {
    this.#due = true;
  }
}

// The share of the numbers that is below: 0.5 gives the middle one.
export function percentile(numbers, share) {
  if (numbers.length === 0) return undefined;
  const sorted = Float64Array.from(numbers).sort();
  return sorted[Math.min(sorted.length - 1, Math.ceil(share * sorted.length) - 1)];
}
