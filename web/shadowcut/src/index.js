// The engine in JavaScript: scenes, engines that follow them, their shadows, and vertex buffers
// that follow engines. A thin layer over c.h, which documents every function; index.d.ts documents
// the members.
//
// JavaScript does not collect the module's memory: objects made by `new`, copy(), castShadows() or
// overlay() must be freed by dispose().
import { Module, ShadowcutError, numberOf } from './module.js';

export { ShadowcutError };
export const invalidIndex = 0xffffffff; // stands for "no index"

// Resolves to the engine in a module of its own: what is made in one cannot be used in another.
export async function load(options) {
  const module = await Module.load(options);
  return Object.freeze({
    version: module.text(module.c.shadowcut_version()),
    versionNumbers: versionNumbers(module),
    Scene: class extends Scene {
      constructor() {
        super(module, module.value('scene_create'));
      }
    },
    Engine: class extends Engine {
      constructor(scene, options) {
        super(module, scene, options);
      }
    },
    Buffers: class extends Buffers {
      constructor(light, layout) {
        super(module, light, layout);
      }
    },
    castShadows: (scene, light, options) => castShadows(module, scene, light, options),
    reasonText: (reason) => module.text(module.c.shadowcut_reason_text(numberOf('reason', reason))),
    isRefusal: (reason) => module.c.shadowcut_is_refusal(numberOf('reason', reason)) === 1,
    get memoryBytes() {
      return module.buffer.byteLength;
    },
  });
}

// [major, minor, patch] of the module.
function versionNumbers(module) {
  return module.within(() => {
    const at = module.take(12);
    module.c.shadowcut_version_numbers(at, at + 4, at + 8);
    return Array.from(module.array(Uint32Array, at, 3));
  });
}

// What the classes below have in common: an address in the module. One's own until it is disposed
// of; or lent, and then asked for at every use, so that who lends it can refuse.
class Handle {
  #at;
  #kind;
  constructor(module, at, kind) {
    Object.defineProperty(this, 'module', { value: module });
    this.#at = at;
    this.#kind = kind;
  }
  get disposed() {
    return this.#at === 0;
  }
  get at() {
    if (this.#at === 0)
      throw new ShadowcutError('INVALID_ARGUMENT', `the ${this.#kind} has been disposed of`);
    return typeof this.#at === 'function' ? this.#at() : this.#at;
  }
  // Twice does no harm; of what is lent it does nothing.
  dispose() {
    if (this.#at === 0 || typeof this.#at === 'function') return;
    this.module.c[`shadowcut_${this.#kind}_destroy`](this.#at);
    this.#at = 0;
  }
}

// An argument that must be of a class, and of the same module.
function addressOf(module, value, Class) {
  if (!(value instanceof Class))
    throw new ShadowcutError('INVALID_ARGUMENT', `an argument is not of class ${Class.name}`);
  if (value.module !== module)
    throw new ShadowcutError('INVALID_ARGUMENT', `an argument is another module's ${Class.name}`);
  return value.at;
}

// ---- Meshes, settings, lights: plain objects here
// ------------------------------------------------------------------------------------

function putPositions(module, positions) {
  if (!(positions?.length % 3 === 0))
    throw new ShadowcutError(
      'INVALID_ARGUMENT',
      'positions must be numbers, three for each vertex',
    );
  const single = positions instanceof Float32Array;
  const at = module.putArray(positions, single ? Float32Array : Float64Array);
  return { at, count: positions.length / 3, suffix: single ? '_float' : '' };
}

// Calls body with a mesh in the module.
function withMesh(module, { positions, indices, cornerCounts, faces }, body) {
  return module.within(() => {
    const mesh = module.value('mesh_create');
    try {
      const vertices = putPositions(module, positions);
      module.call(`mesh_set_vertices${vertices.suffix}`, mesh, vertices.at, vertices.count);
      if (indices) addFaces(module, mesh, indices, cornerCounts);
      for (const face of faces ?? []) addFace(module, mesh, face);
      return body(mesh);
    } finally {
      module.c.shadowcut_mesh_destroy(mesh);
    }
  });
}
function addFaces(module, mesh, indices, cornerCounts) {
  const total = cornerCounts
    ? cornerCounts.reduce((a, b) => a + b, 0)
    : 3 * Math.floor(indices.length / 3);
  if (total !== indices.length)
    throw new ShadowcutError(
      'INVALID_ARGUMENT',
      'there must be as many indices as the faces have corners',
    );
  const at = module.putArray(indices, Uint32Array);
  const counts = cornerCounts ? module.putArray(cornerCounts, Int32Array) : 0;
  module.call('mesh_add_faces', mesh, at, counts, cornerCounts ? cornerCounts.length : total / 3);
}
// [0, 1, 2, 3], or [[0, 1, 2, 3], hole, ...].
function addFace(module, mesh, face) {
  const loops = typeof face[0] === 'number' ? [face] : face;
  loops.forEach((loop, k) => {
    module.within(() =>
      module.call(
        k === 0 ? 'mesh_add_face' : 'mesh_add_hole',
        mesh,
        module.putArray(loop, Uint32Array),
        loop.length,
      ),
    );
  });
}
function readMesh(module, mesh) {
  const [xyz, count] = module.values(2, 'mesh_vertices', mesh);
  const positions = module.array(Float64Array, xyz, 3 * count).slice();
  const faces = Array.from({ length: module.value('mesh_face_count', mesh) }, (_, face) =>
    Array.from({ length: module.value('mesh_loop_count', mesh, face) }, (_, loop) => {
      const [corners, length] = module.values(2, 'mesh_loop', mesh, face, loop);
      return Array.from(module.array(Uint32Array, corners, length));
    }),
  );
  return { positions, faces };
}

// {kind, position or direction, range, spot: {axis, halfAngle}, name}, and c.h's struct.
function putLight(module, { spot, ...light }) {
  return module.put(
    'light',
    spot ? { ...light, hasSpot: true, spotAxis: spot.axis, spotHalfAngle: spot.halfAngle } : light,
  );
}
function lightOf({ hasSpot, spotAxis, spotHalfAngle, position, direction, ...light }) {
  if (light.kind === 'directional') return { ...light, direction, spot: undefined };
  const spot = hasSpot ? { axis: spotAxis, halfAngle: spotHalfAngle } : undefined;
  return { ...light, position, spot };
}

const putPose = (module, pose) => {
  if (pose?.length !== 16)
    throw new ShadowcutError('INVALID_ARGUMENT', 'a pose must have sixteen numbers, row by row');
  return module.putArray(pose, Float64Array);
};

// ---- Scenes
// ------------------------------------------------------------------------------------------

class Scene extends Handle {
  constructor(module, at) {
    super(module, at, 'scene');
  }
  copy() {
    return new Scene(this.module, this.module.value('scene_copy', this.at));
  }
  setTolerances({ flatness, coplanarity }) {
    this.module.call('scene_set_tolerances', this.at, flatness, coplanarity);
  }

  add(mesh, settings) {
    const { module } = this;
    return withMesh(module, mesh, (at) =>
      module.struct(
        'objectId',
        'scene_add_object',
        this.at,
        at,
        module.put('objectSettings', settings),
      ),
    );
  }
  remove(id) {
    this.#edit('remove_object', id);
  }
  setPose(id, pose) {
    this.module.within(() => this.#edit('set_pose', id, putPose(this.module, pose)));
  }
  setVertices(id, positions) {
    this.module.within(() => {
      const { at, count, suffix } = putPositions(this.module, positions);
      this.#edit(`set_vertices${suffix}`, id, at, count);
    });
  }
  setCastsShadows(id, castsShadows) {
    this.#edit('set_casts_shadows', id, castsShadows ? 1 : 0);
  }
  setReceivesShadows(id, receivesShadows) {
    this.#edit('set_receives_shadows', id, receivesShadows ? 1 : 0);
  }
  #edit(name, id, ...args) {
    const { module } = this;
    module.within(() => module.call(`scene_${name}`, this.at, module.putId(id), ...args));
  }

  addLight(light) {
    const { module } = this;
    return module.within(() =>
      module.struct('lightId', 'scene_add_light', this.at, putLight(module, light)),
    );
  }
  removeLight(id) {
    const { module } = this;
    module.within(() => module.call('scene_remove_light', this.at, module.putId(id)));
  }
  setLight(id, light) {
    const { module } = this;
    module.within(() =>
      module.call('scene_set_light', this.at, module.putId(id), putLight(module, light)),
    );
  }
  replaceLights(lights) {
    const { module } = this;
    module.within(() => {
      const places = lights.map((light) => putLight(module, light));
      module.call(
        'scene_replace_lights',
        this.at,
        module.putArray(places, Uint32Array),
        places.length,
      );
    });
  }

  get tolerances() {
    const [flatness, coplanarity] = this.module.within(() => {
      const at = this.module.take(16);
      this.module.call('scene_tolerances', this.at, at, at + 8);
      return this.module.array(Float64Array, at, 2).slice();
    });
    return { flatness, coplanarity };
  }
  get counts() {
    return this.module.struct('sceneCounts', 'scene_count', this.at);
  }
  objectId(index) {
    return this.module.struct('objectId', 'scene_object_id', this.at, index);
  }
  lightId(index) {
    return this.module.struct('lightId', 'scene_light_id', this.at, index);
  }
  object(id) {
    const { module } = this;
    return module.within(() => module.struct('object', 'scene_object', this.at, module.putId(id)));
  }
  firstFace(id) {
    const { module } = this;
    return module.within(() =>
      module.member('object', 'firstFace', 'scene_object', this.at, module.putId(id)),
    );
  }
  light(id) {
    const { module } = this;
    return lightOf(
      module.within(() => module.struct('light', 'scene_light', this.at, module.putId(id))),
    );
  }
  source(id) {
    const { module } = this;
    return module.within(() => {
      const mesh = module.take(4),
        settings = module.begin('objectSettings');
      module.call('scene_source', this.at, module.putId(id), mesh, settings);
      const at = module.data.getUint32(mesh, true);
      try {
        return { mesh: readMesh(module, at), settings: module.read('objectSettings', settings) };
      } finally {
        module.c.shadowcut_mesh_destroy(at);
      }
    });
  }
  changedSince(revision) {
    const { module } = this;
    return module.within(() => {
      const at = module.take(8);
      module.data.setBigUint64(at, BigInt(revision), true);
      const count = module.value('scene_changed_since', this.at, at, 0, 0);
      const indices = module.take(4 * count);
      module.value('scene_changed_since', this.at, at, count, indices);
      return module.array(Uint32Array, indices, count).slice();
    });
  }

  faces(first = 0, count = this.counts.faces - first) {
    return this.module.list('face', first, count, 'scene_faces', this.at);
  }
  facets(first = 0, count = this.counts.facets - first) {
    return this.module.list('facet', first, count, 'scene_facets', this.at);
  }
  corners(first = 0, count = this.counts.corners - first) {
    return this.module.list('corner', first, count, 'scene_corners', this.at);
  }
  vertices(first = 0, count = this.counts.vertices - first) {
    return this.module.numbers(Float64Array, 3 * count, 'scene_vertices', this.at, first, count);
  }
  edges(first = 0, count = this.counts.edges - first) {
    return this.module.list('edge', first, count, 'scene_edges', this.at);
  }
  planes(first = 0, count = this.counts.planes - first) {
    return this.module.list('plane', first, count, 'scene_planes', this.at);
  }
  issues(first = 0, count = this.counts.issues - first) {
    return this.module.list('issue', first, count, 'scene_issues', this.at);
  }
}

// ---- Shadows of one light
// ------------------------------------------------------------------------------------------

function castShadows(module, scene, light, options) {
  return module.within(() => {
    const at = addressOf(module, scene, Scene);
    return new Shadows(
      module,
      module.value('cast_shadows', at, putLight(module, light), module.put('options', options)),
    );
  });
}

class Shadows extends Handle {
  constructor(module, at) {
    super(module, at, 'shadows');
  }
  get blockCount() {
    return this.module.value('shadows_block_count', this.at);
  }
  fragmentCount(block) {
    return this.module.value('shadows_fragment_count', this.at, block);
  }
  fragments(block, first = 0, count = this.fragmentCount(block) - first) {
    return this.module.list('fragment', first, count, 'shadows_fragments', this.at, block);
  }
  corners(block) {
    const [xyz, count] = this.module.values(2, 'shadows_corners', this.at, block);
    return this.module.array(Float64Array, xyz, 3 * count).slice();
  }
  constructions(
    block,
    first = 0,
    count = this.module.value('shadows_construction_count', this.at, block) - first,
  ) {
    return this.module.list('construction', first, count, 'shadows_constructions', this.at, block);
  }
  areas(first = 0, count = this.module.value('shadows_area_count', this.at) - first) {
    return this.module.list('faceArea', first, count, 'shadows_areas', this.at);
  }
  get stats() {
    return this.module.struct('stats', 'shadows_stats', this.at);
  }
}

// ---- Engines
// ------------------------------------------------------------------------------------------

class Engine extends Handle {
  constructor(module, scene, options) {
    const followed = addressOf(module, scene, Scene);
    super(
      module,
      module.within(() => module.value('engine_create', followed, module.put('options', options))),
      'engine',
    );
  }
  update() {
    this.module.call('engine_update', this.at);
    return this.changes;
  }
  updateWithin(ms) {
    this.module.call('engine_update_within', this.at, ms);
    return this.changes;
  }
  compact() {
    this.module.call('engine_compact', this.at);
    return this.changes;
  }
  get changes() {
    const changes = this.module.struct('changes', 'engine_changes', this.at);
    const { lightCount, ...rest } = changes;
    return {
      ...rest,
      lights: Array.from(
        { length: lightCount },
        (_, i) => new LightChanges(this, changes.update, i),
      ),
    };
  }
  get mustCompact() {
    try {
      this.module.value('engine_light_count', this.at);
      return false;
    } catch (error) {
      if (error.status === 'MUST_COMPACT') return true;
      throw error;
    }
  }
  get progress() {
    return this.module.numbers(Float64Array, 1, 'engine_progress', this.at)[0];
  }
  get scene() {
    return new Scene(this.module, () => this.module.value('engine_scene', this.at));
  }
  get lightCount() {
    return this.module.value('engine_light_count', this.at);
  }
  shadows(light) {
    const find = () => this.module.value('engine_shadows', this.at, light);
    find();
    return new Shadows(this.module, find);
  }
  find(light, id) {
    const { module } = this;
    try {
      return module.within(() =>
        module.struct('fragment', 'engine_find', this.at, light, module.put('fragmentId', id)),
      );
    } catch (error) {
      if (error.status === 'NOT_FOUND') return undefined;
      throw error;
    }
  }
  uncertainArea(light) {
    const { faces } = this.scene.counts;
    return this.module.within(() => {
      const at = this.module.take(8 * faces);
      this.module.call('engine_uncertain_area', this.at, light, faces, at);
      return this.module.array(Float64Array, at, faces).slice();
    });
  }
  isLit(light, face, point) {
    const { module } = this;
    if (point?.length !== 3)
      throw new ShadowcutError('INVALID_ARGUMENT', 'a point must have three numbers');
    return module.within(
      () =>
        module.value(
          'engine_is_lit',
          this.at,
          light,
          face,
          module.putArray(point, Float64Array),
        ) === 1,
    );
  }
  overlay(faces) {
    const { module } = this;
    if (!faces) return new LightPartition(module, module.value('engine_overlay', this.at));
    return module.within(
      () =>
        new LightPartition(
          module,
          module.value(
            'engine_overlay_faces',
            this.at,
            module.putArray(faces, Uint32Array),
            faces.length,
          ),
        ),
    );
  }
  validate() {
    this.module.call('engine_validate', this.at);
  }
}

// What an update did to one light's shadows. The lists are the engine's, and copied when they are
// asked for: before its next update.
class LightChanges {
  #engine;
  #update;
  #i;
  #counts;
  constructor(engine, update, i) {
    const { goneCount, addedCount, areaCount, ...rest } = engine.module.struct(
      'lightChanges',
      'engine_light_changes',
      engine.at,
      i,
    );
    this.#engine = engine;
    this.#update = update;
    this.#i = i;
    this.#counts = { gone: goneCount, added: addedCount, areas: areaCount };
    Object.assign(this, rest, { goneCount, addedCount, areaCount });
  }
  get gone() {
    return this.#list('fragmentId', this.#counts.gone, 'engine_gone');
  }
  get added() {
    return this.#list('added', this.#counts.added, 'engine_added');
  }
  get areas() {
    return this.#list('changedArea', this.#counts.areas, 'engine_changed_areas');
  }
  #list(kind, count, name) {
    const { module, at } = this.#engine;
    if (module.struct('changes', 'engine_changes', at).update !== this.#update) {
      throw new ShadowcutError(
        'NOT_FOUND',
        'the engine has been updated since: it no longer knows these changes',
      );
    }
    return module.list(kind, 0, count, name, at, this.#i);
  }
}

// ---- Several lights
// ------------------------------------------------------------------------------------------

class LightPartition extends Handle {
  constructor(module, at) {
    super(module, at, 'light_partition');
  }
  get fragmentCount() {
    return this.module.values(2, 'light_partition_count', this.at)[0];
  }
  get maskWords() {
    return this.module.values(2, 'light_partition_count', this.at)[1];
  }
  fragments(first = 0, count = this.fragmentCount - first) {
    return this.module.list(
      'partitionFragment',
      first,
      count,
      'light_partition_fragments',
      this.at,
    );
  }
  get masks() {
    const [count, words] = this.module.values(2, 'light_partition_count', this.at);
    return this.module
      .array(BigUint64Array, this.module.value('light_partition_masks', this.at), count * words)
      .slice();
  }
  get corners() {
    const [xyz, count] = this.module.values(2, 'light_partition_corners', this.at);
    return this.module.array(Float64Array, xyz, 3 * count).slice();
  }
}

// ---- Vertex buffers that follow an engine
// --------------------------------------------------------------------------------------------

const elements = {
  positions: Float32Array,
  normals: Float32Array,
  faces: Uint32Array,
  objects: Uint32Array,
  states: Uint8Array,
  masks: Uint32Array,
  indices: Uint32Array,
};

class Buffers extends Handle {
  #doubles;
  #info = null; // until the next change
  constructor(module, light, layout) {
    const index = light === 'all' ? invalidIndex : light;
    super(
      module,
      module.within(() =>
        module.value('buffers_create', index, module.put('bufferLayout', layout)),
      ),
      'buffers',
    );
    this.#doubles = layout?.doubles === true;
  }
  update(engine) {
    this.#info = null;
    this.module.call('buffers_update', this.at, addressOf(this.module, engine, Engine));
  }
  fill(scene, shadows) {
    const { module } = this;
    this.#info = null;
    const from = addressOf(module, scene, Scene);
    if (shadows instanceof LightPartition)
      module.call(
        'buffers_fill_partition',
        this.at,
        from,
        addressOf(module, shadows, LightPartition),
      );
    else module.call('buffers_fill', this.at, from, addressOf(module, shadows, Shadows));
  }
  setOrigin(origin) {
    const { module } = this;
    if (origin?.length !== 3)
      throw new ShadowcutError('INVALID_ARGUMENT', 'an origin must have three numbers');
    this.#info = null;
    module.within(() =>
      module.call('buffers_set_origin', this.at, module.putArray(origin, Float64Array)),
    );
  }
  get info() {
    const { at } = this; // throws where there is nothing any more
    return (this.#info ??= Object.freeze(
      this.module.struct('buffersInfo', 'buffers_get_info', at),
    ));
  }

  // The stream where it is in the module's memory. A view dies with the buffers' next change, and
  // with the memory's growth.
  stream(name) {
    const Kind = name === 'positions' && this.#doubles ? Float64Array : elements[name];
    const { vertexCapacity, indexCapacity } = this.info;
    const [at, bytes] = this.module.values(2, 'buffers_stream', this.at, numberOf('stream', name));
    return this.module.array(
      Kind,
      at,
      ((name === 'indices' ? indexCapacity : vertexCapacity) * bytes) / Kind.BYTES_PER_ELEMENT,
    );
  }
  // Elements for each vertex, or index.
  itemSize(name) {
    const Kind = name === 'positions' && this.#doubles ? Float64Array : elements[name];
    return (
      this.module.values(2, 'buffers_stream', this.at, numberOf('stream', name))[1] /
      Kind.BYTES_PER_ELEMENT
    );
  }
  get changedVertices() {
    return this.module.list(
      'range',
      0,
      this.info.changedVertexRanges,
      'buffers_changed_vertices',
      this.at,
    );
  }
  get changedIndices() {
    return this.module.list(
      'range',
      0,
      this.info.changedIndexRanges,
      'buffers_changed_indices',
      this.at,
    );
  }
  // The same as numbers, first and count of each: an array and no more, however many there are.
  get changedVertexNumbers() {
    return this.#rangeNumbers(this.info.changedVertexRanges, 'buffers_changed_vertices');
  }
  get changedIndexNumbers() {
    return this.#rangeNumbers(this.info.changedIndexRanges, 'buffers_changed_indices');
  }
  #rangeNumbers(count, name) {
    const { module } = this;
    return module.within(() => {
      const at = module.take(8 * count);
      module.call(name, this.at, 0, count, at);
      return module.array(Uint32Array, at, 2 * count).slice();
    });
  }
  // What the last update changed of a stream, as ranges of its elements: three.js'
  // addUpdateRange(start, count).
  changedRanges(name) {
    const size = this.itemSize(name);
    const ranges = name === 'indices' ? this.changedIndices : this.changedVertices;
    return ranges.map(({ first, count }) => ({ start: first * size, count: count * size }));
  }
  // Copies these ranges to an array of the page's own, which must have room for all of the stream;
  // and returns them.
  copyChanged(name, target) {
    const ranges = this.changedRanges(name);
    const stream = this.stream(name);
    if (target.length < stream.length)
      throw new ShadowcutError(
        'INVALID_ARGUMENT',
        `the ${name} have grown: make a new array of their length`,
      );
    for (const { start, count } of ranges) target.set(stream.subarray(start, start + count), start);
    return ranges;
  }
}
