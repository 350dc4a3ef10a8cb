// Shading by masks: for every material of the scene one that lights a fragment only by the lights
// that reach it.
//
// A shaded material has its original as its prototype: colours, maps, everything is read from the
// original at the moment when three.js asks, so there is nothing to copy and nothing to keep in
// step; and the original itself, which may be used elsewhere, stays as it is. Own are only the
// identity (three.js keeps programs by it), the listeners, the shader's patch, and what three.js
// itself writes while it draws.
//
// Materials that take no light are drawn without cracks, and otherwise are as they are; raw shaders
// are left alone.
import { Material, ShaderChunk } from 'three';

export const bitsPerNumber = 24; // of a mask: so many are exact in a float
export const mostLights = 4 * bitsPerNumber; // the four numbers of one attribute

const takesLight = (material) =>
  material.isMeshLambertMaterial ||
  material.isMeshPhongMaterial ||
  material.isMeshToonMaterial ||
  material.isMeshStandardMaterial ||
  material.isShadowMaterial ||
  (material.isShaderMaterial && !material.isRawShaderMaterial && material.lights === true);

// What three.js calls a kind of light in its shader's loops, and ours for its lights' bits. Not
// every three.js has suns.
const kinds = Object.fromEntries(
  ['POINT', 'SPOT', 'SUN', 'DIR']
    .filter((kind) => ShaderChunk.lights_fragment_begin.includes(`NUM_${kind}_LIGHTS`))
    .map((kind) => [kind, `shadowcutBits${kind}`]),
);
const kindOf = (light) => {
  if (light.isPointLight) return 'POINT';
  if (light.isSpotLight) return 'SPOT';
  if (light.isSunLight) return 'SUN';
  return light.isDirectionalLight ? 'DIR' : undefined;
};

// Larger by this share of half the picture's height: 0.15 pixels in pictures of a thousand lines.
// What is left out between neighbours comes of a rasteriser's fixed-point coordinates: 1/256 of a
// pixel in graphics cards, 1/16 in software. Faces seen at an angle grow more in the world, up to
// twenty times, so that it is the same in the picture.
const growth = 3e-4;
const growing = /* glsl */ `#include <begin_vertex>
\t{
\t\tmat4 shadowcutToClip = projectionMatrix * modelViewMatrix;
\t\tvec4 at = shadowcutToClip * vec4( transformed, 1.0 );
\t\tvec3 outward = shadowcutOutward * ( ${growth} / projectionMatrix[ 1 ][ 1 ] * abs( at.w ) );
\t\tvec4 moved = at + shadowcutToClip * vec4( outward, 0.0 );
\t\tvec2 aspect = vec2( projectionMatrix[ 1 ][ 1 ] / projectionMatrix[ 0 ][ 0 ], 1.0 );
\t\tvec2 seen = ( moved.xy / moved.w - at.xy / at.w ) * aspect;
\t\tfloat full = ${growth} * max( length( shadowcutOutward ), 1e-6 );
\t\ttransformed += outward / clamp( length( seen ) / full, 0.05, 1.0 );
\t}
`;
const vertexDeclarations = /* glsl */ `
attribute vec4 shadowcutMask;
flat varying highp uvec4 vShadowcutMask;
`;
const fragmentDeclarations = /* glsl */ `
flat varying highp uvec4 vShadowcutMask;
${Object.entries(kinds)
  .map(
    ([kind, name]) =>
      `#if NUM_${kind}_LIGHTS > 0\nuniform int ${name}[ NUM_${kind}_LIGHTS ];\n#endif`,
  )
  .join('\n')}
// 1: the light of that bit reaches the fragment, or nobody has followed it.
float shadowcutReaches( int bit ) {
  if ( bit < 0 ) return 1.0;
  uint word = vShadowcutMask[ bit / ${bitsPerNumber} ];
  return float( ( word >> uint( bit % ${bitsPerNumber} ) ) & 1u );
}
`;
// The product over all lights, as three.js' own.
const shadowMask = /* glsl */ `
float shadowcutShadowMask() {
  float reaches = 1.0;
${Object.entries(kinds)
  .map(
    ([kind, name]) => `  #if NUM_${kind}_LIGHTS > 0
  for ( int i = 0; i < NUM_${kind}_LIGHTS; i ++ ) reaches *= shadowcutReaches( ${name}[ i ] );
  #endif`,
  )
  .join('\n')}
  return reaches;
}
`;

// The loops over lights, each light's colour times its bit.
const lightLoops = ShaderChunk.lights_fragment_begin
  .split(/(?=#if \( NUM_\w+_LIGHTS > 0 \))/)
  .map((loop) => {
    const name = kinds[/^#if \( NUM_(\w+)_LIGHTS > 0 \)/.exec(loop)?.[1]];
    return name
      ? loop.replace(
          /RE_Direct\(/,
          `directLight.color *= shadowcutReaches( ${name}[ i ] );\n\t\tRE_Direct(`,
        )
      : loop;
  })
  .join('');

// uniforms: null where it takes no light.
function patch(shader, uniforms) {
  shader.vertexShader = shader.vertexShader
    .replace('#include <begin_vertex>', growing)
    .replace('void main() {', 'attribute vec3 shadowcutOutward;\nvoid main() {');
  if (!uniforms) return;
  Object.assign(shader.uniforms, uniforms);
  shader.vertexShader = shader.vertexShader.replace(
    'void main() {',
    `${vertexDeclarations}\nvoid main() {\n\tvShadowcutMask = uvec4( shadowcutMask );\n`,
  );
  const isShadow = shader.fragmentShader.includes('getShadowMask()');
  shader.fragmentShader = shader.fragmentShader
    .replace('#include <lights_fragment_begin>', lightLoops)
    .replace('getShadowMask()', 'shadowcutShadowMask()')
    .replace(
      'void main() {',
      `${fragmentDeclarations}${isShadow ? shadowMask : ''}\nvoid main() {`,
    );
}

// Properties that three.js writes while it draws (it draws transparent double-sided materials one
// side after the other), and else reads from the original: what was written counts until it equals
// the original's.
function follow(shaded, original, name) {
  let written;
  Object.defineProperty(shaded, name, {
    configurable: true,
    enumerable: true,
    get: () => written ?? original[name],
    set: (value) => (written = value === original[name] ? undefined : value),
  });
}
function followVersion(shaded, original) {
  let more = 0;
  Object.defineProperty(shaded, 'version', {
    configurable: true,
    enumerable: true,
    get: () => original.version + more,
    set: (value) => (more = value - original.version),
  });
}

function shade(original, uniforms, tinted) {
  const shaded = Object.create(original);
  const identity = new Material(); // for an id and a uuid that nobody else has
  Object.defineProperty(shaded, 'id', { value: identity.id });
  shaded.uuid = identity.uuid;
  shaded._listeners = {};
  follow(shaded, original, 'side');
  followVersion(shaded, original);
  if (tinted) shaded.vertexColors = true;
  // three.js takes a ShaderMaterial's uniforms as they are, and ours are not to be left in them.
  if (original.isShaderMaterial) shaded.uniforms = Object.create(original.uniforms);
  shaded.onBeforeCompile = (shader, renderer) => {
    original.onBeforeCompile(shader, renderer);
    patch(shader, takesLight(original) ? uniforms : null);
  };
  shaded.customProgramCacheKey = () => `shadowcut ${original.customProgramCacheKey()}`;
  return shaded;
}

const nothing = new Material();
nothing.visible = false;

// The materials of the geometry, by slot. A slot is held by as many users as have acquired it, and
// used again after the last.
export class Palette {
  materials = []; // by slot: what draws; of a free slot, what draws nothing
  #slots = []; // { original, tinted, users }
  #found = new Map(); // original -> [slot plain, slot tinted]
  #free = [];
  #uniforms = Object.fromEntries(
    Object.values(kinds).map((name) => [name, { value: new Int32Array(16).fill(-1) }]),
  );
  #sorted = [];

  // Tinted: vertex colours count, even where the original ignores them.
  acquire(original, tinted) {
    let pair = this.#found.get(original);
    if (!pair) this.#found.set(original, (pair = [-1, -1]));
    let slot = pair[+tinted];
    if (slot < 0) {
      slot = this.#free.pop() ?? this.#slots.length;
      this.#slots[slot] = { original, tinted, users: 0 };
      this.materials[slot] = original.isRawShaderMaterial
        ? original
        : shade(original, this.#uniforms, tinted);
      pair[+tinted] = slot;
    }
    ++this.#slots[slot].users;
    return slot;
  }
  release(slot) {
    const { original, tinted } = this.#slots[slot];
    if (--this.#slots[slot].users > 0) return;
    const pair = this.#found.get(original);
    pair[+tinted] = -1;
    if (pair[0] < 0 && pair[1] < 0) this.#found.delete(original);
    if (this.materials[slot] !== original) this.materials[slot].dispose();
    this.materials[slot] = nothing;
    this.#slots[slot] = null;
    this.#free.push(slot);
  }
  dispose() {
    this.#slots.forEach((slot, i) => {
      if (slot && this.materials[i] !== slot.original) this.materials[i].dispose();
    });
    this.materials = this.#slots = [];
    this.#found.clear();
  }

  // Before the geometry is drawn: which bit each light has, in the order in which three.js hands
  // lights to its shaders. `lights` are those that the camera may see, in the order of the scene;
  // bitOf gives -1 for those that nobody follows.
  arrange(lights, camera, bitOf) {
    const sorted = this.#sorted;
    sorted.length = 0;
    for (const light of lights) if (light.layers.test(camera.layers)) sorted.push(light);
    sorted.sort(shadowsAndMapsFirst);
    const counts = { POINT: 0, SPOT: 0, SUN: 0, DIR: 0 };
    for (const light of sorted) {
      const kind = kindOf(light);
      if (kind === undefined) continue;
      const uniform = this.#uniforms[kinds[kind]];
      const i = counts[kind]++;
      if (i >= uniform.value.length)
        uniform.value = Int32Array.from({ length: 2 * i }, (_, k) => uniform.value[k] ?? -1);
      uniform.value[i] = bitOf(light);
    }
  }
}
const rank = (light) => (light.castShadow ? 2 : 0) + (light.map ? 1 : 0);
const shadowsAndMapsFirst = (a, b) => rank(b) - rank(a);
