// The scenes and edits for which tests/support/web_reference.cpp wrote the native engine's results:
// the module gives the same fragments and the same areas, to the last bit.
//
//   SHADOWCUT_REFERENCE=reference.json node --test native.test.mjs
import assert from 'node:assert/strict';
import { readFileSync } from 'node:fs';
import test from 'node:test';
import { load } from '../src/index.js';

const shadowcut = await load();
const histories = JSON.parse(readFileSync(process.env.SHADOWCUT_REFERENCE, 'utf8'));

const bits = new DataView(new ArrayBuffer(8));
function hashOf(fragment, corners) {
  let hash = 2166136261;
  const add = (word) => (hash = Math.imul(hash ^ word, 16777619));
  (add(fragment.face), add(0), add(fragment.lit ? 1 : 0), add(0));
  for (
    let k = 3 * fragment.firstCorner;
    k < 3 * (fragment.firstCorner + fragment.cornerCount);
    ++k
  ) {
    bits.setFloat64(0, corners[k], true);
    (add(bits.getUint32(0, true)), add(bits.getUint32(4, true)));
  }
  return hash;
}

function stateOf(engine, light) {
  const shadows = engine.shadows(light);
  let fragments = 0,
    hashes = 0;
  for (let block = 0; block < shadows.blockCount; ++block) {
    const corners = shadows.corners(block);
    for (const fragment of shadows.fragments(block))
      ((hashes = (hashes + hashOf(fragment, corners)) >>> 0), ++fragments);
  }
  const areas = shadows.areas().flatMap(({ lit, shadowed }) => [lit, shadowed]);
  const uncertain = engine.uncertainArea(light).reduce((a, b) => a + b, 0);
  return { fragments, hashes, areas, uncertain };
}

function apply(scene, ids, objects, step) {
  if (step.add !== undefined)
    ids[step.add] = scene.add(objects[step.add].mesh, objects[step.add].settings);
  else if (step.remove !== undefined) scene.remove(ids[step.remove]);
  else if (step.light) scene.setLight(scene.lightId(0), step.light);
  else if (step.castsShadows !== undefined) {
    scene.setCastsShadows(ids[step.object], step.castsShadows);
    objects[step.object].settings.castsShadows = step.castsShadows;
  } else if (step.pose) {
    scene.setPose(ids[step.object], step.pose);
    objects[step.object].settings.pose = step.pose;
  }
}

for (const { name, kernel, objects, lights, steps } of histories) {
  test(`${name}, kernel ${kernel}`, () => {
    const scene = new shadowcut.Scene();
    const ids = objects.map(({ mesh, settings }) => scene.add(mesh, settings));
    for (const light of lights) scene.addLight(light);
    const engine = new shadowcut.Engine(scene, { kernel });
    steps.forEach((step, k) => {
      apply(scene, ids, objects, step);
      engine.update();
      step.lights.forEach((native, light) => {
        const { uncertain, ...here } = stateOf(engine, light);
        const { uncertain: _, ...there } = native;
        assert.deepEqual(here, there, `after edit ${k}, light ${light}`);
        assert.ok(
          Math.abs(uncertain - native.uncertain) <= 1e-9 * native.uncertain,
          `uncertain after edit ${k}, light ${light}`,
        );
      });
    });
    engine.dispose();
    scene.dispose();
  });
}
