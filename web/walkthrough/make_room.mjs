// Makes public/room.glb of data/room4.obj: the page's room, which the native program reads too.
//
// The OBJ has z up and its objects in world coordinates; glTF has y up. Each object becomes a node
// with its name and a translation to the middle of its foot, so that it can be moved. Every
// coordinate is rounded to a multiple of 2^-16 m (15 micrometres): those are floats, and so are
// their sums and differences in a room of this size. So what touched in the OBJ's doubles touches
// here, and everyone who reads the file has the same world coordinates to the last bit.
import { mkdirSync, readFileSync, writeFileSync } from 'node:fs';
import { ShapeUtils, Vector2, Vector3 } from 'three';

const here = (path) => new URL(path, import.meta.url);
const source = here('../../data/room4.obj');
const target = here('public/room.glb');

const snap = (metres) => Math.round(metres * 65536) / 65536;
const place = (x, y, z) => new Vector3(snap(x), snap(z), snap(-y));

// Colours are sRGB in hexadecimal; the kinds differ in lightness, not in hue alone. A list is gone
// through by the object's number.
const looks = {
  room: { roughness: 1 },
  poster: { roughness: 0.9 },
  desk: { colours: ['b98a58'], roughness: 0.7 },
  computer: { colours: ['7d8188', 'a9adb3'], roughness: 0.6 },
  screen: { colours: ['1c2733'], roughness: 0.25 },
  bookcase: { colours: ['6b4a30'], roughness: 0.75 },
  book: { colours: ['c8553d', '2f5d8a', 'e0c068', '4f7a4a', '8a4f7d', 'e8e2d4'], roughness: 0.9 },
};

const linear = (srgb) => (srgb <= 0.04045 ? srgb / 12.92 : ((srgb + 0.055) / 1.055) ** 2.4);
const colourOf = (hex) => [0, 2, 4].map((at) => linear(parseInt(hex.slice(at, at + 2), 16) / 255));

function readObj(text) {
  const objects = [];
  const vertices = [];
  let light;
  for (const line of text.split('\n')) {
    const [word, ...rest] = line.trim().split(/\s+/);
    if (word === 'o') objects.push({ name: rest[0], faces: [] });
    else if (word === 'v') vertices.push(place(...rest.map(Number)));
    else if (word === 'f')
      objects.at(-1).faces.push(rest.map((corner) => vertices[parseInt(corner, 10) - 1]));
    else if (word === '#')
      light ??= /light point:([^,]+),([^,]+),(\S+)/.exec(line)?.slice(1).map(Number);
  }
  return { objects, light: place(...light) };
}

function normalOf(face) {
  const normal = new Vector3();
  face.forEach((a, k) => {
    const b = face[(k + 1) % face.length];
    ((normal.x += (a.y - b.y) * (a.z + b.z)),
      (normal.y += (a.z - b.z) * (a.x + b.x)),
      (normal.z += (a.x - b.x) * (a.y + b.y)));
  });
  return normal.normalize();
}

// Corners as indices into the face, in triples; concave faces too (the wall around the door).
function trianglesOf(face, normal) {
  const along = new Vector3().subVectors(face[1], face[0]).normalize();
  const across = new Vector3().crossVectors(normal, along);
  return ShapeUtils.triangulateShape(
    face.map((v) => new Vector2(v.dot(along), v.dot(across))),
    [],
  ).flat();
}

// One mesh has floor, walls and ceiling, and one the poster: what differs within an object is told
// by the vertices' colours.
function colourAt(name, normal, corner) {
  if (name === 'room')
    return colourOf(normal.y > 0.5 ? '9a8f80' : normal.y < -0.5 ? 'f2f0ea' : 'd9d2c3');
  if (name === 'poster') return colourOf(['24476b', 'f0d9a0', 'd98a3d', '6fa3b8'][corner]);
  return undefined;
}

class Glb {
  document = {
    asset: { version: '2.0', generator: 'shadowcut, make_room.mjs' },
    extensionsUsed: ['KHR_lights_punctual'],
    extensions: { KHR_lights_punctual: { lights: [] } },
    scene: 0,
    scenes: [{ nodes: [] }],
    nodes: [],
    meshes: [],
    materials: [],
    accessors: [],
    bufferViews: [],
    buffers: [],
  };
  parts = [];
  size = 0;

  node(node) {
    this.document.scenes[0].nodes.push(this.document.nodes.push(node) - 1);
  }
  accessor(values, type, target, bounds) {
    const { accessors, bufferViews } = this.document;
    const componentType = values instanceof Uint16Array ? 5123 : 5126;
    const bytes = Buffer.from(values.buffer, values.byteOffset, values.byteLength);
    bufferViews.push({ buffer: 0, byteOffset: this.size, byteLength: bytes.length, target });
    const padding = Buffer.alloc(-bytes.length & 3);
    this.parts.push(bytes, padding);
    this.size += bytes.length + padding.length;
    const count = values.length / { SCALAR: 1, VEC3: 3 }[type];
    return (
      accessors.push({
        bufferView: bufferViews.length - 1,
        componentType,
        count,
        type,
        ...bounds,
      }) - 1
    );
  }
  bytes() {
    this.document.buffers = [{ byteLength: this.size }];
    let json = Buffer.from(JSON.stringify(this.document));
    json = Buffer.concat([json, Buffer.alloc(-json.length & 3, ' ')]);
    const word = (...values) => Buffer.from(Uint32Array.from(values).buffer);
    return Buffer.concat([
      word(0x46546c67, 2, 12 + 8 + json.length + 8 + this.size),
      word(json.length, 0x4e4f534a),
      json,
      word(this.size, 0x004e4942),
      ...this.parts,
    ]);
  }
}

function materialOf(glb, materials, { name }) {
  const [kind, number = '1'] = name.split('.');
  const { colours, roughness } = looks[kind];
  const pick = colours ? (Number(number) - 1) % colours.length : 0;
  const key = `${kind}${colours?.length > 1 ? `.${pick + 1}` : ''}`;
  if (!materials.has(key)) {
    const baseColorFactor = [...(colours ? colourOf(colours[pick]) : [1, 1, 1]), 1];
    const material = {
      name: key,
      pbrMetallicRoughness: { baseColorFactor, metallicFactor: 0, roughnessFactor: roughness },
    };
    materials.set(key, glb.document.materials.push(material) - 1);
  }
  return materials.get(key);
}

function addObject(glb, materials, object) {
  const corners = object.faces.flat();
  const low = corners.reduce((a, b) => a.clone().min(b), corners[0]),
    high = corners.reduce((a, b) => a.clone().max(b), corners[0]);
  const foot = new Vector3(snap((low.x + high.x) / 2), low.y, snap((low.z + high.z) / 2));
  const positions = [],
    normals = [],
    colours = [],
    indices = [];
  for (const face of object.faces) {
    const first = positions.length / 3,
      normal = normalOf(face);
    face.forEach((v, k) => {
      positions.push(...v.clone().sub(foot).toArray());
      normals.push(...normal.toArray());
      colours.push(...(colourAt(object.name, normal, k) ?? []));
    });
    indices.push(...trianglesOf(face, normal).map((k) => first + k));
  }
  const attributes = {
    POSITION: glb.accessor(new Float32Array(positions), 'VEC3', 34962, {
      min: low.clone().sub(foot).toArray(),
      max: high.clone().sub(foot).toArray(),
    }),
    NORMAL: glb.accessor(new Float32Array(normals), 'VEC3', 34962),
  };
  if (colours.length) attributes.COLOR_0 = glb.accessor(new Float32Array(colours), 'VEC3', 34962);
  const primitive = {
    attributes,
    indices: glb.accessor(new Uint16Array(indices), 'SCALAR', 34963),
    material: materialOf(glb, materials, object),
  };
  glb.document.meshes.push({ name: object.name, primitives: [primitive] });
  glb.node({
    name: object.name,
    mesh: glb.document.meshes.length - 1,
    translation: foot.toArray(),
  });
}

const { objects, light } = readObj(readFileSync(source, 'utf8'));
const glb = new Glb();
const materials = new Map();
for (const object of objects) addObject(glb, materials, object);
glb.document.extensions.KHR_lights_punctual.lights.push({
  type: 'point',
  name: 'lamp',
  intensity: 48,
  color: [1, 1, 1],
});
glb.node({
  name: 'lamp',
  translation: light.toArray(),
  extensions: { KHR_lights_punctual: { light: 0 } },
});
mkdirSync(here('public/'), { recursive: true });
writeFileSync(target, glb.bytes());
console.log(`public/room.glb: ${objects.length} objects`);
