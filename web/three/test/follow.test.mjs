// Random scenes changed at random: after every change, what is drawn must be what the scene says,
// as a SceneShadows built for it would.
import assert from 'node:assert/strict';
import test from 'node:test';
import { load } from 'shadowcut';
import { SceneShadows } from '../src/index.js';
import { RandomScene, randomFrom } from './scenes.mjs';
import { Uploads, areas, checkAll, drawnArea } from './checks.mjs';

const shadowcut = await load();
const seeds = (process.env.SHADOWCUT_SEEDS ?? '1 2 3 4').split(' ').map(Number);
const steps = Number(process.env.SHADOWCUT_STEPS ?? 120);

for (const seed of seeds) {
  test(`random changes are followed: seed ${seed}`, () => {
    const made = new RandomScene(seed);
    const shadows = new SceneShadows(shadowcut, made.scene);
    const uploads = new Uploads();
    const { next } = randomFrom(seed + 1000);
    const seen = [];
    try {
      for (let i = 0; i <= steps; ++i) {
        if (i > 0) for (let k = 0; k <= 2 * next(); ++k) seen.push(made.step());
        if (i % 10 === 5) shadows.outlines = !shadows.outlines;
        shadows.update();
        uploads.follow(shadows);
        checkAll(shadowcut, shadows, made.meshes, { sample: 60, random: next });
        const again = shadows.update();
        assert.equal(again.uploadedBytes, 0);
        assert.equal(again.applied, 0);
        if (i % 5 === 0) compareWithFresh(made, shadows);
      }
      shadows.engine.validate();
      // of groups, or in a range, that there are not
      for (const { message } of shadows.issues) assert.equal(message, 'has no triangles');
    } catch (error) {
      const last = seen.slice(-6).join(', ');
      error.message = `seed ${seed}, after ${last} (${seen.length} changes): ${error.message}`;
      throw error;
    } finally {
      shadows.dispose();
    }
    for (const mesh of made.meshes)
      assert.equal(mesh.layers.mask, 1, 'its layers have been given back');
    assert.ok(!made.scene.children.includes(shadows.mesh));
  });
}

function compareWithFresh(made, shadows) {
  const fresh = new SceneShadows(shadowcut, made.scene);
  try {
    fresh.update();
    const expected = areas(fresh, made.meshes),
      got = areas(shadows, made.meshes);
    assert.deepEqual(Object.keys(got).sort(), Object.keys(expected).sort());
    for (const [key, values] of Object.entries(expected)) {
      values.forEach((value, k) =>
        assert.ok(
          Math.abs(value - got[key][k]) < 1e-7 * (1 + value),
          `area of ${key}: ${got[key][k]}, not ${value}`,
        ),
      );
    }
    const drawn = drawnArea(shadows),
      area = drawnArea(fresh);
    assert.ok(Math.abs(drawn - area) <= 1e-4 * area, `drawn: ${drawn}, not ${area}`);
  } finally {
    fresh.dispose();
  }
}
