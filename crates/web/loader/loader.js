// `LodcLoader`: models of `.lodc` files and `.lods` streams for three.js, from the first byte on.

import * as THREE from 'three';
import { GLTFLoader } from 'three/addons/loaders/GLTFLoader.js';
import { WASM } from './decoder.js';
import { read } from './message.js';
import { documentOf } from './mtl.js';
import {
  LodcMesh, LodcModel, LodcObject, LodcSkinnedMesh, materialsOf, texturesOf,
} from './model.js';

export { LodcMesh, LodcModel, LodcSkinnedMesh } from './model.js';

/** The worker, shared by all loaders, and what it tells to whom. */
const decoding = { worker: null, listeners: new Map(), next: 0 };
/** Milliseconds after which a worker without work is ended, and its memory with it. */
const IDLE = 5000;

function worker() {
  clearTimeout(decoding.idle);
  if (decoding.worker) return decoding.worker;
  const made = started();
  made.onmessage = ({ data }) => decoding.listeners.get(data.id)?.(data);
  made.onerror = (event) => {
    const error = `the decoder does not start: ${event.message ?? 'blocked'}`;
    for (const listener of [...decoding.listeners.values()]) listener({ error });
    endWorker();
  };
  decoding.worker = made;
  return made;
}

function started() {
  try {
    return new Worker(new URL('./worker.js', import.meta.url), { type: 'module' });
  } catch {
    // From another origin a worker can only be imported.
    const address = new URL('./worker.js', import.meta.url).href;
    const text = `import ${JSON.stringify(address)};`;
    const blob = new Blob([text], { type: 'text/javascript' });
    return new Worker(URL.createObjectURL(blob), { type: 'module' });
  }
}

function endWorker() {
  decoding.worker?.terminate();
  decoding.worker = null;
}

/** The next picture, or a moment where none is drawn. */
const picture = () => new Promise((resolve) => {
  const late = setTimeout(resolve, 100);
  requestAnimationFrame(() => {
    clearTimeout(late);
    resolve();
  });
});

/** Loads `.lodc` files and `.lods` streams. The file says which of them it is. */
export class LodcLoader extends THREE.Loader {
  constructor(manager) {
    super(manager);
    /** Makes materials, nodes, skins, animations and images; its own loaders can be set. */
    this.gltf = new GLTFLoader(this.manager);
    this.aborts = new Set();
  }

  /** Loads a model. `options`: `signal`, `onProgress`, `manager`. */
  static load(url, { manager, ...options } = {}) {
    return new LodcLoader(manager).loadAsync(url, options.onProgress, options);
  }

  /**
   * `onLoad` is called with a `LodcModel` when it can be drawn, which of a stream is after its
   * first blocks; `onProgress` as bytes come.
   */
  load(url, onLoad, onProgress, onError, { signal } = {}) {
    const report = (error) => {
      if (onError) onError(error);
      else console.error(error);
      this.manager.itemError(url);
    };
    this.open(url, onProgress, signal).then(onLoad, report);
  }

  loadAsync(url, onProgress, options) {
    return new Promise((resolve, reject) => {
      this.load(url, resolve, onProgress, reject, options);
    });
  }

  /** Stops all that this loader is loading. Models stay as they are. */
  abort() {
    for (const abort of this.aborts) abort.abort();
    return this;
  }

  async open(url, onProgress, signal) {
    const abort = new AbortController();
    const stop = () => abort.abort(signal.reason);
    if (signal?.aborted) stop();
    signal?.addEventListener('abort', stop);
    this.aborts.add(abort);
    this.manager.itemStart(url);
    const full = new URL(this.manager.resolveURL((this.path ?? '') + url), document.baseURI).href;
    const base = this.resourcePath || THREE.LoaderUtils.extractUrlBase(full);
    const opening = new Opening(this, base, abort);
    const whole = opening.whole(full, url, onProgress).finally(() => {
      signal?.removeEventListener('abort', stop);
      this.aborts.delete(abort);
      this.manager.itemEnd(url);
    });
    opening.model.loading.whole = whole;
    // Whoever does not look at it is told by the first promise, or does not care.
    whole.catch(() => {});
    return opening.shown;
  }
}

/** A model on its way. */
class Opening {
  constructor(loader, base, abort) {
    const { signal } = abort;
    Object.assign(this, { loader, base, abort, signal });
    this.model = new LodcModel();
    this.headers = [];
    this.came = [];
    this.waiting = [];
    this.textures = [];
    this.shown = new Promise((resolve, reject) => {
      this.show = resolve;
      this.fail = reject;
    });
  }

  /** Loads, decodes and builds until everything is there. */
  async whole(full, url, onProgress) {
    const id = decoding.next++;
    const send = (data, transfer) => worker().postMessage({ id, ...data }, transfer);
    const ended = new Promise((resolve, reject) => {
      decoding.listeners.set(id, (data) => {
        if (data.error) return reject(new Error(`${url}: ${data.error}`));
        try {
          this.take(data.message);
        } catch (error) {
          return reject(error);
        }
        if (this.complete) return resolve();
        if (data.ended) return reject(new Error(`${url}: the file is cut off, or came incomplete`));
        picture().then(() => send({ next: true }));
        return undefined;
      });
      this.signal.addEventListener('abort', () => reject(this.signal.reason));
    });
    try {
      this.signal.throwIfAborted();
      send({ wasm: WASM });
      await Promise.race([this.fetch(full, url, onProgress, send), ended]);
      await ended;
      this.refuse(new Error(`${url}: the file is incomplete`));
      await this.shown;
      await this.rest();
    } catch (error) {
      if (decoding.worker) send({ drop: true });
      this.refuse(error);
      this.fail(error);
      this.abort.abort(error);
      throw error;
    } finally {
      decoding.listeners.delete(id);
      if (decoding.listeners.size === 0) decoding.idle = setTimeout(endWorker, IDLE);
    }
    this.model.loading.isComplete = true;
    this.model.dispatchEvent({ type: 'complete' });
    return this.model;
  }

  async fetch(full, url, onProgress, send) {
    const { requestHeader, withCredentials } = this.loader;
    const credentials = withCredentials ? 'include' : 'same-origin';
    const options = { headers: requestHeader, credentials, signal: this.signal };
    const response = await fetch(full, options);
    if (!response.ok) throw new Error(`${url}: ${response.status} ${response.statusText}`);
    const total = Number(response.headers.get('Content-Length') ?? 0);
    let loaded = 0;
    const reader = response.body.getReader();
    for (;;) {
      const { done, value } = await reader.read();
      if (done) break;
      const isPage = loaded === 0 && /^\s*</.test(String.fromCharCode(...value.subarray(0, 99)));
      if (isPage) throw new Error(`${url} is HTML, not a .lodc file`);
      loaded += value.byteLength;
      const lengthComputable = total > 0;
      onProgress?.(new ProgressEvent('progress', { lengthComputable, loaded, total }));
      send({ bytes: value }, [value.buffer]);
    }
    send({ end: true });
  }

  /** Takes a message of the decoder. */
  take(message) {
    const { model } = this;
    read(message, this.headers, {
      document: (scene) => {
        this.scene = scene;
        this.buffer = new Uint8Array(scene.buffer);
      },
      buffer: (at, bytes) => this.takeBuffer(at, bytes),
      object: (header) => {
        model.objects[header.number] = new LodcObject(header);
      },
      vertices: (number, first, count, arrays) => model.objects[number].vertices(first, arrays),
      levels: (number, levels, first, indices) => {
        model.objects[number].addLevels(levels, first, indices);
      },
      complete: () => {
        this.complete = true;
      },
    });
    const all = this.scene && this.headers.filter(Boolean).length === this.scene.objects;
    if ((all || this.complete) && !this.building) {
      this.building = this.build().then(this.show, this.fail);
    }
    model.dispatchEvent({ type: 'grown' });
  }

  takeBuffer(at, bytes) {
    this.buffer.set(bytes, at);
    this.came.push([at, at + bytes.length]);
    this.came.sort((a, b) => a[0] - b[0]);
    this.came = this.came.reduce((runs, [start, end]) => {
      const last = runs.at(-1);
      if (last && start <= last[1]) last[1] = Math.max(last[1], end);
      else runs.push([start, end]);
      return runs;
    }, []);
    this.waiting = this.waiting.filter((wait) => !wait());
  }

  /** Bytes of the buffer, when they have come. */
  bytes(start, length) {
    return new Promise((resolve, reject) => {
      const wait = () => {
        const there = length === 0
          || this.came.some(([from, to]) => from <= start && start + length <= to);
        if (there) resolve(this.buffer.slice(start, start + length).buffer);
        else if (this.error) reject(this.error);
        return there || Boolean(this.error);
      };
      if (!wait()) this.waiting.push(wait);
    });
  }

  /** Nothing more will come: says why to whoever waits. */
  refuse(error) {
    this.error = error;
    this.waiting = this.waiting.filter((wait) => !wait());
  }

  /** Makes the scene of what has come. */
  async build() {
    const { gltf } = this.loader;
    const [first = { submeshes: [] }] = this.headers;
    const json = this.scene.document ?? documentOf(this.scene, first);
    this.animations = json.animations;
    delete json.animations;
    splitOthers(json, this.headers);
    // Before others, which would wait for their images; asked for at once.
    gltf.pluginCallbacks.unshift((parser) => new Plugin(parser, this));
    const parsed = new Promise((resolve, reject) => {
      gltf.parse(json, this.base, resolve, reject);
    });
    gltf.pluginCallbacks.shift();
    const result = await parsed;
    const { model } = this;
    for (const child of [...result.scene.children]) model.add(child);
    model.name = result.scene.name;
    model.userData = result.scene.userData;
    model.cameras = result.cameras;
    model.parser = result.parser;
    // Animations find nodes by their names, since copies have other numbers.
    model.traverse((node) => {
      if (node !== model) node.name ||= `node_${node.id}`;
    });
    return model;
  }

  /** Waits for images, which come as they do, and animations. */
  async rest() {
    const { model, animations } = this;
    if (animations) {
      model.parser.json.animations = animations;
      const clips = animations.map((_, i) => model.parser.getDependency('animation', i));
      model.animations.push(...await Promise.all(clips));
      model.dispatchEvent({ type: 'animations' });
    }
    await Promise.all(this.textures);
  }
}

/** Primitives of points and lines become meshes of their own, which are loaded as ever. */
function splitOthers(json, headers) {
  for (const { mesh, submeshes } of headers) {
    const definition = json.meshes?.[mesh];
    const ours = new Set(submeshes.map(({ primitive }) => primitive));
    const others = definition?.primitives.filter((_, i) => !ours.has(i)) ?? [];
    if (others.length === 0) continue;
    definition.others = json.meshes.length;
    json.meshes.push({ ...definition, primitives: others });
  }
}

const FLAT = { normalTexture: [128, 128, 255], emissiveTexture: [0, 0, 0] };

/** What a texture shows before its image has come: nothing that changes a material's factors. */
function placeholder(json, number) {
  const use = (json.materials ?? []).flatMap(Object.entries).find(([, value]) => (
    value?.index === number));
  const [r, g, b] = FLAT[use?.[0]] ?? [255, 255, 255];
  const image = new ImageData(new Uint8ClampedArray([r, g, b, 255]), 1, 1);
  const texture = new THREE.Texture(image);
  texture.flipY = false;
  texture.needsUpdate = true;
  return texture;
}

/** Gives three's glTF loader the objects, the buffer and images that come later. */
class Plugin {
  constructor(parser, opening) {
    this.name = 'lodc';
    Object.assign(this, { parser, opening });
  }

  loadBufferView(index) {
    const { buffer, byteOffset = 0, byteLength } = this.parser.json.bufferViews[index];
    const isOurs = buffer === 0 && this.parser.json.buffers?.[0]?.uri === undefined;
    return isOurs ? this.opening.bytes(byteOffset, byteLength) : null;
  }

  loadTexture(index) {
    const texture = placeholder(this.parser.json, index);
    const others = this.parser._invokeOne((plugin) => (
      plugin !== this && plugin.loadTexture ? plugin.loadTexture(index) : null));
    const { model } = this.opening;
    const arrived = Promise.resolve(others).then(async (real) => {
      await this.opening.shown;
      // One for each picture: a large image takes a while to be uploaded.
      this.opening.uploads = (this.opening.uploads ?? Promise.resolve()).then(picture);
      await this.opening.uploads;
      // three's loader has said so: the material's factors stay.
      if (!real) return;
      const { source } = texture;
      const all = [...materialsOf(model)].flatMap(texturesOf);
      for (const user of new Set(all.filter((other) => other.source === source))) {
        user.dispose();
        const { magFilter, minFilter, wrapS, wrapT, generateMipmaps, format, mipmaps } = real;
        const { name, isCompressedTexture } = real;
        Object.assign(user, { magFilter, minFilter, wrapS, wrapT, generateMipmaps });
        Object.assign(user, { format, mipmaps, name, source: real.source });
        if (isCompressedTexture) user.isCompressedTexture = true;
        user.needsUpdate = true;
      }
      model.dispatchEvent({ type: 'grown' });
    });
    arrived.catch(() => {});
    this.opening.textures.push(arrived);
    return Promise.resolve(texture);
  }

  loadMesh(index) {
    const { parser, opening } = this;
    const object = opening.model.objects.find((one) => one?.header.mesh === index);
    return object ? this.mesh(parser.json.meshes[index], index, object) : null;
  }

  async mesh(definition, index, object) {
    const { parser } = this;
    const { submeshes } = object.header;
    const skinned = definition.isSkinnedMesh === true;
    const meshes = await Promise.all(submeshes.map(async ({ primitive }, part) => {
      const { material, extensions } = definition.primitives[primitive];
      const found = material === undefined
        ? new THREE.MeshStandardMaterial({ color: 0xffffff, metalness: 1, roughness: 1 })
        : await parser.getDependency('material', material);
      const geometry = object.geometry(part);
      const mesh = skinned && geometry.attributes.skinWeight
        ? new LodcSkinnedMesh(geometry, found) : new LodcMesh(geometry, found);
      weigh(mesh, definition);
      if (geometry.morphTargetsRelative) object.users.add(new WeakRef(mesh));
      mesh.name = parser.createUniqueName(definition.name || `mesh_${index}`);
      if (definition.extras) Object.assign(mesh.userData, definition.extras);
      if (extensions) mesh.userData.gltfExtensions = extensions;
      parser.assignFinalMaterial(mesh);
      parser.associations.set(mesh, { meshes: index, primitives: primitive });
      return mesh;
    }));
    if (definition.others !== undefined) {
      meshes.push(await parser.getDependency('mesh', definition.others));
    }
    if (meshes.length === 1) return meshes[0];
    const group = new THREE.Group();
    group.add(...meshes);
    parser.associations.set(group, { meshes: index });
    return group;
  }
}

/** The weights and names of morph targets that a glTF mesh states. */
function weigh(mesh, { weights = [], extras }) {
  mesh.updateMorphTargets();
  const influences = mesh.morphTargetInfluences;
  if (!influences) return;
  weights.forEach((weight, i) => {
    influences[i] = weight;
  });
  const names = extras?.targetNames;
  if (Array.isArray(names) && names.length === influences.length) {
    mesh.morphTargetDictionary = Object.fromEntries(names.map((name, i) => [name, i]));
  }
}
