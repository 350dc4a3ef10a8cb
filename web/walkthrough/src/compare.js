// The split view: on the left the scene with its shadows as geometry, on the right the same meshes
// and lights with three.js' shadow map. Both by one camera, so that an edge runs on across the
// divider; and the zoom, which enlarges a part of the view.
import { Scene } from 'three';
import { meshesOf } from './room.js';

const mostZoom = 64;

export class Compare {
  on = false;
  share = 0.5; // of the width, that is the left half's
  zoom = 1;
  mapSize = 1024;
  #renderer;
  #centre = [0.5, 0.5]; // of what is enlarged, in shares of the view
  #copy = null;

  constructor(renderer) {
    this.#renderer = renderer;
  }

  // The copy is made when it is first shown, and again when what it is a copy of is another, or has
  // more or fewer parts.
  forget() {
    if (!this.#copy) return;
    for (const [, light] of this.#copy.lights) light.dispose();
    for (const material of this.#copy.materials.values()) material.dispose();
    this.#copy = null;
  }
  setMapSize(size) {
    this.mapSize = size;
    this.forget();
  }

  // Enlarges around a point of the view, which stays where it is.
  zoomTo(zoom, x = 0.5, y = 0.5) {
    const next = Math.min(Math.max(zoom, 1), mostZoom);
    const clamp = (c) => Math.min(Math.max(c, 0.5 / next), 1 - 0.5 / next);
    const keep = (c, at) => clamp(c + (at - 0.5) / this.zoom - (at - 0.5) / next);
    this.#centre = [keep(this.#centre[0], x), keep(this.#centre[1], y)];
    this.zoom = next;
  }
  aim(camera, width, height) {
    const [x, y] = this.#centre,
      { zoom } = this;
    if (zoom === 1) camera.clearViewOffset();
    else
      camera.setViewOffset(
        width * zoom,
        height * zoom,
        (x * zoom - 0.5) * width,
        (y * zoom - 0.5) * height,
        width,
        height,
      );
  }

  render(scene, camera, width, height) {
    const renderer = this.#renderer;
    renderer.shadowMap.enabled = this.on;
    if (!this.on) return renderer.render(scene, camera);
    const left = Math.round(width * this.share);
    const copy = this.#follow(scene);
    renderer.setScissorTest(true);
    renderer.setScissor(0, 0, left, height);
    renderer.render(scene, camera);
    renderer.setScissor(left, 0, width - left, height);
    renderer.render(copy, camera);
    renderer.setScissorTest(false);
    return undefined;
  }
  // Draws the map alone, for the clock; nothing of it is seen.
  renderMap(scene, camera) {
    const renderer = this.#renderer;
    const { enabled } = renderer.shadowMap;
    renderer.shadowMap.enabled = true;
    renderer.setScissorTest(true);
    renderer.setScissor(0, 0, 1, 1);
    renderer.render(this.#follow(scene), camera);
    renderer.setScissorTest(false);
    renderer.shadowMap.enabled = enabled;
  }

  #follow(scene) {
    this.#copy ??= this.#copied(scene);
    const { meshes, lights } = this.#copy;
    for (const [from, to] of [...meshes, ...lights]) {
      to.matrixWorld.copy(from.matrixWorld);
      to.visible = from.visible;
    }
    return this.#copy.scene;
  }
  #copied(scene) {
    const copy = { scene: new Scene(), meshes: [], lights: [], materials: new Map() };
    copy.scene.background = scene.background;
    copy.scene.matrixWorldAutoUpdate = false;
    const material = (from) => {
      if (!copy.materials.has(from)) copy.materials.set(from, from.clone());
      return copy.materials.get(from);
    };
    for (const mesh of meshesOf(scene)) {
      if (mesh.userData.drawn) continue;
      const to = mesh.clone(false);
      to.material = Array.isArray(mesh.material)
        ? mesh.material.map(material)
        : material(mesh.material);
      to.layers.set(0);
      copy.meshes.push([mesh, to]);
      copy.scene.add(to);
    }
    scene.traverse(
      (object) =>
        object.isLight && copy.lights.push([object, this.#copiedLight(object, copy.scene)]),
    );
    return copy;
  }
  #copiedLight(light, scene) {
    const to = light.clone(false);
    scene.add(to);
    if (!light.shadow) return to;
    to.castShadow = true;
    to.shadow.mapSize.set(this.mapSize, this.mapSize);
    to.shadow.camera.near = 0.05;
    if (light.target) to.target = light.target;
    return to;
  }
}

// The divider, as a slider: pointer and keys.
export function followDivider(divider, onShare) {
  let held;
  let share = 0.5;
  const put = (value) => {
    share = Math.min(Math.max(value, 0.02), 0.98);
    divider.setAttribute('aria-valuenow', String(Math.round(100 * share)));
    onShare(share);
  };
  divider.addEventListener('pointerdown', (event) => {
    held = event.pointerId;
    divider.setPointerCapture(held);
  });
  divider.addEventListener(
    'pointermove',
    (event) => event.pointerId === held && put(event.clientX / innerWidth),
  );
  for (const end of ['pointerup', 'pointercancel'])
    divider.addEventListener(end, () => (held = undefined));
  divider.addEventListener('keydown', (event) => {
    const by = { ArrowLeft: -0.02, ArrowRight: 0.02, PageDown: -0.1, PageUp: 0.1 }[event.code];
    if (by === undefined) return;
    put(share + by);
    event.preventDefault();
  });
}
