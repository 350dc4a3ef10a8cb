// What `shadowcut cast` writes as glTF: the Khronos validator finds nothing wrong with it, and
// three.js' loader finds every object by its name, with materials for lit and shadowed.
import assert from 'node:assert/strict';
import { mkdtempSync, readFileSync, rmSync } from 'node:fs';
import { tmpdir } from 'node:os';
import { join } from 'node:path';
import { fileURLToPath } from 'node:url';
import test, { after } from 'node:test';
import validator from 'gltf-validator';
import { Vector3 } from 'three';
import { GLTFLoader } from 'three/addons/loaders/GLTFLoader.js';
import { nameOf } from '../src/room.js';
import { native, roomFile } from './page.mjs';

const folder = mkdtempSync(join(tmpdir(), 'gltf-'));
after(() => rmSync(folder, { recursive: true }));
const data = (name) => fileURLToPath(new URL(`../../../data/${name}`, import.meta.url));

const scenes = [
  [data('room4.obj'), 'point:5.3613,3.7171,2.43'],
  [data('room4.obj'), 'point:5.3613,3.7171,2.43', 'point:2,2,2.4', 'sun:0.3,0.4,-1'],
  [data('room1.obj'), 'point:1.7,1.2,2.4', 'point:1,1,1'],
  [data('city8.obj'), 'point:2.876,5.957,7.39', 'sun:0.5,0.3,-1'],
  [data('spheres5.obj'), 'sun:0.5,0.3,-1'],
  [data('triangles200.obj'), 'point:0.3,0.4,5', 'point:-1,2,3'],
  [data('branch3.obj'), 'sun:0.1,-0.3,-1'],
  [data('tetrahedron4.obj'), 'point:2.71,-0.43,3.37'],
  [data('lamp.gltf')],
  [roomFile],
];

// In Node: three.js' loader of files, data: ones too, tells of its progress in browsers' events.
globalThis.ProgressEvent ??= class extends Event {};
const parse = (bytes) =>
  new GLTFLoader().parseAsync(
    bytes.buffer.slice(bytes.byteOffset, bytes.byteOffset + bytes.byteLength),
    '',
  );

for (const [scene, ...lights] of scenes) {
  for (const extension of ['glb', 'gltf']) {
    for (const form of extension === 'glb' ? ['merged', 'pieces', 'conforming'] : ['merged']) {
      const name = scene.split('/').at(-1);
      test(`${name}, ${lights.length} lights given, .${extension}, ${form}`, async () => {
        const file = join(folder, `out.${extension}`);
        native(
          'cast',
          scene,
          '--quiet',
          ...lights.flatMap((light) => ['--light', light]),
          '--form',
          form,
          '-o',
          file,
        );
        const bytes = readFileSync(file);
        const { issues } = await validator.validateBytes(new Uint8Array(bytes), {
          uri: file,
          maxIssues: 20,
        });
        assert.equal(
          issues.numErrors + issues.numWarnings,
          0,
          JSON.stringify(issues.messages, null, 1),
        );

        const { objects } = JSON.parse(native('inspect', scene, '--json', '-'));
        const loaded = (await parse(bytes)).scene;
        assert.deepEqual(
          new Set(loaded.children.map(nameOf)),
          new Set(objects.map(({ name }) => name)),
        );
        const materials = new Set();
        loaded.traverse((object) => {
          if (!object.isMesh) return;
          materials.add(object.material.name);
          const corner = new Vector3();
          for (let i = 0; i < object.geometry.attributes.position.count; ++i)
            assert.ok(
              corner.fromBufferAttribute(object.geometry.attributes.position, i).length() < 1e3,
            );
        });
        assert.ok([...materials].some((name) => name.startsWith('lit')));
        for (const name of materials) assert.match(name, /^(lit|shadowed|lit by \d+(\+\d+)*)$/);
      });
    }
  }
}

test('the room that the page shows', async () => {
  const { issues } = await validator.validateBytes(new Uint8Array(readFileSync(roomFile)), {
    maxIssues: 20,
  });
  assert.equal(issues.numErrors + issues.numWarnings, 0, JSON.stringify(issues.messages, null, 1));
});
