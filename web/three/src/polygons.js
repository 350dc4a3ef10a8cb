// Triangles joined to the polygons that they were cut from. three.js has triangles only; the engine takes any polygon, and a quadrilateral
// costs it half of what two triangles do, with no cut along the diagonal.
//
// Neighbours in the index are joined (there exporters and three.js' own geometries leave the triangles of a polygon) as long as the polygon
// stays flat and convex, and everything that its points inherit is one affine function all over it, so that one triangle tells all.
const flat = 2e-7; // distance from the plane, as a share of the size; the engine's own measure is 1e-6
const alike = 1e-5; // difference of an attribute from the affine function

// triangles: three vertices each; numbers: their materials'; attributes: null, and nothing is joined.
export function joinTriangles(triangles, numbers, points, attributes) {
  const outlines = [], cornerCounts = [], corners = [], materials = [];
  let polygon = null;
  const close = () => {
    if (polygon === null) return;
    outlines.push(...polygon.outline);
    cornerCounts.push(polygon.outline.length);
    corners.push(...polygon.largest);
    materials.push(polygon.number);
  };
  for (let t = 0; t < numbers.length; ++t) {
    const triangle = [triangles[3 * t], triangles[3 * t + 1], triangles[3 * t + 2]];
    if (polygon !== null && attributes && polygon.number === numbers[t] && join(polygon, triangle, points, attributes)) continue;
    close();
    polygon = begin(triangle, numbers[t], points);
  }
  close();
  return {
    outlines: Uint32Array.from(outlines),
    cornerCounts: Int32Array.from(cornerCounts),
    corners: Uint32Array.from(corners),
    numbers: Uint32Array.from(materials),
  };
}

function begin(triangle, number, points) {
  const [a, b, c] = triangle;
  const normal = cross(minus(points, b, a), minus(points, c, a));
  return { outline: triangle, largest: triangle, normal, largestArea: dot(normal, normal), number };
}

// Adds the triangle to the polygon, if they are one.
function join(polygon, triangle, points, attributes) {
  const { outline } = polygon;
  for (let i = 0; i < outline.length; ++i) {
    const from = outline[i], to = outline[(i + 1) % outline.length];
    for (let k = 0; k < 3; ++k) {
      const [b, a, apex] = [triangle[k], triangle[(k + 1) % 3], triangle[(k + 2) % 3]]; // the other way along the edge
      if (!samePoint(points, a, from) || !samePoint(points, b, to)) continue;
      if (!inherit(polygon.largest, [a, b, apex], points, polygon.normal, attributes)) return false;
      const next = [...outline.slice(0, i + 1), apex, ...outline.slice(i + 1)];
      if (!isFlatAndConvex(next, i + 1, polygon, points)) return false;
      polygon.outline = next;
      const normal = cross(minus(points, a, b), minus(points, apex, b)), area = dot(normal, normal);
      if (area > polygon.largestArea) Object.assign(polygon, { largest: triangle, normal, largestArea: area });
      return true;
    }
  }
  return false;
}

function isFlatAndConvex(outline, at, { normal, largest }, points) {
  const length = Math.sqrt(dot(normal, normal));
  if (!(length > 0)) return false;
  const n = outline.length;
  const apex = minus(points, outline[at], largest[0]);
  if (!(Math.abs(dot(apex, normal)) <= flat * length * Math.sqrt(Math.max(dot(apex, apex), length)))) return false;
  for (let k = at - 1; k <= at + 1; ++k) {
    const [p, q, r] = [outline[(k - 1 + n) % n], outline[(k + n) % n], outline[(k + 1) % n]];
    const e = minus(points, q, p), f = minus(points, r, q);
    if (!(dot(cross(e, f), normal) > 1e-6 * length * Math.sqrt(dot(e, e) * dot(f, f)))) return false;
  }
  return true;
}

// Whether these vertices have what the affine function of the triangle's corners says.
function inherit(triangle, vertices, points, normal, attributes) {
  const [o, p, q] = triangle;
  const e1 = minus(points, p, o), e2 = minus(points, q, o), scale = dot(normal, normal);
  for (const vertex of vertices) {
    const d = minus(points, vertex, o);
    const u = dot(cross(d, e2), normal) / scale, v = dot(cross(e1, d), normal) / scale;
    for (const attribute of attributes) {
      if (!attribute) continue;
      const { numbers, itemSize } = attribute;
      for (let i = 0; i < itemSize; ++i) {
        const at = numbers[itemSize * o + i];
        const expected = at + u * (numbers[itemSize * p + i] - at) + v * (numbers[itemSize * q + i] - at);
        if (!(Math.abs(numbers[itemSize * vertex + i] - expected) <= alike * (1 + Math.abs(expected)))) return false;
      }
    }
  }
  return true;
}

const samePoint = (points, a, b) =>
  a === b || (points[3 * a] === points[3 * b] && points[3 * a + 1] === points[3 * b + 1] && points[3 * a + 2] === points[3 * b + 2]);
const minus = (points, a, b) => [points[3 * a] - points[3 * b], points[3 * a + 1] - points[3 * b + 1], points[3 * a + 2] - points[3 * b + 2]];
const cross = (a, b) => [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]];
const dot = (a, b) => a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
