// Exact shadows for a three.js scene: mirrors it into the engine, and draws what the engine makes
// of it as one mesh, without a shadow pass.
//
//   three.js scene --mirror.js (sources.js)--> engine --shadowcut.Buffers--> geometry.js (faces.js)
//     --materials.js--> picture
import { LineBasicMaterial, LineSegments, Mesh } from 'three';
import { FragmentGeometry } from './geometry.js';
import { Palette, mostLights } from './materials.js';
import { Mirror, middleOf } from './mirror.js';

const defaults = {
  kernel: 'fast',
  form: 'merged',
  castsShadows: (mesh) => mesh.castShadow,
  receivesShadows: (mesh) => mesh.receiveShadow,
  dynamic: () => false,
  follows: () => true,
  layer: 31,
  // now and then a cell is built again: a quarter of the engine's own halves that moment, about
  facetsPerCell: 32,
  joins: true,
};

export class SceneShadows {
  #shadowcut;
  #root;
  #options;
  #palette = new Palette();
  #mirror;
  #geometry;
  #buffers = null;
  #light = undefined; // whose buffers they are: an index, or 'all'
  #outlines;
  #origin = null;
  // the geometry may not be what the engine says: it failed, or has never been filled
  #stale = true;
  #disposed = false;

  constructor(shadowcut, scene, options = {}) {
    const unknown = Object.keys(options).find((name) => !(name in defaults));
    if (unknown) throw new TypeError(`there is no option ${unknown}`);
    this.#shadowcut = shadowcut;
    this.#root = scene;
    this.#options = { ...defaults, ...options };
    const { kernel, form, facetsPerCell } = this.#options;
    this.scene = new shadowcut.Scene();
    this.engine = new shadowcut.Engine(this.scene, {
      kernel,
      form,
      tuning: { facetsPerCell },
    });
    this.mesh = new Mesh();
    this.#mirror = new Mirror(this.scene, scene, this.#options, this.#palette, this.mesh);
    this.#geometry = new FragmentGeometry(this.#mirror, this.#palette);
    this.#makeMesh();
    this.#makeOutlines();
    scene.add(this.mesh);
  }

  // In the world, whatever the scene's own matrix; never hit by rays (its originals are), and lit
  // by masks.
  #makeMesh() {
    const { mesh } = this;
    mesh.name = 'shadowcut';
    mesh.geometry.dispose();
    mesh.geometry = this.#geometry.geometry;
    mesh.material = this.#palette.materials;
    mesh.frustumCulled = false;
    mesh.matrixAutoUpdate = mesh.matrixWorldAutoUpdate = false;
    mesh.raycast = () => {};
    mesh.onBeforeRender = (renderer, scene, camera) =>
      this.#palette.arrange(this.#lightsOf(scene), camera, this.#bitOf);
  }
  // Drawn a little nearer than the faces in which they lie.
  #makeOutlines() {
    const material = new LineBasicMaterial({ color: 0x000000 });
    material.onBeforeCompile = (shader) => {
      const bias = '#include <project_vertex>\n\tgl_Position.z -= 1e-4 * gl_Position.w;';
      shader.vertexShader = shader.vertexShader.replace('#include <project_vertex>', bias);
    };
    const lines = (this.#outlines = new LineSegments(this.#geometry.lines, material));
    lines.name = 'shadowcut outlines';
    lines.frustumCulled = lines.visible = false;
    lines.matrixAutoUpdate = lines.matrixWorldAutoUpdate = false;
    lines.raycast = () => {};
    this.mesh.add(lines);
  }

  get outlines() {
    return this.#outlines.visible;
  }
  set outlines(shown) {
    this.#outlines.visible = this.#geometry.withLines = Boolean(shown);
  }
  get outlineMaterial() {
    return this.#outlines.material;
  }
  get issues() {
    return this.#mirror.issues;
  }
  get lights() {
    return this.#mirror.followed;
  }
  get mustCompact() {
    return this.engine.mustCompact;
  }
  objectOf(mesh, instance = 0) {
    return this.#mirror.objectOf(mesh, instance);
  }
  litArea(light = 0) {
    return this.#mirror.followed[light] ? this.engine.shadows(light).stats.litArea : 0;
  }
  facingArea(light = 0) {
    return this.#mirror.followed[light] ? this.engine.shadows(light).stats.facingArea : 0;
  }
  bake(mesh) {
    this.#mirror.bake(mesh);
  }

  update() {
    return this.#run(() => this.engine.update());
  }
  compact() {
    this.#stale = true;
    this.#origin = null;
    return this.#run(() => this.engine.compact());
  }

  #run(bringUpToDate) {
    const start = performance.now();
    const done = {
      applied: 0,
      gone: 0,
      added: 0,
      engineMs: 0,
      ms: 0,
      uploadedBytes: 0,
      rebuilt: false,
    };
    const mirror = this.#mirror,
      geometry = this.#geometry;
    if (this.mesh.parent === null) this.#root.add(this.mesh); // the scene was cleared, perhaps
    this.#updateMatrices();
    mirror.look();
    geometry.uploadedBytes = 0;
    if (mirror.edited || this.#stale) {
      const anew = this.#chooseBuffers() || this.#stale;
      this.#stale = true; // until all has gone well
      count(bringUpToDate(), done);
      this.#buffers.update(this.engine);
      geometry.sync(this.#buffers, this.#light === 'all', anew);
      mirror.edited = this.#stale = false;
    } else if (geometry.wantsSync) {
      this.#buffers.update(this.engine); // nothing: it only forgets the last changes
      geometry.sync(this.#buffers, this.#light === 'all', false);
    }
    done.uploadedBytes = geometry.uploadedBytes;
    done.ms = performance.now() - start;
    return done;
  }
  // As the renderer will; all that is looked at are matrices in the world.
  #updateMatrices() {
    const root = this.#root;
    if (root.parent !== null) root.updateWorldMatrix(true, false);
    if (root.matrixWorldAutoUpdate) root.updateMatrixWorld();
  }

  // Buffers of one light follow it at less than half the cost of the partition by all. True: they
  // are new ones.
  #chooseBuffers() {
    const light = this.#mirror.lightOfBuffers;
    if (this.#buffers && light === this.#light && this.#origin) return false;
    if (!this.#origin) this.#chooseOrigin();
    this.#buffers?.dispose();
    this.#buffers = null;
    const layout = {
      origin: this.#geometry.origin,
      doubles: true,
      indexed: true,
      normals: false,
      objects: true,
      joinedGap: 0,
    };
    this.#buffers = new this.#shadowcut.Buffers(light, {
      ...layout,
      states: light !== 'all',
      masks: light === 'all',
    });
    this.#light = light;
    return true;
  }
  // The middle of what there is: floats keep the digits of a scene far from the world's origin.
  #chooseOrigin() {
    this.#origin = middleOf(this.#mirror);
    this.#geometry.origin = this.#origin ?? [0, 0, 0];
    for (const object of [this.mesh, this.#outlines])
      object.matrixWorld.makeTranslation(...this.#geometry.origin);
  }

  // Bits of the lights in the masks.
  #bitOf = (light) => {
    const index = this.#mirror.bitOf(light);
    if (index < 0 || index >= mostLights) return -1;
    return this.#light === 'all' ? index : 0;
  };
  // Those that three.js draws: of a larger scene than ours, perhaps.
  #lightsOf(scene) {
    if (scene === this.#root) return this.#mirror.drawn;
    const lights = [];
    scene.traverseVisible((object) => {
      if (object.isLight) lights.push(object);
    });
    return lights;
  }

  dispose() {
    if (this.#disposed) return;
    this.#disposed = true;
    this.#mirror.dispose();
    this.mesh.removeFromParent();
    this.#geometry.dispose();
    this.#outlines.material.dispose();
    this.#palette.dispose();
    for (const each of [this.#buffers, this.engine, this.scene]) each?.dispose();
  }
}

function count(changes, done) {
  done.applied = changes.applied;
  done.engineMs = changes.ms;
  for (const { goneCount, addedCount, rebuilt } of changes.lights) {
    done.gone += goneCount;
    done.added += addedCount;
    done.rebuilt ||= rebuilt;
  }
}
