// From three.js to the engine: what stands in the three.js scene, and what of it has changed since
// the last look.
//
// A look goes over all objects of the three.js scene and compares numbers: matrices, versions,
// lights' parameters. It costs some tens of nanoseconds an object, whatever its triangles; only
// what has changed is read, and handed on.
import { Box3, Matrix3, Matrix4, Vector3 } from 'three';
import { mostLights } from './materials.js';
import { Source } from './sources.js';

// One object of the engine: a mesh, or one instance of an InstancedMesh.
class Instance {
  id = null; // null: there is nothing in the engine, because of an issue
  firstFace = 0;
  // column by column, as three.js has it, and as it was last handed on
  matrix = new Float64Array(16).fill(NaN);
  normalMatrix = new Float64Array(9); // column by column; not scaled
  mirrored = false; // the matrix turns the inside out
  tint = null; // of InstancedMesh.instanceColor
  constructor(entry) {
    this.entry = entry;
  }
}

// One mesh.
class Entry {
  geometry = null;
  grouped = false; // it has several materials
  castsShadows = false;
  receivesShadows = false;
  instances = [];
  slots = []; // the palette's, by group
  materials = []; // by group, as they were when the slots were acquired
  vertexColors = []; // of these, likewise
  tinted = false;
  // the mask that the mesh had before it was moved to the layer of its own; 0: it has not been
  // moved
  layers = 0;
  source = null;
  topology = -1;
  positions = -1;
  style = -1;
  matrixVersion = -1;
  colorVersion = -1;
  world = new Float64Array(16).fill(NaN);
  stamp = 0;
  constructor(mesh) {
    this.mesh = mesh;
  }
}

const matrix = new Matrix4(),
  inverse = new Matrix3(),
  from = new Vector3(),
  to = new Vector3();
const pose = new Float64Array(16);
const same = (a, b) => {
  for (let i = 0; i < 16; ++i) if (a[i] !== b[i]) return false;
  return true;
};

export class Mirror {
  instances = []; // by the engine's object index
  followed = []; // the three.js lights, by the engine's light index
  drawn = []; // all lights that are visible, in the order of the scene
  issues = [];
  restyled = new Set(); // entries whose fragments inherit something else since restyled was cleared
  attributesChanged = true; // which attributes there are, or how many numbers of each
  edited = true; // the engine's scene, since edited was cleared
  #scene;
  #root;
  #options;
  #palette;
  #own;
  #entries = new Map();
  #lights = new Map(); // three.js light -> { id, values, stamp }
  #sources = new Map(); // geometry -> [source with one material, source with groups]
  #reported = new Map(); // object -> messages
  #standIn = null;
  #engineIssues = 0;
  #recheck = false;
  #stamp = 0;
  #stack = [];

  // own: objects in the three.js scene that are ours.
  constructor(scene, root, options, palette, own) {
    this.#scene = scene;
    this.#root = root;
    this.#options = options;
    this.#palette = palette;
    this.#own = own;
  }

  // Looks, and edits the engine's scene. What throws (memory) is looked at again by the next look.
  look() {
    ++this.#stamp;
    this.drawn.length = 0;
    const stack = this.#stack;
    stack.length = 0;
    stack.push(this.#root);
    while (stack.length > 0) {
      const object = stack.pop();
      if (!object.visible || object === this.#own) continue;
      if (object.isLight) this.#lookAtLight(object);
      else if (object.isMesh) this.#lookAtMesh(object);
      const { children } = object;
      for (let i = children.length - 1; i >= 0; --i) stack.push(children[i]); // in three.js' order
    }
    for (const entry of this.#entries.values())
      if (entry.stamp !== this.#stamp) this.#forget(entry.mesh, entry);
    for (const [light, known] of this.#lights)
      if (known.stamp !== this.#stamp) this.#forgetLight(light, known);
    this.#standInForLights();
    if (this.#recheck) this.#listRefused();
  }
  bitOf(light) {
    return this.#lights.get(light)?.id.index ?? -1;
  }
  objectOf(mesh, instance) {
    return this.#entries.get(mesh)?.instances[instance]?.id?.index;
  }
  entries() {
    return this.#entries.values();
  }
  dispose() {
    for (const [mesh, entry] of this.#entries) this.#giveBack(mesh, entry);
    this.#entries.clear();
  }

  bake(mesh) {
    const entry = this.#entries.get(mesh);
    if (!entry) return; // it is baked when it is met
    if (entry.source === this.#sources.get(mesh.geometry)?.[+entry.grouped])
      entry.source = new Source(mesh.geometry, entry.grouped, false, mesh);
    else entry.source.bake(mesh);
  }

  // ---- Meshes

  #lookAtMesh(mesh) {
    const castsShadows = this.#options.castsShadows(mesh),
      receivesShadows = this.#options.receivesShadows(mesh);
    if (!castsShadows && !receivesShadows) return;
    if (mesh.isBatchedMesh) return this.#report(mesh, 'a BatchedMesh is not followed');
    let entry = this.#entries.get(mesh);
    if (!entry) this.#entries.set(mesh, (entry = new Entry(mesh)));
    entry.stamp = this.#stamp;
    this.#chooseSource(entry);
    entry.source.check(this.#stamp);
    this.#lookAtSettings(entry, castsShadows, receivesShadows);
    this.#lookAtShape(entry);
    this.#lookAtStyle(entry);
    this.#lookAtPoses(entry);
    if (receivesShadows && entry.instances.some((instance) => instance.id)) this.#move(mesh, entry);
    else this.#giveBack(mesh, entry);
  }
  // A posed mesh has a source of its own; others share their geometry's.
  #chooseSource(entry) {
    const { mesh } = entry;
    const { geometry } = mesh,
      grouped = Array.isArray(mesh.material);
    if (entry.geometry === geometry && entry.grouped === grouped) return;
    const { geometry: old } = entry;
    entry.geometry = geometry;
    entry.grouped = grouped;
    this.#dropSource(old);
    const posed =
      mesh.isSkinnedMesh || mesh.morphTargetInfluences?.some((influence) => influence !== 0);
    entry.source = posed
      ? new Source(geometry, grouped, false, mesh)
      : this.#sourceOf(geometry, grouped);
  }
  #sourceOf(geometry, grouped) {
    let pair = this.#sources.get(geometry);
    if (!pair) this.#sources.set(geometry, (pair = [null, null]));
    return (pair[+grouped] ??= new Source(geometry, grouped, this.#options.joins));
  }

  #lookAtSettings(entry, castsShadows, receivesShadows) {
    if (entry.castsShadows !== castsShadows) this.#set(entry, 'setCastsShadows', castsShadows);
    if (entry.receivesShadows !== receivesShadows)
      this.#set(entry, 'setReceivesShadows', receivesShadows);
    entry.castsShadows = castsShadows;
    entry.receivesShadows = receivesShadows;
  }
  #set(entry, setter, value) {
    for (const { id } of entry.instances)
      if (id) (this.#scene[setter](id, value), (this.edited = true));
  }

  // Another topology: another object. Other positions: the object deformed.
  #lookAtShape(entry) {
    const { source } = entry;
    if (entry.topology !== source.topology) {
      while (entry.instances.length > 0) this.#remove(entry.instances.pop());
      entry.matrixVersion = -1;
      entry.world.fill(NaN);
      entry.topology = source.topology;
      entry.positions = source.positions;
      this.attributesChanged = true;
      if (source.faceCount === 0) this.#report(entry.mesh, 'has no triangles');
    } else if (entry.positions !== source.positions) {
      for (const instance of entry.instances) {
        if (!instance.id) continue;
        this.#scene.setVertices(instance.id, source.points);
        this.#edit(instance);
        this.#recheck = true;
      }
      entry.positions = source.positions;
    }
  }

  #lookAtStyle(entry) {
    const { mesh, source } = entry;
    if (entry.style !== source.style) {
      entry.style = source.style;
      this.attributesChanged = true;
      this.#restyle(entry);
    }
    const colors = mesh.isInstancedMesh ? mesh.instanceColor : null;
    if ((colors?.version ?? -1) !== entry.colorVersion) {
      entry.colorVersion = colors?.version ?? -1;
      entry.instances.forEach((instance, k) => this.#tint(instance, k));
      this.attributesChanged = true;
      this.#restyle(entry);
    }
    const tinted = colors !== null;
    const { material } = mesh;
    const count = entry.grouped ? material.length : 1;
    let changed = entry.tinted !== tinted || entry.materials.length !== count;
    for (let i = 0; !changed && i < count; ++i) {
      const each = entry.grouped ? material[i] : material;
      changed = entry.materials[i] !== each || entry.vertexColors[i] !== each?.vertexColors;
    }
    if (changed) this.#acquire(entry, entry.grouped ? material : [material], tinted);
  }
  #acquire(entry, materials, tinted) {
    const slots = materials.map((material) =>
      material ? this.#palette.acquire(material, tinted) : -1,
    );
    for (const slot of entry.slots) if (slot >= 0) this.#palette.release(slot);
    entry.slots = slots;
    entry.materials = materials.slice();
    entry.vertexColors = materials.map((material) => material?.vertexColors);
    entry.tinted = tinted;
    this.#restyle(entry);
  }
  // What has no fragments as yet gets them in its style.
  #restyle(entry) {
    if (entry.instances.length > 0) this.restyled.add(entry);
  }
  #tint(instance, k) {
    const colors = instance.entry.mesh.instanceColor;
    instance.tint = colors ? [colors.getX(k), colors.getY(k), colors.getZ(k)] : null;
  }

  #lookAtPoses(entry) {
    const { mesh, instances } = entry;
    const world = mesh.matrixWorld.elements;
    if (entry.source.faceCount === 0) return;
    if (!mesh.isInstancedMesh) {
      if (instances.length === 0) instances.push(new Instance(entry));
      this.#pose(instances[0], world);
      return;
    }
    const version = mesh.instanceMatrix.version;
    if (
      version === entry.matrixVersion &&
      mesh.count === instances.length &&
      same(world, entry.world)
    )
      return;
    while (instances.length > mesh.count) this.#remove(instances.pop());
    for (let k = 0; k < mesh.count; ++k) {
      if (k === instances.length) {
        instances.push(new Instance(entry));
        this.#tint(instances[k], k);
      }
      matrix.fromArray(mesh.instanceMatrix.array, 16 * k).premultiply(mesh.matrixWorld);
      this.#pose(instances[k], matrix.elements);
    }
    entry.matrixVersion = version;
    entry.world.set(world);
  }
  #pose(instance, elements) {
    if (same(instance.matrix, elements)) return;
    const { mesh } = instance.entry;
    inverse.setFromMatrix4(matrix.fromArray(elements));
    const determinant = inverse.determinant();
    for (let row = 0; row < 4; ++row)
      for (let column = 0; column < 4; ++column)
        pose[4 * row + column] = elements[4 * column + row];
    try {
      if (instance.id) this.#scene.setPose(instance.id, pose);
      else this.#add(instance);
    } catch (error) {
      if (error.status !== 'REFUSED' && error.status !== 'INVALID_ARGUMENT') throw error;
      if (instance.id) this.#remove(instance);
      instance.matrix.set(elements); // not again until it changes
      const which = mesh.isInstancedMesh
        ? `instance ${instance.entry.instances.indexOf(instance)}: `
        : '';
      const singular = elements.every(Number.isFinite)
        ? 'its matrix cannot be inverted'
        : 'its matrix has numbers that are not finite';
      this.#report(mesh, which + singular);
      return;
    }
    instance.matrix.set(elements);
    instance.mirrored = determinant < 0;
    instance.normalMatrix.set(inverse.invert().transpose().elements);
    this.#edit(instance);
  }
  #add(instance) {
    const { mesh, source, castsShadows, receivesShadows } = instance.entry;
    const settings = {
      pose,
      castsShadows,
      receivesShadows,
      dynamic: this.#options.dynamic(mesh),
      name: mesh.name || mesh.uuid,
    };
    instance.id = this.#scene.add(
      { positions: source.points, indices: source.outlines, cornerCounts: source.cornerCounts },
      settings,
    );
    this.instances[instance.id.index] = instance;
    this.#recheck = true;
  }
  #remove(instance) {
    if (!instance.id) return;
    this.#scene.remove(instance.id);
    this.instances[instance.id.index] = undefined;
    instance.id = null;
    this.edited = true;
  }
  // The object's faces may have got another place.
  #edit(instance) {
    instance.firstFace = this.#scene.firstFace(instance.id);
    this.edited = true;
  }

  #move(mesh, entry) {
    const mask = (1 << this.#options.layer) | 0;
    if (mesh.layers.mask === mask) return;
    entry.layers = mesh.layers.mask;
    mesh.layers.mask = mask;
  }
  #giveBack(mesh, entry) {
    if (entry.layers !== 0 && mesh.layers.mask === ((1 << this.#options.layer) | 0))
      mesh.layers.mask = entry.layers;
    entry.layers = 0;
  }
  #forget(mesh, entry) {
    while (entry.instances.length > 0) {
      this.#remove(entry.instances[entry.instances.length - 1]);
      entry.instances.pop();
    }
    for (const slot of entry.slots) if (slot >= 0) this.#palette.release(slot);
    this.#giveBack(mesh, entry);
    this.#entries.delete(mesh);
    this.restyled.delete(entry);
    this.#dropSource(entry.geometry);
  }
  // Unless somebody uses it.
  #dropSource(geometry) {
    if (!this.#sources.has(geometry)) return;
    for (const other of this.#entries.values()) if (other.geometry === geometry) return;
    this.#sources.delete(geometry);
  }

  // ---- Lights

  #lookAtLight(light) {
    this.drawn.push(light);
    if (light.isRectAreaLight)
      return this.#report(light, 'a RectAreaLight casts no sharp shadows: it is not followed');
    const values = this.#valuesOf(light);
    if (!values || !this.#options.follows(light)) return;
    const known = this.#lights.get(light);
    if (known && values.every((value, i) => Object.is(value, known.values[i]))) {
      known.stamp = this.#stamp;
      return;
    }
    const description = descriptionOf(light, values);
    try {
      if (known) this.#scene.setLight(known.id, description);
      else
        this.#lights.set(light, { id: this.#scene.addLight(description), values: null, stamp: 0 });
    } catch (error) {
      if (error.status !== 'REFUSED' && error.status !== 'INVALID_ARGUMENT') throw error;
      this.#report(light, error.message.replace(/^light \S+: /, ''));
      return; // and what there was of it goes
    }
    const now = this.#lights.get(light);
    now.values = values.slice();
    now.stamp = this.#stamp;
    this.followed[now.id.index] = light;
    if (now.id.index >= mostLights) {
      this.#report(
        light,
        `only ${mostLights} lights have a bit in the masks: this one shades as if unshadowed`,
      );
    }
    this.edited = true;
  }
  #valuesOf(light) {
    from.setFromMatrixPosition(light.matrixWorld);
    if (light.isPointLight) return [from.x, from.y, from.z, light.distance];
    if (light.isSunLight) return [-from.x, -from.y, -from.z];
    if (!light.isSpotLight && !light.isDirectionalLight) return null;
    to.setFromMatrixPosition(light.target.matrixWorld).sub(from);
    if (light.isDirectionalLight) return [to.x, to.y, to.z];
    return [from.x, from.y, from.z, light.distance, to.x, to.y, to.z, light.angle];
  }
  #forgetLight(light, { id }) {
    this.#scene.removeLight(id);
    this.#lights.delete(light);
    this.followed[id.index] = undefined;
    this.edited = true;
  }
  // Fragments are a light's. Where there is none, one that reaches nothing has them: every face
  // whole, and nothing is cut.
  #standInForLights() {
    const wanted = this.#lights.size === 0;
    if (wanted === (this.#standIn !== null)) return;
    if (wanted) {
      this.#standIn = this.#scene.addLight({
        kind: 'point',
        position: [0, 0, 0],
        range: Number.MIN_VALUE,
      });
    } else {
      this.#scene.removeLight(this.#standIn);
      this.#standIn = null;
    }
    this.edited = true;
  }
  // The index of the one light of the engine, or 'all'.
  get lightOfBuffers() {
    if (this.#standIn) return this.#standIn.index;
    if (this.#lights.size > 1) return 'all';
    return this.#lights.values().next().value.id.index;
  }

  // ---- Issues

  #report(object, message) {
    const messages = this.#reported.get(object);
    if (messages?.has(message)) return;
    if (messages) messages.add(message);
    else this.#reported.set(object, new Set([message]));
    this.issues.push({ object, message });
  }
  // What the engine has left out, but for triangles of no area, which nobody sees.
  #listRefused() {
    this.#recheck = false;
    const { issues } = this.#scene.counts;
    if (issues === 0 && this.#engineIssues === 0) return;
    this.#engineIssues = issues;
    const refused = new Map();
    for (const { object, reason } of this.#scene.issues()) {
      const mesh = this.instances[object]?.entry.mesh;
      const words = told[reason];
      if (mesh && words) refused.set(mesh, (refused.get(mesh) ?? new Set()).add(words));
    }
    for (const [mesh, words] of refused)
      for (const each of words) this.#report(mesh, `triangles are left out: ${each}`);
  }
}
const told = {
  nonFinite: 'they have coordinates that are not finite',
  indexOutOfRange: 'they have indices beyond the vertices',
};

function descriptionOf(light, values) {
  const name = light.name || light.uuid;
  if (light.isDirectionalLight || light.isSunLight)
    return { kind: 'directional', direction: values, name };
  const position = values.slice(0, 3),
    range = light.distance > 0 ? light.distance : Infinity;
  if (light.isPointLight) return { kind: 'point', position, range, name };
  return {
    kind: 'point',
    position,
    range,
    spot: { axis: values.slice(4, 7), halfAngle: light.angle },
    name,
  };
}

// The middle of a box around all vertices in the world; null where there are none. Cost: all
// vertices.
export function middleOf(mirror) {
  const all = new Box3(),
    box = new Box3();
  for (const { source, instances } of mirror.entries()) {
    const local = source.box();
    for (const instance of instances) {
      if (instance.id && !local.isEmpty())
        all.union(box.copy(local).applyMatrix4(matrix.fromArray(instance.matrix)));
    }
  }
  return all.isEmpty() ? null : all.getCenter(from).toArray();
}
