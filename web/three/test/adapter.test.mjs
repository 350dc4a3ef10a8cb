// What SceneShadows does besides following: what it cannot mirror, poses on request, materials, far
// scenes, out of memory, and giving back.
import assert from 'node:assert/strict';
import test from 'node:test';
import * as THREE from 'three';
import { load } from 'shadowcut';
import { SceneShadows } from '../src/index.js';
import { Palette } from '../src/materials.js';
import { checkAll } from './checks.mjs';

const shadowcut = await load();

function shown(geometry, material = new THREE.MeshStandardMaterial(), position = [0, 0, 0]) {
  const mesh = new THREE.Mesh(geometry, material);
  mesh.castShadow = mesh.receiveShadow = true;
  mesh.position.set(...position);
  return mesh;
}
function room() {
  const scene = new THREE.Scene();
  const floor = shown(new THREE.PlaneGeometry(8, 8).rotateX(-Math.PI / 2));
  const box = shown(new THREE.BoxGeometry(), new THREE.MeshLambertMaterial(), [0, 1, 0]);
  const lamp = new THREE.PointLight();
  lamp.position.set(0, 4, 0);
  scene.add(floor, box, lamp);
  return { scene, floor, box, lamp };
}
function follow(scene, options) {
  const shadows = new SceneShadows(shadowcut, scene, options);
  shadows.update();
  return shadows;
}
const near = (got, expected, tolerance = 1e-9) =>
  assert.ok(Math.abs(got - expected) <= tolerance * Math.abs(expected), `${got}, not ${expected}`);

test('a table in a room: areas to the last digit', () => {
  const { scene, box } = room();
  const shadows = follow(scene, { kernel: 'exact' });
  // The box's top, at 1.5 of the light's 4, throws a square of side 4 / 2.5 on the floor; the light
  // sees the top, and no side.
  near(shadows.litArea(), 64 - 1.6 * 1.6 + 1);
  near(shadows.facingArea(), 65);
  const { ms, engineMs, ...done } = shadows.update();
  assert.deepEqual(done, { applied: 0, gone: 0, added: 0, uploadedBytes: 0, rebuilt: false });
  box.visible = false;
  assert.equal(shadows.update().applied, 1);
  near(shadows.litArea(), 64);
  scene.clear();
  scene.add(box);
  box.visible = true;
  shadows.update();
  assert.ok(scene.children.includes(shadows.mesh), 'it is there again');
  assert.deepEqual(shadows.lights.filter(Boolean), []);
  shadows.dispose();
});

test('what is given back', () => {
  const { scene, floor, box, lamp } = room();
  floor.layers.set(3);
  const before = scene.children.slice(),
    { material } = box;
  const shadows = follow(scene);
  assert.equal(floor.layers.mask, 1 << 31);
  assert.equal(box.layers.mask, 1 << 31);
  assert.equal(
    new THREE.Raycaster(new THREE.Vector3(0, 5, 0), new THREE.Vector3(0, -1, 0)).intersectObject(
      scene,
    ).length,
    0,
  );
  const caster = new THREE.Raycaster(new THREE.Vector3(0, 5, 0), new THREE.Vector3(0, -1, 0));
  caster.layers.enable(31);
  assert.equal(caster.intersectObject(scene)[0].object, box);
  box.removeFromParent();
  shadows.update();
  assert.equal(box.layers.mask, 1);
  scene.add(box);
  shadows.update();
  shadows.dispose();
  shadows.dispose();
  assert.equal(floor.layers.mask, 1 << 3);
  assert.equal(box.layers.mask, 1);
  assert.equal(box.material, material);
  assert.deepEqual(new Set(scene.children), new Set(before));
  assert.ok(shadows.engine.disposed && shadows.scene.disposed);
  assert.equal(lamp.layers.mask, 1);
});

test('what only casts is drawn by three.js, what only receives casts nothing', () => {
  const { scene, floor, box } = room();
  box.receiveShadow = false;
  floor.castShadow = false;
  const shadows = follow(scene);
  assert.equal(box.layers.mask, 1);
  near(shadows.litArea(), 64 - 1.6 * 1.6);
  box.castShadow = false;
  shadows.update();
  near(shadows.litArea(), 64);
  assert.equal(shadows.objectOf(box), undefined);
  shadows.dispose();
});

test('what cannot be mirrored is told once, and the rest goes on', () => {
  const { scene, floor, box, lamp } = room();
  const broken = shown(new THREE.BoxGeometry());
  broken.geometry.attributes.position.setX(0, NaN);
  const empty = shown(new THREE.BufferGeometry());
  const squashed = shown(new THREE.BoxGeometry());
  squashed.scale.y = 0;
  const lost = shown(new THREE.BoxGeometry());
  lost.position.x = NaN;
  const area = new THREE.RectAreaLight();
  const nowhere = new THREE.PointLight();
  nowhere.position.y = Infinity;
  const batched = new THREE.BatchedMesh(1, 24, 36);
  batched.castShadow = true;
  scene.add(broken, empty, squashed, lost, area, nowhere, batched);
  const shadows = follow(scene);
  for (let i = 0; i < 3; ++i) {
    lamp.position.x += 0.1;
    shadows.update();
  }
  const told = (object) =>
    shadows.issues.filter((issue) => issue.object === object).map(({ message }) => message);
  assert.deepEqual(told(broken), [
    'triangles are left out: they have coordinates that are not finite',
  ]);
  assert.deepEqual(told(empty), ['has no triangles']);
  assert.deepEqual(told(squashed), ['its matrix cannot be inverted']);
  assert.deepEqual(told(lost), ['its matrix has numbers that are not finite']);
  assert.match(told(area)[0], /RectAreaLight/);
  assert.match(told(nowhere)[0], /not finite/);
  assert.match(told(batched)[0], /BatchedMesh/);
  assert.equal(shadows.issues.length, 7);
  assert.equal(shadows.objectOf(squashed), undefined);
  squashed.scale.y = 1;
  squashed.position.set(2, 1, 2);
  scene.remove(broken);
  shadows.update();
  assert.notEqual(shadows.objectOf(squashed), undefined);
  checkAll(shadowcut, shadows, [floor, box, squashed]);
  shadows.dispose();
});

test('no light, one, and several', () => {
  const { scene, floor, box, lamp } = room();
  scene.remove(lamp);
  const shadows = follow(scene);
  const drawn = () => shadows.mesh.geometry.groups.reduce((sum, { count }) => sum + count, 0);
  const bare = drawn();
  assert.equal(bare, 3 * (2 + 12));
  assert.equal(shadows.litArea(), 0);
  scene.add(lamp);
  shadows.update();
  assert.ok(drawn() > bare);
  assert.equal(shadows.lights[0] ?? shadows.lights[1], lamp);
  const many = Array.from({ length: 40 }, (_, i) => {
    const light = new THREE.DirectionalLight();
    light.position.set(Math.sin(i), 3, Math.cos(i));
    return light;
  });
  scene.add(...many);
  shadows.update();
  assert.equal(shadows.mesh.geometry.attributes.shadowcutMask.itemSize, 2);
  checkAll(shadowcut, shadows, [floor, box]);
  many.forEach((light) => scene.remove(light));
  scene.remove(lamp);
  shadows.update();
  assert.equal(drawn(), bare);
  shadows.dispose();
});

test('lights beyond the bits of a mask are told, and shade as if unshadowed', () => {
  const { scene } = room();
  scene.remove(scene.children[1]);
  for (let i = 0; i < 97; ++i) {
    const light = new THREE.DirectionalLight();
    light.position.set(Math.sin(i), 3, Math.cos(i));
    scene.add(light);
  }
  const shadows = follow(scene);
  assert.equal(shadows.issues.length, 2);
  for (const { message } of shadows.issues) assert.match(message, /only 96 lights have a bit/);
  shadows.dispose();
});

test('poses are taken on request', () => {
  const scene = new THREE.Scene();
  const geometry = new THREE.CylinderGeometry(0.3, 0.3, 2, 8, 4);
  const { position } = geometry.attributes;
  const indices = [],
    weights = [];
  for (let i = 0; i < position.count; ++i) {
    const t = (position.getY(i) + 1) / 2;
    indices.push(0, 1, 0, 0);
    weights.push(1 - t, t, 0, 0);
  }
  geometry.setAttribute('skinIndex', new THREE.Uint16BufferAttribute(indices, 4));
  geometry.setAttribute('skinWeight', new THREE.Float32BufferAttribute(weights, 4));
  const bones = [new THREE.Bone(), new THREE.Bone()];
  bones[0].position.y = -1;
  bones[1].position.y = 2;
  bones[0].add(bones[1]);
  const mesh = new THREE.SkinnedMesh(geometry, new THREE.MeshStandardMaterial());
  mesh.castShadow = mesh.receiveShadow = true;
  mesh.add(bones[0]);
  mesh.bind(new THREE.Skeleton(bones));
  const sun = new THREE.DirectionalLight();
  scene.add(mesh, sun);
  const shadows = follow(scene);
  const before = shadows.facingArea();
  bones[1].rotation.x = 1;
  scene.updateMatrixWorld(true);
  assert.equal(shadows.update().applied, 0); // not asked for
  shadows.bake(mesh);
  assert.equal(shadows.update().applied, 1);
  assert.notEqual(shadows.facingArea(), before);
  // As three.js has it, vertex for vertex; and its shader's normals.
  const posed = geometry.clone();
  const p = new THREE.Vector3(),
    n = new THREE.Vector4();
  for (let i = 0; i < position.count; ++i) {
    mesh.getVertexPosition(i, p);
    posed.attributes.position.setXYZ(i, p.x, p.y, p.z);
    n.set(
      geometry.attributes.normal.getX(i),
      geometry.attributes.normal.getY(i),
      geometry.attributes.normal.getZ(i),
      0,
    );
    mesh.applyBoneTransform(i, n);
    posed.attributes.normal.setXYZ(i, n.x, n.y, n.z);
  }
  mesh.geometry = posed;
  checkAll(shadowcut, shadows, [mesh]);
  shadows.dispose();
});

test('morphs, on request', () => {
  const { scene, box } = room();
  const { position } = box.geometry.attributes;
  box.geometry.morphAttributes.position = [
    new THREE.Float32BufferAttribute(
      Float32Array.from(position.array, (x) => 2 * x),
      3,
    ),
  ];
  box.updateMorphTargets();
  const shadows = follow(scene, { kernel: 'exact' });
  near(shadows.litArea(), 64 - 1.6 * 1.6 + 1);
  box.morphTargetInfluences[0] = 1;
  shadows.bake(box);
  shadows.update();
  near(shadows.litArea(), 64 - 16 + 4); // its top, of side 2, is at 2
  box.morphTargetInfluences[0] = 0;
  shadows.bake(box);
  shadows.update();
  near(shadows.litArea(), 64 - 1.6 * 1.6 + 1);
  shadows.dispose();
});

test('far from the origin floats keep their digits', () => {
  const { scene, floor, box, lamp } = room();
  const far = new THREE.Vector3(4e6, -2e6, 1e6);
  for (const object of [floor, box, lamp]) object.position.add(far);
  const shadows = follow(scene);
  near(shadows.litArea(), 64 - 1.6 * 1.6 + 1, 1e-7);
  const { array, stride } = shadows.mesh.geometry.attributes.position.data;
  const largest = array.reduce(
    (most, x, i) => (i % stride < 3 ? Math.max(most, Math.abs(x)) : most),
    0,
  );
  assert.ok(largest < 10, 'positions are less an origin nearby');
  const { elements } = shadows.mesh.matrixWorld;
  assert.ok(Math.hypot(elements[12] - far.x, elements[13] - far.y, elements[14] - far.z) < 10);
  checkAll(shadowcut, shadows, [floor, box]);
  shadows.dispose();
});

test('a scene with a matrix of its own', () => {
  const { scene, floor, box, lamp } = room();
  const world = new THREE.Scene();
  world.add(scene);
  scene.position.set(3, 2, 1);
  scene.rotation.z = 0.3;
  scene.scale.setScalar(2);
  const shadows = follow(scene);
  near(shadows.litArea(), 4 * (64 - 1.6 * 1.6 + 1), 1e-6);
  checkAll(shadowcut, shadows, [floor, box]);
  lamp.layers.set(4);
  shadows.dispose();
});

test('a material follows its original, which stays as it is', () => {
  const { scene, box } = room();
  const original = box.material;
  let compiled = 0;
  original.onBeforeCompile = () => ++compiled;
  original.customProgramCacheKey = () => 'mine';
  const own = Object.keys(original).sort();
  const shadows = follow(scene);
  const slot = shadows.mesh.geometry.groups
    .map(({ materialIndex }) => shadows.mesh.material[materialIndex])
    .find((m) => m.isMeshLambertMaterial);
  assert.notEqual(slot, original);
  assert.ok(slot.id !== original.id && slot.uuid !== original.uuid);
  assert.equal(slot.color, original.color);
  original.color = new THREE.Color(1, 0, 0);
  original.map = new THREE.Texture();
  original.opacity = 0.5;
  assert.equal(slot.color, original.color);
  assert.equal(slot.map, original.map);
  assert.equal(slot.opacity, 0.5);
  const { version } = slot;
  original.needsUpdate = true;
  assert.equal(slot.version, version + 1);
  // What three.js does with transparent double-sided materials while it draws.
  original.side = THREE.DoubleSide;
  assert.equal(slot.side, THREE.DoubleSide);
  slot.side = THREE.BackSide;
  slot.needsUpdate = true;
  assert.equal(original.side, THREE.DoubleSide);
  slot.side = THREE.DoubleSide;
  original.side = THREE.FrontSide;
  assert.equal(slot.side, THREE.FrontSide);
  const shader = { uniforms: {}, ...THREE.ShaderLib.lambert };
  shader.uniforms = {};
  slot.onBeforeCompile(shader, null);
  assert.equal(compiled, 1);
  assert.match(slot.customProgramCacheKey(), /mine/);
  assert.equal(
    shader.fragmentShader.match(/directLight\.color \*= shadowcutReaches/g).length,
    Object.keys(shader.uniforms).length,
  );
  let disposed = 0;
  slot.addEventListener('dispose', () => ++disposed);
  original.dispose();
  assert.equal(disposed, 0);
  shadows.dispose();
  assert.equal(disposed, 1);
  assert.deepEqual(
    Object.keys(original)
      .filter((name) => name !== '_listeners')
      .sort(),
    own,
  );
});

test("bits go to lights in three.js' order", () => {
  const palette = new Palette();
  const material = palette.materials[palette.acquire(new THREE.MeshLambertMaterial(), false)];
  const shader = { uniforms: {}, vertexShader: '', fragmentShader: '' };
  material.onBeforeCompile(shader, null);
  const { shadowcutBitsPOINT, shadowcutBitsSPOT, shadowcutBitsDIR } = shader.uniforms;
  const make = (Light, change = () => {}) => {
    const light = new Light();
    change(light);
    return light;
  };
  const lights = [
    make(THREE.PointLight), // 0
    make(THREE.SpotLight), // 1
    make(THREE.PointLight, (light) => (light.castShadow = true)), // 2
    make(THREE.AmbientLight), // 3
    make(THREE.SpotLight, (light) => (light.map = new THREE.Texture())), // 4
    // 5
    make(
      THREE.SpotLight,
      (light) => ((light.map = new THREE.Texture()), (light.castShadow = true)),
    ),
    make(THREE.SpotLight, (light) => (light.castShadow = true)), // 6
    make(THREE.DirectionalLight, (light) => light.layers.set(2)), // 7: not seen
    make(THREE.DirectionalLight), // 8
  ];
  palette.arrange(lights, new THREE.Camera(), (light) => lights.indexOf(light));
  assert.deepEqual([...shadowcutBitsPOINT.value.slice(0, 2)], [2, 0]);
  assert.deepEqual([...shadowcutBitsSPOT.value.slice(0, 4)], [5, 6, 4, 1]);
  assert.deepEqual([...shadowcutBitsDIR.value.slice(0, 1)], [8]);
  const more = Array.from({ length: 50 }, () => make(THREE.PointLight));
  palette.arrange(more, new THREE.Camera(), (light) => more.indexOf(light));
  assert.deepEqual([...shadowcutBitsPOINT.value.slice(0, 50)], [...Array(50).keys()]);
});

test('lights that are not to be followed', () => {
  const { scene, lamp } = room();
  const other = new THREE.PointLight();
  other.position.set(2, 3, 0);
  scene.add(other);
  const shadows = follow(scene, { follows: (light) => light === lamp });
  assert.deepEqual(shadows.lights.filter(Boolean), [lamp]);
  shadows.dispose();
  assert.throws(() => new SceneShadows(shadowcut, scene, { kernal: 'fast' }), /kernal/);
});

test('out of memory can be caught, and compact() makes it right', async () => {
  const small = await load({ maximumMemory: 24 * 2 ** 20 });
  const { scene, floor, box, lamp } = room();
  const shadows = new SceneShadows(small, scene);
  shadows.update();
  const balls = [];
  let failed = null;
  for (let i = 0; i < 200 && !failed; ++i) {
    const ball = shown(new THREE.SphereGeometry(0.4, 48, 32), undefined, [
      3 * Math.sin(i),
      1 + (i % 5) / 2,
      3 * Math.cos(i),
    ]);
    balls.push(ball);
    scene.add(ball);
    try {
      shadows.update();
    } catch (error) {
      failed = error;
    }
  }
  assert.equal(failed?.status, 'OUT_OF_MEMORY');
  for (const ball of balls) scene.remove(ball);
  if (shadows.mustCompact) {
    assert.throws(() => shadows.update(), { status: 'MUST_COMPACT' });
    shadows.compact();
  }
  assert.equal(shadows.mustCompact, false);
  shadows.update();
  near(shadows.litArea(), 64 - 1.6 * 1.6 + 1);
  lamp.position.x = 0.5;
  shadows.update();
  checkAll(small, shadows, [floor, box]);
  shadows.dispose();
});
