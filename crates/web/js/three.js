// three.js: models with continuous levels, many of which share one geometry, and streams that are
// drawn while they load.

import * as THREE from 'three';
import { GLTFLoader } from 'three/addons/loaders/GLTFLoader.js';
import { clone } from 'three/addons/utils/SkeletonUtils.js';
import { Crowd } from './crowd.js';
import { Glb } from './glb.js';
import { objects } from './geometry.js';
import { Selection, pixelSize } from './selection.js';

/** Loads `.lodc` files and `.lods` streams. */
export class LodcLoader {
  /** @param lodc a `Lodc` module */
  constructor(lodc, manager) {
    this.lodc = lodc;
    this.gltf = new GLTFLoader(manager);
  }

  /** The model of a `.lodc` file at an address. */
  async load(url) {
    const response = await fetch(url);
    if (!response.ok) throw new Error(`${url}: ${response.status}`);
    return this.parse(new Uint8Array(await response.arrayBuffer()));
  }

  /** The model of a `.lodc` file's bytes. */
  async parse(bytes) {
    return this.model(this.lodc.glb(bytes));
  }

  /** The model of a GLB with levels. */
  async model(glb) {
    const gltf = await this.gltf.parseAsync(glb.buffer, '');
    return new LodcModel(gltf, new Glb(glb));
  }

  /**
   * Loads a `.lods` stream. `shown(gltf, progress)` is called whenever half as many triangles again
   * have come, and with the whole; it may return a promise, which is waited for.
   */
  async stream(url, shown) {
    const response = await fetch(url);
    if (!response.ok) throw new Error(`${url}: ${response.status}`);
    const stream = this.lodc.stream();
    const reader = response.body.getReader();
    let drawn = 0;
    try {
      for (;;) {
        const { done, value } = await reader.read();
        const progress = done ? stream.progress : stream.feed(value);
        const [triangles] = stream.triangles();
        if (triangles > drawn * 1.5 || (done && triangles > 0)) {
          drawn = triangles;
          const gltf = await this.gltf.parseAsync(stream.mesh().buffer, '');
          await shown(gltf, progress);
        }
        if (done) return progress;
      }
    } finally {
      stream.close();
    }
  }
}

/** What all copies of a model share: geometry, materials, levels. */
export class LodcModel {
  constructor(gltf, glb) {
    this.animations = gltf.animations;
    this.scene = gltf.scene;
    this.objects = objects(glb);
    const ladder = (object) => object && new Crowd(new Selection([object.levels]));
    this.ladders = this.objects.map(ladder);
    const parts = new Map();
    // Animations find nodes by name, or by a number that copies do not share.
    gltf.scene.traverse((node) => {
      node.name ||= node.uuid;
    });
    gltf.scene.traverse((mesh) => {
      const of = gltf.parser.associations.get(mesh);
      if (!mesh.isMesh || of?.meshes === undefined) return;
      const object = this.objects[of.meshes];
      const part = object && this.part(glb, of, object);
      if (!part) return;
      const ladder = this.ladders[of.meshes];
      if (!parts.has(part)) parts.set(part, this.share(mesh.geometry, ladder, part));
      mesh.geometry = parts.get(part);
      mesh.userData.lodc = { object: of.meshes, part: object.parts.indexOf(part) };
    });
  }

  /** The part of a primitive; none of one that is no triangle mesh. */
  part(glb, { meshes, primitives = 0 }, object) {
    const all = glb.json.meshes[meshes].primitives;
    const number = all.slice(0, primitives).filter((p) => p.extras?.lodc).length;
    return all[primitives].extras?.lodc ? object.parts[number] : null;
  }

  /** The geometry with the indices of all rungs of a ladder. */
  share(geometry, ladder, part) {
    const { indices } = ladder.ranges.get(part.submesh);
    geometry.setIndex(new THREE.BufferAttribute(indices, 1));
    geometry.computeBoundingSphere();
    return geometry;
  }
}

/**
 * One copy of a model. Its vertices, indices and materials are those of the model; only the range
 * of indices that is drawn is its own.
 */
export class LodcMesh extends THREE.Group {
  /** @param pixels a level errs by at most so many pixels */
  constructor(model, pixels = 1) {
    super();
    this.model = model;
    this.pixels = pixels;
    this.content = clone(model.scene);
    this.add(this.content);
    this.meshes = [];
    this.content.traverse((mesh) => {
      const lodc = mesh.userData.lodc;
      if (!mesh.isMesh || lodc?.part === undefined) return;
      mesh.geometry = shared(mesh.geometry);
      this.meshes.push({ mesh, ...lodc });
    });
    this.rungs = model.objects.map(() => 0);
    this.show(this.rungs);
  }

  /** Chooses levels for a camera and a picture of so many pixels in height. */
  update(camera, height) {
    this.updateWorldMatrix(true, true);
    const scale = this.matrixWorld.getMaxScaleOnAxis();
    const pixel = pixelSize(THREE.MathUtils.degToRad(camera.fov), height) / camera.zoom;
    const eye = new THREE.Vector3().setFromMatrixPosition(camera.matrixWorld);
    const allowed = this.model.objects.map(() => Infinity);
    const sphere = new THREE.Sphere();
    for (const { mesh, object } of this.meshes) {
      sphere.copy(mesh.geometry.boundingSphere).applyMatrix4(mesh.matrixWorld);
      const away = Math.max(eye.distanceTo(sphere.center) - sphere.radius, camera.near);
      allowed[object] = Math.min(allowed[object], (this.pixels * pixel * away) / scale);
    }
    this.show(this.model.ladders.map((ladder, object) => (
      ladder ? Math.max(ladder.levels.findLastIndex((l) => l.error <= allowed[object]), 0) : 0)));
  }

  /** Shows one rung for each object; 0 is the finest. */
  show(rungs) {
    this.rungs = rungs;
    for (const { mesh, object, part } of this.meshes) {
      const { submesh } = this.model.objects[object].parts[part];
      const { first, count } = this.model.ladders[object].ranges.get(submesh);
      mesh.geometry.setDrawRange(first[rungs[object]], count[rungs[object]]);
    }
  }

  /** Triangles at the present levels. */
  get triangles() {
    return this.meshes.reduce((sum, { mesh }) => sum + mesh.geometry.drawRange.count / 3, 0);
  }
}

/** A geometry with a draw range of its own over the same buffers. */
function shared(geometry) {
  const own = new THREE.BufferGeometry();
  own.index = geometry.index;
  Object.assign(own.attributes, geometry.attributes);
  Object.assign(own.morphAttributes, geometry.morphAttributes);
  own.morphTargetsRelative = geometry.morphTargetsRelative;
  own.boundingSphere = geometry.boundingSphere;
  own.boundingBox = geometry.boundingBox;
  return own;
}
