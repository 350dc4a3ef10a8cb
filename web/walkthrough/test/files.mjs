// GLBs for tests: good ones, and broken in every way that the page has words for.

const word = (...values) => Buffer.from(Uint32Array.from(values).buffer);

export function glb(document, bin = Buffer.alloc(0)) {
  let json = Buffer.from(typeof document === 'string' ? document : JSON.stringify(document));
  json = Buffer.concat([json, Buffer.alloc(-json.length & 3, ' ')]);
  const chunk = bin.length > 0 ? [word(bin.length, 0x004e4942), bin] : [];
  const size = 12 + 8 + json.length + (bin.length > 0 ? 8 + bin.length : 0);
  return Buffer.concat([word(0x46546c67, 2, size), word(json.length, 0x4e4f534a), json, ...chunk]);
}

// One mesh; triangles by corners, nine numbers each.
export function meshDocument(triangles, { mode = 4, node = {} } = {}) {
  const bin = Buffer.from(Float32Array.from(triangles).buffer);
  const bound = (pick) =>
    [0, 1, 2].map((axis) =>
      triangles.reduce(
        (best, c, k) => (k % 3 === axis && Number.isFinite(c) ? pick(best, c) : best),
        triangles[axis] || 0,
      ),
    );
  return {
    document: {
      asset: { version: '2.0' },
      scene: 0,
      scenes: [{ nodes: [0] }],
      nodes: [{ name: 'thing', mesh: 0, ...node }],
      meshes: [{ primitives: [{ attributes: { POSITION: 0 }, mode }] }],
      accessors: [
        {
          bufferView: 0,
          componentType: 5126,
          count: triangles.length / 3,
          type: 'VEC3',
          min: bound(Math.min),
          max: bound(Math.max),
        },
      ],
      bufferViews: [{ buffer: 0, byteLength: bin.length }],
      buffers: [{ byteLength: bin.length }],
    },
    bin,
  };
}
export const meshGlb = (...args) => {
  const { document, bin } = meshDocument(...args);
  return glb(document, bin);
};

// An upright pyramid: open below.
export function pyramid(size = 1) {
  const corners = [
    [-1, 0, -1],
    [-1, 0, 1],
    [1, 0, 1],
    [1, 0, -1],
  ].map((c) => c.map((x) => (x * size) / 2));
  return corners.flatMap((corner, k) => [...corner, ...corners[(k + 1) % 4], 0, size, 0]);
}

// A grid of squares with small bumps, two triangles each.
export function carpet(side) {
  const triangles = [],
    at = (i, k) => [i / side, 0.002 * Math.sin(1.7 * i) * Math.cos(2.3 * k), k / side];
  for (let i = 0; i < side; ++i) {
    for (let k = 0; k < side; ++k)
      triangles.push(
        ...at(i, k),
        ...at(i, k + 1),
        ...at(i + 1, k),
        ...at(i + 1, k),
        ...at(i, k + 1),
        ...at(i + 1, k + 1),
      );
  }
  return triangles;
}

// name -> [bytes, what the page says]
export function hostile() {
  const good = meshGlb(pyramid());
  const { document, bin } = meshDocument(pyramid());
  const changed = (change) => {
    const copy = structuredClone(document);
    change(copy);
    return glb(copy, bin);
  };
  const chain = (length) => Array.from({ length }, (_, k) => ({ children: [k + 1] }));
  const broken = pyramid();
  broken[4] = NaN;
  return {
    'empty.glb': [Buffer.alloc(0), /not a GLB/],
    'text.glb': [Buffer.from('a letter to nobody, about nothing in particular'), /not a GLB/],
    'truncated.glb': [
      good.subarray(0, good.length - 40),
      /truncated: it says it has \d+ bytes, and there are \d+/,
    ],
    'headless.glb': [good.subarray(0, 16), /not a GLB/],
    'old.glb': [Buffer.concat([word(0x46546c67, 1, 40), Buffer.alloc(28)]), /version 1/],
    'json.glb': [glb('{"asset": {"version": "2.0"}, '), /not JSON/],
    'null.glb': [glb('null'), /not JSON/],
    'nothing.glb': [glb({ asset: { version: '2.0' } }), /no scene/],
    'lies.glb': [changed((d) => (d.accessors[0].count = 999)), /not a GLB that can be read/],
    'huge.glb': [changed((d) => (d.accessors[0].count = 3e9)), /1,000,000,000 triangles/],
    'sparse.glb': [
      changed(
        (d) => (
          (d.accessors[0] = { componentType: 5126, count: 4e9, type: 'VEC3' }),
          (d.meshes[0].primitives[0].mode = 0)
        ),
      ),
      /4,000,000,000 numbers that are not in the file/,
    ],
    'circle.glb': [changed((d) => (d.nodes = [{ children: [1] }, { children: [0] }])), /circles/],
    'self.glb': [changed((d) => (d.nodes = [{ children: [0], mesh: 0 }])), /no tree/],
    'twice.glb': [changed((d) => (d.nodes = [{ children: [1, 1] }, { mesh: 0 }])), /no tree/],
    'deep.glb': [changed((d) => (d.nodes = [...chain(5000), { mesh: 0 }])), /deep/],
    'crowd.glb': [
      changed((d) => (d.nodes = Array.from({ length: 10_001 }, () => ({ mesh: 0 })))),
      /10,001 nodes/,
    ],
    'draco.glb': [
      changed((d) => (d.extensionsRequired = ['KHR_draco_mesh_compression'])),
      /KHR_draco_mesh_compression/,
    ],
    'outside.glb': [
      changed((d) => (d.buffers[0].uri = 'https://example.com/all.bin')),
      /another file/,
    ],
    'points.glb': [meshGlb(pyramid(), { mode: 0 }), /no triangles/],
    'flat.glb': [changed((d) => (d.nodes[0].scale = [0, 0, 0])), /no extent/],
    'infinite.glb': [
      glb(
        JSON.stringify(document).replace(
          '"name":"thing"',
          '"name":"thing","translation":[1e999,0,0]',
        ),
        bin,
      ),
      /beyond/,
    ],
    'all-nan.glb': [meshGlb(Array(36).fill(NaN)), /no triangles.*no numbers/],
    'nan.glb': [meshGlb(broken), /is here.*1 triangle has corners that are no numbers/],
    'too-many.glb': [meshGlb(carpet(230)), /105,800 triangles/],
  };
}
