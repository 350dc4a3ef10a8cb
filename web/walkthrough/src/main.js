// The walkthrough: puts the parts together, and draws when something has changed.
//
//   room.js  what is shown          walk.js, pointer.js, drag.js  who moves what        compare.js
//            beside three.js' shadow map
//   drop.js  somebody's own GLB     xr.js    in VR                                      panel.js,
//            meter.js  figures
//
// begin.js fetches the engine and the room; the room is drawn as soon as it is there, and with its
// shadows as soon as they are.
import {
  Group,
  NeutralToneMapping,
  PerspectiveCamera,
  Vector2,
  Vector3,
  WebGLRenderer,
} from 'three';
import { SceneShadows } from 'shadowcut-three';
import { Compare, followDivider } from './compare.js';
import { Drag } from './drag.js';
import { followDrops, readModel, Refusal } from './drop.js';
import { fetchRoom } from './fetch.js';
import { MapMeter, percentile, UploadMeter } from './meter.js';
import { Panel } from './panel.js';
import { Pointer } from './pointer.js';
import { isWithin, nameOf, parseGlb, World } from './room.js';
import { inTheWorld, isField, Walk } from './walk.js';
import { prepareXr, Vr } from './xr.js';

const layer = 31; // of the meshes that are drawn by their fragments
const canvas = document.getElementById('view');

class App {
  renderer = new WebGLRenderer({ canvas, antialias: true });
  camera = new PerspectiveCamera(65, 1, 0.05, 200);
  rig = new Group();
  compare = new Compare(this.renderer);
  upload = new UploadMeter(this.renderer.getContext());
  mapMeter = new MapMeter(this.renderer);
  walk = new Walk(this.camera, this.rig);
  drag = new Drag(layer);
  world = null;
  shadowcut = null;
  shadows = null;
  kernel = 'fast';
  asNative = {}; // what of the adapter's options is to be the native program's
  outlines = false;
  built = false; // the shadows have been built and drawn; what comes is updates
  #chosen = 'lamp';
  #dirty = true;
  #last = 0;
  #fast = false;
  #waiting = []; // for the next frame drawn
  #idle;
  #buildMs = Infinity;
  #models = [];

  constructor() {
    this.renderer.toneMapping = NeutralToneMapping;
    this.rig.add(this.camera);
    this.panel = new Panel({
      kernel: (kernel) => this.setKernel(kernel),
      outlines: (shown) => this.setOutlines(shown),
      compare: (on) => this.setCompare(on),
      mapSize: (size) => (this.compare.setMapSize(size), this.setZoom(this.compare.zoom)),
      zoom: (zoom) => this.setZoom(zoom),
      chosen: (name) => (this.#chosen = name),
      file: (file) => this.open(file),
      reset: () => this.reset(),
      home: () => this.home(),
      measure: () => this.measure(),
      vr: () => this.enterVr(),
    });
    const moved = () => this.invalidate();
    const { walk, drag, camera, rig, renderer } = this;
    const chosen = (object) => this.choose(this.nameOfMovable(object));
    this.pointer = new Pointer(canvas, document.getElementById('stick'), {
      walk,
      drag,
      camera,
      moved,
      chosen,
      zoomed: () => this.compare.zoom,
    });
    this.vr = new Vr({ renderer, rig, drag, walk, camera, ...this.#aroundVr() });
    this.#followKeys();
    followDrops(document.getElementById('dropping'), (file) => this.open(file));
    followDivider(document.getElementById('divider'), (share) => {
      this.compare.share = share;
      this.setCompare(this.compare.on);
    });
    addEventListener('resize', () => this.resize());
    matchMedia(`(resolution: ${devicePixelRatio}dppx)`).addEventListener('change', () =>
      this.resize(),
    );
    canvas.addEventListener('webglcontextlost', () =>
      this.panel.say(
        'The graphics processor has dropped this page. It may come back; otherwise reload.',
      ),
    );
    canvas.addEventListener('webglcontextrestored', () => this.panel.say(''));
    addEventListener(
      'wheel',
      (event) => {
        // those zoom the page, and scroll the panel
        if (event.ctrlKey || event.target.closest('#panel')) return;
        event.preventDefault();
        this.setZoom(
          this.compare.zoom * 2 ** (-Math.sign(event.deltaY) / 4),
          event.clientX / innerWidth,
          event.clientY / innerHeight,
        );
      },
      { passive: false },
    );
    this.resize();
    this.renderer.setAnimationLoop((time) => this.frame(time));
    prepareXr(this.panel);
  }

  // Promises of the engine, and of the room's bytes.
  async begin(engine, room) {
    this.enter(World.room((await parseGlb(await room)).scene));
    performance.mark('the room is drawn');
    this.shadowcut = await engine;
    this.follow();
    this.draw();
    performance.mark('the shadows are drawn');
  }

  // ---- What is shown

  enter(world) {
    this.leave();
    this.world = world;
    world.scene.add(this.rig);
    this.walk.enter(world);
    this.drag.enter(world);
    this.setZoom(1);
    this.panel.names(
      [...world.movables.keys()],
      (this.#chosen = [...world.movables.keys()].at(-1)),
    );
    this.draw();
  }
  leave() {
    if (!this.world) return;
    this.unfollow();
    this.compare.forget();
    this.world.dispose();
    this.world = null;
    this.#models.length = 0;
  }

  // The engine begins to follow the scene that is shown; builds at the next frame.
  follow() {
    this.unfollow();
    this.shadows = new SceneShadows(this.shadowcut, this.world.scene, {
      kernel: this.kernel,
      layer,
      ...this.asNative,
    });
    // by its fragments: no ray hits it, and no shadow map has it
    this.shadows.mesh.userData.drawn = true;
    this.shadows.outlines = this.outlines;
    this.panel.forgetUpdates();
    this.built = false;
    this.invalidate();
  }
  unfollow() {
    this.shadows?.dispose();
    this.shadows = null;
  }

  async open(file) {
    if (!this.shadowcut) return this.panel.say('One moment: the room is not there yet.');
    this.panel.say(`Reading ${file.name} …`);
    try {
      const { model, triangles, notes } = await readModel(file);
      this.panel.say(`Cutting the shadows of ${triangles.toLocaleString('en')} triangles …`);
      await painted();
      if (this.panel.alone) await this.showAlone(model, file.name, notes);
      else this.showInRoom(model, file.name, notes);
    } catch (error) {
      if (error instanceof Refusal) this.panel.say(error.message);
      else if (error.status === 'OUT_OF_MEMORY')
        this.panel.say(
          `${file.name}: its shadows need more memory than this page can have. ` +
            'What was here before is here again.',
        );
      else (console.error(error), this.panel.say(`${file.name}: ${error.message}.`));
    }
    this.invalidate();
    return undefined;
  }
  showInRoom(model, name, notes) {
    const ahead = new Vector3(0, 0, -2.5).applyEuler(this.camera.rotation).add(this.rig.position);
    const { min, max } = this.world.bounds;
    ahead.clamp(min.clone().addScalar(1), max.clone().addScalar(-1));
    const root = this.world.addModel(model, name, ahead);
    this.compare.forget();
    try {
      this.draw(true);
    } catch (error) {
      this.world.removeModel(root);
      this.compare.forget();
      this.follow();
      this.draw();
      throw error;
    }
    this.#models.push(root);
    this.#chosen = this.nameOfMovable(root);
    this.panel.names([...this.world.movables.keys()], this.#chosen);
    this.#sayModel(name, root, notes);
  }
  async showAlone(model, name, notes) {
    const world = World.alone(model);
    try {
      this.enter(world);
      this.follow();
      this.draw(true);
    } catch (error) {
      await this.reset(); // the room again
      throw error;
    }
    this.#sayModel(name, world.scene, notes);
  }
  #sayModel(name, root, notes) {
    const words = [...notes];
    const issues = this.shadows.issues.filter(({ object }) => isWithin(object, root));
    if (issues.length > 0)
      words.push(
        `${nameOf(issues[0].object)}: ${issues[0].message}` +
          `${issues.length > 1 ? `; and ${issues.length - 1} more like it` : ''}.`,
      );
    this.panel.say(words.length > 0 ? `${name} is here. ${words.join(' ')}` : '');
  }

  async reset() {
    this.panel.say('');
    try {
      if (this.world?.isRoom) {
        for (const root of this.#models.splice(0)) this.world.removeModel(root);
        this.world.reset();
        this.compare.forget();
        this.panel.names([...this.world.movables.keys()], (this.#chosen = 'lamp'));
        if (!this.shadows) this.follow();
      } else {
        this.enter(World.room((await parseGlb(await fetchRoom())).scene));
        this.follow();
      }
    } catch (error) {
      this.panel.say(error.message);
    }
    this.invalidate();
  }

  // ---- Settings

  setKernel(kernel) {
    this.kernel = kernel;
    this.panel.set('kernel', kernel);
    if (this.shadowcut) this.follow();
  }
  setOutlines(shown) {
    this.outlines = shown;
    if (this.shadows) this.shadows.outlines = shown;
    this.invalidate();
  }
  setCompare(on) {
    this.compare.on = on;
    this.panel.halves(on, this.compare.share);
    this.invalidate();
  }
  setZoom(zoom, x, y) {
    this.compare.zoomTo(zoom, x, y);
    this.panel.zoom(this.compare.zoom, this.compare.mapSize);
    this.invalidate();
  }
  choose(name) {
    this.#chosen = name;
    this.panel.set('chosen', name);
  }
  nameOfMovable(object) {
    for (const [name, each] of this.world.movables) if (each === object) return name;
    return undefined;
  }
  home() {
    this.walk.home();
    this.setZoom(1);
  }

  #followKeys() {
    const keys = {
      KeyO: () => this.panel.toggle('outlines'),
      KeyC: () => this.panel.toggle('compare'),
      KeyR: () => this.reset(),
      KeyH: () => this.panel.toggle('fold'),
      Home: () => this.home(),
      Digit1: () => this.setKernel('fast'),
      Digit2: () => this.setKernel('exact'),
      Equal: () => this.setZoom(this.compare.zoom * 2 ** 0.25),
      Minus: () => this.setZoom(this.compare.zoom / 2 ** 0.25),
      NumpadAdd: () => this.setZoom(this.compare.zoom * 2 ** 0.25),
      NumpadSubtract: () => this.setZoom(this.compare.zoom / 2 ** 0.25),
      Escape: () => this.panel.say(''),
    };
    const steps = {
      ArrowLeft: [-1, 0, 0],
      ArrowRight: [1, 0, 0],
      ArrowUp: [0, 0, 1],
      ArrowDown: [0, 0, -1],
      PageUp: [0, 1, 0],
      PageDown: [0, -1, 0],
    };
    addEventListener('keydown', (event) => {
      this.#fast = event.shiftKey;
      if (event.ctrlKey || event.altKey || event.metaKey || isField(event.target) || !this.world)
        return;
      if (event.shiftKey && steps[event.code]) this.nudge(...steps[event.code]);
      else if (keys[event.code] && !event.repeat) keys[event.code]();
      else return;
      event.preventDefault();
    });
    addEventListener('keyup', (event) => (this.#fast = event.shiftKey));
  }
  // Moves what is chosen by five centimetres, as the eye sees left and ahead, along the axis of the
  // room that is nearest to it.
  nudge(right, up, forwards) {
    const object = this.world.movables.get(this.#chosen);
    if (!object) return;
    const quarter = (Math.round(this.walk.yaw / (Math.PI / 2)) * Math.PI) / 2,
      sin = Math.round(Math.sin(quarter)),
      cos = Math.round(Math.cos(quarter));
    if (this.drag.moveBy(object, inTheWorld(right, up, forwards, sin, cos).multiplyScalar(0.05)))
      this.invalidate();
  }

  // ---- Drawing

  invalidate() {
    this.#dirty = true;
  }
  resize() {
    if (this.renderer.xr.isPresenting) return;
    this.renderer.setPixelRatio(Math.min(devicePixelRatio, 2));
    this.renderer.setSize(innerWidth, innerHeight, false);
    this.camera.aspect = innerWidth / innerHeight;
    this.camera.fov = this.camera.aspect < 1 ? 80 : 65;
    this.camera.updateProjectionMatrix();
    this.invalidate();
  }
  frame(time) {
    const seconds = Math.min((time - this.#last) / 1000, 0.1);
    this.#last = time;
    if (!this.world) return;
    if (this.vr.presenting) {
      this.vr.step(seconds);
      this.#dirty = true;
    } else if (this.walk.step(seconds, this.#fast)) {
      this.#dirty = true;
    }
    if (!this.#dirty) return;
    try {
      this.draw();
    } catch (error) {
      this.#failed(error);
    }
  }

  // loud: what goes wrong with the engine is the caller's.
  draw(loud = false) {
    this.#dirty = false;
    this.upload.reset();
    const done = this.#update(loud);
    if (this.vr.presenting) this.renderer.render(this.world.scene, this.camera);
    else this.#drawPage(done);
    if (done) this.#account(done);
    for (const resolve of this.#waiting.splice(0)) resolve(this.state(done));
  }
  #drawPage(done) {
    const { compare } = this;
    if (compare.on && done?.applied) this.mapMeter.measureNext();
    compare.aim(this.camera, innerWidth, innerHeight);
    compare.render(this.world.scene, this.camera, innerWidth, innerHeight);
    if (compare.on && this.mapMeter.ms !== undefined) this.#showMap(this.mapMeter.ms);
  }
  #update(loud) {
    if (!this.shadows) return undefined;
    try {
      return this.shadows.update();
    } catch (error) {
      if (loud || error.status !== 'OUT_OF_MEMORY') throw error;
      return this.shadows.compact(); // what the tree had grown by is given back
    }
  }
  #failed(error) {
    console.error(error);
    this.unfollow();
    this.panel.say(
      `The shadows have stopped: ${error.message}. “Everything as it was” begins anew.`,
    );
  }

  #account(done) {
    if (done.applied === 0 && this.built) return;
    if (this.built) {
      this.panel.update({
        ...done,
        buffersMs: done.ms - done.engineMs,
        uploadMs: this.upload.ms,
        uploadedBytes: this.upload.bytes,
      });
    } else this.#buildMs = done.engineMs;
    this.panel.state(this.figures());
    this.built = true;
    clearTimeout(this.#idle);
    // when nothing moves; what would be felt is left to the button
    if (this.#buildMs < 50) this.#idle = setTimeout(() => this.measureRebuild(), 1500);
  }
  figures() {
    const sum = { fragments: 0, lit: 0, facing: 0, lights: 0 };
    this.shadows?.lights.forEach((light, k) => {
      if (!light) return;
      const { litFragments, shadowedFragments, litArea, facingArea } =
        this.shadows.engine.shadows(k).stats;
      sum.fragments += litFragments + shadowedFragments;
      sum.lit += litArea;
      sum.facing += facingArea;
      ++sum.lights;
    });
    return sum;
  }
  // Figures with all digits, and all fragments: those of faces turned away too, as `shadowcut
  // replay` counts them.
  state(done) {
    let allFragments = 0;
    this.shadows?.lights.forEach((light, k) => {
      const shadows = light && this.shadows.engine.shadows(k);
      for (let block = 0; block < shadows?.blockCount; ++block)
        allFragments += shadows.fragmentCount(block);
    });
    return {
      ...this.figures(),
      allFragments,
      kernel: this.kernel,
      update: done && { ...done, uploadMs: this.upload.ms, uploadedBytes: this.upload.bytes },
    };
  }
  nextFrame() {
    this.invalidate();
    return new Promise((resolve) => this.#waiting.push(resolve));
  }

  // ---- Measuring

  // In a new engine, which follows the same scene and is thrown away.
  measureRebuild() {
    if (!this.shadows || this.drag.held || this.walk.moving) return;
    const times = [];
    for (let k = 0; k < (this.#buildMs < 200 ? 3 : 1); ++k) {
      const engine = new this.shadowcut.Engine(this.shadows.scene, { kernel: this.kernel });
      try {
        times.push(engine.update().ms);
      } finally {
        engine.dispose();
      }
    }
    this.panel.rebuild(percentile(times, 0.5), this.kernel);
  }
  measureMap() {
    const times = [];
    this.compare.renderMap(this.world.scene, this.camera); // its programs are compiled
    for (let k = 0; k < 3; ++k) {
      this.mapMeter.measureNext();
      this.compare.renderMap(this.world.scene, this.camera);
      times.push(this.mapMeter.ms);
    }
    this.#showMap(percentile(times, 0.5));
  }
  #showMap(ms) {
    const size = this.compare.mapSize;
    this.panel.map(ms, `6 × ${size}²`, this.world.lights.length);
  }
  measure() {
    if (!this.shadows) return;
    this.measureRebuild();
    this.measureMap();
    this.invalidate();
  }

  // ---- VR

  #aroundVr() {
    const at = new Vector3();
    return {
      began: () => {
        at.copy(this.camera.position);
        this.setCompare(false);
        this.panel.set('compare', false);
        this.setZoom(1);
        this.camera.clearViewOffset();
      },
      ended: () => {
        this.camera.position.copy(at);
        this.walk.look(0, 0);
        this.resize();
      },
    };
  }
  async enterVr() {
    try {
      await this.vr.enter();
    } catch (error) {
      this.panel.say(`VR did not begin: ${error.message}`);
    }
  }
}

const painted = () => new Promise((resolve) => requestAnimationFrame(() => setTimeout(resolve)));

const app = new App();
export function begin(engine, room) {
  app
    .begin(engine, room)
    .catch((error) => app.panel.say(`This page could not begin: ${error.message}`));
}

// For tests, which drive the page as a person would and compare its figures with the native
// engine's:
//   frame()         the next frame's figures (state() above), and what its update did
//   poses()         of all that the engine has, by name: sixteen numbers, row by row, local to
//                   world; and lights: where the points are
//   under(x, y)     the name of what can be dragged there, in CSS pixels
//   place(name, at) puts a thing there by itself, without what it carries
//   undrawn(name, at)  the same, and at once all that a frame does but for the drawing: everything
//                      is uploaded, no material is visible
//   asNative()      builds anew, as `shadowcut replay` does: the file's triangles are not joined to
//                   polygons, cells are as large as the engine likes
window.walkthrough = {
  frame: () => app.nextFrame(),
  poses: () => {
    const poses = {};
    app.world.scene.traverse((object) => {
      if (object.isMesh && app.shadows.objectOf(object) !== undefined)
        poses[nameOf(object)] = object.matrixWorld.clone().transpose().toArray();
    });
    return {
      poses,
      lights: app.world.lights.map((light) => light.getWorldPosition(new Vector3()).toArray()),
    };
  },
  under: (x, y) => {
    const hit = app.drag.hit(
      new Vector2((2 * x) / innerWidth - 1, 1 - (2 * y) / innerHeight),
      app.camera,
    );
    return hit?.movable && app.nameOfMovable(hit.movable);
  },
  place: (name, at) => void app.world.movables.get(name).position.fromArray(at),
  undrawn: (name, at) => {
    const all = [];
    app.world.scene.traverse(
      ({ material }) => material && all.push(...[material].flat().filter(({ visible }) => visible)),
    );
    window.walkthrough.place(name, at);
    all.forEach((material) => (material.visible = false));
    const frame = app.nextFrame();
    app.draw();
    all.forEach((material) => (material.visible = true));
    return frame;
  },
  asNative: () => {
    app.asNative = { joins: false, facetsPerCell: 128 };
    app.follow();
  },
};
