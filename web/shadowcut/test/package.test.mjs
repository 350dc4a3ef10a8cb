// The package by itself: what it exports, how large it is, buffers that follow random edits,
// errors, and memory that runs out.
import assert from 'node:assert/strict';
import { once } from 'node:events';
import { readFileSync, readdirSync } from 'node:fs';
import test from 'node:test';
import { Worker } from 'node:worker_threads';
import { gzipSync } from 'node:zlib';
import { functions } from '../dist/interface.js';
import { ShadowcutError, load, invalidIndex } from '../src/index.js';

const shadowcut = await load();

const box = ([x, y, z], [w, d, h]) => ({
  positions: [
    x,
    y,
    z,
    x + w,
    y,
    z,
    x + w,
    y + d,
    z,
    x,
    y + d,
    z,
    x,
    y,
    z + h,
    x + w,
    y,
    z + h,
    x + w,
    y + d,
    z + h,
    x,
    y + d,
    z + h,
  ],
  faces: [
    [3, 2, 1, 0],
    [4, 5, 6, 7],
    [0, 1, 5, 4],
    [1, 2, 6, 5],
    [2, 3, 7, 6],
    [3, 0, 4, 7],
  ],
});
const square = (side, z) => ({
  positions: [0, 0, z, side, 0, z, side, side, z, 0, side, z],
  faces: [[0, 1, 2, 3]],
});
const at = (x, y, z) => [1, 0, 0, x, 0, 1, 0, y, 0, 0, 1, z, 0, 0, 0, 1];

// Mulberry32.
function random(seed) {
  return () => {
    seed = (seed + 0x6d2b79f5) | 0;
    let t = Math.imul(seed ^ (seed >>> 15), 1 | seed);
    t = (t + Math.imul(t ^ (t >>> 7), 61 | t)) ^ t;
    return ((t ^ (t >>> 14)) >>> 0) / 2 ** 32;
  };
}

function smallTown(next, houses) {
  const scene = new shadowcut.Scene();
  scene.add(square(20, 0));
  const ids = Array.from({ length: houses }, () =>
    scene.add(box([0, 0, 0], [1 + next(), 1 + next(), 1 + 3 * next()]), {
      pose: at(18 * next(), 18 * next(), 0),
    }),
  );
  scene.addLight({ position: [10, 10, 12] });
  scene.addLight({ kind: 'directional', direction: [0.3, -0.4, -1] });
  return { scene, ids };
}

const fails = (status, body) =>
  assert.throws(
    body,
    (error) =>
      error instanceof ShadowcutError && error.status === status && error.message.length > 0,
  );

test('the module exports the functions of c.h, and JavaScript uses each of them', async () => {
  const module = await WebAssembly.compile(
    readFileSync(new URL('../dist/shadowcut.wasm', import.meta.url)),
  );
  const exported = WebAssembly.Module.exports(module)
    .map(({ name }) => name)
    .filter((name) => name.startsWith('shadowcut_'));
  assert.deepEqual([...exported].sort(), [...functions].sort());
  const source = ['index.js', 'module.js']
    .map((name) => readFileSync(new URL(`../src/${name}`, import.meta.url), 'utf8'))
    .join('');
  // Named otherwise: made of a class' name, of a struct's, or with a suffix.
  const made = /_destroy$|_init$|_float$|^(scene_(remove_object|set_\w+)|mesh_set_vertices)$/;
  // Exceptions carry the name of their status.
  const unused = functions
    .map((name) => name.slice(10))
    .filter((name) => !made.test(name) && !source.includes(name));
  assert.deepEqual(unused, ['status_name']);
});

test('WebAssembly and JavaScript come to less than 400 kB gzipped', () => {
  let size = 0;
  for (const folder of ['../dist/', '../src/']) {
    for (const name of readdirSync(new URL(folder, import.meta.url))) {
      if (!name.endsWith('.ts'))
        size += gzipSync(readFileSync(new URL(folder + name, import.meta.url)), {
          level: 9,
        }).length;
    }
  }
  console.log(`${size} bytes`);
  assert.ok(size < 400e3, `${size} bytes`);
});

test('buffers kept from changed ranges are the whole buffers, through 200 edits', () => {
  const next = random(1);
  const { scene, ids } = smallTown(next, 12);
  const engine = new shadowcut.Engine(scene);
  const follower = (light, layout, ...more) => ({
    buffers: new shadowcut.Buffers(light, layout),
    names: ['positions', 'faces', 'states', ...more],
    mirror: {},
  });
  const followers = [
    follower(0, {}, 'normals'),
    follower(0, { indexed: true, doubles: true, objects: true }, 'normals', 'objects', 'indices'),
    follower(1, { show: 'lit', normals: false }),
    follower('all', { masks: true }, 'normals', 'masks'),
  ];
  for (let edit = 0; edit < 200; ++edit) {
    const id = ids[Math.floor(next() * ids.length)];
    if (next() < 0.1)
      scene.setLight(scene.lightId(0), { position: [20 * next(), 20 * next(), 8 + 4 * next()] });
    else if (next() < 0.2) scene.setCastsShadows(id, next() < 0.5);
    else scene.setPose(id, at(18 * next(), 18 * next(), 2 * next()));
    engine.update();
    for (const { buffers, names, mirror } of followers) {
      buffers.update(engine);
      const { grown, vertexCount, indexCount } = buffers.info;
      for (const name of names) {
        const stream = buffers.stream(name);
        if (grown) mirror[name] = new stream.constructor(stream.length);
        buffers.copyChanged(name, mirror[name]);
        const count = (name === 'indices' ? indexCount : vertexCount) * buffers.itemSize(name);
        assert.deepEqual(
          mirror[name].subarray(0, count),
          buffers.stream(name).slice(0, count),
          `${name} after edit ${edit}, seed 1`,
        );
      }
    }
  }
  // And buffers filled at once hold as many fragments.
  const fresh = new shadowcut.Buffers(0);
  fresh.fill(engine.scene, engine.shadows(0));
  assert.equal(fresh.info.fragmentCount, followers[0].buffers.info.fragmentCount);
  fresh.dispose();
  const partition = engine.overlay();
  assert.equal(partition.fragmentCount, followers[3].buffers.info.fragmentCount);
  assert.equal(partition.masks.length, partition.fragmentCount * partition.maskWords);
  assert.ok(engine.overlay([0]).fragmentCount < partition.fragmentCount);
  engine.validate();
  [partition, engine, scene, ...followers.map(({ buffers }) => buffers)].forEach((each) =>
    each.dispose(),
  );
});

test('versions', () => {
  assert.equal(shadowcut.versionNumbers.join('.'), shadowcut.version);
});

test('a point is lit like its fragment', () => {
  const next = random(5);
  const { scene, ids } = smallTown(next, 10);
  const engine = new shadowcut.Engine(scene);
  for (let edit = 0; edit < 10; ++edit) {
    if (edit > 0) scene.setPose(ids[edit % ids.length], at(18 * next(), 18 * next(), 0));
    engine.update();
    for (const light of [0, 1]) {
      const shadows = engine.shadows(light);
      for (let block = 0; block < shadows.blockCount; ++block) {
        const corners = shadows.corners(block);
        for (const { face, lit, area, firstCorner, cornerCount } of shadows.fragments(block)) {
          if (area < 1e-3) continue;
          const middle = [0, 1, 2].map((k) => {
            let sum = 0;
            for (let i = 0; i < cornerCount; ++i) sum += corners[3 * (firstCorner + i) + k];
            return sum / cornerCount;
          });
          assert.equal(engine.isLit(light, face, middle), lit);
        }
      }
    }
  }
  fails('NOT_FOUND', () => engine.isLit(2, 0, [0, 0, 0]));
  fails('INVALID_ARGUMENT', () => engine.isLit(0, 1e6, [0, 0, 0]));
  fails('INVALID_ARGUMENT', () => engine.isLit(0, 0, [0, 0]));
  fails('REFUSED', () => engine.isLit(0, 0, [0, NaN, 0]));
  engine.dispose();
  scene.dispose();
});

test('it runs in a worker', async () => {
  const code = `
    const { parentPort } = await import('node:worker_threads');
    const { load } = await import(${JSON.stringify(new URL('../src/index.js', import.meta.url))});
    parentPort.postMessage((await load()).version);`;
  const worker = new Worker(new URL(`data:text/javascript,${encodeURIComponent(code)}`));
  const [version] = await once(worker, 'message');
  assert.equal(version, shadowcut.version);
});

test('what changed is what there is', () => {
  const { scene, ids } = smallTown(random(2), 6);
  const engine = new shadowcut.Engine(scene, { kernel: 'exact', constructions: true });
  const known = [new Map(), new Map()];
  const key = ({ cell, piece, place }) => `${cell} ${piece} ${place}`;
  for (let edit = 0; edit < 20; ++edit) {
    if (edit > 0) scene.setPose(ids[edit % ids.length], at(edit, 3, 0.25));
    const changes = engine.update();
    for (const change of changes.lights) {
      if (change.rebuilt) known[change.light].clear();
      for (const id of change.gone) known[change.light].delete(key(id));
      for (const { id } of change.added)
        known[change.light].set(key(id), engine.find(change.light, id));
      for (const { face, area } of change.areas)
        assert.deepEqual(engine.shadows(change.light).areas(face, 1)[0], area);
    }
    for (const light of [0, 1]) {
      const shadows = engine.shadows(light);
      const all = Array.from({ length: shadows.blockCount }, (_, block) =>
        shadows.fragments(block),
      ).flat();
      assert.equal(known[light].size, all.length);
      for (const fragment of all)
        assert.equal(known[light].get(key(fragment.id)).area, fragment.area);
      assert.equal(shadows.constructions(0).length, shadows.corners(0).length / 3);
    }
  }
  scene.setPose(ids[0], at(9, 9, 1));
  const [last] = engine.update().lights;
  assert.equal(last.gone.length, last.goneCount);
  engine.update();
  fails('NOT_FOUND', () => last.gone);
  engine.dispose();
  scene.dispose();
});

test('a scene gives back the source of an object', () => {
  const scene = new shadowcut.Scene();
  const positions = Float64Array.of(
    0,
    0,
    0,
    4,
    0,
    0,
    4,
    4,
    0,
    0,
    4,
    0,
    1,
    1,
    0,
    2,
    1,
    0,
    2,
    2,
    0,
    1,
    2,
    0,
  );
  const mesh = {
    positions,
    faces: [
      [
        [0, 1, 2, 3],
        [4, 5, 6, 7],
      ],
    ],
  };
  const id = scene.add(mesh, { name: 'Tür', sides: 'open', dynamic: true, pose: at(1, 2, 3) });
  const source = scene.source(id);
  assert.deepEqual(source.mesh, mesh);
  assert.deepEqual(source.settings, {
    sides: 'open',
    castsShadows: true,
    receivesShadows: true,
    dynamic: true,
    pose: at(1, 2, 3),
    name: 'Tür',
  });
  assert.equal(scene.object(id).name, 'Tür');
  assert.equal(scene.faces()[0].area, 15);
  scene.setVertices(id, new Float32Array(mesh.positions.map((x) => 2 * x)));
  assert.equal(scene.faces()[0].area, 60);
  const light = scene.addLight({
    position: [0, 0, 9],
    range: 20,
    spot: { axis: [0, 0, -1], halfAngle: 1 },
  });
  assert.deepEqual(scene.light(light), {
    kind: 'point',
    position: [0, 0, 9],
    range: 20,
    spot: { axis: [0, 0, -1], halfAngle: 1 },
    name: '',
  });
  scene.replaceLights([{ position: [1, 1, 9] }, { kind: 'directional', direction: [0, 0, -1] }]);
  assert.equal(scene.light(scene.lightId(1)).kind, 'directional');
  const copy = scene.copy();
  scene.remove(id);
  assert.equal(copy.object(id).faceCount, 1);
  assert.deepEqual(copy.tolerances, { flatness: 1e-6, coplanarity: 1e-12 });
  const indexed = copy.add({
    positions: new Float32Array([0, 0, 0, 1, 0, 0, 0, 1, 0]),
    indices: new Uint16Array([0, 1, 2]),
  });
  assert.equal(copy.object(indexed).faceCount, 1);
  assert.equal(copy.firstFace(indexed), copy.object(indexed).firstFace);
  assert.ok(copy.changedSince(0).includes(indexed.index));
  const shadows = shadowcut.castShadows(
    copy,
    { position: [0.5, 0.5, 5] },
    { kernel: 'exact', form: 'conforming' },
  );
  assert.ok(shadows.stats.litArea > 0);
  [copy, scene, shadows].forEach((each) => each.dispose());
});

test('errors', async () => {
  const scene = new shadowcut.Scene();
  const id = scene.add(square(1, 0));
  const other = new shadowcut.Scene();
  fails('FOREIGN', () => other.remove(id));
  scene.remove(id);
  fails('STALE', () => scene.remove(id));
  fails('STALE', () => scene.setPose(id, at(0, 0, 0)));
  fails('NOT_FOUND', () => scene.objectId(id.index));
  const nan = scene.add({ positions: [0, 0, 0, 1, 0, 0, NaN, 1, 0], indices: [0, 1, 2] });
  assert.equal(scene.object(nan).facetCount, 0);
  const [issue] = scene.issues();
  assert.equal(issue.reason, 'nonFinite');
  assert.ok(
    shadowcut.isRefusal('nonFinite') &&
      !shadowcut.isRefusal('notFlat') &&
      shadowcut.reasonText('nonFinite').length > 0,
  );
  fails('REFUSED', () => scene.setPose(nan, Array(16).fill(NaN)));
  fails('REFUSED', () => scene.addLight({ position: [NaN, 0, 0] }));
  fails('REFUSED', () => scene.addLight({ kind: 'directional', direction: [0, 0, 0] }));
  fails('REFUSED', () => scene.addLight({ kind: 'directional', direction: [0, 0, -1], range: 5 }));
  fails('INVALID_ARGUMENT', () => scene.addLight({ kind: 'area' }));
  fails('INVALID_ARGUMENT', () => new shadowcut.Engine(scene, { tuning: { facetsPerRoom: 1 } }));
  fails('REFUSED', () => new shadowcut.Engine(scene, { constructions: true }));
  const tuning = { order: 'random', seed: 3, incremental: false };
  new shadowcut.Engine(scene, { tuning }).dispose();
  fails('INVALID_ARGUMENT', () => scene.setPose(nan, [1, 2, 3]));
  fails('INVALID_ARGUMENT', () => scene.add({ positions: [1, 2], faces: [] }));
  fails('INVALID_ARGUMENT', () => scene.add({ positions: [0, 0, 0], indices: [0, 0] }));
  fails('INVALID_ARGUMENT', () => scene.add(square(1, 0), { colour: 'red' }));
  fails('INVALID_ARGUMENT', () => new shadowcut.Engine({}));
  fails('INVALID_ARGUMENT', () => new shadowcut.Engine(scene, { kernel: 'exactly' }));
  fails('REFUSED', () => shadowcut.castShadows(scene, { position: [0, 0, 1] }, { minArea: -1 }));
  fails('INVALID_ARGUMENT', () => scene.faces(0, 1000));
  scene.addLight({ position: [0, 0, 1] });
  const engine = new shadowcut.Engine(scene);
  const buffers = new shadowcut.Buffers(0);
  fails('NOT_FOUND', () => buffers.update(engine));
  engine.update();
  fails('NOT_FOUND', () => engine.shadows(1));
  fails('INVALID_ARGUMENT', () => engine.scene.add(square(1, 1)));
  buffers.update(engine);
  fails('NOT_FOUND', () => buffers.stream('masks'));
  assert.equal(engine.find(0, { cell: invalidIndex, piece: 0, place: 0 }), undefined);
  const shadows = engine.shadows(0);
  const elsewhere = await load();
  fails('INVALID_ARGUMENT', () => new elsewhere.Engine(scene));
  scene.dispose();
  scene.dispose();
  fails('INVALID_ARGUMENT', () => scene.counts);
  assert.ok(scene.disposed);
  engine.update(); // an engine keeps its scene alive
  engine.dispose();
  engine.dispose();
  fails('INVALID_ARGUMENT', () => engine.update());
  fails('INVALID_ARGUMENT', () => shadows.areas());
  buffers.dispose();
  fails('INVALID_ARGUMENT', () => buffers.info);
  other.dispose();
  await assert.rejects(load({ maximumMemory: 1 }), ShadowcutError);
});

test('memory that runs out is an exception; the engine must be compacted', async () => {
  const small = await load({ maximumMemory: 32 << 20 });
  const bystanding = new small.Scene();
  bystanding.add(square(4, 0));
  bystanding.add(square(1, 1));
  bystanding.addLight({ position: [1, 1, 4] });
  const bystander = new small.Engine(bystanding);
  const [ground] = (bystander.update(), bystander.shadows(0).areas());

  const next = random(3);
  const scene = new small.Scene();
  scene.add(square(200, 0));
  scene.addLight({ position: [100, 100, 50] });
  const engine = new small.Engine(scene);
  engine.update();
  const ids = [];
  const runsOut = (body) => {
    try {
      body();
      return false;
    } catch (error) {
      assert.ok(error instanceof ShadowcutError && error.status === 'OUT_OF_MEMORY', error.stack);
      return true;
    }
  };
  const addSome = () => {
    for (let k = 0; k < 10; ++k)
      ids.push(scene.add(box([200 * next(), 200 * next(), 0], [1, 1, 10 * next()])));
  };
  while (!engine.mustCompact) {
    assert.ok(ids.length < 1e5, 'memory does not run out');
    // Where an addition fails there may still be room for an update; for a tree beside the old one
    // there is invalidIndex.
    if (runsOut(addSome)) scene.setLight(scene.lightId(0), { position: [100 + next(), 100, 50] });
    assert.equal(
      runsOut(() => engine.update()),
      engine.mustCompact,
    );
  }
  console.log(`out of memory at ${ids.length} boxes, ${small.memoryBytes} bytes`);
  assert.ok(small.memoryBytes <= 32 << 20);
  fails('MUST_COMPACT', () => engine.update());
  fails('MUST_COMPACT', () => engine.shadows(0));

  // Others are as they were, and go on once there is room.
  assert.deepEqual(bystander.shadows(0).areas()[0], ground);
  for (const id of ids.splice(10)) scene.remove(id);
  engine.compact();
  assert.ok(!engine.mustCompact);
  engine.update();
  engine.validate();
  bystanding.setPose(bystanding.objectId(1), at(0.5, 0, 0));
  bystander.update();
  bystander.validate();
  engine.dispose();
  scene.dispose();
  const again = new small.Engine(bystanding, { kernel: 'exact' });
  again.update();
  assert.ok(
    Math.abs(again.shadows(0).areas()[0].lit - bystander.shadows(0).areas()[0].lit) < 1e-12,
  );
});
