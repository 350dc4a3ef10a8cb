// Triangles joined to the polygons that they were cut from. three.js has triangles only; the engine
// takes any polygon, and a quadrilateral costs it half of what two triangles do, with no cut along
// the diagonal.
//
// Neighbours in the index are joined (there exporters and three.js' own geometries leave the
// triangles of a polygon) as long as the polygon stays flat and convex, and everything that its
// points inherit is one affine function all over it, so that one triangle tells all.
// distance from the plane, as a share of the size; the engine's own measure is 1e-6
const flat = 2e-7;
const alike = 1e-5; // difference of an attribute from the affine function

const most = 64; // corners of a polygon

// triangles: three vertices each; numbers: their materials'; attributes: null, and nothing is
// joined.
export function joinTriangles(triangles, numbers, points, attributes) {
  const joiner = new Joiner(points, attributes ? attributes.filter(Boolean) : null);
  const count = numbers.length;
  const outlines = new Uint32Array(3 * count),
    cornerCounts = new Int32Array(count);
  const corners = new Uint32Array(3 * count),
    materials = new Uint32Array(count);
  let faces = 0,
    at = 0;
  const close = (number) => {
    outlines.set(joiner.outline.subarray(0, joiner.count), at);
    corners.set(joiner.triangle, 3 * faces);
    materials[faces] = number;
    at += cornerCounts[faces++] = joiner.count;
  };
  for (let t = 0; t < count; ++t) {
    const a = triangles[3 * t],
      b = triangles[3 * t + 1],
      c = triangles[3 * t + 2];
    if (t > 0) {
      if (attributes && numbers[t] === numbers[t - 1] && joiner.join(a, b, c)) continue;
      close(numbers[t - 1]);
    }
    joiner.begin(a, b, c);
  }
  if (count > 0) close(numbers[count - 1]);
  return {
    outlines: outlines.slice(0, at),
    cornerCounts: cornerCounts.slice(0, faces),
    corners: corners.slice(0, 3 * faces),
    numbers: materials.slice(0, faces),
  };
}

// The polygon at hand. Plain numbers throughout: it runs once over every triangle of a scene,
// before the first picture.
class Joiner {
  outline = new Uint32Array(most);
  count = 0;
  triangle = new Uint32Array(3); // its largest, from which the rest is worked out
  #points;
  #attributes;
  #normal = new Float64Array(3); // of that triangle; its length is twice the area
  #length = 0;
  #e1 = new Float64Array(3); // its edges from the first corner
  #e2 = new Float64Array(3);
  #cross = new Float64Array(3);

  constructor(points, attributes) {
    this.#points = points;
    this.#attributes = attributes;
  }

  begin(a, b, c) {
    const { outline } = this;
    ((outline[0] = a), (outline[1] = b), (outline[2] = c));
    this.count = 3;
    this.#measure(a, b, c);
    this.#take(a, b, c);
  }
  // Adds the triangle, if it and the polygon are one.
  join(a, b, c) {
    const { count, outline } = this;
    if (count === most) return false;
    for (let i = 0; i < count; ++i) {
      const from = outline[i],
        to = outline[i + 1 < count ? i + 1 : 0];
      if (this.#same(b, from) && this.#same(a, to)) return this.#joinAt(i, a, b, c, c);
      if (this.#same(c, from) && this.#same(b, to)) return this.#joinAt(i, a, b, c, a);
      if (this.#same(a, from) && this.#same(c, to)) return this.#joinAt(i, a, b, c, b);
    }
    return false;
  }
  #joinAt(i, a, b, c, apex) {
    if (!this.#fits(i, apex) || !this.#inherits(a) || !this.#inherits(b) || !this.#inherits(c))
      return false;
    this.outline.copyWithin(i + 2, i + 1, this.count++);
    this.outline[i + 1] = apex;
    this.#measure(a, b, c);
    if (Math.hypot(this.#cross[0], this.#cross[1], this.#cross[2]) > this.#length)
      this.#take(a, b, c);
    return true;
  }

  // Flat, and convex: between corner i and the next.
  #fits(i, apex) {
    const { outline, count } = this;
    const p = this.#points,
      n = this.#normal,
      length = this.#length,
      o = 3 * this.triangle[0],
      q = 3 * apex;
    if (!(length > 0)) return false;
    const dx = p[q] - p[o],
      dy = p[q + 1] - p[o + 1],
      dz = p[q + 2] - p[o + 2];
    const distance = Math.abs(dx * n[0] + dy * n[1] + dz * n[2]) / length;
    if (!(distance <= flat * Math.sqrt(Math.max(dx * dx + dy * dy + dz * dz, length))))
      return false;
    const from = outline[i],
      to = outline[(i + 1) % count],
      before = outline[(i + count - 1) % count],
      after = outline[(i + 2) % count];
    return (
      this.#turnsLeft(before, from, apex) &&
      this.#turnsLeft(from, apex, to) &&
      this.#turnsLeft(apex, to, after)
    );
  }
  #turnsLeft(a, b, c) {
    const p = this.#points,
      n = this.#normal;
    const ex = p[3 * b] - p[3 * a],
      ey = p[3 * b + 1] - p[3 * a + 1],
      ez = p[3 * b + 2] - p[3 * a + 2];
    const fx = p[3 * c] - p[3 * b],
      fy = p[3 * c + 1] - p[3 * b + 1],
      fz = p[3 * c + 2] - p[3 * b + 2];
    const turn =
      n[0] * (ey * fz - ez * fy) + n[1] * (ez * fx - ex * fz) + n[2] * (ex * fy - ey * fx);
    return (
      turn >
      1e-6 * this.#length * Math.sqrt((ex * ex + ey * ey + ez * ez) * (fx * fx + fy * fy + fz * fz))
    );
  }

  // Whether a vertex has what the affine function of the triangle's corners says.
  #inherits(vertex) {
    const p = this.#points,
      n = this.#normal,
      e1 = this.#e1,
      e2 = this.#e2;
    const [o, second, third] = this.triangle;
    const dx = p[3 * vertex] - p[3 * o],
      dy = p[3 * vertex + 1] - p[3 * o + 1],
      dz = p[3 * vertex + 2] - p[3 * o + 2];
    const scale = 1 / (this.#length * this.#length);
    const u =
      scale *
      (n[0] * (dy * e2[2] - dz * e2[1]) +
        n[1] * (dz * e2[0] - dx * e2[2]) +
        n[2] * (dx * e2[1] - dy * e2[0]));
    const v =
      scale *
      (n[0] * (e1[1] * dz - e1[2] * dy) +
        n[1] * (e1[2] * dx - e1[0] * dz) +
        n[2] * (e1[0] * dy - e1[1] * dx));
    for (let k = 0; k < this.#attributes.length; ++k) {
      const { numbers, itemSize } = this.#attributes[k];
      for (let i = 0; i < itemSize; ++i) {
        const first = numbers[itemSize * o + i];
        const expected =
          first +
          u * (numbers[itemSize * second + i] - first) +
          v * (numbers[itemSize * third + i] - first);
        if (
          !(Math.abs(numbers[itemSize * vertex + i] - expected) <= alike * (1 + Math.abs(expected)))
        )
          return false;
      }
    }
    return true;
  }

  #same(a, b) {
    const p = this.#points;
    return (
      a === b ||
      (p[3 * a] === p[3 * b] && p[3 * a + 1] === p[3 * b + 1] && p[3 * a + 2] === p[3 * b + 2])
    );
  }
  #measure(a, b, c) {
    const p = this.#points,
      cross = this.#cross;
    const bx = p[3 * b] - p[3 * a],
      by = p[3 * b + 1] - p[3 * a + 1],
      bz = p[3 * b + 2] - p[3 * a + 2];
    const cx = p[3 * c] - p[3 * a],
      cy = p[3 * c + 1] - p[3 * a + 1],
      cz = p[3 * c + 2] - p[3 * a + 2];
    ((cross[0] = by * cz - bz * cy),
      (cross[1] = bz * cx - bx * cz),
      (cross[2] = bx * cy - by * cx));
  }
  #take(a, b, c) {
    const p = this.#points,
      e1 = this.#e1,
      e2 = this.#e2;
    ((this.triangle[0] = a), (this.triangle[1] = b), (this.triangle[2] = c));
    this.#normal.set(this.#cross);
    this.#length = Math.hypot(this.#cross[0], this.#cross[1], this.#cross[2]);
    for (let i = 0; i < 3; ++i)
      ((e1[i] = p[3 * b + i] - p[3 * a + i]), (e2[i] = p[3 * c + i] - p[3 * a + i]));
  }
}
