// A crowd of one chain that walks away: each copy at the level of its distance, which switches to
// the next one or morphs there. Addresses: ?model=x.glb&copies=500&pixels=4

import * as THREE from 'three';
import { GLTFLoader } from 'three/addons/loaders/GLTFLoader.js';
import { ChainModel, LodcChain } from '../chain.js';

const query = new URLSearchParams(location.search);
const [told, slider] = ['told', 'geomorph'].map((id) => document.getElementById(id));
const renderer = new THREE.WebGLRenderer({ antialias: true });
renderer.setPixelRatio(Math.min(window.devicePixelRatio, 2));
document.body.append(renderer.domElement);
const scene = new THREE.Scene();
scene.background = new THREE.Color('#eceef1');
scene.add(new THREE.HemisphereLight('#ffffff', '#8a8f98', 2.2));
const sun = new THREE.DirectionalLight('#ffffff', 2.4);
sun.position.set(-3, 5, 4);
scene.add(sun);

const gltf = await new GLTFLoader().loadAsync(query.get('model') ?? '../models/chain.glb');
const model = await ChainModel.of(gltf);
const size = new THREE.Box3().setFromObject(model.scene).getSize(new THREE.Vector3()).length();
const camera = new THREE.PerspectiveCamera(40, 1, size / 20, size * 400);
camera.position.set(0, size * 0.8, size * 2);
camera.lookAt(0, 0, -size * 8);
const resize = () => {
  renderer.setSize(window.innerWidth, window.innerHeight);
  camera.aspect = window.innerWidth / window.innerHeight;
  camera.updateProjectionMatrix();
};
window.addEventListener('resize', resize);
resize();

const amount = Number(query.get('copies') ?? 500);
const side = Math.ceil(Math.sqrt(amount));
const copies = Array.from({ length: amount }, (_, i) => {
  const copy = new LodcChain(model, Number(query.get('pixels') ?? 1));
  copy.position.set((i % side) - side / 2, 0, -Math.floor(i / side)).multiplyScalar(size);
  copy.rotation.y = (i * 2.4) % 6.28;
  scene.add(copy);
  return copy;
});
const mixers = model.animations.slice(0, 1).flatMap((clip) => copies.map((copy) => {
  const mixer = new THREE.AnimationMixer(copy.content);
  mixer.clipAction(clip).play();
  return mixer;
}));

const clock = new THREE.Clock();
const depth = side * size;
renderer.setAnimationLoop(() => {
  const passed = clock.getDelta();
  for (const mixer of mixers) mixer.update(passed);
  for (const copy of copies) {
    copy.morphs = slider.value === '1';
    copy.position.z -= passed * size * 0.7;
    if (copy.position.z < -depth * 1.6) copy.position.z += depth * 1.6;
    copy.update(camera, renderer.domElement.height);
  }
  renderer.render(scene, camera);
  const drawn = copies.reduce((sum, copy) => sum + copy.triangles, 0);
  told.textContent = `${copies.length} copies, ${drawn.toLocaleString('en')} triangles`;
  Object.assign(document.documentElement.dataset, { ready: true, copies: copies.length, drawn });
});
