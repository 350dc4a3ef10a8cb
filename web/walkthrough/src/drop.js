// Somebody's own GLB: what is refused, and why, in words for the page. Everything that a file can
// do wrong ends in a Refusal, before it can cost much; what is wrong with single triangles costs
// those.
import { Box3 } from 'three';
import { meshesOf, parseGlb } from './room.js';

// A file is in memory about three times while it is read (bytes, three.js' arrays, the engine's
// numbers), in a tab that a phone may end at some hundred megabytes.
export const mostBytes = 64 * 2 ** 20;
// The engine cuts this many in about ten seconds, in which the page stands still, and says so.
export const mostTriangles = 100_000;
const mostNodes = 10_000; // every one is looked at in every frame
const deepest = 500; // nodes within nodes: three.js goes down by recursion
const patience = 30; // seconds

export class Refusal extends Error {}

const known = new Set([
  'KHR_lights_punctual',
  'KHR_materials_unlit',
  'KHR_materials_emissive_strength',
  'KHR_materials_clearcoat',
  'KHR_materials_ior',
  'KHR_materials_sheen',
  'KHR_materials_specular',
  'KHR_materials_transmission',
  'KHR_materials_volume',
  'KHR_materials_iridescence',
  'KHR_materials_anisotropy',
  'KHR_materials_dispersion',
  'KHR_texture_transform',
  'KHR_mesh_quantization',
  'EXT_mesh_gpu_instancing',
  'EXT_meshopt_compression',
  'KHR_meshopt_compression',
  'EXT_texture_webp',
  'EXT_texture_avif',
  'EXT_materials_bump',
]);

// { model, triangles, notes }
export async function readModel(file) {
  const refuse = (why) => {
    throw new Refusal(`${file.name}: ${why}`);
  };
  if (file.size > mostBytes)
    refuse(
      `${megabytes(file.size)}; this page takes GLBs of up to ${megabytes(mostBytes)}, ` +
        'so that phones can follow.',
    );
  const bytes = await file.arrayBuffer().catch(() => refuse('the file cannot be read.'));
  const document = documentOf(bytes, refuse);
  checkDocument(document, refuse);
  const prepare = await decodersFor(document);
  let gltf;
  try {
    gltf = await withPatience(parseGlb(bytes, prepare));
  } catch (error) {
    refuse(`not a GLB that can be read: ${error.message}`);
  }
  const model = gltf.scene ?? gltf.scenes?.[0];
  if (!model) refuse('there is no scene in it.');
  const notes = [];
  const triangles = clean(model, notes);
  if (triangles === 0)
    refuse(
      ['there are no triangles in it, so there is nothing to cast a shadow.', ...notes].join(' '),
    );
  if (triangles > mostTriangles) refuse(tooMany(triangles));
  model.updateMatrixWorld(true);
  const { min, max } = new Box3().setFromObject(model);
  if (min.equals(max)) refuse('it has no extent: everything is scaled to nothing.');
  if (![...min.toArray(), ...max.toArray()].every((c) => Math.abs(c) < 1e30))
    refuse('its coordinates are beyond what can be drawn.');
  return { model, triangles, notes };
}

const megabytes = (bytes) => `${(bytes / 2 ** 20).toFixed(0)} MB`;
const tooMany = (triangles) =>
  `${triangles.toLocaleString('en')} triangles; this page takes up to ` +
  `${mostTriangles.toLocaleString('en')}, so that it does not stand still for long.`;

function documentOf(bytes, refuse) {
  const view = new DataView(bytes),
    word = (at) => view.getUint32(at, true);
  if (bytes.byteLength < 20 || word(0) !== 0x46546c67)
    refuse('not a GLB: it does not begin as one. (A .gltf can be made a .glb by any exporter.)');
  if (word(4) !== 2) refuse(`a GLB of version ${word(4)}; version 2 is what can be read.`);
  if (word(8) > bytes.byteLength)
    refuse(`truncated: it says it has ${word(8)} bytes, and there are ${bytes.byteLength}.`);
  const length = word(12);
  if (word(16) !== 0x4e4f534a || 20 + length > bytes.byteLength)
    refuse('not a GLB: its first part is not what it says.');
  try {
    const document = JSON.parse(new TextDecoder().decode(new Uint8Array(bytes, 20, length)));
    if (document !== null && typeof document === 'object') return document;
  } catch {
    // said below
  }
  return refuse('not a GLB: its description is not JSON.');
}

const list = (value) => (Array.isArray(value) ? value : []);

function checkDocument(document, refuse) {
  const foreign = list(document.extensionsRequired).find((name) => !known.has(name));
  if (foreign) refuse(`it needs ${foreign}, which this page does not read.`);
  const outside = [...list(document.buffers), ...list(document.images)].find(
    (each) => typeof each?.uri === 'string' && !each.uri.startsWith('data:'),
  );
  if (outside)
    refuse(
      `it refers to another file, ${outside.uri.slice(0, 60)}; ` +
        'this page reads nothing but the GLB.',
    );
  if (list(document.nodes).length > mostNodes)
    refuse(
      `${document.nodes.length.toLocaleString('en')} nodes; ` +
        `this page takes up to ${mostNodes.toLocaleString('en')}.`,
    );
  checkTree(document, refuse);
  // Accessors with nothing in the file are zeros, as many as they like.
  const zeros = list(document.accessors).reduce(
    (sum, each) => sum + (each?.bufferView === undefined ? Number(each?.count) || 0 : 0),
    0,
  );
  if (zeros > 3 * mostTriangles)
    refuse(`it wants ${zeros.toLocaleString('en')} numbers that are not in the file.`);
  const triangles = trianglesOf(document);
  if (triangles > mostTriangles) refuse(tooMany(triangles));
}

// Nodes must be trees, or the reader would go round for ever.
function checkTree(document, refuse) {
  const nodes = list(document.nodes),
    parent = new Map();
  nodes.forEach((node, i) => {
    for (const child of list(node?.children)) {
      if (parent.has(child) || child === i) refuse('its nodes are no tree.');
      parent.set(child, i);
    }
  });
  const depths = new Map();
  nodes.forEach((_, i) => {
    const path = [];
    let at = i;
    for (; at !== undefined && !depths.has(at); at = parent.get(at)) {
      path.push(at);
      if (path.length > deepest)
        refuse(`its nodes go round in circles, or are nested more than ${deepest} deep.`);
    }
    let depth = at === undefined ? 0 : depths.get(at);
    for (const node of path.reverse()) depths.set(node, ++depth);
    if (depth > deepest) refuse(`its nodes are nested more than ${deepest} deep.`);
  });
}

// As the accessors say, before anything is made of them.
function trianglesOf(document) {
  const counts = list(document.meshes).map((mesh) =>
    list(mesh?.primitives).reduce((sum, primitive) => {
      const mode = primitive?.mode ?? 4;
      const corners =
        document.accessors?.[primitive?.indices ?? primitive?.attributes?.POSITION]?.count ?? 0;
      return sum + (mode === 4 ? corners / 3 : mode > 4 ? Math.max(corners - 2, 0) : 0);
    }, 0),
  );
  return Math.floor(list(document.nodes).reduce((sum, node) => sum + (counts[node?.mesh] ?? 0), 0));
}

async function decodersFor(document) {
  if (!list(document.extensionsUsed).some((name) => name.endsWith('_meshopt_compression')))
    return undefined;
  const { MeshoptDecoder } = await import('three/addons/libs/meshopt_decoder.module.js');
  return (loader) => loader.setMeshoptDecoder(MeshoptDecoder);
}

function withPatience(promise) {
  let clock;
  const late = new Promise(
    (_, reject) =>
      (clock = setTimeout(
        () => reject(new Error(`reading it took more than ${patience} seconds`)),
        1000 * patience,
      )),
  );
  return Promise.race([promise, late]).finally(() => clearTimeout(clock));
}

// Takes out what is no triangle with finite corners, and what is no mesh but hangs among them:
// cameras, points and lines. Returns how many triangles are left.
function clean(model, notes) {
  let left = 0,
    broken = 0;
  for (const mesh of meshesOf(model)) {
    const { geometry } = mesh;
    broken += dropBroken(geometry);
    const corners = geometry.index?.count ?? geometry.attributes.position?.count ?? 0;
    if (corners < 3) mesh.removeFromParent();
    else left += Math.floor(corners / 3) * (mesh.isInstancedMesh ? mesh.count : 1);
  }
  if (broken > 0)
    notes.push(
      broken === 1
        ? '1 triangle has corners that are no numbers, and is left out.'
        : `${broken} triangles have corners that are no numbers, and are left out.`,
    );
  return left;
}

function dropBroken(geometry) {
  const { position } = geometry.attributes;
  if (!position) return 0;
  const bad = new Set();
  for (let i = 0; i < position.count; ++i) {
    if (!Number.isFinite(position.getX(i) + position.getY(i) + position.getZ(i))) bad.add(i);
  }
  const corners = geometry.index
    ? Array.from(geometry.index.array)
    : Array.from({ length: position.count }, (_, i) => i);
  const outside = corners.some((i) => i >= position.count);
  if (bad.size === 0 && !outside) return 0;
  const kept = [];
  for (let k = 0; k + 2 < corners.length; k += 3) {
    const triangle = corners.slice(k, k + 3);
    if (triangle.every((i) => i < position.count && !bad.has(i))) kept.push(...triangle);
  }
  geometry.setIndex(kept);
  for (const i of bad) position.setXYZ(i, 0, 0, 0); // nobody's corner any more
  geometry.boundingBox = geometry.boundingSphere = null;
  return Math.floor((corners.length - kept.length) / 3);
}

// Files dragged onto the page.
export function followDrops(notice, onFile) {
  const carriesFile = (event) => event.dataTransfer?.types.includes('Files');
  addEventListener('dragover', (event) => {
    if (!carriesFile(event)) return;
    event.preventDefault();
    notice.hidden = false;
  });
  addEventListener('dragleave', (event) => event.relatedTarget === null && (notice.hidden = true));
  addEventListener('drop', (event) => {
    notice.hidden = true;
    if (!carriesFile(event)) return;
    event.preventDefault();
    if (event.dataTransfer.files.length > 0) onFile(event.dataTransfer.files[0]);
  });
}
