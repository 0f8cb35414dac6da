// Objects of a GLB with levels: vertex arrays, materials and collapse sequences.

import { Levels, Submesh } from './levels.js';
import { drawingOrder } from './order.js';
import { edginess, smoothNormals } from './normals.js';

/** All objects by their number in the document; null for meshes without levels. */
export function objects(glb) {
  return (glb.json.meshes ?? []).map((mesh, number) => object(glb, mesh, number));
}

function object(glb, mesh, number) {
  const lodc = mesh.extras?.lodc;
  if (!lodc) return null;
  const parts = mesh.primitives.filter((p) => p.extras?.lodc).map((p) => part(glb, p));
  completeNormals(parts);
  const words = (index) => (index === undefined ? new Uint32Array(0) : glb.words(index));
  const levels = new Levels({
    records: lodc.records,
    triangles: parts.reduce((sum, p) => sum + p.submesh.triangles, 0),
    ends: words(lodc.ends),
    counts: words(lodc.triangles),
    errors: lodc.errors === undefined ? new Float32Array(0) : glb.floats(lodc.errors),
    scale: lodc.scale,
    diagonal: lodc.diagonal,
    submeshes: parts.map((p) => p.submesh),
    ranks: lodc.ranks && { places: glb.words(lodc.ranks), lods: glb.words(lodc.rank_lods) },
  });
  return { name: mesh.name || `Object ${number + 1}`, parts, levels, weights: mesh.weights ?? [] };
}

/** Gives parts without normals smooth ones. */
export function completeNormals(parts) {
  if (parts.every((p) => p.normals)) return;
  const made = smoothNormals(parts);
  const edgy = edginess(parts, made) > 0.2;
  parts.forEach((p, i) => {
    p.edgy = edgy && !p.normals;
    p.normals ??= made[i];
  });
}

/** A primitive that holds all its levels. */
function part(glb, primitive) {
  const { numbers, targets, removals, strips } = primitive.extras.lodc;
  const source = glb.words(primitive.indices);
  const arrays = vertexArrays(glb, primitive);
  const { positions } = arrays;
  // Beyond 2^23 triangles numbers do not fit the keys of the sort.
  const order = source.length < 3 * 2 ** 23 ? drawingOrder(source, positions) : null;
  const submesh = new Submesh({
    source,
    order,
    numbers: glb.words(numbers),
    targets: glb.words(targets),
    removals: glb.words(removals),
  });
  return { ...arrays, submesh, strips: strips === undefined ? null : glb.words(strips) };
}

/** The vertices of a primitive: one entry for each in every array. */
export function vertexArrays(glb, { attributes: names, material, targets }) {
  const floats = (name) => (names[name] === undefined ? null : glb.floats(names[name]));
  const delta = (index) => (index === undefined ? null : glb.floats(index));
  return {
    material: material ?? -1,
    positions: floats('POSITION'),
    normals: floats('NORMAL'),
    edgy: false,
    uvs: [floats('TEXCOORD_0'), floats('TEXCOORD_1')],
    colours: colours(glb, names.COLOR_0),
    joints: floats('JOINTS_0'),
    weights: wholeWeights(floats('WEIGHTS_0')),
    morphs: (targets ?? []).map((target) => ({
      positions: delta(target.POSITION), normals: delta(target.NORMAL),
    })),
  };
}

/** Joint weights whose sum is one for every vertex, as not all files have them. */
function wholeWeights(weights) {
  for (let v = 0; v < (weights?.length ?? 0); v += 4) {
    const sum = weights[v] + weights[v + 1] + weights[v + 2] + weights[v + 3];
    if (sum > 0) for (let k = 0; k < 4; k++) weights[v + k] /= sum;
  }
  return weights;
}

/** Vertex colours with four components each. */
function colours(glb, index) {
  if (index === undefined) return null;
  const values = glb.floats(index);
  if (glb.width(index) === 4) return values;
  const four = new Float32Array((values.length / 3) * 4).fill(1);
  for (let v = 0; v < values.length / 3; v++) four.set(values.subarray(3 * v, 3 * v + 3), 4 * v);
  return four;
}

/** Positions and normals of a part with morph targets applied. */
export function morphed(part, weights) {
  const positions = part.positions.slice();
  const normals = part.normals.slice();
  part.morphs.forEach((morph, target) => {
    const weight = weights[target] ?? 0;
    if (weight === 0) return;
    const move = (values, deltas) => {
      if (deltas) for (let i = 0; i < values.length; i++) values[i] += weight * deltas[i];
    };
    move(positions, morph.positions);
    move(normals, morph.normals);
  });
  return { positions, normals };
}

/** The edges of all triangles as pairs of vertices. */
export function edges({ indices, triangles }) {
  const lines = new Uint32Array(6 * triangles);
  for (let t = 0; t < triangles; t++) {
    const [a, b, c] = [indices[3 * t], indices[3 * t + 1], indices[3 * t + 2]];
    const at = 6 * t;
    lines[at] = a; lines[at + 1] = b; lines[at + 2] = b;
    lines[at + 3] = c; lines[at + 4] = c; lines[at + 5] = a;
  }
  return lines;
}
