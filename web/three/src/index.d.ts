// What the members are and give; README.md has how it is used.
import type { Light, LineBasicMaterial, Mesh, Object3D } from 'three';
import type { Engine, Scene, Shadowcut } from 'shadowcut';

export interface SceneShadowsOptions {
  kernel?: 'fast' | 'exact';
  form?: 'pieces' | 'merged' | 'conforming';
  /**
   * As Options.tuning of the engine; otherwise 32, with which the slowest updates take about half
   * as long as with the engine's own (128).
   */
  facetsPerCell?: number;
  /** Whether the mesh casts shadows; otherwise mesh.castShadow. */
  castsShadows?: (mesh: Mesh) => boolean;
  /**
   * Whether the mesh receives shadows: it is cut, and drawn by SceneShadows.mesh. Otherwise
   * mesh.receiveShadow.
   */
  receivesShadows?: (mesh: Mesh) => boolean;
  /**
   * Whether the mesh is expected to move, which is cheaper then. Asked when the mesh is first seen.
   * Otherwise false.
   */
  dynamic?: (mesh: Mesh) => boolean;
  /**
   * Has shadows: of point, spot and directional lights; otherwise all. Others light as if nothing
   * stood before them.
   */
  follows?: (light: Light) => boolean;
  /**
   * Where received meshes go while SceneShadows.mesh draws them: cameras do not see it, raycasters
   * may enable it. Otherwise 31.
   */
  layer?: number;
  /**
   * Triangles are joined to the polygons they were cut from. Where not, the engine has three.js'
   * triangles, as a program that reads the same file has.
   */
  joins?: boolean;
}

export interface SceneUpdate {
  /** Objects and lights that the engine has brought up to date. */
  applied: number;
  /** Fragments, of all lights. */
  gone: number;
  added: number;
  /** The engine's own time, and that of the whole call. */
  engineMs: number;
  ms: number;
  /** What the next render has to send to the graphics card. */
  uploadedBytes: number;
  /** A light's tree is a new one. */
  rebuilt: boolean;
}

export interface SceneIssue {
  object: Object3D;
  message: string;
}

export class SceneShadows {
  /** Adds `mesh` to the scene, and does nothing else before the first update. */
  constructor(shadowcut: Shadowcut, scene: Object3D, options?: SceneShadowsOptions);
  /**
   * Before every render: looks at what has changed in the scene, and brings engine and mesh up to
   * date. Throws ShadowcutError OUT_OF_MEMORY or MUST_COMPACT: see mustCompact.
   */
  update(): SceneUpdate;
  /**
   * Everything anew: after out of memory, when something has been removed; or after large changes.
   */
  compact(): SceneUpdate;
  readonly mustCompact: boolean;
  /**
   * Takes a skinned or morphed mesh's present pose, from the next update on. It was taken when the
   * mesh was met, too.
   */
  bake(mesh: Mesh): void;

  /**
   * All that is received, in one geometry: groups by material, attributes position, normal,
   * shadowcutMask, and what any mesh has of uv, uv1, color, tangent. Bit k % 24 of shadowcutMask's
   * number k / 24: the light of that index reaches (of one light only, bit 0).
   */
  readonly mesh: Mesh;
  /** Draws the outlines of fragments. From the next update on. */
  outlines: boolean;
  readonly outlineMaterial: LineBasicMaterial;

  readonly engine: Engine;
  readonly scene: Scene;
  /** The lights followed, by the engine's light index; undefined where it is free. */
  readonly lights: readonly (Light | undefined)[];
  /** Of faces turned to the light. 0 where there is no such light. */
  litArea(light?: number): number;
  facingArea(light?: number): number;
  /** The engine's object index; undefined where the mesh is not there. */
  objectOf(mesh: Mesh, instance?: number): number | undefined;
  /** What could not be mirrored, each once. */
  readonly issues: readonly SceneIssue[];

  /** Gives the meshes back their layers, and the memory of the engine's. */
  dispose(): void;
}
