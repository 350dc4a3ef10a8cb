// What fragments inherit: the numbers at the corners of a triangle of the face in which a fragment
// lies, in the world, and from them those at any point of the face. Affine maps keep barycentric
// coordinates, so the triangle is brought to the world, once for all corners of fragments.
import { carried } from './sources.js';

const [normal, , , color, tangent] = carried.keys();
const kept = 256; // faces: an update brings many fragments of few

// The faces read since begin(), as long as no other has taken their place.
export class FaceReader {
  #frames = [];
  #itemSizes = [];
  #stamp = 0;

  // By number in `carried`; 0: not carried.
  set itemSizes(sizes) {
    this.#itemSizes = sizes;
    const total = sizes.reduce((a, b) => a + b, 0);
    this.#frames = Array.from({ length: kept }, () => new Frame(total));
  }
  // Matrices, or what a face inherits, may have changed.
  begin() {
    ++this.#stamp;
  }
  read(instance, face, origin) {
    const frame = this.#frames[face % kept];
    if (frame.face !== face || frame.stamp !== this.#stamp) {
      frame.read(instance, face, origin, this.#itemSizes);
      frame.face = face;
      frame.stamp = this.#stamp;
    }
    return frame;
  }
}

class Frame {
  face = -1;
  stamp = -1;
  #a;
  #b;
  #c;
  #points = new Float64Array(9); // of the corners, less the origin
  #unit = new Float64Array(3); // the face's normal, to its front
  // Where the triangle is seen from the axis to which it is turned most: which coordinates are
  // left, the first corner, the two edges from it over their cross product.
  #u = 0;
  #v = 1;
  #edges = new Float64Array(6);
  #isTriangle = true; // the face; otherwise it is more than the triangle

  constructor(size) {
    this.#a = new Float64Array(size);
    this.#b = new Float64Array(size);
    this.#c = new Float64Array(size);
  }

  read(instance, face, origin, itemSizes) {
    const { entry } = instance;
    const { source } = entry;
    const first = 3 * (face - instance.firstFace);
    this.#isTriangle = source.cornerCounts[face - instance.firstFace] === 3;
    this.#place(instance, source, first, origin);
    let at = 0;
    for (let k = 0; k < itemSizes.length; ++k) {
      const size = itemSizes[k];
      if (size === 0) continue;
      for (let c = 0; c < 3; ++c) {
        const to = c === 0 ? this.#a : c === 1 ? this.#b : this.#c;
        this.#copy(k, size, source.attributes[k], source.corners[first + c], to, at);
        if (k === normal)
          this.#turnNormal(instance.normalMatrix, source.attributes[k] !== undefined, to, at);
        else if (k === tangent) this.#turnTangent(instance.matrix, to, at);
        else if (k === color && entry.tinted)
          this.#tint(entry, instance.tint, first / 3, size, to, at);
      }
      at += size;
    }
  }

  // At a point of the triangle, less the origin: three of `positions`, from `from` on. (Numbers
  // handed over by themselves would be garbage.)
  interpolate(positions, from, out, at) {
    const f = this.#edges;
    const pu = positions[from + this.#u] - f[0],
      pv = positions[from + this.#v] - f[1];
    let b = pu * f[5] - pv * f[4],
      c = pv * f[2] - pu * f[3];
    if (this.#isTriangle) {
      // Rounding must not leave it: of a needle it would by far.
      ((b = clamp(b)), (c = clamp(c)));
      if (b + c > 1) {
        const scale = 1 / (b + c);
        ((b *= scale), (c *= scale));
      }
    }
    const a = 1 - b - c;
    const A = this.#a,
      B = this.#b,
      C = this.#c;
    const nx = a * A[0] + b * B[0] + c * C[0],
      ny = a * A[1] + b * B[1] + c * C[1],
      nz = a * A[2] + b * B[2] + c * C[2];
    const length = Math.sqrt(nx * nx + ny * ny + nz * nz) || 1;
    // the normal is the first
    ((out[at] = nx / length), (out[at + 1] = ny / length), (out[at + 2] = nz / length));
    for (let i = 3; i < A.length; ++i) out[at + i] = a * A[i] + b * B[i] + c * C[i];
  }

  #place(instance, source, first, origin) {
    const m = instance.matrix,
      p = this.#points,
      { points, corners } = source;
    const ox = m[12] - origin[0],
      oy = m[13] - origin[1],
      oz = m[14] - origin[2];
    for (let c = 0; c < 3; ++c) {
      const from = 3 * corners[first + c];
      const x = points[from],
        y = points[from + 1],
        z = points[from + 2];
      p[3 * c] = m[0] * x + m[4] * y + m[8] * z + ox;
      p[3 * c + 1] = m[1] * x + m[5] * y + m[9] * z + oy;
      p[3 * c + 2] = m[2] * x + m[6] * y + m[10] * z + oz;
    }
    const bx = p[3] - p[0],
      by = p[4] - p[1],
      bz = p[5] - p[2],
      cx = p[6] - p[0],
      cy = p[7] - p[1],
      cz = p[8] - p[2];
    const nx = by * cz - bz * cy,
      ny = bz * cx - bx * cz,
      nz = bx * cy - by * cx;
    const ax = Math.abs(nx),
      ay = Math.abs(ny),
      az = Math.abs(nz);
    if (az >= ax && az >= ay) this.#project(0, 1, nz);
    else if (ay >= ax) this.#project(0, 2, -ny);
    else this.#project(1, 2, nx);
    const length = (instance.mirrored ? -1 : 1) * Math.sqrt(nx * nx + ny * ny + nz * nz) || 1;
    ((this.#unit[0] = nx / length), (this.#unit[1] = ny / length), (this.#unit[2] = nz / length));
  }
  #project(u, v, doubledArea) {
    const p = this.#points,
      f = this.#edges;
    ((this.#u = u), (this.#v = v));
    ((f[0] = p[u]), (f[1] = p[v]));
    ((f[2] = (p[3 + u] - p[u]) / doubledArea), (f[3] = (p[3 + v] - p[v]) / doubledArea));
    ((f[4] = (p[6 + u] - p[u]) / doubledArea), (f[5] = (p[6 + v] - p[v]) / doubledArea));
  }

  // What a mesh does not have: white, and zeros.
  #copy(k, size, attribute, vertex, to, at) {
    const have = attribute ? attribute.itemSize : 0;
    for (let i = 0; i < size; ++i)
      to[at + i] = i < have ? attribute.numbers[have * vertex + i] : k === color ? 1 : 0;
  }
  #turnNormal(m, given, to, at) {
    const x = to[at],
      y = to[at + 1],
      z = to[at + 2];
    const nx = m[0] * x + m[3] * y + m[6] * z,
      ny = m[1] * x + m[4] * y + m[7] * z,
      nz = m[2] * x + m[5] * y + m[8] * z;
    const length = Math.sqrt(nx * nx + ny * ny + nz * nz);
    // as three.js does; only what is not brought to length one is affine beyond the triangle
    const by = this.#isTriangle ? length : 1;
    if (given && length > 0) ((to[at] = nx / by), (to[at + 1] = ny / by), (to[at + 2] = nz / by));
    else ((to[at] = this.#unit[0]), (to[at + 1] = this.#unit[1]), (to[at + 2] = this.#unit[2]));
  }
  #turnTangent(m, to, at) {
    const x = to[at],
      y = to[at + 1],
      z = to[at + 2];
    const tx = m[0] * x + m[4] * y + m[8] * z,
      ty = m[1] * x + m[5] * y + m[9] * z,
      tz = m[2] * x + m[6] * y + m[10] * z;
    const length = Math.sqrt(tx * tx + ty * ty + tz * tz) || 1;
    ((to[at] = tx / length), (to[at + 1] = ty / length), (to[at + 2] = tz / length));
  }
  // As three.js: an instance's colour counts always, vertex colours where the material says so.
  #tint(entry, tint, face, size, to, at) {
    const colored = entry.vertexColors[entry.source.groups?.[face] ?? 0];
    for (let i = 0; i < size; ++i)
      to[at + i] = (colored ? to[at + i] : 1) * (i < 3 && tint ? tint[i] : 1);
  }
}
const clamp = (x) => (x > 0 ? Math.min(x, 1) : 0);
