// WebAssembly beside native code: whole builds (castShadows) of made scenes on one thread, with the
// fast kernel.
//
//   node bench.mjs BIN      BIN holds make_scenes and shadowcut_bench: build/release/bin
//
// Both sides time themselves (buildMs + emitMs), in turns, and the minimum over all repeats counts:
// machines' speeds drift. Both must make the same fragments.
import { execFileSync } from 'node:child_process';
import { mkdtempSync, readFileSync, rmSync } from 'node:fs';
import { tmpdir } from 'node:os';
import { join } from 'node:path';
import { load } from './src/index.js';

const names = ['room:1', 'room:4', 'city:18', 'city:32', 'city:57', 'spheres:6', 'triangles:1000'];
const turns = 3;
const seconds = 1; // of each side's turn

const bin = process.argv[2];
if (!bin) {
  console.error('usage: node bench.mjs BIN');
  process.exit(1);
}
const shadowcut = await load();
const folder = mkdtempSync(join(tmpdir(), 'shadowcut-'));

// What make_scenes writes: `o`, `v` and `f`, and the light in the first line.
function sceneOf(obj) {
  const scene = new shadowcut.Scene();
  const at = obj
    .match(/light point:(\S+)/)[1]
    .split(',')
    .map(Number);
  let base = 1;
  for (const part of obj.split(/^o .*\n/m).slice(1)) {
    const rows = part.split('\n').map((line) => line.split(' '));
    const positions = rows
      .filter(([key]) => key === 'v')
      .flatMap((row) => row.slice(1).map(Number));
    const faces = rows
      .filter(([key]) => key === 'f')
      .map((row) => row.slice(1).map((v) => Number(v) - base));
    scene.add({ positions, faces });
    base += positions.length / 3;
  }
  return { scene, light: { position: at } };
}

function here({ scene, light }, best) {
  const end = performance.now() + 1000 * seconds;
  do {
    const shadows = shadowcut.castShadows(scene, light, {});
    const { buildMs, emitMs, litFragments, shadowedFragments } = shadows.stats;
    shadows.dispose();
    best.web = Math.min(best.web, buildMs + emitMs);
    best.fragments = litFragments + shadowedFragments;
  } while (performance.now() < end);
}

function native(name, best) {
  const options = [
    `--benchmark_filter=^${name}/threads:1/`,
    `--benchmark_min_time=${seconds}`,
    '--benchmark_format=json',
  ];
  const text = execFileSync(join(bin, 'shadowcut_bench'), options, {
    stdio: ['ignore', 'pipe', 'ignore'],
  });
  const [row] = JSON.parse(text).benchmarks;
  best.native = Math.min(best.native, row.build_ms + row.emit_ms);
  const fragments = row.lit + row.shadowed;
  if (fragments !== best.fragments)
    throw new Error(`${name}: ${best.fragments} fragments here, ${fragments} natively`);
}

try {
  console.log('scene            fragments   native ms      wasm ms   wasm/native');
  for (const name of names) {
    execFileSync(join(bin, 'make_scenes'), [folder, name]);
    const scene = sceneOf(readFileSync(join(folder, `${name.replace(':', '')}.obj`), 'utf8'));
    const best = { web: Infinity, native: Infinity };
    for (let turn = 0; turn < turns; ++turn) (here(scene, best), native(name, best));
    console.log(
      name.padEnd(15),
      String(best.fragments).padStart(10),
      best.native.toFixed(3).padStart(11),
      best.web.toFixed(3).padStart(12),
      (best.web / best.native).toFixed(2).padStart(13),
    );
    scene.scene.dispose();
  }
} finally {
  rmSync(folder, { recursive: true });
}
