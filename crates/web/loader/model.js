// A model whose meshes choose their levels by themselves, whenever they are drawn.

import * as THREE from 'three';

const sphere = new THREE.Sphere();
const point = new THREE.Vector3();
const viewport = new THREE.Vector4();

/** Vertices from which the extent of a skinned mesh is taken: a coarse level's come first. */
const EXTENT = 1000;

/** Triangles in the lists of all levels of an object, and of those that stay when more come: as
 * the decoder makes them. */
const listed = (triangles) => Math.min(Math.max(2e6 / triangles, 3), 11) * triangles;

/** The error in world units that is `pixels` high at a distance from a camera. */
export function allowed(camera, height, pixels, distance) {
  const perPixel = 2 / (camera.projectionMatrix.elements[5] * height);
  return pixels * perPixel * (camera.isOrthographicCamera ? 1 : Math.max(distance, camera.near));
}

function heightOf(renderer) {
  const target = renderer.getRenderTarget();
  return target ? target.height : renderer.getViewport(viewport).w * renderer.getPixelRatio();
}

/** The shared part of an object: arrays with room, and where its levels lie in the index. */
export class LodcObject {
  constructor(header) {
    this.header = header;
    this.levels = [];
    this.box = new THREE.Box3();
    this.geometries = [];
    // Meshes with morph targets, whose geometry is made anew when it grows.
    this.users = new Set();
    if (header.vertices > 0) return;
    this.vertices(0, [new Float32Array(0), ...header.attributes.map(({ Type }) => new Type(0))]);
    this.addLevels([], 0, new Uint32Array(0));
  }

  /** Takes the vertices from `first` on: into arrays with room for all, or as the arrays. */
  vertices(first, arrays) {
    const { vertices, attributes } = this.header;
    const all = arrays[0].length === 3 * vertices;
    this.attributes ??= [{ Type: Float32Array, width: 3 }, ...attributes].map((a, i) => (
      new THREE.BufferAttribute(all ? arrays[i] : new a.Type(a.width * vertices), a.width,
        a.normalized)));
    if (!all) this.attributes.forEach((a, i) => put(a, first * a.itemSize, arrays[i]));
    for (let i = 0; i < arrays[0].length; i += 3) {
      this.box.expandByPoint(point.fromArray(arrays[0], i));
    }
  }

  /** Takes levels whose indices lie from `first` on; what was there goes. */
  addLevels(levels, first, indices) {
    this.levels = this.levels.filter((level) => level.end <= first);
    let at = first;
    for (const { error, triangles } of levels) {
      const ranges = triangles.map((count) => {
        const range = { start: at, count: 3 * count };
        at += 3 * count;
        return range;
      });
      const total = triangles.reduce((sum, count) => sum + count, 0);
      this.levels.push({ error, triangles: total, ranges, end: at });
    }
    const all = first === 0 && this.levels.at(-1)?.triangles === this.header.triangles;
    const { triangles: most } = this.header;
    // The present one comes behind those that stay.
    this.index ??= new THREE.BufferAttribute(
      all ? indices : new Uint32Array(3 * Math.ceil(listed(most) + most)), 1);
    if (!all) put(this.index, first, indices);
    this.geometries.forEach((geometry, part) => this.grow(geometry, part));
  }

  /** The geometry of a submesh: attributes of the object, and a range of its index. */
  geometry(part) {
    if (this.geometries[part]) return this.geometries[part];
    const geometry = new THREE.BufferGeometry();
    geometry.index = this.index;
    geometry.userData.lodc = { object: this, part };
    [geometry.attributes.position] = this.attributes;
    for (const stream of this.header.submeshes[part].streams) {
      const { name, target } = this.header.attributes[stream];
      const attribute = this.attributes[stream + 1];
      // A source's own form of positions stands for those of all objects.
      if (name !== null && target < 0) geometry.attributes[name] = attribute;
      if (target >= 0 && ['position', 'normal', 'color'].includes(name)) {
        (geometry.morphAttributes[name] ??= [])[target] = attribute;
        geometry.morphTargetsRelative = true;
      }
    }
    geometry.boundingSphere = new THREE.Sphere();
    geometry.boundingBox = this.box;
    this.geometries[part] = geometry;
    this.measure(geometry);
    this.finest(geometry);
    return geometry;
  }

  /** Makes a geometry show what has come since. */
  grow(geometry, part) {
    if (geometry.morphTargetsRelative) {
      // Morph targets are in a texture that is made once for each geometry.
      delete this.geometries[part];
      const fresh = this.geometry(part);
      for (const user of this.users) {
        const mesh = user.deref();
        if (!mesh) this.users.delete(user);
        else if (mesh.geometry === geometry) mesh.geometry = fresh;
      }
      // Its buffers belong to the fresh one.
      Object.assign(geometry, { index: null, attributes: {} });
      geometry.dispose();
      return;
    }
    this.measure(geometry);
    this.finest(geometry);
  }

  measure(geometry) {
    this.box.getBoundingSphere(geometry.boundingSphere);
    for (const target of geometry.morphAttributes.position ?? []) {
      geometry.boundingSphere.radius += reach(target);
    }
  }

  /** What draws a geometry in another way than by our meshes shows all triangles. */
  finest(geometry) {
    this.show(geometry, this.levels.length - 1);
  }

  /** Makes the range of a geometry that of a level. */
  show(geometry, level) {
    const { start, count } = this.range(geometry.userData.lodc.part, level);
    geometry.setDrawRange(start, count);
  }

  range(part, level) {
    const at = Math.min(level ?? Infinity, this.levels.length - 1);
    return this.levels[at]?.ranges[part] ?? { start: 0, count: 0 };
  }

  /** The coarsest level whose error is allowed, in the object's units; else the finest. */
  choose(error) {
    const at = this.levels.findIndex((level) => level.error <= error);
    return at < 0 ? this.levels.length - 1 : at;
  }
}

/** How far a morph target moves the first vertices at most. */
function reach(target) {
  let most = 0;
  for (let v = 0; v < Math.min(target.count, EXTENT); v++) {
    most = Math.max(most, point.fromBufferAttribute(target, v).length());
  }
  return most;
}

/** Puts values into an attribute from a place on. */
function put(attribute, at, values) {
  attribute.array.set(values, at);
  attribute.addUpdateRange(at, values.length);
  attribute.needsUpdate = true;
}

/** Adds levels to a class of meshes. */
const Levelled = (Base) => class extends Base {
  get lodc() {
    return this.geometry.userData.lodc;
  }

  /** The level that was drawn last, counted from the finest, 0. */
  get level() {
    const last = this.lodc.object.levels.length - 1;
    return Math.max(last - (this.shown ?? last), 0);
  }

  /** The model that this mesh is part of: itself or the copy that it belongs to. */
  get model() {
    let node = this;
    while (node && !node.isLodcModel) node = node.parent;
    return node;
  }

  /** Chooses the level for a camera and a picture `height` pixels high. */
  choose(camera, height) {
    const { object } = this.lodc;
    const model = this.model;
    if (typeof model?.level === 'number') {
      this.shown = Math.max(object.levels.length - 1 - Math.round(model.level), 0);
      return;
    }
    const bounds = this.boundingSphere ?? this.geometry.boundingSphere;
    sphere.copy(bounds).applyMatrix4(this.matrixWorld);
    const distance = point.setFromMatrixPosition(camera.matrixWorld).distanceTo(sphere.center);
    // Joints scale a skinned mesh, not its own node.
    const scale = this.isSkinnedMesh && model
      ? object.header.scale * model.matrixWorld.getMaxScaleOnAxis()
      : this.matrixWorld.getMaxScaleOnAxis();
    const error = allowed(camera, height, model?.pixels ?? 1, distance - sphere.radius);
    this.shown = object.choose(error / scale);
  }

  onBeforeRender(renderer, scene, camera, geometry) {
    this.choose(camera, heightOf(renderer));
    this.lodc.object.show(geometry, this.shown);
  }

  onAfterRender(renderer, scene, camera, geometry) {
    this.lodc.object.finest(geometry);
  }

  onBeforeShadow(renderer, object, camera, shadowCamera, geometry) {
    this.lodc.object.show(geometry, this.shown);
  }

  onAfterShadow(renderer, object, camera, shadowCamera, geometry) {
    this.lodc.object.finest(geometry);
  }

  raycast(raycaster, hits) {
    this.lodc.object.show(this.geometry, this.shown);
    super.raycast(raycaster, hits);
    this.lodc.object.finest(this.geometry);
  }

  copy(source, recursive) {
    super.copy(source, recursive);
    if (source.geometry.morphTargetsRelative) this.lodc.object.users.add(new WeakRef(this));
    return this;
  }

  /** Triangles of the present level. */
  get triangles() {
    const { object, part } = this.lodc;
    return object.range(part, this.shown).count / 3;
  }
};

export class LodcMesh extends Levelled(THREE.Mesh) {}

export class LodcSkinnedMesh extends Levelled(THREE.SkinnedMesh) {
  /** The extent of the first vertices, which are those of a coarse level, in the present pose. */
  computeBoundingSphere() {
    const { object } = this.lodc;
    const box = new THREE.Box3();
    const count = Math.min(object.header.vertices, EXTENT);
    for (let v = 0; v < count; v++) box.expandByPoint(this.getVertexPosition(v, point));
    this.boundingSphere ??= new THREE.Sphere();
    box.getBoundingSphere(this.boundingSphere);
    const level = object.levels.find(({ end }) => end > 0);
    const finite = Number.isFinite(level?.error) ? level.error : 0;
    this.boundingSphere.radius = this.boundingSphere.radius * 1.1 + finite;
  }
}

/** What a loader gives; `loader.d.ts` says what each member is. */
export class LodcModel extends THREE.Group {
  constructor() {
    super();
    this.isLodcModel = true;
    this.type = 'LodcModel';
    this.pixels = 1;
    this.level = null;
    this.animations = [];
    this.cameras = [];
    /** What has come, of copies, too. */
    this.loading = { isComplete: false, whole: Promise.resolve() };
    this.objects = [];
    this.parser = null;
  }

  get isComplete() {
    return this.loading.isComplete;
  }

  get whenComplete() {
    return this.loading.whole.then(() => this);
  }

  get meshes() {
    const meshes = [];
    this.traverse((node) => {
      if (node.isMesh && node.geometry.userData.lodc) meshes.push(node);
    });
    return meshes;
  }

  get triangles() {
    return this.meshes.reduce((sum, mesh) => sum + mesh.triangles, 0);
  }

  update(camera, height) {
    this.updateWorldMatrix(true, true);
    for (const mesh of this.meshes) mesh.choose(camera, height);
  }

  copy(source, recursive = true) {
    super.copy(source, recursive);
    const { pixels, level, animations, cameras, loading, objects, parser } = source;
    Object.assign(this, { pixels, level, animations, cameras, loading, objects, parser });
    if (recursive) rebind(source, this);
    return this;
  }

  /** Frees buffers, materials and textures of this model and all its copies. */
  dispose() {
    for (const { geometries } of this.objects) geometries.forEach((geometry) => geometry.dispose());
    for (const material of materialsOf(this)) {
      for (const texture of texturesOf(material)) {
        texture.source.data?.close?.();
        texture.dispose();
      }
      material.dispose();
    }
    this.traverse((node) => node.skeleton?.dispose());
  }
}

/** Gives the skinned meshes of a copy the bones of the copy. */
function rebind(source, copy) {
  const twins = new Map();
  const pair = (a, b) => {
    twins.set(a, b);
    a.children.forEach((child, i) => pair(child, b.children[i]));
  };
  pair(source, copy);
  const skeletons = new Map();
  for (const [a, b] of twins) {
    if (!a.isSkinnedMesh) continue;
    const { skeleton } = a;
    if (!skeletons.has(skeleton)) {
      const bones = skeleton.bones.map((bone) => twins.get(bone) ?? bone);
      skeletons.set(skeleton, new THREE.Skeleton(bones, skeleton.boneInverses));
    }
    b.bind(skeletons.get(skeleton), a.bindMatrix);
    b.boundingSphere = null;
  }
}

/** The materials of a model, each once. */
export function materialsOf(model) {
  const all = new Set();
  model.traverse((node) => {
    if (node.material) [node.material].flat().forEach((material) => all.add(material));
  });
  return all;
}

/** The textures of a material. */
export function texturesOf(material) {
  return Object.values(material).filter((value) => value?.isTexture);
}
