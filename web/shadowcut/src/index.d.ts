// The types of the engine. include/shadowcut/*.hpp define the terms (fragment, facet, side, range,
// kernel, form); names are those of C++ in camelCase.
//
// Units and frame: one right-handed world frame in the caller's length unit; areas are that
// squared; angles are radians. Positions are x, y, z one after another; a pose is sixteen numbers,
// row by row, local to world (three.js has columns: matrix.clone().transpose()).
//
// Results are copies unless stated otherwise. Objects with dispose() must be disposed of, and throw
// when they are used afterwards. Every function throws ShadowcutError on failure.

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

/** Stands for "no index". */
export const invalidIndex: 0xffffffff;

export interface LoadOptions {
  /** The contents of dist/shadowcut.wasm. */
  wasmBinary?: ArrayBuffer | ArrayBufferView;
  /** The location of dist/shadowcut.wasm; otherwise next to this module. */
  wasmUrl?: string | URL;
  /** In bytes, at least 16 MiB; otherwise 4 GiB. */
  maximumMemory?: number;
}
/**
 * The engine in a new module with a memory of its own: objects of one module cannot be used with
 * another.
 */
export function load(options?: LoadOptions): Promise<Shadowcut>;

export interface Shadowcut {
  readonly version: string;
  /** Major, minor, patch. */
  readonly versionNumbers: [number, number, number];
  readonly Scene: new () => Scene;
  /** Follows the scene, and keeps it alive. Builds nothing yet. */
  readonly Engine: new (scene: Scene, options?: Options) => Engine;
  /** Empty buffers for one light, by its index, or for the partition by all. */
  readonly Buffers: new (light: number | 'all', layout?: BufferLayout) => Buffers;
  /** Computes the shadows of one light once. */
  castShadows(scene: Scene, light: Light, options?: Options): Shadows;
  /** A short English phrase. */
  reasonText(reason: Reason): string;
  /** Whether the face was refused; otherwise it was repaired. */
  isRefusal(reason: Reason): boolean;
  /** The size of the module's memory, which never shrinks. */
  readonly memoryBytes: number;
}

export interface Disposable {
  /**
   * Frees the memory. Calling it again has no effect, nor has calling it on objects that belong to
   * an engine.
   */
  dispose(): void;
  readonly disposed: boolean;
}

export type Numbers = ArrayLike<number>;
export type Vec3 = [number, number, number];

// ---- Scenes

export interface Mesh {
  /** In the frame of the object: floats if it is a Float32Array, otherwise doubles. */
  positions: Numbers;
  /**
   * The corners of faces without holes, one after another: triangles, or cornerCounts gives the
   * number of corners of each.
   */
  indices?: Numbers;
  cornerCounts?: number[] | Int32Array;
  /**
   * More faces, after those of `indices`: an outer loop, or [outer loop, hole, ...],
   * counter-clockwise seen from the front.
   */
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
  castsShadows?: boolean;
  receivesShadows?: boolean;
  /** Expected to move: inserted last, at the leaves of the tree. */
  dynamic?: boolean;
  pose?: Numbers;
  name?: string;
}
export interface Light {
  kind?: 'point' | 'directional';
  /** Of a point light. */
  position?: Numbers;
  /** Of the rays of a directional light; any length except zero. */
  direction?: Numbers;
  /** Of a point light, as `spot`: with a directional light they are REFUSED. */
  range?: number;
  spot?: { axis: Numbers; halfAngle: number };
  name?: string;
}
export interface SceneObject {
  sides: Sides;
  castsShadows: boolean;
  receivesShadows: boolean;
  dynamic: boolean;
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
  /** The number of changes made to the scene. */
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
  /** (index of the edge << 1) | 1 if it runs from b to a. */
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
  /**
   * Faces that are not usable (for example with NaN positions) are left out and reported as issues.
   */
  add(mesh: Mesh, settings?: ObjectSettings): ObjectId;
  remove(id: ObjectId): void;
  setPose(id: ObjectId, pose: Numbers): void;
  /** As many vertices as the object's mesh has, in the frame of the object. */
  setVertices(id: ObjectId, positions: Numbers): void;
  setCastsShadows(id: ObjectId, castsShadows: boolean): void;
  setReceivesShadows(id: ObjectId, receivesShadows: boolean): void;
  addLight(light: Light): LightId;
  removeLight(id: LightId): void;
  setLight(id: LightId, light: Light): void;
  replaceLights(lights: Light[]): void;
  /** To be set before objects are added. */
  setTolerances(tolerances: { flatness: number; coplanarity: number }): void;
  readonly tolerances: { flatness: number; coplanarity: number };
  /** An independent copy, in which the ids of the original are valid. */
  copy(): Scene;

  readonly counts: SceneCounts;
  /** The id of the object at an index. NOT_FOUND: the index is free. */
  objectId(index: number): ObjectId;
  lightId(index: number): LightId;
  object(id: ObjectId): SceneObject;
  /** object(id).firstFace, without reading the other members. */
  firstFace(id: ObjectId): number;
  light(id: LightId): Light;
  /** The arguments of add() that recreate the object in its present state. */
  source(id: ObjectId): {
    mesh: { positions: Float64Array; faces: number[][][] };
    settings: Required<ObjectSettings>;
  };
  /** Indices of the objects changed after a revision, the least recently changed one first. */
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

/** Parameters of speed and memory. They do not change the lit regions. */
export interface Tuning {
  order?: 'solidAngle' | 'asGiven' | 'random';
  seed?: number | bigint;
  facetsPerCell?: number;
  incremental?: boolean;
  joinThreshold?: number;
}
/** An option that does not apply is REFUSED. */
export interface Options {
  kernel?: 'fast' | 'exact';
  form?: 'pieces' | 'merged' | 'conforming';
  /** The module has one thread. */
  threads?: number;
  minArea?: number;
  minSolidAngle?: number;
  /** Needs the exact kernel, and the form 'pieces' or 'merged'. */
  constructions?: boolean;
  tuning?: Tuning;
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
  /** `invalidIndex`: lit, or turned away. */
  caster: number;
  /** Index into the corners of its block. */
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
  cellsRebuilt: number;
  joined: number;
  deferred: number;
}
/**
 * The shadows of one light. Those of an engine follow its updates, and throw NOT_FOUND while the
 * light does not exist.
 */
export interface Shadows extends Disposable {
  readonly blockCount: number;
  fragmentCount(block: number): number;
  fragments(block: number, first?: number, count?: number): Fragment[];
  /** x, y, z of the block's corners, counter-clockwise seen from the light. */
  corners(block: number): Float64Array;
  /** The exact definitions of the corners; empty unless Options.constructions. */
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
  // Copied when read, until the engine's next update; NOT_FOUND afterwards. Apply `gone` before
  // `added`.
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
  /**
   * Applies all edits since the last update; the first update builds. OUT_OF_MEMORY: see
   * mustCompact.
   */
  update(): Changes;
  /** The same, but stops between two objects when the time, in milliseconds, is over. */
  updateWithin(ms: number): Changes;
  /** Rebuilds everything. */
  compact(): Changes;
  /** The changes of the last update or compact. */
  readonly changes: Changes;
  /**
   * An update ran out of memory: everything but compact() and dispose() throws MUST_COMPACT until
   * compact() has succeeded.
   */
  readonly mustCompact: boolean;
  readonly progress: number;
  /** The engine's copy of the scene, to which all indices refer. Read only. */
  readonly scene: Scene;
  readonly lightCount: number;
  shadows(light: number): Shadows;
  find(light: number, id: FragmentId): Fragment | undefined;
  /** For each face an upper bound on the area whose state, lit or shadowed, may be wrong. */
  uncertainArea(light: number): Float64Array;
  /**
   * Whether a light reaches a point of a face (index into the faces of `scene`). The point is taken
   * as on the face's plane.
   */
  isLit(light: number, face: number, point: Numbers): boolean;
  /** One partition for all lights, or the part of it on these faces. */
  overlay(faces?: Numbers): LightPartition;
  /** Checks every invariant; for tests. */
  validate(): void;
}
export interface LightPartition extends Disposable {
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
  /** Subtracted from all positions. */
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
  /**
   * A capacity or maskWords changed: create arrays and buffers of the new capacity. The ranges
   * cover everything.
   */
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
  /**
   * To be called after every update of the engine. Refills the buffers after a skipped update, or
   * for another engine.
   */
  update(engine: Engine): void;
  fill(scene: Scene, shadows: Shadows | LightPartition): void;
  /** The next update refills the buffers. */
  setOrigin(origin: Numbers): void;
  readonly info: BuffersInfo;
  /**
   * A view of the module's memory, as long as the capacity. It is invalid after the next change of
   * the buffers, and when the memory has grown (its length is 0 then), which any call may cause:
   * use it at once, and do not keep it.
   */
  stream<Name extends keyof Streams>(name: Name): Streams[Name];
  /** The number of elements for each vertex, or index. */
  itemSize(name: keyof Streams): number;
  /** The ranges of vertices and indices that the last update changed. */
  readonly changedVertices: { first: number; count: number }[];
  readonly changedIndices: { first: number; count: number }[];
  /** The same as first, count, first, count, ...: without an object for each range. */
  readonly changedVertexNumbers: Uint32Array;
  readonly changedIndexNumbers: Uint32Array;
  /**
   * The same in elements of a stream: the arguments of three.js'
   * BufferAttribute.addUpdateRange(start, count).
   */
  changedRanges(name: keyof Streams): { start: number; count: number }[];
  /**
   * Copies these ranges to an array outside the module, at least as long as the stream, and returns
   * them.
   */
  copyChanged(
    name: keyof Streams,
    target: Streams[keyof Streams],
  ): { start: number; count: number }[];
}
