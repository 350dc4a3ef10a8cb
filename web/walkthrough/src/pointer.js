// What mouse, pen and fingers on the view mean: whoever takes hold of furniture or a lamp drags it,
// whoever takes hold of anything else looks around; two fingers walk. The stick is a thumb's.
import { Vector2 } from 'three';

const lookPerWidth = 2.4; // radians for a drag across the whole view
const walkPerWidth = 8; // metres, likewise, for two fingers

export class Pointer {
  #fingers = new Map(); // pointer id -> where it was last
  #at = new Vector2();

  // hold: { walk, drag, camera, zoomed(), moved(), chosen(object) }
  constructor(canvas, stick, hold) {
    this.canvas = canvas;
    this.hold = hold;
    canvas.addEventListener('pointerdown', (event) => this.#down(event));
    canvas.addEventListener('pointermove', (event) => this.#move(event));
    for (const end of ['pointerup', 'pointercancel', 'lostpointercapture'])
      canvas.addEventListener(end, (event) => this.#up(event));
    canvas.addEventListener('contextmenu', (event) => event.preventDefault());
    this.#follow(stick);
  }

  // In clip coordinates.
  point(event) {
    const { clientWidth, clientHeight } = this.canvas;
    return this.#at.set(
      (2 * event.clientX) / clientWidth - 1,
      1 - (2 * event.clientY) / clientHeight,
    );
  }
  #down(event) {
    const { drag, camera, chosen } = this.hold;
    this.canvas.focus({ preventScroll: true });
    this.canvas.setPointerCapture(event.pointerId);
    this.#fingers.set(event.pointerId, { x: event.clientX, y: event.clientY });
    if (this.#fingers.size > 1) return drag.release(); // two fingers walk
    if (event.button !== 0) return;
    const hit = drag.hit(this.point(event), camera);
    if (!hit?.movable) return;
    drag.grab(hit, camera, event.shiftKey);
    chosen(hit.movable);
  }
  #move(event) {
    const { walk, drag, camera, moved, zoomed } = this.hold;
    const before = this.#fingers.get(event.pointerId);
    if (!before) return this.#hover(event);
    const scale = 1 / this.canvas.clientWidth / this.#fingers.size;
    const right = (event.clientX - before.x) * scale,
      down = (event.clientY - before.y) * scale;
    ((before.x = event.clientX), (before.y = event.clientY));
    if (drag.held) drag.drag(this.point(event), camera);
    else if (this.#fingers.size > 1) walk.go(-right * walkPerWidth, down * walkPerWidth);
    else walk.look((right * lookPerWidth) / zoomed(), (down * lookPerWidth) / zoomed());
    moved();
  }
  #hover(event) {
    if (event.pointerType !== 'mouse') return;
    const { drag, camera } = this.hold;
    this.canvas.classList.toggle(
      'over',
      drag.hit(this.point(event), camera)?.movable !== undefined,
    );
  }
  #up(event) {
    if (!this.#fingers.delete(event.pointerId)) return;
    this.hold.drag.release();
    this.hold.moved();
  }

  #follow(stick) {
    const knob = stick.firstElementChild;
    let finger;
    const put = (x, y) => {
      knob.style.transform = `translate(${x * 2}rem, ${y * 2}rem)`;
      this.hold.walk.thumb(x, -y);
      this.hold.moved();
    };
    const follow = (event) => {
      const box = stick.getBoundingClientRect(),
        radius = box.width / 2;
      const x = (event.clientX - box.left) / radius - 1,
        y = (event.clientY - box.top) / radius - 1;
      const length = Math.max(Math.hypot(x, y), 1);
      put(x / length, y / length);
    };
    stick.addEventListener('pointerdown', (event) => {
      finger = event.pointerId;
      stick.setPointerCapture(finger);
      follow(event);
    });
    stick.addEventListener('pointermove', (event) => event.pointerId === finger && follow(event));
    for (const end of ['pointerup', 'pointercancel']) {
      stick.addEventListener(end, (event) => {
        if (event.pointerId !== finger) return;
        finger = undefined;
        put(0, 0);
      });
    }
  }
}
