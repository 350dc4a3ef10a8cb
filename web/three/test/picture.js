// One scene, drawn by fragments and by three.js' own shadow maps; how far the two pictures differ.
// Runs in the page of picture.html.
import * as THREE from 'three';
import { load } from 'shadowcut';
import { SceneShadows } from 'shadowcut-three';

const width = 800,
  height = 500;

function makeScene() {
  const scene = new THREE.Scene();
  scene.background = new THREE.Color(0x101820);
  const add = (geometry, material, position, change = () => {}) => {
    const mesh = new THREE.Mesh(geometry, material);
    mesh.position.set(...position);
    mesh.castShadow = mesh.receiveShadow = true;
    change(mesh);
    scene.add(mesh);
    return mesh;
  };
  add(
    new THREE.BoxGeometry(12, 0.2, 12),
    new THREE.MeshStandardMaterial({ color: 0xffffff, roughness: 0.8 }),
    [0, -0.1, 0],
  );
  add(
    new THREE.BoxGeometry(1, 2, 1),
    new THREE.MeshLambertMaterial({ color: 0xd0e0ff }),
    [-1.5, 1, 0],
    (mesh) => (mesh.rotation.y = 0.4),
  );
  add(
    new THREE.IcosahedronGeometry(0.7, 0),
    new THREE.MeshStandardMaterial({ color: 0xffe0c0, flatShading: true }),
    [1.5, 1.4, 0.5],
  );
  add(
    new THREE.BoxGeometry(1.2, 0.6, 0.8),
    new THREE.MeshPhongMaterial({ color: 0xc0ffc0 }),
    [0.2, 0.3, 2],
    (mesh) => (mesh.scale.x = -1),
  );
  add(
    new THREE.PlaneGeometry(2, 1.2),
    new THREE.MeshLambertMaterial({ color: 0xffffff, side: THREE.DoubleSide }),
    [-0.5, 2.6, -1.8],
    (mesh) => (mesh.rotation.x = -1),
  );
  add(
    new THREE.SphereGeometry(0.4, 24, 16),
    new THREE.MeshStandardMaterial({ color: 0xffc0ff }),
    [3, 0.8, -1],
    (mesh) => (mesh.receiveShadow = false),
  );
  const posts = new THREE.InstancedMesh(
    new THREE.BoxGeometry(0.2, 1.4, 0.2),
    new THREE.MeshToonMaterial(),
    4,
  );
  for (let k = 0; k < 4; ++k) {
    posts.setMatrixAt(k, new THREE.Matrix4().makeTranslation(-3.6 + 0.7 * k, 0.7, -3));
    posts.setColorAt(k, new THREE.Color().setHSL(k / 4, 0.6, 0.7));
  }
  posts.castShadow = posts.receiveShadow = true;
  scene.add(posts);
  scene.add(new THREE.AmbientLight(0xffffff, 0.15));
  const red = new THREE.PointLight(0xff6040, 60);
  red.position.set(3.5, 4.5, 3.5);
  const blue = new THREE.SpotLight(0x4080ff, 90, 0, 0.8, 0.2);
  blue.position.set(-4, 5, 3);
  scene.add(red, blue, blue.target);
  for (const light of [red, blue]) {
    light.castShadow = true;
    light.shadow.mapSize.set(2048, 2048);
    light.shadow.camera.near = 1;
    light.shadow.camera.far = 14;
    light.shadow.bias = -0.0008;
  }
  return scene;
}

function draw(renderer, scene, camera) {
  const target = new THREE.WebGLRenderTarget(width, height, { samples: 0 });
  renderer.setRenderTarget(target);
  renderer.render(scene, camera);
  const pixels = new Uint8Array(4 * width * height);
  renderer.readRenderTargetPixels(target, 0, 0, width, height, pixels);
  renderer.setRenderTarget(null);
  renderer.render(scene, camera);
  return pixels;
}
const step = (a, i, b, j) =>
  Math.max(Math.abs(a[i] - b[j]), Math.abs(a[i + 1] - b[j + 1]), Math.abs(a[i + 2] - b[j + 2]));

// The share of pixels that differ, and how far from an edge of the second picture they are at most.
function compare(a, b) {
  let differing = 0,
    farthest = 0,
    worst = null;
  for (let y = 0; y < height; ++y) {
    for (let x = 0; x < width; ++x) {
      const i = 4 * (y * width + x);
      if (step(a, i, b, i) <= 6) continue;
      ++differing;
      const distance = distanceToEdge(b, x, y);
      if (distance > farthest)
        ((farthest = distance),
          (worst = [x, y, [...a.subarray(i, i + 3)], [...b.subarray(i, i + 3)]]));
    }
  }
  return { share: differing / (width * height), farthest, worst };
}
function distanceToEdge(p, x, y) {
  for (let r = 1; r < 30; ++r) {
    for (let v = Math.max(y - r, 0); v <= Math.min(y + r, height - 2); ++v) {
      for (let u = Math.max(x - r, 0); u <= Math.min(x + r, width - 2); ++u) {
        const i = 4 * (v * width + u);
        if (step(p, i, p, i + 4) > 12 || step(p, i, p, i + 4 * width) > 12) return r;
      }
    }
  }
  return 30;
}

window.run = async () => {
  const shadowcut = await load();
  const renderer = new THREE.WebGLRenderer({ antialias: false, preserveDrawingBuffer: true });
  renderer.setSize(width, height);
  document.body.style.margin = 0;
  document.body.append(renderer.domElement);
  const camera = new THREE.PerspectiveCamera(45, width / height, 0.1, 50);
  camera.position.set(4, 5.5, 8);
  camera.lookAt(0, 0.3, 0);
  const scene = makeScene();
  const pictures = {};
  const shot = (name) => (pictures[name] = renderer.domElement.toDataURL('image/png'));

  renderer.shadowMap.enabled = true;
  renderer.shadowMap.type = THREE.BasicShadowMap;
  const maps = draw(renderer, scene, camera);
  shot('maps');

  renderer.shadowMap.enabled = false;
  for (const light of scene.children.filter((object) => object.isLight)) light.castShadow = false;
  const shadows = new SceneShadows(shadowcut, scene);
  shadows.update();
  const fragments = draw(renderer, scene, camera);
  shot('fragments');
  const both = compare(fragments, maps);

  // Moved by updates, and there again; then as a scene of its own: what was uploaded in ranges is
  // what there is.
  const box = scene.children.find((object) => object.position.y === 1);
  for (let i = 1; i <= 20; ++i) {
    box.position.x = -1.5 + 2 * Math.sin(i / 3);
    box.material = i % 3 === 0 ? new THREE.MeshStandardMaterial({ color: 0xffff00 }) : box.material;
    shadows.update();
    renderer.render(scene, camera);
  }
  const moved = draw(renderer, scene, camera);
  shadows.outlines = true;
  shadows.update();
  draw(renderer, scene, camera);
  shot('outlines');
  const areas = [shadows.litArea(0), shadows.litArea(1)];
  shadows.dispose();
  const again = new SceneShadows(shadowcut, scene);
  again.update();
  const fresh = draw(renderer, scene, camera);
  const ranges = compare(moved, fresh);
  again.dispose();
  renderer.shadowMap.enabled = false;
  const unshadowed = draw(renderer, scene, camera);
  return {
    both,
    ranges,
    areas,
    unshadowed: compare(unshadowed, fresh).share,
    errors: renderer.getContext().getError(),
    issues: again.issues.length,
    pictures,
  };
};
window.ready = true;
