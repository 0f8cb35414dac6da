// A crowd of one model, each copy at the level that its distance needs, and a stream in the middle
// that is drawn while it loads. Addresses: ?model=x.lodc&stream=x.lods&copies=400&slow=1

import * as THREE from 'three';
import { OrbitControls } from 'three/addons/controls/OrbitControls.js';
import { Lodc } from '../lodc.js';
import { LodcLoader, LodcMesh } from '../three.js';

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

const loader = new LodcLoader(await Lodc.create());
const model = await loader.load(query.get('model') ?? '../models/crowd.lodc');
const size = new THREE.Box3().setFromObject(model.scene).getSize(new THREE.Vector3()).length();
const amount = Number(query.get('copies') ?? 400);
const side = Math.ceil(Math.sqrt(amount));
const copies = Array.from({ length: amount }, (_, i) => {
  const copy = new LodcMesh(model);
  copy.position.set((i % side) - side / 2, 0, -Math.floor(i / side)).multiplyScalar(size * 1.1);
  copy.rotation.y = (i * 2.4) % 6.28;
  scene.add(copy);
  return copy;
});
camera.position.set(0, size * 1.6, size * 3.2);
controls.target.set(0, 0, -size);

const mixers = model.animations.slice(0, 1).flatMap((clip) => copies.map((copy) => {
  const mixer = new THREE.AnimationMixer(copy.content);
  mixer.clipAction(clip).play();
  return mixer;
}));

const streamed = new THREE.Group();
streamed.position.set(0, size * 1.2, 0);
scene.add(streamed);
let arrived = '';
loader.stream(query.get('stream') ?? '../models/stream.lods', async (gltf, progress) => {
  const box = new THREE.Box3().setFromObject(gltf.scene);
  const middle = box.getCenter(new THREE.Vector3());
  const scale = size / box.getSize(new THREE.Vector3()).length();
  gltf.scene.position.copy(middle).multiplyScalar(-scale);
  gltf.scene.scale.setScalar(scale);
  streamed.clear();
  streamed.add(gltf.scene);
  const [now, all] = [0, 1].map((k) => progress.objects.reduce((n, o) => n + o.triangles[k], 0));
  arrived = `stream ${now.toLocaleString('en')} of ${all.toLocaleString('en')} triangles`;
  document.documentElement.dataset.streamed = now;
  if (query.get('slow')) await new Promise((resolve) => setTimeout(resolve, 400));
});

const clock = new THREE.Clock();
renderer.setAnimationLoop(() => {
  const passed = clock.getDelta();
  for (const mixer of mixers) mixer.update(passed);
  controls.update();
  camera.updateMatrixWorld();
  const height = renderer.domElement.height;
  for (const copy of copies) copy.update(camera, height);
  renderer.render(scene, camera);
  const drawn = copies.reduce((sum, copy) => sum + copy.triangles, 0);
  const whole = copies.length * model.objects.reduce((n, o) => n + (o?.levels.triangles ?? 0), 0);
  told.textContent = [
    `${copies.length} copies: ${drawn.toLocaleString('en')} triangles instead of `
      + whole.toLocaleString('en'),
    `in all ${renderer.info.render.triangles.toLocaleString('en')} drawn in `
      + `${(passed * 1000).toFixed(1)} ms`,
    arrived,
  ].join('\n');
  const page = document.documentElement.dataset;
  Object.assign(page, { ready: true, copies: copies.length, drawn, whole });
});
