// Moves furniture and lamps along the floor, or upright; what stands on a thing comes along. Things
// may be pushed into one another: the engine cuts what crosses as well.
import { Box3, Plane, Raycaster, Vector3 } from 'three';
import { isWithin, meshesOf } from './room.js';

const floorNormal = new Vector3(0, 1, 0);
const farthest = 40; // metres from the eye that a thing can be dragged to
const touching = 0.01; // metres

export class Drag {
  world = null;
  held = null; // what is dragged
  #raycaster = new Raycaster();
  #layer;
  #plane = new Plane();
  #offset = new Vector3();
  #carried = [];

  // layer: the one that received meshes are moved to.
  constructor(layer) {
    this.#layer = layer;
    this.#raycaster.layers.enable(layer);
  }

  enter(world) {
    this.world = world;
    this.held = null;
  }

  // What is under the pointer, whether or not it can be moved; point: in clip coordinates.
  hit(point, camera) {
    this.#raycaster.setFromCamera(point, camera);
    return this.hitAlong();
  }
  hitAlong(ray = this.#raycaster.ray) {
    this.#raycaster.ray.copy(ray);
    const isThing = (mesh) => mesh.castShadow || mesh.receiveShadow || mesh.parent?.isLight;
    const meshes = meshesOf(this.world.scene).filter(
      (mesh) => isThing(mesh) && mesh.layers.test(this.#raycaster.layers) && !mesh.userData.drawn,
    );
    const [first] = this.#raycaster.intersectObjects(meshes, false);
    return first && { point: first.point, movable: this.#movable(first.object) };
  }
  #movable(object) {
    const movables = new Set(this.world.movables.values());
    for (let at = object; at; at = at.parent) if (movables.has(at)) return at;
    return undefined;
  }

  // Takes hold of what was hit; upright: it will go up and down, and not along the floor.
  grab({ point, movable }, camera, upright) {
    this.held = movable;
    this.#carried = upright ? [] : this.carriedBy(movable);
    const eye = camera.getWorldPosition(new Vector3());
    // A horizontal plane at the eye's own height is seen from its edge: there the thing goes
    // sideways only.
    const edgeOn = Math.abs(eye.y - point.y) < 0.12 * eye.distanceTo(point);
    if (upright || edgeOn)
      this.#plane.setFromNormalAndCoplanarPoint(
        new Vector3(eye.x - point.x, 0, eye.z - point.z).normalize(),
        point,
      );
    else this.#plane.setFromNormalAndCoplanarPoint(floorNormal, point);
    this.#offset.copy(movable.getWorldPosition(new Vector3())).sub(point);
    this.upright = upright;
  }
  drag(point, camera) {
    this.#raycaster.setFromCamera(point, camera);
    return this.dragAlong();
  }
  // Whether it moved.
  dragAlong(ray = this.#raycaster.ray) {
    const at = ray.intersectPlane(this.#plane, new Vector3());
    if (!at || at.distanceTo(ray.origin) > farthest) return false;
    at.add(this.#offset);
    const now = this.held.getWorldPosition(new Vector3());
    return this.moveBy(
      this.held,
      this.upright ? new Vector3(0, at.y - now.y, 0) : new Vector3(at.x - now.x, 0, at.z - now.z),
      this.#carried,
    );
  }
  release() {
    this.held = null;
  }

  // Moves a thing and what it carries, as far as the room goes.
  moveBy(object, by, carried = this.carriedBy(object)) {
    const { bounds } = this.world;
    const box = object.isLight
      ? new Box3().setFromCenterAndSize(object.position, new Vector3(0.1, 0.1, 0.1))
      : new Box3().setFromObject(object);
    for (const axis of ['x', 'y', 'z']) {
      by[axis] = Math.min(
        Math.max(by[axis], Math.min(bounds.min[axis] - box.min[axis], 0)),
        Math.max(bounds.max[axis] - box.max[axis], 0),
      );
    }
    if (by.lengthSq() === 0) return false;
    for (const each of [object, ...carried])
      this.#place(each, each.getWorldPosition(new Vector3()).add(by));
    return true;
  }
  #place(object, world) {
    object.parent.worldToLocal(world);
    object.position.copy(world);
    object.updateMatrixWorld(true);
  }

  // What rests on it or is within it, and what rests on that or is within that.
  carriedBy(object) {
    if (object.isLight) return [];
    const others = new Map();
    for (const other of this.world.movables.values()) {
      if (!other.isLight && !isWithin(other, object) && !isWithin(object, other))
        others.set(other, new Box3().setFromObject(other));
    }
    const carried = [],
      open = [new Box3().setFromObject(object)];
    while (open.length > 0) {
      const under = open.pop();
      for (const [other, box] of others) {
        if (!carries(under, box)) continue;
        carried.push(other);
        open.push(box);
        others.delete(other);
      }
    }
    return carried;
  }
}

function carries(under, box) {
  const middle = box.getCenter(new Vector3());
  const above =
    middle.x >= under.min.x &&
    middle.x <= under.max.x &&
    middle.z >= under.min.z &&
    middle.z <= under.max.z;
  const rests = above && Math.abs(box.min.y - under.max.y) < touching;
  return rests || under.clone().expandByScalar(touching).containsBox(box);
}
