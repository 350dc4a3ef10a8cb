// What is read of a three.js geometry: its faces, as the engine takes them, and the attributes that
// fragments inherit, as plain arrays. Read once for all meshes that share a geometry, and again
// when three.js' version numbers say that something has changed.
import { Box3, Vector3, Vector4 } from 'three';
import { joinTriangles } from './polygons.js';

// The attributes carried over, by their numbers in the lists below, and how many numbers of each
// there may be.
export const carried = ['normal', 'uv', 'uv1', 'color', 'tangent'];

const versionOf = (attribute) =>
  attribute
    ? attribute.isInterleavedBufferAttribute
      ? attribute.data.version
      : attribute.version
    : -1;

// As a plain array with nothing between: the attribute's own where it is one (nothing is copied,
// then), otherwise a copy.
function numbersOf(attribute, itemSize = attribute.itemSize) {
  const { array } = attribute;
  if (
    !attribute.isInterleavedBufferAttribute &&
    attribute.itemSize === itemSize &&
    array instanceof Float32Array
  ) {
    return array.length === attribute.count * itemSize
      ? array
      : array.subarray(0, attribute.count * itemSize);
  }
  const out = new Float32Array(attribute.count * itemSize);
  for (let i = 0; i < attribute.count; ++i) {
    for (let k = 0; k < itemSize; ++k) out[i * itemSize + k] = attribute.getComponent(i, k);
  }
  return out;
}

let revisions = 0; // no two sources have one in common

export class Source {
  // Revisions: topology (which triangles there are), positions, style (what fragments inherit).
  // Users compare them with what they have seen.
  topology = 0;
  positions = 0;
  style = 0;
  points; // x, y, z by vertex, in the object's frame
  outlines; // the faces: their vertices, one face after another
  cornerCounts; // of each
  // three vertices of each: the triangle from which all that the face's points have is worked out
  corners;
  groups; // the material's number by face; or null: the first everywhere
  attributes = []; // by number in `carried`: { numbers, itemSize }, or undefined
  #geometry;
  #grouped;
  #baked; // the mesh whose pose was taken, or null
  #joins; // triangles to polygons
  #changes; // positions or attributes have changed, and will again: its triangles are not joined
  #seen = { attributes: [], versions: [] };
  #checked = -1;

  constructor(geometry, grouped, joins, baked = null) {
    this.#geometry = geometry;
    this.#grouped = grouped;
    this.#baked = baked;
    this.#changes = baked !== null;
    this.#joins = joins;
  }
  get faceCount() {
    return this.cornerCounts.length;
  }

  // Brings all up to date; once for each stamp.
  check(stamp) {
    if (this.#checked === stamp) return;
    this.#checked = stamp;
    const { position } = this.#geometry.attributes;
    const moved =
      this.#seen.position !== position || this.#seen.positionVersion !== versionOf(position);
    const restyled = this.#attributesChanged();
    const known = this.corners !== undefined;
    const joined =
      known && !this.#changes && (moved || restyled) && this.outlines.length > 3 * this.faceCount;
    if (known && (moved || restyled)) this.#changes = true;
    const anew = joined || this.#topologyChanged();
    if (anew || moved) this.#readPositions();
    if (anew || restyled) this.#readAttributes();
    if (anew) this.#readFaces();
  }
  // Takes the mesh's present pose, from now on.
  bake(mesh) {
    this.#baked = mesh;
    if (!this.corners) return; // nothing has been read as yet
    this.#readPositions();
    this.#readAttributes();
  }

  // Around the finite vertices, in the object's frame.
  box() {
    const { points } = this;
    const low = [Infinity, Infinity, Infinity],
      high = [-Infinity, -Infinity, -Infinity];
    for (let i = 0; i < points.length; ++i) {
      const x = points[i],
        k = i % 3;
      if (!Number.isFinite(x)) continue;
      if (x < low[k]) low[k] = x;
      if (x > high[k]) high[k] = x;
    }
    return new Box3(new Vector3(...low), new Vector3(...high));
  }

  #topologyChanged() {
    const { index, drawRange, groups, attributes } = this.#geometry;
    const seen = this.#seen;
    const groupsChanged =
      this.#grouped &&
      (seen.groups?.length !== groups.length ||
        groups.some((g, i) => {
          const s = seen.groups[i];
          return s.start !== g.start || s.count !== g.count || s.materialIndex !== g.materialIndex;
        }));
    return (
      groupsChanged ||
      !this.corners ||
      seen.index !== index ||
      seen.indexVersion !== versionOf(index) ||
      seen.start !== drawRange.start ||
      seen.count !== drawRange.count ||
      seen.vertices !== (attributes.position?.count ?? 0)
    );
  }
  #readFaces() {
    const { index, drawRange, groups, attributes } = this.#geometry;
    const vertices = attributes.position?.count ?? 0;
    const seen = this.#seen;
    Object.assign(seen, {
      index,
      indexVersion: versionOf(index),
      start: drawRange.start,
      count: drawRange.count,
      vertices,
    });
    seen.groups = groups.map((g) => ({ ...g }));
    const all = index ? index.count : vertices;
    const first = Math.max(0, drawRange.start),
      end = Math.min(all, drawRange.start + drawRange.count);
    const parts = this.#grouped ? groups : [{ start: 0, count: Infinity, materialIndex: 0 }];
    const triangles = [],
      numbers = [];
    for (const { start, count, materialIndex } of parts) {
      const last = Math.min(end, start + count);
      for (let i = Math.max(first, start); i + 2 < last; i += 3) {
        for (let k = i; k < i + 3; ++k) triangles.push(index ? index.getX(k) : k);
        numbers.push(materialIndex ?? 0);
      }
    }
    const faces = joinTriangles(
      triangles,
      numbers,
      this.points,
      this.#joins && !this.#changes ? this.attributes : null,
    );
    this.outlines = faces.outlines;
    this.cornerCounts = faces.cornerCounts;
    this.corners = faces.corners;
    this.groups = this.#grouped ? faces.numbers : null;
    this.topology = ++revisions;
  }

  #readPositions() {
    const { position } = this.#geometry.attributes;
    this.#seen.position = position;
    this.#seen.positionVersion = versionOf(position);
    if (!position) this.points = new Float32Array(0);
    else if (this.#baked) this.points = posedPositions(this.#baked);
    else this.points = numbersOf(position, 3);
    this.positions = ++revisions;
  }

  #attributesChanged() {
    const { attributes } = this.#geometry;
    for (let k = 0; k < carried.length; ++k) {
      const attribute = attributes[carried[k]];
      if (this.#seen.attributes[k] !== attribute || this.#seen.versions[k] !== versionOf(attribute))
        return true;
    }
    return false;
  }
  #readAttributes() {
    const { attributes } = this.#geometry;
    carried.forEach((name, k) => {
      const attribute = attributes[name];
      this.#seen.attributes[k] = attribute;
      this.#seen.versions[k] = versionOf(attribute);
      this.attributes[k] = attribute && {
        numbers: numbersOf(attribute),
        itemSize: attribute.itemSize,
      };
    });
    if (this.#baked)
      for (const k of [0, 4])
        if (this.attributes[k])
          this.attributes[k].numbers = posedDirections(this.#baked, carried[k]);
    this.style = ++revisions;
  }
}

// Skinned and morphed, in the object's frame, as three.js' shaders would.
function posedPositions(mesh) {
  const { count } = mesh.geometry.attributes.position;
  const out = new Float64Array(3 * count);
  const p = new Vector3();
  for (let i = 0; i < count; ++i) mesh.getVertexPosition(i, p).toArray(out, 3 * i);
  return out;
}
// Normals (morphed and skinned) and tangents (skinned).
function posedDirections(mesh, name) {
  const { attributes, morphAttributes, morphTargetsRelative } = mesh.geometry;
  const attribute = attributes[name],
    size = attribute.itemSize;
  const out = new Float32Array(size * attribute.count);
  const targets = (name === 'normal' && mesh.morphTargetInfluences && morphAttributes.normal) || [];
  const d = new Vector4(),
    base = new Vector3(),
    target = new Vector3();
  for (let i = 0; i < attribute.count; ++i) {
    base.fromBufferAttribute(attribute, i);
    d.set(base.x, base.y, base.z, 0);
    targets.forEach((morph, k) => {
      target.fromBufferAttribute(morph, i);
      if (!morphTargetsRelative) target.sub(base);
      const influence = mesh.morphTargetInfluences[k];
      ((d.x += influence * target.x), (d.y += influence * target.y), (d.z += influence * target.z));
    });
    if (mesh.isSkinnedMesh) mesh.applyBoneTransform(i, d);
    const length = Math.hypot(d.x, d.y, d.z) || 1;
    ((out[size * i] = d.x / length),
      (out[size * i + 1] = d.y / length),
      (out[size * i + 2] = d.z / length));
    if (size === 4) out[4 * i + 3] = attribute.getW(i);
  }
  return out;
}
