// The engine's types. What the words mean (fragment, facet, side, reach, kernel, form) is said in
// include/shadowcut/*.hpp, once; the words of enums are theirs in camelCase.
//
// Units and frame: one right-handed world frame in the caller's length unit; areas are that
// squared; angles are radians. Positions are x, y, z one after another; a pose is sixteen numbers,
// row by row, local to world (three.js has columns: matrix.clone().transpose()).
//
// Everything is handed out as a copy, unless it says otherwise. What has dispose() is to be
// disposed of; used afterwards it throws. Every function throws ShadowcutError.

export type Status =
  | 'INVALID_ARGUMENT'
  | 'REFUSED'
  | 'STALE'
  | 'FOREIGN'
  | 'NOT_FOUND'
  | 'OUT_OF_MEMORY'
  | 'MUST_COMPACT'
  | 'INTERNAL_ERROR';
export class ShadowcutError extends Error {
  readonly status: Status;
  constructor(status: Status, message: string);
}

/** As an index: no such thing. */
export const none: 0xffffffff;

export interface LoadOptions {
  /** dist/shadowcut.wasm, where one has it at hand. */
  wasmBinary?: ArrayBuffer | ArrayBufferView;
  /** Where it is; otherwise next to this module. */
  wasmUrl?: string | URL;
  /** Bytes, from 16 MiB on; otherwise 4 GiB. */
  maximumMemory?: number;
}
/** The engine in a module of its own, with its own memory: what is made in one cannot be used in another. */
export function load(options?: LoadOptions): Promise<Shadowcut>;

export interface Shadowcut {
  readonly version: string;
  readonly Scene: new () => Scene;
  /** Follows the scene, and keeps it alive. Builds nothing yet. */
  readonly Engine: new (scene: Scene, options?: Options) => Engine;
  /** Empty buffers for one light, by its index, or for the partition by all. */
  readonly Buffers: new (light: number | 'all', layout?: BufferLayout) => Buffers;
  /** The one-off call. */
  castShadows(scene: Scene, light: Light, options?: Options): Shadows;
  /** A short English phrase. */
  describe(reason: Reason): string;
  /** Whether the face was refused; otherwise it was repaired. */
  refuses(reason: Reason): boolean;
  /** The size of the module's memory. It only grows. */
  readonly memoryBytes: number;
}

export interface Disposable {
  /** Gives the memory back. Once is enough; twice does no harm. Does nothing where an engine lends it. */
  dispose(): void;
  readonly disposed: boolean;
}

export type Numbers = ArrayLike<number>;
export type Vec3 = [number, number, number];

// ---- Scenes

export interface Mesh {
  /** In the object's frame. Doubles, unless it is a Float32Array. */
  positions: Numbers;
  /** Faces without holes, one after another: triangles, or as many corners as cornerCounts says of each. */
  indices?: Numbers;
  cornerCounts?: number[] | Int32Array;
  /** Faces: an outer loop, or [outer loop, hole, ...]. Counter-clockwise seen from the front. After those of `indices`. */
  faces?: (number[] | number[][])[];
}
export interface ObjectId {
  readonly index: number;
  readonly generation: number;
  readonly scene: number;
}
export type LightId = ObjectId;
export type Sides = 'automatic' | 'closed' | 'open';
export interface ObjectSettings {
  sides?: Sides;
  casts?: boolean;
  receives?: boolean;
  /** Expected to move: kept at the leaves of the tree. */
  moves?: boolean;
  pose?: Numbers;
  name?: string;
}
export interface Light {
  kind?: 'point' | 'directional';
  /** A point light's place; the direction in which a directional light travels. */
  at?: Numbers;
  range?: number;
  spot?: { axis: Numbers; halfAngle: number };
  name?: string;
}
export interface SceneObject {
  sides: Sides;
  casts: boolean;
  receives: boolean;
  moves: boolean;
  firstFace: number;
  faceCount: number;
  firstVertex: number;
  vertexCount: number;
  firstFacet: number;
  facetCount: number;
  firstEdge: number;
  edgeCount: number;
  aligned: number;
  alignedBy: number;
  signedVolume: number;
  pose: number[];
  name: string;
}
export interface SceneCounts {
  objects: number;
  lights: number;
  faces: number;
  facets: number;
  corners: number;
  vertices: number;
  edges: number;
  planes: number;
  issues: number;
  /** How often the scene has been changed. */
  revision: number;
}
export interface Face {
  object: number;
  number: number;
  firstFacet: number;
  facetCount: number;
  area: number;
}
export interface Facet {
  face: number;
  plane: number;
  firstCorner: number;
  cornerCount: number;
}
export interface Corner {
  vertex: number;
  /** (index of the edge << 1) | 1 when it runs from b to a. */
  edge: number;
}
export interface Plane {
  normal: Vec3;
  point: Vec3;
  exactNormal: Vec3;
  flatness: number;
  tilt: number;
}
export type Reason =
  | 'nonFinite'
  | 'indexOutOfRange'
  | 'tooFewCorners'
  | 'zeroArea'
  | 'selfIntersecting'
  | 'duplicate'
  | 'repeatedCorner'
  | 'notFlat';
export interface Issue {
  object: number;
  face: number;
  reason: Reason;
  detail: string;
}

export interface Scene extends Disposable {
  /** Faces that cannot be used (NaN positions, say) are left out, and listed among the issues. */
  add(mesh: Mesh, settings?: ObjectSettings): ObjectId;
  remove(id: ObjectId): void;
  setPose(id: ObjectId, pose: Numbers): void;
  /** As many as the object's mesh has, in its own frame. */
  setVertices(id: ObjectId, positions: Numbers): void;
  setCasts(id: ObjectId, casts: boolean): void;
  setReceives(id: ObjectId, receives: boolean): void;
  addLight(light: Light): LightId;
  removeLight(id: LightId): void;
  setLight(id: LightId, light: Light): void;
  replaceLights(lights: Light[]): void;
  /** Before objects are added. */
  setTolerances(tolerances: { flatness: number; coplanarity: number }): void;
  readonly tolerances: { flatness: number; coplanarity: number };
  /** A scene of its own, which knows the ids of the original. */
  copy(): Scene;

  readonly counts: SceneCounts;
  /** Of what stands at an index. */
  objectId(index: number): ObjectId;
  lightId(index: number): LightId;
  object(id: ObjectId): SceneObject;
  /** The first of an object's faces: object(id).firstFace, without reading the rest. */
  firstFace(id: ObjectId): number;
  light(id: LightId): Light;
  /** What add() takes to make the object again as it stands. */
  given(id: ObjectId): {
    mesh: { positions: Float64Array; faces: number[][][] };
    settings: Required<ObjectSettings>;
  };
  /** Indices of the objects changed after a revision, the one changed longest ago first. */
  changedSince(revision: number): Uint32Array;
  // The scene flattened, in world coordinates: all, or `count` from `first` on.
  faces(first?: number, count?: number): Face[];
  facets(first?: number, count?: number): Facet[];
  corners(first?: number, count?: number): Corner[];
  vertices(first?: number, count?: number): Float64Array;
  edges(first?: number, count?: number): { a: number; b: number }[];
  planes(first?: number, count?: number): Plane[];
  issues(first?: number, count?: number): Issue[];
}

// ---- Shadows

export interface Options {
  kernel?: 'fast' | 'exact';
  form?: 'pieces' | 'merged' | 'conforming';
  order?: 'solidAngle' | 'asGiven' | 'random';
  seed?: number | bigint;
  /** One is what there is. */
  threads?: number;
  facetsPerCell?: number;
  minArea?: number;
  minSolidAngle?: number;
  edits?: boolean;
  joinThreshold?: number;
  constructions?: boolean;
}
export interface FragmentId {
  cell: number;
  piece: number;
  place: number;
}
export interface Fragment {
  id: FragmentId;
  face: number;
  facet: number;
  /** `none`: lit, or turned away. */
  caster: number;
  /** Of its block's corners. */
  firstCorner: number;
  cornerCount: number;
  lit: boolean;
  area: number;
}
export interface LightLine {
  crossing: boolean;
  v: Vec3[];
}
export interface Construction {
  in: LightLine;
  out: LightLine;
  vertex: number;
}
export interface FaceArea {
  facing: 'refused' | 'away' | 'outOfReach' | 'ignored' | 'toward';
  area: number;
  lit: number;
  shadowed: number;
  dropped: number;
}
export interface Stats {
  faces: number;
  facingFaces: number;
  facets: number;
  facingArea: number;
  litArea: number;
  shadowedArea: number;
  droppedArea: number;
  litFragments: number;
  shadowedFragments: number;
  cells: number;
  nodes: number;
  spNodes: number;
  ppNodes: number;
  pieces: number;
  crossingLines: number;
  predicates: number;
  on: number;
  byIdentity: number;
  byFilter: number;
  byExact: number;
  depth: number;
  bytes: number;
  buildMs: number;
  emitMs: number;
  markedNodes: number;
  longestLocationList: number;
  cellsBuiltAgain: number;
  joined: number;
  deferred: number;
}
/** Of one light. One's own from castShadows(); an engine's follow it, and throw NOT_FOUND while there is no such light. */
export interface Shadows extends Disposable {
  readonly blockCount: number;
  fragmentCount(block: number): number;
  fragments(block: number, first?: number, count?: number): Fragment[];
  /** x, y, z of the block's corners, counter-clockwise seen from the light. */
  corners(block: number): Float64Array;
  /** What the corners are, exactly; none unless Options.constructions. */
  constructions(block: number, first?: number, count?: number): Construction[];
  /** By the scene's faces. */
  areas(first?: number, count?: number): FaceArea[];
  readonly stats: Stats;
}

// ---- Engines

export interface LightChanges {
  readonly light: number;
  readonly rebuilt: boolean;
  readonly removed: boolean;
  readonly goneCount: number;
  readonly addedCount: number;
  readonly areaCount: number;
  // Copied when asked for, and known until the engine's next update: NOT_FOUND afterwards. Apply
  // `gone` before `added`.
  readonly gone: FragmentId[];
  readonly added: { id: FragmentId; index: number }[];
  readonly areas: { face: number; area: FaceArea }[];
}
export interface Changes {
  update: number;
  applied: number;
  complete: boolean;
  ms: number;
  lights: LightChanges[];
}
export interface Engine extends Disposable {
  /** Applies all edits since the last one; the first builds. OUT_OF_MEMORY: see mustCompact. */
  update(): Changes;
  /** Stops between objects once the time is up. */
  updateWithin(ms: number): Changes;
  /** Builds everything anew. */
  compact(): Changes;
  /** Of the last update or compact. */
  readonly changes: Changes;
  /** An update ran out of memory: everything but compact() and dispose() throws MUST_COMPACT until compact() has succeeded. */
  readonly mustCompact: boolean;
  readonly progress: number;
  /** The engine's own copy, which the shadows are of; lent, to be read only. */
  readonly scene: Scene;
  readonly lightCount: number;
  shadows(light: number): Shadows;
  find(light: number, id: FragmentId): Fragment | undefined;
  /** By face: a bound of the area that may be in the other state. */
  undecided(light: number): Float64Array;
  /** One partition for all lights, or the part of it on these faces. */
  combined(faces?: Numbers): LightSets;
  /** Checks every invariant; for tests. */
  validate(): void;
}
export interface LightSets extends Disposable {
  readonly fragmentCount: number;
  /** 64-bit words of a fragment's set of lights. */
  readonly maskWords: number;
  fragments(
    first?: number,
    count?: number,
  ): { face: number; facet: number; firstCorner: number; cornerCount: number }[];
  /** Light k reaches fragment i iff bit k%64 of masks[i*maskWords + k/64] is set. */
  readonly masks: BigUint64Array;
  readonly corners: Float64Array;
}

// ---- Vertex buffers that follow an engine

export interface BufferLayout {
  doubles?: boolean;
  indexed?: boolean;
  normals?: boolean;
  faces?: boolean;
  objects?: boolean;
  states?: boolean;
  masks?: boolean;
  show?: 'all' | 'lit' | 'shadowed';
  /** Positions are handed out less this. */
  origin?: Numbers;
  holeShare?: number;
  joinedGap?: number;
}
export interface BuffersInfo {
  vertexCount: number;
  vertexCapacity: number;
  indexCount: number;
  indexCapacity: number;
  fragmentCount: number;
  holeVertices: number;
  maskWords: number;
  /** Capacities or maskWords changed: make arrays and buffers of the new capacity; the ranges are everything. */
  grown: boolean;
  changedVertexRanges: number;
  changedIndexRanges: number;
}
export interface Streams {
  positions: Float32Array | Float64Array;
  normals: Float32Array;
  faces: Uint32Array;
  objects: Uint32Array;
  states: Uint8Array;
  masks: Uint32Array;
  indices: Uint32Array;
}
export interface Buffers extends Disposable {
  /** After every update of the engine. After one that was missed, or another engine's, everything is filled anew. */
  update(engine: Engine): void;
  fill(scene: Scene, shadows: Shadows | LightSets): void;
  /** The next update fills everything anew. */
  setOrigin(origin: Numbers): void;
  readonly info: BuffersInfo;
  /**
   * A view of the module's memory, as long as the capacity. It is dead after the next change of the buffers, and after whatever makes
   * the memory grow (its length is 0 then), which any call may: use it at once, and do not keep it.
   */
  stream<Name extends keyof Streams>(name: Name): Streams[Name];
  /** Elements for each vertex, or index. */
  itemSize(name: keyof Streams): number;
  /** What the last update changed, in vertices and indices. */
  readonly changedVertices: { first: number; count: number }[];
  readonly changedIndices: { first: number; count: number }[];
  /** The same as first, count, first, count, ...: for pages that read them every frame, and want nothing collected. */
  readonly changedVertexNumbers: Uint32Array;
  readonly changedIndexNumbers: Uint32Array;
  /** The same in a stream's elements: what three.js' BufferAttribute.addUpdateRange(start, count) takes. */
  changedRanges(name: keyof Streams): { start: number; count: number }[];
  /** Copies them to an array of the page's own, as long as the stream or longer, which no growth touches; and returns them. */
  copyChanged(
    name: keyof Streams,
    target: Streams[keyof Streams],
  ): { start: number; count: number }[];
}
