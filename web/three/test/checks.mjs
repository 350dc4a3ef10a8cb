// What must hold of a SceneShadows after every update, worked out another way: from the three.js
// scene, by three.js' own mathematics, and from buffers that are filled anew.
import assert from 'node:assert/strict';
import * as THREE from 'three';

// A second copy of what is on a graphics card: made as three.js makes it, from whole arrays and
// from the ranges marked for upload.
export class Uploads {
  #copies = new Map();
  #versions = new Map();
  follow(shadows) {
    const { geometry } = shadows.mesh;
    const lines = shadows.mesh.children[0].geometry;
    const all = [geometry.attributes.position?.data, geometry.index, lines.index].filter(Boolean);
    for (const attribute of all) {
      const { array, updateRanges } = attribute;
      if (!this.#copies.has(attribute)) this.#copies.set(attribute, array.slice());
      else if (this.#versions.get(attribute) !== attribute.version) {
        const copy = this.#copies.get(attribute);
        if (updateRanges.length === 0) copy.set(array);
        for (const { start, count } of updateRanges)
          copy.set(array.subarray(start, start + count), start);
      }
      attribute.clearUpdateRanges(); // as the renderer does
      this.#versions.set(attribute, attribute.version);
      assert.deepEqual(
        this.#copies.get(attribute),
        array,
        'what was uploaded is not what there is',
      );
    }
    for (const old of this.#copies.keys())
      if (!all.includes(old)) (this.#copies.delete(old), this.#versions.delete(old));
  }
}

// The triangles of the scene in the world, by object of the engine: [{ mesh, instance, points,
// normals ... }].
function worldTriangles(shadows, meshes) {
  const byObject = new Map();
  for (const mesh of meshes) {
    const { geometry, material } = mesh;
    const { index, attributes, drawRange, groups } = geometry;
    const all = index ? index.count : attributes.position.count;
    const last = Math.min(all, drawRange.start + drawRange.count);
    const list = [];
    for (const group of Array.isArray(material)
      ? groups
      : [{ start: 0, count: all, materialIndex: 0 }]) {
      const from = Math.max(group.start, drawRange.start),
        to = Math.min(last, group.start + group.count);
      for (let i = from; i + 2 < to; i += 3) {
        list.push({
          corners: [0, 1, 2].map((k) => (index ? index.getX(i + k) : i + k)),
          material: Array.isArray(material) ? material[group.materialIndex] : material,
        });
      }
    }
    for (let instance = 0; instance < (mesh.isInstancedMesh ? mesh.count : 1); ++instance) {
      const object = shadows.objectOf(mesh, instance);
      if (object === undefined) continue;
      const matrix = mesh.matrixWorld.clone();
      if (mesh.isInstancedMesh)
        matrix.multiply(new THREE.Matrix4().fromArray(mesh.instanceMatrix.array, 16 * instance));
      const normalMatrix = new THREE.Matrix3().getNormalMatrix(matrix);
      const flip = matrix.determinant() < 0 ? -1 : 1;
      byObject.set(
        object,
        list.map(({ corners, material }) => {
          const points = corners.map((v) =>
            new THREE.Vector3().fromBufferAttribute(attributes.position, v).applyMatrix4(matrix),
          );
          const normal = new THREE.Triangle(...points).getNormal(new THREE.Vector3());
          return {
            mesh,
            instance,
            corners,
            material,
            points,
            normal,
            normalMatrix,
            matrix,
            flip,
            attributes,
          };
        }),
      );
    }
  }
  return byObject;
}

// What is drawn: [{ material, mask, vertices: [v, v, v], points (floats, less the origin) }].
function drawnTriangles(shadows) {
  const { geometry, material } = shadows.mesh;
  const { position, shadowcutMask } = geometry.attributes;
  const out = [];
  for (const { start, count, materialIndex } of geometry.groups) {
    for (let i = start; i < start + count; i += 3) {
      const vertices = [0, 1, 2].map((k) => geometry.index.getX(i + k));
      const points = vertices.flatMap((v) => [
        position.getX(v),
        position.getY(v),
        position.getZ(v),
      ]);
      const mask = [...Array(shadowcutMask.itemSize).keys()].map((k) =>
        shadowcutMask.getComponent(vertices[0], k),
      );
      for (const v of vertices)
        mask.forEach((m, k) => assert.equal(shadowcutMask.getComponent(v, k), m));
      out.push({ material: material[materialIndex], mask, vertices, points });
    }
  }
  return out;
}
// The triangles of the mesh in which the middle of these points lies, in their planes and inside:
// one, unless some overlap.
function sourcesOf(points, triangles, origin) {
  const [a, b, c] = [0, 3, 6].map((k) =>
    new THREE.Vector3(...points.slice(k, k + 3)).add(new THREE.Vector3(...origin)),
  );
  const middle = a.clone().add(b).add(c).divideScalar(3),
    turned = new THREE.Triangle(a, b, c).getNormal(new THREE.Vector3());
  const distances = triangles.map((triangle) => {
    const n = triangle.normal,
      [p] = triangle.points;
    const off = Math.abs(n.x * (middle.x - p.x) + n.y * (middle.y - p.y) + n.z * (middle.z - p.z));
    if (n.lengthSq() === 0 || off > 0.01) return Infinity;
    const outside = Math.max(
      0,
      ...barycentric(middle, triangle.points)
        .toArray()
        .map((w) => -w),
    );
    // of two faces, back to back, the right one
    return outside + 100 * off + (n.dot(turned) * triangle.flip < 0 ? 0.01 : 0);
  });
  const least = Math.min(...distances);
  return triangles.filter((_, i) => distances[i] <= least + 1e-4);
}
// One of them will do.
function checkAny(sources, check) {
  let failed = null;
  for (const source of sources) {
    try {
      return check(source);
    } catch (error) {
      failed ??= error;
    }
  }
  throw failed;
}
const keyOf = (points, mask) => `${points.join(' ')}|${mask}`;

// The same from buffers of the engine that are filled anew: key -> [{ face, object }].
function filledTriangles(shadowcut, shadows, light, origin) {
  const all = light === 'all',
    sizeOfMask = shadows.mesh.geometry.attributes.shadowcutMask.itemSize;
  const bitsOf = (list, size) => {
    const bits = [...list].reduce((sum, word, k) => sum | (BigInt(word) << BigInt(32 * k)), 0n);
    return Array.from({ length: size }, (_, k) => Number((bits >> BigInt(24 * k)) & 0xffffffn));
  };
  const buffers = new shadowcut.Buffers(light, {
    origin,
    indexed: true,
    objects: true,
    masks: all,
  });
  buffers.update(shadows.engine);
  const { indexCount, maskWords: words } = buffers.info;
  const indices = buffers.stream('indices').slice(0, indexCount),
    positions = buffers.stream('positions').slice();
  const faces = buffers.stream('faces').slice(),
    objects = buffers.stream('objects').slice();
  const states = buffers.stream('states').slice(),
    masks = all ? buffers.stream('masks').slice() : null;
  buffers.dispose();
  const found = new Map(),
    lines = new Map();
  let fan = [];
  const close = () => {
    fan.forEach((v, i) => {
      const key = [v, fan[(i + 1) % fan.length]]
        .map((w) => positions.subarray(3 * w, 3 * w + 3).join(' '))
        .join(' - ');
      lines.set(key, (lines.get(key) ?? 0) + 1);
    });
  };
  for (let i = 0; i < indexCount; i += 3) {
    const [a, b, c] = indices.subarray(i, i + 3);
    const key = keyOf(
      [a, b, c].flatMap((v) => [...positions.subarray(3 * v, 3 * v + 3)]),
      all ? bitsOf(masks.subarray(words * a, words * (a + 1)), sizeOfMask) : [states[a]],
    );
    if (!found.has(key)) found.set(key, []);
    found.get(key).push({ face: faces[a], object: objects[a] });
    if (a !== fan[0]) (close(), (fan = [a, b, c]));
    else fan.push(c);
  }
  close();
  return { found, lines };
}

export function checkAll(
  shadowcut,
  shadows,
  meshes,
  { sample = Infinity, random = Math.random } = {},
) {
  const origin = shadows.mesh
    .getWorldPosition(new THREE.Vector3().setFromMatrixPosition(shadows.mesh.matrixWorld))
    .toArray();
  const followed = shadows.lights
    .map((light, index) => ({ light, index }))
    .filter(({ light }) => light);
  const light = followed.length > 1 ? 'all' : followed.length === 1 ? followed[0].index : 0;
  if (followed.length > 0)
    checkTriangles(shadowcut, shadows, meshes, light, origin, followed, sample, random);
  checkLayers(shadows, meshes);
}

function checkTriangles(shadowcut, shadows, meshes, light, origin, followed, sample, random) {
  const drawn = drawnTriangles(shadows);
  const { found, lines } = filledTriangles(shadowcut, shadows, light, origin);
  const world = worldTriangles(shadows, meshes);
  let count = 0; // without those of a group for which there is no material
  const complete = (mesh) =>
    !Array.isArray(mesh.material) ||
    mesh.geometry.groups.every(({ materialIndex }) => mesh.material[materialIndex]);
  for (const [key, list] of found) {
    for (const { object } of list) {
      const triangles = world.get(object);
      if (
        complete(triangles[0].mesh) ||
        sourcesOf(key.split('|')[0].split(' ').map(Number), triangles, origin)[0].material
      )
        ++count;
    }
  }
  assert.equal(drawn.length, count, 'as many triangles as the engine has');
  const casters = [...world.values()]
    .flat()
    .filter(({ mesh }) => mesh.castShadow)
    .map(({ points }) => points);
  for (const triangle of drawn) {
    const list = found.get(keyOf(triangle.points, triangle.mask));
    assert.ok(list?.length > 0, 'a triangle that the engine does not have');
    const { object } = list.length === 1 ? list[0] : list.pop();
    if (random() * drawn.length > sample) continue;
    const sources = sourcesOf(triangle.points, world.get(object), origin);
    checkAny(sources, (source) => {
      checkMaterial(triangle.material, source);
      checkAttributes(shadows.mesh.geometry, triangle, source, origin);
      checkWinding(triangle, source);
    });
    if (sources.length === 1) {
      const closed = shadows.scene.object(shadows.scene.objectId(object)).sides === 'closed';
      checkRays(triangle, sources[0], closed, casters, followed, origin, light);
    }
  }
  if (shadows.outlines) checkLines(shadows, lines);
}

function checkMaterial(material, source) {
  assert.equal(material.color, source.material.color, "the original's colour");
  assert.equal(material.type, source.material.type);
  if (source.mesh.instanceColor) assert.equal(material.vertexColors, true);
  else assert.equal(material.vertexColors, source.material.vertexColors);
}

const barycentric = (p, [a, b, c]) => THREE.Triangle.getBarycoord(p, a, b, c, new THREE.Vector3());

function checkAttributes(geometry, { vertices }, source, origin) {
  const { attributes, corners, points, mesh } = source;
  const size = Math.max(...points.map((p) => p.distanceTo(points[0])));
  const tolerance = 1e-3; // of floats, in triangles somewhat smaller than the scene
  // a needle's coordinates are worth little
  const height = new THREE.Triangle(...points).getArea() / size;
  if (height < 0.02) return;
  for (const v of vertices) {
    const p = new THREE.Vector3()
      .fromBufferAttribute(geometry.attributes.position, v)
      .add(new THREE.Vector3(...origin));
    const weights = barycentric(p, points).toArray();
    const mix = (values) => values.reduce((sum, value, k) => sum + weights[k] * value, 0);
    for (const name of ['uv', 'uv1', 'color']) {
      const attribute = attributes[name],
        got = geometry.attributes[name];
      if (!got) {
        assert.ok(!attribute);
        continue;
      }
      const tinted = name === 'color' && mesh.instanceColor;
      for (let k = 0; k < got.itemSize; ++k) {
        let expected =
          attribute && k < attribute.itemSize
            ? mix(corners.map((c) => attribute.getComponent(c, k)))
            : name === 'color'
              ? 1
              : 0;
        if (tinted) {
          if (!source.material.vertexColors) expected = 1;
          if (k < 3) expected *= mesh.instanceColor.getComponent(source.instance, k);
        }
        assert.ok(
          Math.abs(got.getComponent(v, k) - expected) < 5 * tolerance,
          `${name}: ${got.getComponent(v, k)}, not ${expected}`,
        );
      }
    }
    const normal = new THREE.Vector3().fromBufferAttribute(geometry.attributes.normal, v);
    const expected = [];
    if (attributes.normal) {
      for (const unit of [true, false]) {
        // at the corners, as three.js does; or, where triangles were joined, only in the end
        const sum = new THREE.Vector3();
        corners.forEach((c, k) => {
          const n = new THREE.Vector3()
            .fromBufferAttribute(attributes.normal, c)
            .applyMatrix3(source.normalMatrix);
          sum.addScaledVector(unit ? n.normalize() : n, weights[k]);
        });
        if (sum.length() < 0.05) return;
        expected.push(sum.normalize());
      }
    } else {
      expected.push(source.normal.clone().multiplyScalar(source.flip));
    }
    const near = expected.some((n) => normal.distanceTo(n) < 20 * tolerance);
    assert.ok(near, `normal ${normal.toArray()}, not ${expected[0].toArray()}`);
  }
}
// As three.js would draw it: the front is where the source triangle's corners run
// counter-clockwise, in the object's frame.
function checkWinding({ points }, source) {
  const [a, b, c] = [0, 3, 6].map((k) => new THREE.Vector3(...points.slice(k, k + 3)));
  const turned = new THREE.Triangle(a, b, c),
    whole = new THREE.Triangle(...source.points);
  const size = Math.max(a.distanceTo(b), b.distanceTo(c), c.distanceTo(a));
  if (turned.getArea() <= 1e-4 * size) return; // what floats make of a needle has any direction
  const cosine =
    turned.getNormal(new THREE.Vector3()).dot(whole.getNormal(new THREE.Vector3())) * source.flip;
  assert.ok(cosine > 0.9, `turned the wrong way: ${cosine}`);
}

// 1: hit, 0: missed, -1: too close to call.
function hits(from, direction, distance, [a, b, c]) {
  const e1 = b.clone().sub(a),
    e2 = c.clone().sub(a);
  const p = direction.clone().cross(e2),
    det = e1.dot(p);
  const t0 = from.clone().sub(a);
  if (Math.abs(det) < 1e-3 * e1.length() * e2.length()) {
    const n = e1.clone().cross(e2).normalize();
    return Math.abs(n.dot(t0)) > 0.05 && Math.abs(n.dot(direction)) < 1e-9 ? 0 : -1;
  }
  const u = t0.dot(p) / det,
    q = t0.clone().cross(e1),
    v = direction.dot(q) / det,
    t = e2.dot(q) / det;
  const margin = 0.02;
  const inside = Math.min(u, v, 1 - u - v);
  if (inside < -margin || t < -margin || t > distance + margin) return 0;
  return inside > margin && t > margin && t < distance - margin ? 1 : -1;
}
function isOutOfReach(light, direction, distance) {
  if (light.distance > 0 && distance > 0.99 * light.distance) return true;
  if (!light.isSpotLight) return false;
  const axis = new THREE.Vector3()
    .setFromMatrixPosition(light.target.matrixWorld)
    .sub(new THREE.Vector3().setFromMatrixPosition(light.matrixWorld));
  return axis.angleTo(direction.clone().negate()) > 0.99 * light.angle;
}
function checkRays({ points, mask }, source, closed, casters, followed, origin, only) {
  const centre = new THREE.Vector3();
  for (const k of [0, 3, 6]) centre.add(new THREE.Vector3(...points.slice(k, k + 3)));
  centre.divideScalar(3).add(new THREE.Vector3(...origin));
  for (const { light, index } of followed) {
    const at = new THREE.Vector3().setFromMatrixPosition(light.matrixWorld);
    let direction = at.clone().sub(centre),
      distance = direction.length();
    if (light.isDirectionalLight)
      ((direction = at
        .clone()
        .sub(new THREE.Vector3().setFromMatrixPosition(light.target.matrixWorld))),
        (distance = 1e3));
    direction.normalize();
    if (isOutOfReach(light, direction, distance)) continue; // there is nothing to be in shadow of
    const bit = only === 'all' ? index : 0;
    const lit = ((mask[Math.floor(bit / 24)] >> (bit % 24)) & 1) === 1;
    let doubtful = false,
      shadowed = false;
    for (const caster of casters) {
      if (caster.every((p, k) => p.equals(source.points[k]))) continue;
      const h = hits(centre, direction, distance, caster);
      shadowed ||= h === 1;
      doubtful ||= h === -1;
    }
    const whole = new THREE.Triangle(...source.points).getNormal(new THREE.Vector3());
    const cosine = whole.dot(direction) * source.flip;
    if (Math.abs(cosine) < 1e-3) continue; // edge-on
    if (closed && cosine < 0) shadowed = true; // turned away
    if (shadowed) assert.ok(!lit, `lit by ${light.type}, though something stands between`);
    else if (!doubtful) assert.ok(lit, `not lit by ${light.type}, though nothing stands between`);
  }
}

function checkLines(shadows, expected) {
  const { geometry } = shadows.mesh.children[0];
  const { position } = geometry.attributes;
  const lines = new Map();
  for (let i = 0; i < geometry.drawRange.count; i += 2) {
    const a = geometry.index.getX(i),
      b = geometry.index.getX(i + 1);
    if (a === b) continue;
    const key = [a, b]
      .map((v) => [position.getX(v), position.getY(v), position.getZ(v)].join(' '))
      .join(' - ');
    lines.set(key, (lines.get(key) ?? 0) + 1);
  }
  assert.deepEqual(new Map([...lines].sort()), new Map([...expected].sort()), 'outlines');
}

function checkLayers(shadows, meshes) {
  for (const mesh of meshes) {
    let shown = true;
    mesh.traverseAncestors((parent) => (shown &&= parent.visible));
    const there =
      shown && mesh.visible && mesh.receiveShadow && shadows.objectOf(mesh) !== undefined;
    assert.equal(mesh.layers.mask, there ? 1 << 31 : 1, 'the layer');
  }
}

// Areas by mesh, instance and light, from what is drawn by two of them.
export function areas(shadows, meshes) {
  const faces = shadows.engine.scene.faces();
  const out = {};
  shadows.lights.forEach((light, index) => {
    if (!light) return;
    const list = shadows.engine.shadows(index).areas();
    meshes.forEach((mesh, m) => {
      for (let k = 0; k < (mesh.isInstancedMesh ? mesh.count : 1); ++k) {
        const object = shadows.objectOf(mesh, k);
        if (object === undefined) continue;
        let lit = 0,
          shadowed = 0;
        list.forEach(
          (area, f) =>
            faces[f].object === object && ((lit += area.lit), (shadowed += area.shadowed)),
        );
        out[`${m} ${k} ${light.uuid}`] = [lit, shadowed];
      }
    });
  });
  return out;
}
export function drawnArea(shadows) {
  return drawnTriangles(shadows).reduce((sum, { points }) => {
    const [a, b, c] = [0, 3, 6].map((k) => new THREE.Vector3(...points.slice(k, k + 3)));
    return sum + new THREE.Triangle(a, b, c).getArea();
  }, 0);
}
