// Hashes of all that the WebAssembly package hands out; output_hashes.py calls it.
//
//   node scripts/output_hashes.mjs WEB_DIR JOBS.json      WEB_DIR: web/shadowcut, built
//
// Does the same things as output_hashes_c.py and hashes the same bytes: both must stay in step.
import { createHash } from 'node:crypto';
import { readFileSync } from 'node:fs';
import { join } from 'node:path';
import { pathToFileURL } from 'node:url';

const [webDir, jobsFile] = process.argv.slice(2);
const importFrom = (path) => import(pathToFileURL(join(webDir, path)).href);
const shadowcut = await (await importFrom('src/index.js')).load();
const { enums } = await importFrom('dist/interface.js');

// Members that are not hashed: they depend on the machine.
const skipped = new Set(['bytes', 'buildMs', 'emitMs', 'ms']);
const forms = ['pieces', 'merged', 'conforming'];
// Of one light, and of the partition by all lights.
const layouts = [
  [0, { objects: true }, ['positions', 'normals', 'faces', 'objects', 'states']],
  ['all', { doubles: true, indexed: true, masks: true },
    ['positions', 'normals', 'faces', 'states', 'masks', 'indices']],
];

// SHA-256 of numbers, each as a double, and of bytes.
class Digest {
  #hash = createHash('sha256');
  add(...values) {
    const flat = [];
    flatten(values, flat);
    this.#hash.update(new Uint8Array(new Float64Array(flat).buffer));
  }
  addBytes(array) {
    this.#hash.update(new Uint8Array(array.buffer, array.byteOffset, array.byteLength));
  }
  get hex() {
    return this.#hash.digest('hex');
  }
}

// A word of an enum is its number, another text its length and its bytes; of an object all members
// but those skipped.
function flatten(value, out, key) {
  if (typeof value === 'number' || typeof value === 'boolean') out.push(Number(value));
  else if (typeof value === 'string' && key in enums) out.push(enums[key].indexOf(value));
  else if (typeof value === 'string') {
    const bytes = new TextEncoder().encode(value);
    out.push(bytes.length, ...bytes);
  } else if (Array.isArray(value) || ArrayBuffer.isView(value)) {
    for (const element of value) flatten(element, out);
  } else {
    for (const [name, member] of Object.entries(value)) {
      if (!skipped.has(name)) flatten(member, out, name);
    }
  }
}

// ---- What is hashed --------------------------------------------------------------------------

function addScene(digest, scene) {
  const { counts } = scene;
  digest.add(counts);
  for (let index = 0; index < counts.objects; ++index) {
    const object = objectAt(scene, index);
    if (object) digest.add(index, object);
  }
  digest.add(scene.faces(), scene.facets(), scene.corners(), scene.vertices(), scene.edges(),
    scene.planes());
}

function objectAt(scene, index) {
  try {
    return scene.object(scene.objectId(index));
  } catch {
    return null; // the place of one that was removed
  }
}

function addShadows(digest, shadows) {
  for (let block = 0; block < shadows.blockCount; ++block) {
    digest.add(shadows.fragments(block));
    digest.addBytes(shadows.corners(block));
    digest.add(shadows.constructions(block));
  }
  digest.add(shadows.areas(), shadows.stats);
}

function addChanges(digest, { update, applied, complete, lights }) {
  digest.add(update, applied, complete);
  for (const light of lights) {
    const { rebuilt, removed, goneCount, addedCount, areaCount } = light;
    digest.add(light.light, rebuilt, removed, goneCount, addedCount, areaCount);
    digest.add(light.gone, light.added, light.areas);
  }
}

function addCombined(digest, engine) {
  const sets = engine.overlay();
  digest.add(sets.fragmentCount, sets.maskWords, sets.fragments());
  digest.addBytes(sets.masks);
  digest.addBytes(sets.corners);
  sets.dispose();
}

function addBuffers(digest, buffers, streams) {
  const { info } = buffers;
  digest.add(info, buffers.changedVertices, buffers.changedIndices);
  for (const name of streams) {
    const count = name === 'indices' ? info.indexCount : info.vertexCount;
    digest.addBytes(buffers.stream(name).subarray(0, count * buffers.itemSize(name)));
  }
}

// ---- Scenes and edits ------------------------------------------------------------------------

const lightOf = ({ kind, at }) =>
  kind === 'point' ? { kind, position: at } : { kind, direction: at };

// A scene that edits are applied to, as `shadowcut replay` does.
class Player {
  constructor(job) {
    this.scene = new shadowcut.Scene();
    this.ids = new Map();
    this.removed = new Map();
    for (const { name, positions, faces } of job.objects) {
      this.ids.set(name, this.scene.add({ positions, faces }, { name }));
    }
    this.lights = job.lights.map(lightOf);
    for (const light of this.lights) this.scene.addLight(light);
  }

  apply({ op, object, light, at, matrix, translate }) {
    const { scene, ids } = this;
    const id = ids.get(object);
    if (op === 'light') {
      const { kind } = this.lights[light];
      this.lights[light] = lightOf({ kind, at });
      scene.setLight(scene.lightId(light), this.lights[light]);
    } else if (op === 'remove') {
      this.removed.set(object, scene.source(id));
      scene.remove(id);
    } else if (op === 'add') {
      const { mesh, settings } = this.removed.get(object);
      ids.set(object, scene.add(mesh, settings));
    } else if (op === 'pose') {
      scene.setPose(id, matrix);
    } else if (op === 'move') {
      const { pose } = scene.object(id);
      translate.forEach((by, k) => (pose[4 * k + 3] += by));
      scene.setPose(id, pose);
    }
  }
}

// Name of a part -> hash.
function run(job) {
  const digests = new Map();
  const digest = (name) => {
    if (!digests.has(name)) digests.set(name, new Digest());
    return digests.get(name);
  };

  const player = new Player(job);
  const { kernel } = job;
  for (const form of forms) {
    player.lights.forEach((light, k) => {
      const shadows = shadowcut.castShadows(player.scene, light, { kernel, form, threads: 1 });
      addShadows(digest(`cast_${form}_${k}`), shadows);
      shadows.dispose();
    });
  }

  const options = { kernel, threads: 1, constructions: kernel === 'exact' };
  const engine = new shadowcut.Engine(player.scene, options);
  const buffers = layouts.map(([light, layout]) => new shadowcut.Buffers(light, layout));

  const seeChanges = (changes) => {
    addChanges(digest('changes'), changes);
    layouts.forEach(([, , streams], k) => {
      buffers[k].update(engine);
      addBuffers(digest(`buffers_${k}`), buffers[k], streams);
    });
  };
  const seeAll = (when) => {
    addScene(digest(`scene_${when}`), engine.scene);
    player.lights.forEach((_, k) => {
      addShadows(digest(`shadows_${when}`), engine.shadows(k));
      digest(`undecided_${when}`).add(engine.uncertainArea(k));
    });
    addCombined(digest(`combined_${when}`), engine);
  };

  seeChanges(engine.update());
  seeAll('built');
  for (const edit of job.edits) {
    if (edit.op === 'update') seeChanges(engine.update());
    else player.apply(edit);
  }
  seeAll('edited');
  engine.validate();
  seeChanges(engine.compact());
  seeAll('compacted');

  for (const handle of [...buffers, engine, player.scene]) handle.dispose();
  return [...digests].map(([name, { hex }]) => [`${job.name}/${name}`, hex]);
}

const jobs = JSON.parse(readFileSync(jobsFile, 'utf8'));
console.log(JSON.stringify(Object.fromEntries(jobs.flatMap(run))));
