// Walking and looking: keys, a thumb's stick, two fingers, and turns of the head. Knows the eye;
// what the pointer means is pointer.js' business.
import { MathUtils, Vector3 } from 'three';

const speed = 2.2; // metres a second
const axes = {
  KeyW: [0, 1],
  ArrowUp: [0, 1],
  KeyS: [0, -1],
  ArrowDown: [0, -1],
  KeyA: [-1, 0],
  ArrowLeft: [-1, 0],
  KeyD: [1, 0],
  ArrowRight: [1, 0],
};
const lifts = { KeyE: 1, KeyQ: -1 };

export class Walk {
  world = null;
  #camera;
  #rig;
  #keys = new Set();
  #thumb = [0, 0];
  #yaw = 0;
  #pitch = 0;

  // The rig carries the camera; in VR the headset moves the camera within it.
  constructor(camera, rig) {
    this.#camera = camera;
    this.#rig = rig;
    camera.rotation.order = 'YXZ';
    addEventListener('keydown', (event) => {
      if (event.ctrlKey || event.altKey || event.metaKey || isField(event.target)) return;
      if (!(event.code in axes || event.code in lifts)) return;
      if (event.shiftKey && event.code.startsWith('Arrow')) return; // moves what is chosen
      this.#keys.add(event.code);
      event.preventDefault();
    });
    addEventListener('keyup', (event) => this.#keys.delete(event.code));
    addEventListener('blur', () => this.#keys.clear());
  }

  enter(world) {
    this.world = world;
    this.home();
  }
  home() {
    const { at, yaw, pitch } = this.world.start;
    this.#rig.position.set(at.x, 0, at.z);
    this.#camera.position.set(0, at.y, 0);
    ((this.#yaw = yaw), (this.#pitch = pitch));
    this.#turn();
  }

  // By radians: to the left, up.
  look(left, up) {
    this.#yaw += left;
    this.#pitch = MathUtils.clamp(this.#pitch + up, -1.5, 1.5);
    this.#turn();
  }
  #turn() {
    this.#camera.rotation.set(this.#pitch, this.#yaw, 0);
  }

  // -1 to 1: to the right, forwards.
  thumb(right, forwards) {
    this.#thumb = [right, forwards];
  }
  // By metres.
  go(right, forwards, up = 0) {
    this.goBy(inTheWorld(right, up, forwards, Math.sin(this.#yaw), Math.cos(this.#yaw)));
  }
  // In the world.
  goBy(by) {
    const { position } = this.#rig;
    ((position.x += by.x), (position.z += by.z));
    const { min, max } = this.world.bounds,
      margin = 0.15;
    position.x = MathUtils.clamp(position.x, min.x + margin, max.x - margin);
    position.z = MathUtils.clamp(position.z, min.z + margin, max.z - margin);
    this.#camera.position.y = MathUtils.clamp(
      this.#camera.position.y + by.y,
      min.y + margin,
      max.y - margin,
    );
  }
  // Whether anything moved.
  step(seconds, fast) {
    let [right, forwards] = this.#thumb,
      up = 0;
    for (const key of this.#keys) {
      ((right += axes[key]?.[0] ?? 0), (forwards += axes[key]?.[1] ?? 0), (up += lifts[key] ?? 0));
    }
    if (right === 0 && forwards === 0 && up === 0) return false;
    const metres = speed * seconds * (fast ? 2.5 : 1);
    this.go(right * metres, forwards * metres, up * metres * 0.5);
    return true;
  }
  get yaw() {
    return this.#yaw;
  }
  get moving() {
    return this.#keys.size > 0 || this.#thumb[0] !== 0 || this.#thumb[1] !== 0;
  }
}

// What is to the right, up and forwards of an eye that is turned to the left by an angle.
export const inTheWorld = (right, up, forwards, sin, cos) =>
  new Vector3(right * cos - forwards * sin, up, -right * sin - forwards * cos);

// Keys there are the field's own.
export function isField(element) {
  return (
    element instanceof HTMLSelectElement ||
    (element instanceof HTMLInputElement && element.type !== 'checkbox') ||
    element.getAttribute?.('role') === 'slider'
  );
}
