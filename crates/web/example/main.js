// A crowd of one model, each copy at the level that its distance needs, and a stream in the middle
// that is drawn while it loads. Addresses: ?model=x.lodc&stream=x.lods&copies=400

import * as THREE from 'three';
import { OrbitControls } from 'three/addons/controls/OrbitControls.js';
import { LodcLoader } from '../loader/loader.js';

const query = new URLSearchParams(location.search);
const told = document.getElementById('told');
const renderer = new THREE.WebGLRenderer({ antialias: true });
renderer.setPixelRatio(Math.min(window.devicePixelRatio, 2));
document.body.append(renderer.domElement);
const scene = new THREE.Scene();
scene.background = new THREE.Color('#eceef1');
scene.add(new THREE.HemisphereLight('#ffffff', '#8a8f98', 2.2));
const sun = new THREE.DirectionalLight('#ffffff', 2.4);
sun.position.set(-3, 5, 4);
scene.add(sun);
const camera = new THREE.PerspectiveCamera(40, 1, 0.05, 2000);
const controls = new OrbitControls(camera, renderer.domElement);

function resize() {
  renderer.setSize(window.innerWidth, window.innerHeight);
  camera.aspect = window.innerWidth / window.innerHeight;
  camera.updateProjectionMatrix();
}
window.addEventListener('resize', resize);
resize();

const model = await LodcLoader.load(query.get('model') ?? '../models/crowd.lodc');
await model.whenComplete;
const size = new THREE.Box3().setFromObject(model).getSize(new THREE.Vector3()).length();
const amount = Number(query.get('copies') ?? 400);
const side = Math.ceil(Math.sqrt(amount));
const copies = Array.from({ length: amount }, (_, i) => {
  const copy = model.clone();
  copy.position.set((i % side) - side / 2, 0, -Math.floor(i / side)).multiplyScalar(size * 1.1);
  copy.rotation.y = (i * 2.4) % 6.28;
  scene.add(copy);
  return copy;
});
camera.position.set(0, size * 1.6, size * 3.2);
controls.target.set(0, 0, -size);

const mixers = model.animations.slice(0, 1).flatMap((clip) => copies.map((copy) => {
  const mixer = new THREE.AnimationMixer(copy);
  mixer.clipAction(clip).play();
  return mixer;
}));

let streamed = null;
LodcLoader.load(query.get('stream') ?? '../models/stream.lods').then((shown) => {
  streamed = shown;
  const box = new THREE.Box3().setFromObject(shown);
  shown.scale.setScalar(size / box.getSize(new THREE.Vector3()).length());
  shown.position.set(0, size * 1.2, 0);
  scene.add(shown);
});

const clock = new THREE.Clock();
renderer.setAnimationLoop(() => {
  const passed = clock.getDelta();
  for (const mixer of mixers) mixer.update(passed);
  controls.update();
  camera.updateMatrixWorld();
  renderer.render(scene, camera);
  const drawn = copies.reduce((sum, copy) => sum + copy.triangles, 0);
  const whole = copies.length * model.objects.reduce((n, o) => n + o.header.triangles, 0);
  told.textContent = [
    `${copies.length} copies: ${drawn.toLocaleString('en')} triangles instead of `
      + whole.toLocaleString('en'),
    `in all ${renderer.info.render.triangles.toLocaleString('en')} drawn in `
      + `${(passed * 1000).toFixed(1)} ms`,
    `stream: ${(streamed?.triangles ?? 0).toLocaleString('en')} triangles`
      + (streamed?.isComplete ? '' : ' so far'),
  ].join('\n');
  const page = document.documentElement.dataset;
  const arrived = streamed?.triangles ?? 0;
  Object.assign(page, { ready: true, copies: copies.length, drawn, whole, streamed: arrived });
});
