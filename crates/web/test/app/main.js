// What the tests of the package do in a page that Vite has bundled: `test/browser.mjs` calls it.

import * as THREE from 'three';
import { GLTFLoader } from 'three/addons/loaders/GLTFLoader.js';
import { MTLLoader } from 'three/addons/loaders/MTLLoader.js';
import { OBJLoader } from 'three/addons/loaders/OBJLoader.js';
import { LodcLoader } from 'lodc';
import { LodcCrowd } from 'lodc/crowd';
import './element.js';

const renderer = new THREE.WebGLRenderer({ preserveDrawingBuffer: true });
renderer.setSize(640, 480, false);
renderer.domElement.style.width = '640px';
document.body.append(renderer.domElement);

function stage() {
  const scene = new THREE.Scene();
  scene.background = new THREE.Color(0x334455);
  scene.add(new THREE.HemisphereLight(0xffffff, 0x998877, 4));
  const sun = new THREE.DirectionalLight(0xffffff, 2);
  sun.position.set(2, 3, 4);
  scene.add(sun);
  return scene;
}

/** A camera that sees all of an object. */
function cameraFor(object, away = 1) {
  object.updateWorldMatrix(true, true);
  const sphere = new THREE.Box3().setFromObject(object).getBoundingSphere(new THREE.Sphere());
  const { radius } = sphere;
  const camera = new THREE.PerspectiveCamera(45, 640 / 480, radius / 100, radius * 1000);
  camera.position.set(0.6, 0.45, 1).normalize().multiplyScalar(2.6 * away * sphere.radius);
  camera.position.add(sphere.center);
  camera.lookAt(sphere.center);
  camera.updateMatrixWorld();
  return camera;
}

function pixels() {
  const { width, height } = renderer.domElement;
  const bytes = new Uint8Array(4 * width * height);
  const gl = renderer.getContext();
  gl.readPixels(0, 0, width, height, gl.RGBA, gl.UNSIGNED_BYTE, bytes);
  return bytes;
}

function draw(object, camera) {
  const scene = stage();
  scene.add(object);
  renderer.render(scene, camera);
  return pixels();
}

/** Pixels that differ by more than 2 of 255, and those that are not the background's. */
function difference(a, b) {
  let [differ, drawn] = [0, 0];
  for (let i = 0; i < a.length; i += 4) {
    const most = Math.max(...[0, 1, 2].map((k) => Math.abs(a[i + k] - b[i + k])));
    if (most > 2) differ += 1;
    if (a[i] !== a[0] || a[i + 1] !== a[1] || a[i + 2] !== a[2]) drawn += 1;
  }
  return { differ, drawn };
}

/** Means of the colours of what is drawn: how far it is from grey. */
function colourfulness(bytes) {
  let [sum, count] = [0, 0];
  for (let i = 0; i < bytes.length; i += 4) {
    const [r, g, b] = [bytes[i], bytes[i + 1], bytes[i + 2]];
    if (r === bytes[0] && g === bytes[1] && b === bytes[2]) continue;
    sum += Math.max(r, g, b) - Math.min(r, g, b);
    count += 1;
  }
  return count === 0 ? 0 : sum / count;
}

function pose(object, clip, seconds) {
  if (!clip) return;
  const mixer = new THREE.AnimationMixer(object);
  mixer.clipAction(clip).play();
  mixer.setTime(seconds);
  object.updateMatrixWorld(true);
}

/** Draws a model and the same one as plain glTF, at the moment of an animation; how they differ. */
async function compare(url, plain, seconds = 0) {
  const model = await LodcLoader.load(url);
  await model.whenComplete;
  const gltf = await new GLTFLoader().loadAsync(plain);
  model.pixels = -1;
  const camera = cameraFor(gltf.scene);
  pose(gltf.scene, gltf.animations[0], seconds);
  const wanted = draw(gltf.scene, camera);
  pose(model, model.animations[0], seconds);
  const mine = draw(model, camera);
  const copy = model.clone();
  pose(copy, model.animations[0], seconds);
  const copied = difference(draw(copy, camera), wanted).differ;
  return {
    ...difference(mine, wanted), copied, colours: [colourfulness(mine), colourfulness(wanted)],
    clips: [model.animations.length, gltf.animations.length], triangles: model.triangles,
  };
}

/** A material without light, so that those of two kinds can be compared. */
function unlit({ name, map, color, opacity, transparent }) {
  // Those of which three.js's loader knows less are looked at, not compared.
  const visible = ['floor', 'board'].includes(name);
  const side = THREE.DoubleSide;
  return new THREE.MeshBasicMaterial({ map, color, opacity, transparent, visible, side });
}

/** Draws `boards.obj` of a file or a stream, and by three.js's own loaders. */
async function boards(url) {
  const model = await LodcLoader.load(url);
  await model.whenComplete;
  model.pixels = -1;
  const materials = model.meshes.map(({ material }) => material);
  const { map } = materials.find(({ name }) => name === 'clamped');
  const ends = [map.wrapS, map.wrapT].map((wrap) => wrap === THREE.ClampToEdgeWrapping);
  const isGrey = ({ name, color: { r, g, b } }) => name === '' && r === 0.6 && g === r && b === r;
  const missing = materials.filter(isGrey).length;
  const manager = new THREE.LoadingManager();
  const loaded = new Promise((resolve) => { manager.onLoad = resolve; });
  const mtl = await new MTLLoader(manager).loadAsync('/plain.mtl');
  mtl.preload();
  const obj = await new OBJLoader(manager).setMaterials(mtl).loadAsync('/boards.obj');
  await loaded;
  for (const object of [model, obj]) {
    object.traverse((node) => {
      if (!node.material) return;
      const { material } = node;
      node.material = Array.isArray(material) ? material.map(unlit) : unlit(material);
    });
  }
  const camera = cameraFor(obj);
  return { ...difference(draw(model, camera), draw(obj, camera)), ends, missing };
}

let streamed;

/** Begins to load, and to draw whatever has come; resolves with the first picture. */
async function begin(url) {
  const model = await LodcLoader.load(url);
  model.pixels = -1;
  const stream = { model, events: [], triangles: [], waiting: [], camera: cameraFor(model) };
  streamed = stream;
  const scene = stage();
  scene.add(model);
  const frame = () => {
    renderer.render(scene, stream.camera);
    const { triangles } = model;
    if (triangles !== stream.triangles.at(-1)) stream.triangles.push(triangles);
    stream.waiting.splice(0).forEach((drawn) => drawn());
    if (!stream.done) requestAnimationFrame(frame);
  };
  for (const type of ['grown', 'animations', 'complete']) {
    model.addEventListener(type, () => stream.events.push(type));
  }
  frame();
  stream.geometries = renderer.info.memory.geometries;
  return { triangles: model.triangles };
}

/** The next picture; fails with the stream. */
function drawn() {
  const next = new Promise((resolve) => streamed.waiting.push(resolve));
  const failed = new Promise((_, reject) => streamed.model.whenComplete.catch(reject));
  return Promise.race([next, failed]);
}

/** Waits until a stream shows more triangles than so many; how many it does. */
async function grown(triangles) {
  while (streamed.model.triangles <= triangles) await drawn();
  return streamed.model.triangles;
}

/** Waits until all of a stream has come and is drawn. */
async function whole() {
  await streamed.model.whenComplete;
  await drawn();
  return streamed.model.triangles;
}

/** Ends drawing; levels for a picture from afar and from near. */
async function finish() {
  streamed.done = true;
  const { model, events, triangles, geometries } = streamed;
  const [near, far] = [1, 40].map((away) => {
    model.pixels = 1;
    draw(model, cameraFor(model, away));
    return model.triangles;
  });
  const result = {
    near, far, triangles, complete: model.isComplete, last: events.at(-1),
    geometries: [geometries, renderer.info.memory.geometries],
    colour: colourfulness(draw(model, cameraFor(model))),
  };
  model.dispose();
  return result;
}

/** `count` copies at growing distances; what they share, and what a ray hits. */
async function crowd(url, count) {
  const model = await LodcLoader.load(url);
  await model.whenComplete;
  const scene = stage();
  const sphere = new THREE.Box3().setFromObject(model).getBoundingSphere(new THREE.Sphere());
  const copies = [];
  const side = Math.ceil(Math.sqrt(count));
  for (let i = 0; i < count; i++) {
    const copy = i === 0 ? model : model.clone();
    copy.position.set((i % side) - side / 2, 0, -Math.floor(i / side));
    copy.position.multiplyScalar(2.4 * sphere.radius);
    copies.push(copy);
    scene.add(copy);
  }
  const { radius } = sphere;
  const camera = new THREE.PerspectiveCamera(45, 640 / 480, radius / 10, radius * 1000);
  camera.position.set(0, 3 * sphere.radius, 5 * sphere.radius);
  camera.lookAt(0, 0, -6 * sphere.radius);
  camera.updateMatrixWorld();
  renderer.render(scene, camera);
  const counts = copies.map((copy) => copy.triangles);
  const geometries = new Set(copies.flatMap((copy) => copy.meshes.map(({ geometry }) => geometry)));
  const cast = (copy) => {
    const box = new THREE.Box3().setFromObject(copy, true);
    const from = box.getCenter(new THREE.Vector3());
    from.z += 100 * sphere.radius;
    const ray = new THREE.Raycaster(from, new THREE.Vector3(0, 0, -1));
    const most = Math.max(...ray.intersectObject(copy).map(({ faceIndex }) => faceIndex), -1);
    return { hit: most >= 0, faces: most };
  };
  return {
    near: Math.max(...counts.slice(0, side)), far: Math.min(...counts.slice(-side)),
    drawn: renderer.info.render.triangles, geometries: geometries.size,
    sum: counts.reduce((a, b) => a + b),
    all: Math.max(...model.objects.map(({ header }) => header.triangles)), hit: cast(model).hit,
    memory: renderer.info.memory,
  };
}

/** The same copies as clones and as a crowd: draw calls, triangles, pixels that differ. */
async function crowdOf(url, count) {
  const model = await LodcLoader.load(url);
  await model.whenComplete;
  const { radius } = new THREE.Box3().setFromObject(model).getBoundingSphere(new THREE.Sphere());
  const crowd = new LodcCrowd(model, count);
  const clones = new THREE.Group();
  const side = Math.ceil(Math.sqrt(count));
  for (let i = 0; i < count; i++) {
    const copy = model.clone();
    copy.position.set((i % side) - side / 2, 0, -Math.floor(i / side)).multiplyScalar(2.4 * radius);
    copy.rotation.y = i;
    copy.updateMatrix();
    crowd.setMatrixAt(i, copy.matrix);
    clones.add(copy);
  }
  const camera = new THREE.PerspectiveCamera(45, 640 / 480, radius / 10, radius * 1000);
  camera.position.set(0, 3 * radius, 5 * radius);
  camera.lookAt(0, 0, -6 * radius);
  camera.updateMatrixWorld();
  const wanted = draw(clones, camera);
  const calls = [renderer.info.render.calls];
  // Those that are out of sight have chosen no level.
  for (const copy of clones.children) copy.update(camera, 480);
  const triangles = [clones.children.reduce((sum, copy) => sum + copy.triangles, 0)];
  crowd.update(camera, 480);
  const drawn = draw(crowd, camera);
  calls.push(renderer.info.render.calls);
  triangles.push(crowd.triangles);
  crowd.level = 0;
  crowd.update(camera, 480);
  const finest = crowd.triangles;
  crowd.dispose();
  const again = difference(draw(model, cameraFor(model)), draw(model, cameraFor(model)));
  const whole = model.objects.reduce((sum, { header }) => sum + header.triangles, 0) * count;
  return { calls, triangles, finest, whole, again, ...difference(drawn, wanted) };
}

/**
 * Opens a file: WebAssemblies that the page's thread compiled, bytes that it sent to the worker,
 * those of them that it kept, and buffers that the model's arrays lie in.
 */
async function aside(url) {
  const { compile, instantiate, compileStreaming, instantiateStreaming } = WebAssembly;
  const functions = { compile, instantiate, compileStreaming, instantiateStreaming };
  const { postMessage } = Worker.prototype;
  let [compiled, sent, copied] = [0, 0, 0];
  for (const [name, own] of Object.entries(functions)) {
    WebAssembly[name] = (...args) => {
      compiled += 1;
      return own(...args);
    };
  }
  Worker.prototype.postMessage = function send(data, transfer) {
    sent += data.bytes?.byteLength ?? 0;
    postMessage.call(this, data, transfer);
    copied += data.bytes?.byteLength ?? 0;
  };
  const model = await LodcLoader.load(url);
  await model.whenComplete;
  Object.assign(WebAssembly, functions);
  Worker.prototype.postMessage = postMessage;
  const geometries = new Set(model.meshes.map(({ geometry }) => geometry));
  const arrays = [...geometries].flatMap(({ index, attributes }) => (
    [index, ...Object.values(attributes)].map(({ array }) => array)));
  const buffers = new Set(arrays.map(({ buffer }) => buffer)).size;
  model.dispose();
  return { compiled, sent, copied, arrays: arrays.length, buffers };
}

/** Errors of all kinds: what is said, and that nothing goes on. */
async function refused(url) {
  try {
    const model = await LodcLoader.load(url);
    await model.whenComplete;
    return 'loaded';
  } catch (error) {
    return error.message;
  }
}

async function aborted(url) {
  const controller = new AbortController();
  const loading = LodcLoader.load(url, { signal: controller.signal });
  controller.abort();
  try {
    await loading;
    return 'loaded';
  } catch (error) {
    return error.name;
  }
}

Object.assign(window, {
  compare, boards, begin, grown, whole, finish, crowd, crowdOf, aside, refused, aborted,
});
document.documentElement.dataset.ready = '';
