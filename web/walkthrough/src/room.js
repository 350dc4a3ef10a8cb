// What is shown: the furnished room and its lamp, or somebody's own scene. Loads GLBs, makes their
// meshes cast and receive, and gives lights something to be seen and held by.
import {
  Box3,
  BufferGeometry,
  Color,
  Group,
  HemisphereLight,
  Line,
  LineBasicMaterial,
  Mesh,
  MeshBasicMaterial,
  MeshLambertMaterial,
  PointLight,
  Scene,
  SphereGeometry,
  Vector3,
} from 'three';
import { GLTFLoader } from 'three/addons/loaders/GLTFLoader.js';

export const eyeHeight = 1.65; // metres

// Names as the file has them: GLTFLoader takes the dots out of "desk.1", and keeps the name here.
export const nameOf = (object) => object.userData.name || object.name || object.type;

// Itself, too.
export function isWithin(object, root) {
  for (let at = object; at; at = at.parent) if (at === root) return true;
  return false;
}

export function parseGlb(bytes, prepare) {
  const loader = new GLTFLoader();
  prepare?.(loader);
  return loader.parseAsync(bytes, '');
}

export function meshesOf(root) {
  const meshes = [];
  root.traverse((object) => object.isMesh && meshes.push(object));
  return meshes;
}

// The furniture is matt: Lambert's shading is a fifth of the standard material's program, which
// counts on phones and at the first picture.
function matt(root) {
  const made = new Map();
  for (const mesh of meshesOf(root)) {
    const { name, color, vertexColors } = mesh.material;
    if (!made.has(mesh.material))
      made.set(mesh.material, new MeshLambertMaterial({ name, color, vertexColors }));
    mesh.material = made.get(mesh.material);
  }
}

export function castAndReceive(root) {
  for (const mesh of meshesOf(root)) {
    mesh.castShadow = mesh.receiveShadow = true;
    // Sheets that lie on what carries them, a poster on its wall: in the depth buffer they come
    // first.
    for (const material of [mesh.material].flat()) {
      if (!/^(poster|screen)/.test(material.name)) continue;
      Object.assign(material, {
        polygonOffset: true,
        polygonOffsetFactor: -1,
        polygonOffsetUnits: -2,
      });
    }
  }
}

const shadowLights = (root) => {
  const lights = [];
  root.traverse(
    (object) =>
      (object.isPointLight || object.isSpotLight || object.isDirectionalLight) &&
      lights.push(object),
  );
  return lights;
};

// A bulb, something larger around it for fingers to hold, and a wire up to the ceiling. They
// neither cast nor receive, so that the lamp's light is a point's.
function dressLamp(light, ceiling) {
  const bulb = new Mesh(
    new SphereGeometry(0.07, 24, 16),
    new MeshBasicMaterial({ color: 0xfff1b8 }),
  );
  const grip = new Mesh(new SphereGeometry(0.2, 12, 8), bulb.material);
  grip.visible = false; // rays hit it all the same
  const wire = new Line(
    new BufferGeometry().setFromPoints([new Vector3(), new Vector3(0, 1, 0)]),
    new LineBasicMaterial({ color: 0x14181d }),
  );
  const hang = () => (wire.scale.y = Math.max(ceiling - light.position.y, 1e-3));
  wire.onBeforeRender = hang;
  hang();
  light.add(bulb, grip, wire);
}

function surroundings(scene) {
  scene.background = new Color(0x8c857a);
  scene.add(new HemisphereLight(0xffffff, 0xb8ab98, 1.3));
}

// Everything about the scene that is walked through: what can be moved, where one may go, where one
// starts.
export class World {
  scene = new Scene();
  movables = new Map(); // name -> object
  lights = [];
  isRoom = false;
  bounds = new Box3();
  start = { at: new Vector3(), yaw: 0, pitch: 0 };
  #begun = [];

  static room(gltf) {
    const world = new World();
    surroundings(world.scene);
    matt(gltf);
    castAndReceive(gltf);
    const parts = [...gltf.children];
    world.bounds.setFromObject(gltf);
    world.bounds.min.y = 0;
    world.scene.add(...parts);
    for (const part of parts) {
      if (part.isLight) world.#addLight(part, world.bounds.max.y);
      else if (!world.#holdsFast(part)) world.movables.set(nameOf(part), part);
    }
    world.isRoom = true;
    world.start = { at: new Vector3(0.9, eyeHeight, -7.2), yaw: -2.1, pitch: -0.22 };
    return world.#begin();
  }

  // Somebody's scene instead of the room: as large as a room, on the ground, and with a lamp above
  // its middle where it has no light.
  static alone(model) {
    const world = new World();
    surroundings(world.scene);
    castAndReceive(model);
    const root = fit(model, 8, true);
    world.scene.add(root);
    world.bounds.setFromObject(root);
    const size = world.bounds.getSize(new Vector3()),
      middle = world.bounds.getCenter(new Vector3());
    const lights = shadowLights(root),
      scale = root.children[0].scale.x;
    for (const light of lights) {
      if (light.isDirectionalLight) continue;
      light.intensity *= scale * scale; // as bright on what is now so much nearer
      light.distance *= scale;
    }
    if (lights.length === 0) {
      const lamp = new PointLight(0xffffff, 6 + 0.4 * size.lengthSq());
      lamp.name = 'lamp';
      lamp.position.set(middle.x, world.bounds.max.y + Math.max(0.35 * size.y, 0.5), middle.z);
      world.scene.add(lamp);
      world.#addLight(lamp, lamp.position.y + 0.5);
    }
    world.lights.push(...lights);
    for (const mesh of meshesOf(root)) world.#addMovable(mesh);
    world.bounds.expandByScalar(6).min.y = 0;
    world.start = {
      at: new Vector3(
        middle.x,
        Math.max(eyeHeight, 0.7 * size.y),
        middle.z + size.z / 2 + 0.5 * size.x + 2,
      ),
      yaw: 0,
      pitch: -0.2,
    };
    return world.#begin();
  }

  // Puts a model into this world, on the floor at a place.
  addModel(model, name, at) {
    castAndReceive(model);
    for (const light of shadowLights(model)) light.removeFromParent();
    const root = fit(model, 1.6, false);
    ((root.position.x = at.x), (root.position.z = at.z));
    root.userData.name = name;
    this.scene.add(root);
    this.#addMovable(root);
    return root;
  }
  removeModel(root) {
    root.removeFromParent();
    disposeOf(root);
    for (const [name, object] of this.movables) if (object === root) this.movables.delete(name);
  }

  #addMovable(object) {
    const name = nameOf(object);
    let key = name;
    for (let k = 2; this.movables.has(key); ++k) key = `${name} (${k})`;
    this.movables.set(key, object);
  }
  #addLight(light, ceiling) {
    dressLamp(light, ceiling);
    this.lights.push(light);
    this.movables.set(nameOf(light), light);
  }
  // A floor, a wall, the room itself: as large as the scene along two axes.
  #holdsFast(object) {
    const all = this.bounds.getSize(new Vector3()),
      size = new Box3().setFromObject(object).getSize(new Vector3());
    return ['x', 'y', 'z'].filter((axis) => size[axis] > 0.9 * all[axis]).length >= 2;
  }
  #begin() {
    for (const object of this.movables.values())
      this.#begun.push([object, object.position.clone()]);
    return this;
  }
  reset() {
    for (const [object, position] of this.#begun) object.position.copy(position);
  }

  dispose() {
    disposeOf(this.scene);
  }
}

// What the graphics processor has of it.
function disposeOf(root) {
  for (const mesh of meshesOf(root)) {
    mesh.geometry.dispose();
    for (const material of [mesh.material].flat()) {
      for (const value of Object.values(material)) if (value?.isTexture) value.dispose();
      material.dispose();
    }
  }
}

// In a group that scales it down, or up, to `length` along its longest side, and puts its foot on
// the floor. What has a sensible size keeps it, unless it is to fill the view.
function fit(model, length, always) {
  model.updateMatrixWorld(true);
  const box = new Box3().setFromObject(model),
    size = box.getSize(new Vector3()),
    middle = box.getCenter(new Vector3());
  const longest = Math.max(size.x, size.y, size.z);
  const scale = always || longest > length || longest < length / 10 ? length / longest : 1;
  const root = new Group();
  model.position.sub(new Vector3(middle.x, box.min.y, middle.z));
  const inner = new Group().add(model);
  inner.scale.setScalar(scale);
  return root.add(inner);
}
