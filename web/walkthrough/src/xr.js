// Virtual reality, where there is a headset: enters and leaves it, walks with the sticks, and grabs
// furniture with the triggers. Where there is none, says what is missing.
import { BufferGeometry, Line, LineBasicMaterial, Matrix4, Ray, Vector3 } from 'three';

const walkSpeed = 1.8; // metres a second

export async function prepareXr(panel) {
  const say = async () => {
    const words = await whyNot();
    panel.vr(words === '', words || 'A headset is there.');
  };
  await say();
  navigator.xr?.addEventListener?.('devicechange', say);
}

async function whyNot() {
  if (!isSecureContext) return 'VR needs this page to come over https, or from this machine.';
  if (!navigator.xr)
    return (
      'This browser has no WebXR. Browsers on headsets have it; ' +
      'so has Chrome on a computer with a headset.'
    );
  try {
    return (await navigator.xr.isSessionSupported('immersive-vr'))
      ? ''
      : 'WebXR is here, but no headset: connect one, or open this page in its browser.';
  } catch {
    return 'This page may not use WebXR here: its server or the page around it forbids it.';
  }
}

export class Vr {
  #renderer;
  #rig;
  #drag;
  #hands = [];
  #holding = null;

  // hold: { renderer, rig, drag, walk, camera, moved, began, ended }
  constructor(hold) {
    const { renderer, rig, drag } = hold;
    this.hold = hold;
    this.#renderer = renderer;
    this.#rig = rig;
    this.#drag = drag;
  }
  get presenting() {
    return this.#renderer.xr.isPresenting;
  }

  async enter() {
    const { xr } = this.#renderer;
    if (xr.isPresenting) return xr.getSession().end();
    const session = await navigator.xr.requestSession('immersive-vr', {
      optionalFeatures: ['local-floor'],
    });
    this.hold.began();
    session.addEventListener('end', () => this.hold.ended());
    xr.enabled = true;
    this.#makeHands();
    await xr.setSession(session);
    return undefined;
  }
  #makeHands() {
    if (this.#hands.length > 0) return;
    for (const k of [0, 1]) {
      const hand = this.#renderer.xr.getController(k);
      hand.add(
        new Line(
          new BufferGeometry().setFromPoints([new Vector3(), new Vector3(0, 0, -6)]),
          new LineBasicMaterial({ color: 0xffd75e }),
        ),
      );
      hand.addEventListener('selectstart', () => this.#grab(hand));
      hand.addEventListener('selectend', () => this.#holding === hand && this.#release());
      this.#rig.add(hand);
      this.#hands.push(hand);
    }
  }
  #rayOf(hand) {
    const turned = new Matrix4().extractRotation(hand.matrixWorld);
    return new Ray(
      new Vector3().setFromMatrixPosition(hand.matrixWorld),
      new Vector3(0, 0, -1).applyMatrix4(turned),
    );
  }
  #grab(hand) {
    const hit = this.#drag.hitAlong(this.#rayOf(hand));
    if (!hit?.movable) return;
    this.#drag.grab(hit, hand, false);
    this.#holding = hand;
  }
  #release() {
    this.#holding = null;
    this.#drag.release();
  }

  // Every frame of a session: sticks walk where the head looks, and what is held follows its ray.
  step(seconds) {
    if (this.#holding) this.#drag.dragAlong(this.#rayOf(this.#holding));
    const head = new Vector3();
    this.#renderer.xr.getCamera().getWorldDirection(head).setY(0).normalize();
    for (const { gamepad } of this.#renderer.xr.getSession().inputSources) {
      const [x, y] = gamepad?.axes.slice(-2) ?? [0, 0];
      if (Math.hypot(x, y) < 0.15) continue;
      const metres = walkSpeed * seconds;
      this.hold.walk.goBy(
        new Vector3(-head.z * x - head.x * y, 0, head.x * x - head.z * y).multiplyScalar(metres),
      );
    }
  }
}
