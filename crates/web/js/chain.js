// three.js: chains of levels as `lodc chain` writes them, shown by distance. Those of --geomorph
// geomorph: a level has become the next one where that one begins.

import * as THREE from 'three';
import { clone } from 'three/addons/utils/SkeletonUtils.js';
import { ChainLevels, TARGET } from './chainlevels.js';
import { pixelSize } from './selection.js';

export { ChainLevels };

/** What all copies of a chain share: `await ChainModel.of(gltf)`, of what three's loader made. */
export class ChainModel {
  static async of(gltf) {
    const { json } = gltf.parser;
    const model = new ChainModel(gltf.scene, gltf.animations, new ChainLevels(json));
    const nodes = (json.nodes ?? []).map((node, i) => [i, node.extensions?.MSFT_lod?.ids]);
    // Level 0 stands in the scene; the others beside it, with its transform.
    for (const [node, ids] of nodes.filter(([, others]) => others)) {
      const first = await gltf.parser.getDependency('node', node);
      model.mark(first, 0);
      for (const [k, id] of ids.entries()) {
        const level = await gltf.parser.getDependency('node', id);
        first.parent.add(level);
        model.mark(level, k + 1);
      }
    }
    return model;
  }

  constructor(scene, animations, levels) {
    Object.assign(this, { scene, animations, levels });
    scene.traverse((node) => {
      // Animations find nodes by name, or by a number that copies do not share.
      node.name ||= node.uuid;
    });
  }

  /** Marks the meshes of a node, not those of its children: primitives are no nodes. */
  mark(node, level) {
    const own = node.isMesh ? [node] : node.children.filter((c) => c.isMesh && !c.userData.name);
    for (const mesh of own) mesh.userData.lodcLevel = level;
    node.name ||= node.uuid;
  }
}

/** One copy of a chain, at one of its levels, on its way to the next one. */
export class LodcChain extends THREE.Group {
  /**
   * @param model a `ChainModel`
   * @param pixels the most that a level may err, in pixels
   */
  constructor(model, pixels = model.levels.screen?.pixels ?? 1) {
    super();
    this.model = model;
    this.pixels = pixels;
    /** Levels morph; false: they switch. */
    this.morphs = true;
    this.content = clone(model.scene);
    this.add(this.content);
    this.meshes = [];
    this.content.traverse((mesh) => {
      const level = mesh.userData.lodcLevel;
      if (level === undefined) return;
      const names = mesh.morphTargetDictionary ?? {};
      this.meshes.push({ mesh, level, target: names[TARGET], layers: mesh.layers.mask });
    });
    this.sphere = new THREE.Box3().setFromObject(model.scene).getBoundingSphere(new THREE.Sphere());
    this.show(0, 0);
  }

  /** Shows the level that a camera needs, in a picture `height` pixels high. */
  update(camera, height) {
    this.updateWorldMatrix(true, false);
    const scale = this.matrixWorld.getMaxScaleOnAxis();
    const centre = this.sphere.center.clone().applyMatrix4(this.matrixWorld);
    const eye = new THREE.Vector3().setFromMatrixPosition(camera.matrixWorld);
    const away = Math.max(eye.distanceTo(centre) - this.sphere.radius * scale, camera.near);
    const { screen } = this.model.levels;
    const pixel = pixelSize(THREE.MathUtils.degToRad(camera.fov), height) / camera.zoom;
    const stated = pixelSize(THREE.MathUtils.degToRad(screen.fovy), screen.height);
    this.at((away / scale) * ((pixel * this.pixels) / (stated * screen.pixels)));
  }

  /** Shows the level at a distance in the units of the file. Call it after animation mixers. */
  at(distance) {
    const { level, weight } = this.model.levels.at(distance, this.level);
    this.show(level, this.morphs ? weight : 0);
  }

  /** Shows a level, a weight's part of the way to the next one. */
  show(level, weight) {
    Object.assign(this, { level, weight });
    for (const { mesh, level: own, target, layers } of this.meshes) {
      // Not `visible`: children of a node stay with level 0.
      mesh.layers.mask = own === level ? layers : 0;
      if (own === level && target !== undefined) mesh.morphTargetInfluences[target] = weight;
    }
  }

  /** Triangles of the present level. */
  get triangles() {
    const shown = this.meshes.filter(({ level }) => level === this.level);
    return shown.reduce((sum, { mesh }) => sum + mesh.geometry.index.count / 3, 0);
  }
}
