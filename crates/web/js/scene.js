// The scene of a GLB: nodes, skins, morph weights, animations, and where objects are shown.

import { animations, sampled } from './animation.js';
import { objects } from './geometry.js';
import { IDENTITY, composed, moved, times } from './math.js';

/** The third axis upward, as the second one is in glTF. */
const THIRD_UP = [1, 0, 0, 0, 0, 0, -1, 0, 0, 1, 0, 0, 0, 0, 0, 1];

export class Scene {
  constructor(glb, shown = objects(glb)) {
    this.glb = glb;
    this.objects = shown;
    this.animations = animations(glb);
    this.nodes = (glb.json.nodes ?? []).map((source) => node(glb, source));
    this.skins = (glb.json.skins ?? []).map((skin) => {
      const flat = skin.inverseBindMatrices === undefined
        ? null : glb.floats(skin.inverseBindMatrices);
      const inverse = (j) => (flat ? Array.from(flat.subarray(16 * j, 16 * j + 16)) : IDENTITY);
      return { joints: skin.joints, inverse: skin.joints.map((_, j) => inverse(j)) };
    });
    const scene = glb.json.scenes?.[glb.json.scene ?? 0];
    const children = new Set(this.nodes.flatMap((n) => n.children));
    const roots = this.nodes.map((_, n) => n).filter((n) => !children.has(n));
    this.roots = scene?.nodes ?? roots;
    this.pose(null, 0);
  }

  /** Stands on the axis `y`, as all glTF does, or `z`. */
  stand(up) {
    this.up = up;
    this.pose(this.posed?.animation ?? null, this.posed?.seconds ?? 0);
  }

  /** Poses all nodes by an animation, or at rest. */
  pose(animation, seconds) {
    this.posed = { animation, seconds };
    for (const n of this.nodes) Object.assign(n, n.rest);
    for (const channel of animation?.channels ?? []) {
      const n = this.nodes[channel.node];
      if (n) Object.assign(n, { [channel.path]: sampled(channel, seconds), matrix: null });
    }
    const place = (index, parent) => {
      const n = this.nodes[index];
      n.world = times(parent, n.matrix ?? composed(n.translation, n.rotation, n.scale));
      n.children.forEach((child) => place(child, n.world));
    };
    const stand = this.up === 'z' ? THIRD_UP : IDENTITY;
    this.roots.forEach((root) => place(root, stand));
  }

  /**
   * Objects where the scene shows them: `{ object, world, joints, weights }`, with one matrix for
   * each joint if there is a skin (it stands for `world` then).
   */
  placements() {
    const found = [];
    const visit = (index) => {
      const n = this.nodes[index];
      const object = this.objects[n.mesh];
      if (object) {
        const skin = this.skins[n.skin];
        const joints = skin?.joints.map((joint, j) => (
          times(this.nodes[joint].world ?? IDENTITY, skin.inverse[j])));
        for (const own of n.instances) {
          const world = own ? times(n.world, own) : n.world;
          found.push({ object, world, joints, weights: n.weights ?? object.weights });
        }
      }
      n.children.forEach(visit);
    };
    this.roots.forEach(visit);
    return found;
  }

  /** The smallest box around all that is shown, over a part of the vertices of large objects. */
  bounds() {
    const low = [Infinity, Infinity, Infinity];
    const high = [-Infinity, -Infinity, -Infinity];
    for (const { object, world, joints } of this.placements()) {
      for (const part of object.parts) {
        const every = Math.max(1, Math.floor(part.positions.length / 3 / 20000));
        for (let v = 0; v < part.positions.length / 3; v += every) {
          const p = placed(part, v, world, joints);
          for (let i = 0; i < 3; i++) {
            low[i] = Math.min(low[i], p[i]);
            high[i] = Math.max(high[i], p[i]);
          }
        }
      }
    }
    return low[0] <= high[0] ? { low, high } : { low: [-1, -1, -1], high: [1, 1, 1] };
  }
}

function node(glb, source) {
  const rest = {
    translation: source.translation ?? [0, 0, 0],
    rotation: source.rotation ?? [0, 0, 0, 1],
    scale: source.scale ?? [1, 1, 1],
    matrix: source.matrix ?? null,
    weights: source.weights,
  };
  const { mesh, skin, children = [] } = source;
  const instancing = source.extensions?.EXT_mesh_gpu_instancing?.attributes;
  return { rest, mesh, skin, children, instances: instancing ? copies(glb, instancing) : [null] };
}

/** Matrices of `EXT_mesh_gpu_instancing`. */
function copies(glb, { TRANSLATION, ROTATION, SCALE }) {
  const of = (accessor, width, usual) => {
    if (accessor === undefined) return () => usual;
    const values = glb.floats(accessor);
    return (i) => Array.from(values.subarray(width * i, width * i + width));
  };
  const [t, r, s] = [of(TRANSLATION, 3, [0, 0, 0]), of(ROTATION, 4, [0, 0, 0, 1]),
    of(SCALE, 3, [1, 1, 1])];
  const { count } = glb.json.accessors[TRANSLATION ?? ROTATION ?? SCALE];
  return Array.from({ length: count }, (_, i) => composed(t(i), r(i), s(i)));
}

/** Position of a vertex in the world. */
function placed({ positions, joints: of, weights }, v, world, joints) {
  const p = [positions[3 * v], positions[3 * v + 1], positions[3 * v + 2]];
  if (!joints || !of || !weights) return moved(world, p);
  const out = [0, 0, 0];
  for (let k = 0; k < 4; k++) {
    const weight = weights[4 * v + k];
    if (weight === 0 || !joints[of[4 * v + k]]) continue;
    const q = moved(joints[of[4 * v + k]], p);
    for (let i = 0; i < 3; i++) out[i] += weight * q[i];
  }
  return out;
}
