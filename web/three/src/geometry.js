// From the engine to three.js: one geometry of lit and shadowed triangles, kept in step with the
// engine's buffers.
//
// Vertices. Those of shadowcut.Buffers, one for each corner of a fragment, at the same places; all
// that a vertex has lies in one interleaved array, so that a range of vertices is one upload. A
// fragment lies in one face of the engine, which is one polygon of a mesh: what that polygon's
// corners have is interpolated to the fragment's. Triangles. The buffers' too, but sorted by
// material: each material has a region of the index, with room to spare; a triangle that comes is
// put at the region's end, and where one goes, the region's last takes its place. So what has to be
// uploaded is in proportion to what has changed. Regions that overflow are laid out anew, all of
// them, with half as much room again. Cracks. Where a corner of one fragment lies on the edge of
// another, a rasteriser leaves pixels out between the two. So each vertex says where "outward" is,
// and the shaders (materials.js) draw fragments larger than they are by a small share of a pixel.
// Outlines. Lines from each vertex to the next around its fragment: a second index over the same
// vertices, kept only while it is wanted.
import {
  BufferAttribute,
  BufferGeometry,
  InterleavedBuffer,
  InterleavedBufferAttribute,
  Sphere,
  Vector3,
} from 'three';
import { FaceReader } from './faces.js';
import { bitsPerNumber } from './materials.js';
import { carried } from './sources.js';

const invalidIndex = 0xffffffff;
const joinedVertexBytes = 8192; // ranges with no more than this between them are uploaded as one
const joinedIndices = 512;
const mostRanges = 256; // that wait for a renderer

const [normal, , , color] = carried.keys();

// A growing list of numbers that does not allocate once it is large enough.
class Numbers {
  array = new Int32Array(1024);
  length = 0;
  push(value) {
    if (this.length === this.array.length) {
      const more = new Int32Array(2 * this.length);
      more.set(this.array);
      this.array = more;
    }
    this.array[this.length++] = value;
  }
}

// Marks a range for upload. Nobody may have drawn for long: then the ranges become one.
function touch(attribute, start, count) {
  const ranges = attribute.updateRanges;
  if (ranges.length >= mostRanges) {
    let end = start + count;
    for (const range of ranges)
      ((start = Math.min(start, range.start)), (end = Math.max(end, range.start + range.count)));
    attribute.clearUpdateRanges();
    count = end - start;
  }
  attribute.addUpdateRange(start, count);
  attribute.needsUpdate = true;
}

export class FragmentGeometry {
  geometry = new BufferGeometry();
  lines = new BufferGeometry();
  origin = [0, 0, 0]; // the buffers'
  withLines = false; // wanted; the next sync sees to it
  uploadedBytes = 0; // that the last sync has asked for
  #mirror;
  #palette;
  #vertices = null; // InterleavedBuffer
  #stride = 0;
  #maskSize = 1;
  #itemSizes = []; // by number in `carried`: how many numbers of a vertex; 0: none
  #index = null;
  #lineIndex = null;

  #tripleCount = 0; // of the buffers
  #slotOf = new Int32Array(0); // by triple of the buffers: the slot of its material, or -1
  #placeOf = new Int32Array(0); // by triple: where it is in the index, in triangles
  #tripleAt = new Int32Array(0); // by place: which triple it is
  #regions = []; // by slot: { first, count, capacity }
  #touched = new Numbers(); // places
  #streams = null;
  #reader = new FaceReader();

  constructor(mirror, palette) {
    this.#mirror = mirror;
    this.#palette = palette;
    // Never culled, and sorted as if it stood at its origin: it is everywhere.
    this.geometry.boundingSphere = new Sphere(new Vector3(), Infinity);
    this.lines.boundingSphere = this.geometry.boundingSphere;
  }
  dispose() {
    this.geometry.dispose();
    this.lines.dispose();
  }

  get wantsSync() {
    return this.#mirror.restyled.size > 0 || this.withLines !== (this.#lineIndex !== null);
  }
  // After buffers.update(). One light: bit 0 of a mask; all lights: the bits are the lights'
  // indices. Everything anew: where the buffers are others than the last time, or something failed.
  sync(buffers, allLights, anew) {
    this.uploadedBytes = 0;
    const { info } = buffers;
    // Before the streams, which these calls might end.
    const vertexRanges = buffers.changedVertexNumbers,
      indexRanges = buffers.changedIndexNumbers;
    this.#streams = {
      positions: buffers.stream('positions'),
      faces: buffers.stream('faces'),
      objects: buffers.stream('objects'),
      indices: buffers.stream('indices'),
      states: allLights ? null : buffers.stream('states'),
      masks: allLights ? buffers.stream('masks') : null,
      maskWords: info.maskWords,
    };
    const layoutChanged = this.#layOut(allLights);
    this.#reader.begin();
    if (anew || layoutChanged || info.grown || !this.#vertices) this.#fill(info);
    else this.#follow(vertexRanges, indexRanges, info);
    if (this.withLines !== (this.#lineIndex !== null)) this.#makeLines();
    this.lines.setDrawRange(0, 2 * info.vertexCount);
    this.#streams = null;
    this.#mirror.restyled.clear();
  }

  // ---- Layout

  // Which numbers a vertex has: those that any source has. True where that has changed.
  #layOut(allLights) {
    const maskSize = allLights
      ? Math.min(4, Math.ceil(this.#mirror.followed.length / bitsPerNumber))
      : 1;
    if (!this.#mirror.attributesChanged && maskSize === this.#maskSize) return false;
    const sizes = carried.map(() => 0);
    sizes[normal] = 3;
    for (const { source, tinted } of this.#mirror.entries()) {
      source.attributes.forEach(
        (attribute, k) => attribute && (sizes[k] = Math.max(sizes[k], attribute.itemSize)),
      );
      if (tinted) sizes[color] = Math.max(sizes[color], 3);
    }
    this.#mirror.attributesChanged = false;
    const changed =
      maskSize !== this.#maskSize || carried.some((_, k) => sizes[k] !== this.#itemSizes[k]);
    this.#itemSizes = sizes;
    this.#maskSize = maskSize;
    this.#stride = 6 + maskSize + sizes.reduce((a, b) => a + b, 0);
    this.#reader.itemSizes = sizes;
    return changed;
  }

  // ---- Everything

  #fill(info) {
    this.dispose(); // of what three.js has made of the old arrays
    this.#makeVertices(info.vertexCapacity);
    this.#writeVertices(0, info.vertexCount);
    this.#tripleCount = info.indexCount / 3;
    this.#writeOutward(0, this.#tripleCount);
    const triples = info.indexCapacity / 3;
    this.#slotOf = new Int32Array(triples).fill(-1);
    this.#placeOf = new Int32Array(triples);
    for (let t = 0; t < this.#tripleCount; ++t) this.#slotOf[t] = this.#slotFor(t);
    this.#layOutRegions();
    this.#lineIndex = null; // and made anew, if it is wanted
    this.uploadedBytes += this.#vertices.array.byteLength;
  }
  #makeVertices(capacity) {
    this.#vertices = new InterleavedBuffer(new Float32Array(capacity * this.#stride), this.#stride);
    const { geometry } = this;
    for (const name of Object.keys(geometry.attributes)) geometry.deleteAttribute(name);
    const position = new InterleavedBufferAttribute(this.#vertices, 3, 0);
    geometry.setAttribute('position', position);
    geometry.setAttribute(
      'shadowcutMask',
      new InterleavedBufferAttribute(this.#vertices, this.#maskSize, 6),
    );
    geometry.setAttribute('shadowcutOutward', new InterleavedBufferAttribute(this.#vertices, 3, 3));
    let at = 6 + this.#maskSize;
    carried.forEach((name, k) => {
      const size = this.#itemSizes[k];
      if (size > 0)
        geometry.setAttribute(name, new InterleavedBufferAttribute(this.#vertices, size, at));
      at += size;
    });
    this.lines.setAttribute('position', position);
  }

  // ---- What has changed

  #follow(vertexRanges, indexRanges, info) {
    this.#followVertices(vertexRanges);
    const count = info.indexCount / 3;
    for (let t = count; t < this.#tripleCount; ++t) this.#takeOut(t);
    this.#tripleCount = count;
    let fits = true;
    for (let i = 0; i < indexRanges.length; i += 2) {
      const first = indexRanges[i] / 3,
        end = first + indexRanges[i + 1] / 3;
      for (let t = first; t < end; ++t) fits = this.#putRight(t) && fits;
      this.#writeOutward(first, end);
      if (this.#lineIndex) this.#writeLines(first, end);
    }
    if (this.#mirror.restyled.size > 0) fits = this.#restyle() && fits;
    if (!fits) return this.#layOutRegions();
    this.#uploadIndices();
    this.#makeGroups();
  }
  #followVertices(ranges) {
    let first = 0,
      end = -1;
    const gap = joinedVertexBytes / (4 * this.#stride);
    for (let i = 0; i < ranges.length; i += 2) {
      const from = ranges[i],
        to = from + ranges[i + 1];
      this.#writeVertices(from, to);
      if (end >= 0 && from > end + gap) {
        this.#uploadVertices(first, end);
        end = -1;
      }
      if (end < 0) first = from;
      end = to;
    }
    if (end >= 0) this.#uploadVertices(first, end);
  }
  #uploadVertices(first, end) {
    touch(this.#vertices, first * this.#stride, (end - first) * this.#stride);
    this.uploadedBytes += (end - first) * this.#stride * 4;
    if (!this.#lineIndex) return;
    this.#clearLines(first, end);
    touch(this.#lineIndex, 2 * first, 2 * (end - first));
    this.uploadedBytes += 8 * (end - first);
  }

  // Meshes whose materials or attributes have changed, while their fragments are the same: all of
  // theirs.
  #restyle() {
    const { objects, faces, indices } = this.#streams;
    const { instances, restyled } = this.#mirror;
    let fits = true,
      first = 0,
      end = -1;
    for (let t = 0; t < this.#tripleCount; ++t) {
      const a = indices[3 * t];
      if (faces[a] === invalidIndex || !restyled.has(instances[objects[a]].entry)) continue;
      fits = this.#putRight(t) && fits;
      const last = indices[3 * t + 2] + 1;
      this.#writeVertices(a, last);
      if (end >= 0 && a > end) (this.#uploadVertices(first, end), (end = -1));
      if (end < 0) first = a;
      end = last;
    }
    if (end >= 0) this.#uploadVertices(first, end);
    return fits;
  }

  // ---- Triangles

  // The slot of a triple's material; -1 for holes, and what has no material.
  #slotFor(t) {
    const { faces, objects, indices } = this.#streams;
    const a = indices[3 * t],
      face = faces[a];
    if (face === invalidIndex || indices[3 * t + 1] === a) return -1;
    const instance = this.#mirror.instances[objects[a]];
    const { slots, source } = instance.entry;
    return (source.groups ? slots[source.groups[face - instance.firstFace]] : slots[0]) ?? -1;
  }
  // False: there is no room.
  #putRight(t) {
    const slot = this.#slotFor(t);
    const old = this.#slotOf[t];
    if (old === slot) {
      if (slot >= 0) this.#write(t);
      return true;
    }
    if (old >= 0) this.#takeOut(t);
    this.#slotOf[t] = slot;
    if (slot < 0) return true;
    const region = this.#regions[slot];
    // and then all regions are laid out by slotOf
    if (!region || region.count === region.capacity) return false;
    this.#placeOf[t] = region.first + region.count++;
    this.#tripleAt[this.#placeOf[t]] = t;
    this.#write(t);
    return true;
  }
  #takeOut(t) {
    const slot = this.#slotOf[t];
    this.#slotOf[t] = -1;
    if (slot < 0) return;
    const region = this.#regions[slot];
    // while there is no room, what is in the regions is not kept
    if (!region || region.count === 0) return;
    const place = this.#placeOf[t],
      end = region.first + --region.count;
    if (place === end) return;
    const last = this.#tripleAt[end];
    this.#placeOf[last] = place;
    this.#tripleAt[place] = last;
    this.#write(last);
  }
  #write(t) {
    const { indices } = this.#streams;
    const { array } = this.#index;
    const at = 3 * this.#placeOf[t],
      from = 3 * t;
    if (
      array[at] === indices[from] &&
      array[at + 1] === indices[from + 1] &&
      array[at + 2] === indices[from + 2]
    )
      return;
    ((array[at] = indices[from]),
      (array[at + 1] = indices[from + 1]),
      (array[at + 2] = indices[from + 2]));
    this.#touched.push(this.#placeOf[t]);
  }
  #uploadIndices() {
    const { array, length } = this.#touched;
    if (length === 0) return;
    array.subarray(0, length).sort();
    let first = array[0],
      end = first + 1;
    for (let i = 1; i <= length; ++i) {
      const place = i < length ? array[i] : Infinity;
      if (place <= end + joinedIndices / 3) {
        end = Math.max(end, place + 1);
        continue;
      }
      touch(this.#index, 3 * first, 3 * (end - first));
      this.uploadedBytes += 12 * (end - first);
      ((first = place), (end = place + 1));
    }
    this.#touched.length = 0;
  }

  // All regions anew, by slotOf.
  #layOutRegions() {
    this.#touched.length = 0;
    const counts = this.#palette.materials.map(() => 0);
    for (let t = 0; t < this.#tripleCount; ++t) if (this.#slotOf[t] >= 0) ++counts[this.#slotOf[t]];
    let total = 0;
    this.#regions = counts.map((count) => {
      const capacity = count + (count >> 1) + 16;
      const region = { first: total, count: 0, capacity };
      total += capacity;
      return region;
    });
    if (!this.#index || this.#index.array.length < 3 * total) {
      if (this.#index) this.geometry.dispose();
      this.#index = new BufferAttribute(new Uint32Array(3 * total), 1);
      this.geometry.setIndex(this.#index);
      this.#tripleAt = new Int32Array(total);
    } else {
      this.#index.clearUpdateRanges();
      this.#index.needsUpdate = true;
    }
    const { array } = this.#index;
    const { indices } = this.#streams;
    for (let t = 0; t < this.#tripleCount; ++t) {
      const slot = this.#slotOf[t];
      if (slot < 0) continue;
      const region = this.#regions[slot],
        place = region.first + region.count++;
      this.#placeOf[t] = place;
      this.#tripleAt[place] = t;
      for (let k = 0; k < 3; ++k) array[3 * place + k] = indices[3 * t + k];
    }
    this.uploadedBytes += array.byteLength;
    this.#makeGroups();
  }
  #makeGroups() {
    const { groups } = this.geometry;
    let n = 0;
    for (let slot = 0; slot < this.#regions.length; ++slot) {
      const { first, count } = this.#regions[slot];
      if (count === 0) continue;
      const group = (groups[n++] ??= { start: 0, count: 0, materialIndex: 0 });
      ((group.start = 3 * first), (group.count = 3 * count), (group.materialIndex = slot));
    }
    groups.length = n;
  }

  // ---- Outlines

  // Two numbers a vertex: itself, and the next of its fragment; twice itself in holes.
  #makeLines() {
    this.dispose(); // of both: disposing of one takes from three.js the buffer that they share
    if (!this.withLines) {
      this.#lineIndex = null;
      this.lines.setIndex(null);
      return;
    }
    const { array, stride } = this.#vertices;
    this.#lineIndex = new BufferAttribute(new Uint32Array((2 * array.length) / stride), 1);
    this.lines.setIndex(this.#lineIndex);
    this.#writeLines(0, this.#tripleCount);
    this.uploadedBytes += this.#lineIndex.array.byteLength;
  }
  #clearLines(first, end) {
    const { faces } = this.#streams;
    const { array } = this.#lineIndex;
    for (let v = first; v < end; ++v) {
      if (faces[v] === invalidIndex) array[2 * v + 1] = array[2 * v];
    }
  }
  // Of triples: a fragment's follow each other as a fan, the last one closes it.
  #writeLines(first, end) {
    const { faces, indices } = this.#streams;
    const { array } = this.#lineIndex;
    for (let t = first; t < end; ++t) {
      const a = indices[3 * t],
        b = indices[3 * t + 1],
        c = indices[3 * t + 2];
      if (faces[a] === invalidIndex) continue;
      if (b === a + 1) ((array[2 * a] = a), (array[2 * a + 1] = b));
      ((array[2 * b] = b), (array[2 * b + 1] = c));
      ((array[2 * c] = c), (array[2 * c + 1] = a));
    }
  }

  // ---- Vertices

  #writeVertices(first, end) {
    const { positions, faces, objects, states } = this.#streams;
    const { instances } = this.#mirror;
    const out = this.#vertices.array,
      stride = this.#stride,
      inherited = 6 + this.#maskSize,
      reader = this.#reader;
    let face = -1,
      frame = null;
    for (let v = first; v < end; ++v) {
      if (faces[v] === invalidIndex) continue; // a hole: nothing refers to it
      if (faces[v] !== face) {
        face = faces[v];
        frame = reader.read(instances[objects[v]], face, this.origin);
      }
      const at = v * stride;
      ((out[at] = positions[3 * v]),
        (out[at + 1] = positions[3 * v + 1]),
        (out[at + 2] = positions[3 * v + 2]));
      if (states !== null) out[at + 6] = states[v];
      else this.#writeMask(v, at + 6);
      frame.interpolate(positions, 3 * v, out, at + inherited);
    }
  }
  // Of whole fragments: what moves both edges at a corner outward by one, in the face's plane; no
  // more than four at sharp corners.
  #writeOutward(firstTriple, endTriple) {
    const { indices } = this.#streams;
    for (let t = firstTriple; t < endTriple;) {
      const first = indices[3 * t];
      let last = indices[3 * t + 2];
      for (++t; t < endTriple && indices[3 * t] === first; ++t) last = indices[3 * t + 2];
      if (last > first) this.#writeOutwardOf(first, last);
    }
  }
  #writeOutwardOf(first, last) {
    const p = this.#streams.positions,
      out = this.#vertices.array,
      stride = this.#stride;
    let nx = 0,
      ny = 0,
      nz = 0; // twice the area, along the normal
    const ox = p[3 * first],
      oy = p[3 * first + 1],
      oz = p[3 * first + 2];
    let bx = p[3 * first + 3] - ox,
      by = p[3 * first + 4] - oy,
      bz = p[3 * first + 5] - oz;
    for (let v = first + 2; v <= last; ++v) {
      const cx = p[3 * v] - ox,
        cy = p[3 * v + 1] - oy,
        cz = p[3 * v + 2] - oz;
      ((nx += by * cz - bz * cy), (ny += bz * cx - bx * cz), (nz += bx * cy - by * cx));
      ((bx = cx), (by = cy), (bz = cz));
    }
    const n = 1 / (Math.sqrt(nx * nx + ny * ny + nz * nz) || 1);
    ((nx *= n), (ny *= n), (nz *= n));
    // Outward of the edge that comes to a corner, and of the one that leaves it.
    let ux = 0,
      uy = 0,
      uz = 0;
    for (let v = first - 1; v <= last; ++v) {
      const from = 3 * (v < first ? last : v),
        to = 3 * (v === last ? first : v + 1);
      const ex = p[to] - p[from],
        ey = p[to + 1] - p[from + 1],
        ez = p[to + 2] - p[from + 2];
      const e = 1 / (Math.sqrt(ex * ex + ey * ey + ez * ez) || 1);
      const wx = (ey * nz - ez * ny) * e,
        wy = (ez * nx - ex * nz) * e,
        wz = (ex * ny - ey * nx) * e;
      if (v >= first) {
        const scale = 1 / Math.max(1 + ux * wx + uy * wy + uz * wz, 0.125);
        const at = v * stride + 3;
        ((out[at] = (ux + wx) * scale),
          (out[at + 1] = (uy + wy) * scale),
          (out[at + 2] = (uz + wz) * scale));
      }
      ((ux = wx), (uy = wy), (uz = wz));
    }
  }
  #writeMask(v, at) {
    const { masks, maskWords } = this.#streams;
    const out = this.#vertices.array;
    for (let k = 0; k < this.#maskSize; ++k) {
      const bit = k * bitsPerNumber,
        word = v * maskWords + (bit >> 5),
        shift = bit & 31;
      let value = masks[word] >>> shift;
      if (shift > 32 - bitsPerNumber && (bit >> 5) + 1 < maskWords)
        value |= masks[word + 1] << (32 - shift);
      out[at + k] = value & 0xffffff;
    }
  }
}
