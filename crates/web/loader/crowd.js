// Many copies of a model with few draw calls: those of one level are instances of one mesh.

import * as THREE from 'three';
import { allowed } from './model.js';

const sphere = new THREE.Sphere();
const eye = new THREE.Vector3();
const placed = new THREE.Matrix4();
const inverse = new THREE.Matrix4();

/** A geometry of its own with the same buffers, for a range of its own. */
function sharing(geometry) {
  const shared = new THREE.BufferGeometry();
  Object.assign(shared, { index: geometry.index, boundingBox: geometry.boundingBox });
  Object.assign(shared.attributes, geometry.attributes);
  shared.boundingSphere = geometry.boundingSphere;
  return shared;
}

/** `count` copies of a model without skins and morph targets; `crowd.d.ts` has its members. */
export class LodcCrowd extends THREE.Group {
  constructor(model, count) {
    super();
    const moves = ({ isSkinnedMesh, geometry }) => (
      isSkinnedMesh || geometry.morphTargetsRelative);
    if (model.meshes.some(moves)) {
      throw new Error('a crowd has no skins and no morph targets: clone the model instead');
    }
    Object.assign(this, { model, count, pixels: 1, level: null });
    this.matrices = Array.from({ length: count }, () => new THREE.Matrix4());
    // By level, counted from the coarsest, an `InstancedMesh`.
    this.parts = model.meshes.map((mesh) => ({ mesh, local: new THREE.Matrix4(), levels: [] }));
  }

  setMatrixAt(index, matrix) {
    this.matrices[index].copy(matrix);
  }

  getMatrixAt(index, matrix) {
    return matrix.copy(this.matrices[index]);
  }

  /** The copies of a part at a level. */
  instances(part, level) {
    if (!part.levels[level]) {
      const { mesh: { geometry, material, castShadow, receiveShadow, name } } = part;
      const mesh = new THREE.InstancedMesh(sharing(geometry), material, this.count);
      mesh.instanceMatrix.setUsage(THREE.DynamicDrawUsage);
      Object.assign(mesh, { castShadow, receiveShadow, name, frustumCulled: false, count: 0 });
      part.levels[level] = mesh;
      this.add(mesh);
    }
    return part.levels[level];
  }

  update(camera, height) {
    this.updateWorldMatrix(true, false);
    this.model.updateWorldMatrix(true, true);
    inverse.copy(this.model.matrixWorld).invert();
    eye.setFromMatrixPosition(camera.matrixWorld);
    for (const part of this.parts) {
      const { mesh, local, levels } = part;
      const { object, part: number } = mesh.lodc;
      local.multiplyMatrices(inverse, mesh.matrixWorld);
      for (const instances of levels) if (instances) instances.count = 0;
      for (const matrix of this.matrices) {
        placed.multiplyMatrices(matrix, local);
        const instances = this.instances(part, this.choose(mesh, object, camera, height));
        instances.setMatrixAt(instances.count++, placed);
      }
      levels.forEach((instances, level) => {
        const { start, count } = object.range(number, level);
        instances.geometry.setDrawRange(start, count);
        instances.instanceMatrix.needsUpdate = true;
        instances.visible = instances.count > 0 && count > 0;
      });
    }
  }

  /** The level, from the coarsest, of the copy that stands at `placed`. */
  choose(mesh, object, camera, height) {
    const last = object.levels.length - 1;
    if (typeof this.level === 'number') return Math.max(last - Math.round(this.level), 0);
    const world = placed.clone().premultiply(this.matrixWorld);
    sphere.copy(mesh.geometry.boundingSphere).applyMatrix4(world);
    const distance = eye.distanceTo(sphere.center) - sphere.radius;
    const error = allowed(camera, height, this.pixels, distance);
    return Math.max(object.choose(error / world.getMaxScaleOnAxis()), 0);
  }

  get triangles() {
    const drawn = this.parts.flatMap(({ levels }) => levels.filter(({ visible }) => visible));
    return drawn.reduce((sum, { geometry: { drawRange }, count }) => (
      sum + (count * drawRange.count) / 3), 0);
  }

  dispose() {
    for (const mesh of this.parts.flatMap(({ levels }) => levels.filter(Boolean))) {
      // The buffers belong to the model.
      Object.assign(mesh.geometry, { index: null, attributes: {} });
      mesh.geometry.dispose();
      mesh.dispose();
    }
  }
}
