// What an update costs: a desk of the furnished room, moved a thousand times by small steps. node
// bench.mjs [moves]
import { readFile } from 'node:fs/promises';
import * as THREE from 'three';
import { OBJLoader } from 'three/addons/loaders/OBJLoader.js';
import { load } from 'shadowcut';
import { SceneShadows } from './src/index.js';

const moves = Number(process.argv[2] ?? 1000);
const text = await readFile(new URL('../../data/room4.obj', import.meta.url), 'utf8');
const shadowcut = await load();

function room(lamps) {
  const scene = new THREE.Scene();
  const furniture = new OBJLoader().parse(text);
  furniture.traverse((object) => (object.castShadow = object.receiveShadow = true));
  scene.add(furniture);
  for (const at of lamps) {
    const lamp = new THREE.PointLight();
    lamp.position.set(...at);
    scene.add(lamp);
  }
  return scene;
}
const at = (sorted, share) =>
  sorted[Math.min(sorted.length - 1, Math.floor(share * sorted.length))];
const figures = (values) => {
  const sorted = Float64Array.from(values).sort();
  const [median, p99, most] = [0.5, 0.99, 1].map((share) => at(sorted, share).toFixed(3));
  return `median ${median}  p99 ${p99}  most ${most}`;
};

for (const [name, lamps] of [['one lamp', [[5.3613, 3.7171, 2.43]]]]) {
  const scene = room(lamps);
  const desk = scene.getObjectByName('desk.4');
  const shadows = new SceneShadows(shadowcut, scene, { dynamic: (mesh) => mesh === desk });
  const first = shadows.update();
  console.log(
    `${name}: first update ${first.ms.toFixed(1)} ms (engine ${first.engineMs.toFixed(1)}), ` +
      `${shadows.mesh.geometry.attributes.position.count} vertices, ${first.added} fragments`,
  );
  const ms = [],
    engineMs = [],
    bytes = [],
    ranges = [],
    added = [];
  const { data } = shadows.mesh.geometry.attributes.position;
  for (let i = 0; i < moves + 100; ++i) {
    desk.position.x = 0.3 * Math.sin(i / 100);
    desk.position.y = 0.2 * Math.sin(i / 70);
    const done = shadows.update();
    const uploads = [shadows.mesh.geometry.attributes.position.data, shadows.mesh.geometry.index];
    if (i >= 100) {
      (ms.push(done.ms),
        added.push(done.added),
        engineMs.push(done.engineMs),
        bytes.push(done.uploadedBytes / 1024));
      ranges.push(uploads.reduce((sum, { updateRanges }) => sum + updateRanges.length, 0));
    }
    for (const each of uploads) each.clearUpdateRanges();
  }
  console.log(
    `  update ms    ${figures(ms)}\n  engine ms    ${figures(engineMs)}\n` +
      `  kB uploaded  ${figures(bytes)}\n  added        ${figures(added)}\n` +
      `  ranges       ${figures(ranges)}`,
  );
  const still = [];
  for (let i = 0; i < 200; ++i) still.push(shadows.update().ms);
  console.log(`  nothing ms   ${figures(still)}`);
  shadows.dispose();
}
