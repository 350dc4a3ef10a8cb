// Random three.js scenes, and random changes of them. All from a seed.
import * as THREE from 'three';

export function randomFrom(seed) {
  let state = seed >>> 0;
  const next = () => {
    // mulberry32
    state = (state + 0x6d2b79f5) >>> 0;
    let t = Math.imul(state ^ (state >>> 15), state | 1);
    t ^= t + Math.imul(t ^ (t >>> 7), t | 61);
    return ((t ^ (t >>> 14)) >>> 0) / 4294967296;
  };
  const between = (low, high) => low + (high - low) * next();
  return {
    next,
    between,
    below: (n) => Math.floor(n * next()),
    pick: (list) => list[Math.floor(list.length * next())],
  };
}

const materials = (r) => {
  const options = {
    color: new THREE.Color(r.next(), r.next(), r.next()),
    side: r.pick([THREE.FrontSide, THREE.DoubleSide, THREE.BackSide]),
  };
  const Kind = r.pick([
    THREE.MeshLambertMaterial,
    THREE.MeshPhongMaterial,
    THREE.MeshStandardMaterial,
    THREE.MeshPhysicalMaterial,
    THREE.MeshToonMaterial,
    THREE.MeshBasicMaterial,
  ]);
  return new Kind({ ...options, vertexColors: r.next() < 0.3 });
};

function geometries(r) {
  let geometry = r.pick([
    () => new THREE.BoxGeometry(r.between(0.5, 2), r.between(0.5, 2), r.between(0.5, 2)),
    () => new THREE.SphereGeometry(r.between(0.4, 1), 6, 4),
    () => new THREE.ConeGeometry(0.8, 1.5, 5),
    () => new THREE.PlaneGeometry(2, 1.5, 2, 1),
    () => new THREE.TetrahedronGeometry(1),
    () => new THREE.TorusGeometry(0.7, 0.25, 4, 6),
  ])();
  if (r.next() < 0.3 && geometry.index) geometry = geometry.toNonIndexed();
  const { count } = geometry.attributes.position;
  if (r.next() < 0.4) {
    const size = r.pick([3, 4]);
    geometry.setAttribute(
      'color',
      new THREE.BufferAttribute(
        Float32Array.from({ length: size * count }, () => r.next()),
        size,
      ),
    );
  }
  if (r.next() < 0.2)
    geometry.setAttribute(
      'uv1',
      new THREE.BufferAttribute(
        Uint8Array.from({ length: 2 * count }, () => r.below(256)),
        2,
        true,
      ),
    );
  if (r.next() < 0.2) geometry.deleteAttribute('uv');
  if (r.next() < 0.1) geometry.deleteAttribute('normal');
  return geometry;
}

function place(object, r) {
  object.position.set(r.between(-4, 4), r.between(0.5, 3), r.between(-4, 4));
  object.rotation.set(r.between(-3, 3), r.between(-3, 3), r.between(-3, 3));
}

function randomMesh(r) {
  const geometry = geometries(r);
  const material =
    geometry.groups.length > 0 && r.next() < 0.5 ? [0, 1, 2].map(() => materials(r)) : materials(r);
  let mesh;
  if (r.next() < 0.2) {
    mesh = new THREE.InstancedMesh(geometry, material, 4);
    mesh.count = 1 + r.below(4);
    for (let k = 0; k < 4; ++k) setInstance(mesh, k, r);
    if (r.next() < 0.7)
      for (let k = 0; k < 4; ++k) mesh.setColorAt(k, new THREE.Color(r.next(), r.next(), r.next()));
  } else {
    mesh = new THREE.Mesh(geometry, material);
  }
  place(mesh, r);
  mesh.castShadow = r.next() < 0.9;
  mesh.receiveShadow = r.next() < 0.9;
  return mesh;
}
function setInstance(mesh, k, r) {
  const dummy = new THREE.Object3D();
  place(dummy, r);
  dummy.position.multiplyScalar(0.6);
  dummy.scale.set(r.between(0.3, 1), r.between(0.3, 1), r.between(0.3, 1));
  dummy.updateMatrix();
  mesh.setMatrixAt(k, dummy.matrix);
  mesh.instanceMatrix.needsUpdate = true;
}

function randomLight(r) {
  const light = r.pick([
    () => new THREE.PointLight(0xffffff, 5, r.next() < 0.3 ? r.between(3, 8) : 0),
    () => new THREE.SpotLight(0xffffff, 5, 0, r.between(0.3, 1.2)),
    () => new THREE.DirectionalLight(),
  ])();
  light.position.set(r.between(-5, 5), r.between(4, 6), r.between(-5, 5));
  light.castShadow = r.next() < 0.5;
  return light;
}

export class RandomScene {
  scene = new THREE.Scene();
  meshes = [];
  lights = [];
  constructor(seed) {
    this.r = randomFrom(seed);
    const floor = new THREE.Mesh(new THREE.PlaneGeometry(12, 12), new THREE.MeshStandardMaterial());
    floor.rotation.x = -Math.PI / 2;
    floor.castShadow = floor.receiveShadow = true;
    this.group = new THREE.Group();
    this.group.scale.set(1.2, 0.9, 1);
    this.scene.add(floor, this.group);
    this.meshes.push(floor);
    for (let i = 0; i < 5; ++i) this.addMesh();
    this.addLight();
  }
  addMesh() {
    const mesh = randomMesh(this.r);
    this.r.pick([this.scene, this.scene, this.group]).add(mesh);
    this.meshes.push(mesh);
  }
  addLight() {
    const light = randomLight(this.r);
    this.scene.add(light);
    if (light.target)
      (this.scene.add(light.target),
        light.target.position.set(this.r.between(-2, 2), 0, this.r.between(-2, 2)));
    this.lights.push(light);
  }

  // One random change; its name.
  step() {
    const { r } = this;
    const mesh = r.pick(this.meshes),
      light = r.pick(this.lights);
    const changes = {
      move: () =>
        mesh.position.add(
          new THREE.Vector3(r.between(-0.5, 0.5), r.between(-0.2, 0.2), r.between(-0.5, 0.5)),
        ),
      rotate: () => mesh.rotateY(r.between(-1, 1)),
      scale: () => mesh.scale.set(r.between(0.5, 1.5), r.between(0.5, 1.5), r.between(0.5, 1.5)),
      mirror: () => (mesh.scale.x = -mesh.scale.x),
      moveGroup: () => this.group.rotateY(r.between(-1, 1)),
      add: () => this.meshes.length < 10 && this.addMesh(),
      remove: () =>
        this.meshes.length > 4 &&
        (mesh.removeFromParent(), this.meshes.splice(this.meshes.indexOf(mesh), 1)),
      hide: () => (mesh.visible = !mesh.visible),
      casts: () => (mesh.castShadow = !mesh.castShadow),
      receives: () => (mesh.receiveShadow = !mesh.receiveShadow),
      material: () => (mesh.material = materials(r)),
      materials: () =>
        mesh.geometry.groups.length > 0 && (mesh.material = [0, 1, 2, 3].map(() => materials(r))),
      shareMaterial: () => (mesh.material = r.pick(this.meshes).material),
      vertexColors: () =>
        [mesh.material].flat().forEach((each) => (each.vertexColors = !each.vertexColors)),
      geometry: () => (mesh.geometry = geometries(r)),
      shareGeometry: () => (mesh.geometry = r.pick(this.meshes).geometry),
      deform: () => {
        const { position } = mesh.geometry.attributes;
        for (let i = 0; i < position.array.length; ++i) position.array[i] *= r.between(0.95, 1.05);
        position.needsUpdate = true;
      },
      recolor: () => {
        const { color } = mesh.geometry.attributes;
        if (!color) return;
        for (let i = 0; i < color.array.length; ++i) color.array[i] = r.next();
        color.needsUpdate = true;
      },
      reuv: () => {
        const { uv } = mesh.geometry.attributes;
        if (!uv) return;
        for (let i = 0; i < uv.array.length; ++i) uv.array[i] = r.next();
        uv.needsUpdate = true;
      },
      drawRange: () => mesh.geometry.setDrawRange(3 * r.below(4), r.pick([Infinity, 18])),
      instance: () => mesh.isInstancedMesh && setInstance(mesh, r.below(4), r),
      instanceCount: () => mesh.isInstancedMesh && (mesh.count = 1 + r.below(4)),
      instanceColor: () =>
        mesh.isInstancedMesh &&
        (mesh.setColorAt(r.below(4), new THREE.Color(r.next(), r.next(), r.next())),
        (mesh.instanceColor.needsUpdate = true)),
      reparent: () => r.pick([this.scene, this.group]).add(mesh),
      moveLight: () =>
        light?.position.add(new THREE.Vector3(r.between(-1, 1), 0, r.between(-1, 1))),
      moveTarget: () =>
        light?.target?.position.add(new THREE.Vector3(r.between(-1, 1), 0, r.between(-1, 1))),
      addLight: () => this.lights.length < 3 && this.addLight(),
      removeLight: () =>
        light && (light.removeFromParent(), this.lights.splice(this.lights.indexOf(light), 1)),
      hideLight: () => light && (light.visible = !light.visible),
      nothing: () => {},
    };
    const name = r.pick(Object.keys(changes));
    changes[name]();
    return name;
  }
}
