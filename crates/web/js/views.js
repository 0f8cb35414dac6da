// View-dependent levels on WebGPU: `view.wgsl` chooses a LOD for every vertex by the error that it
// makes on the screen, and moves vertices on their way to the next level (geomorphing).

import { partition } from './levels.js';
import { Session } from './plan.js';

/** Entries of the table of LODs by error, as in the shader. */
const ERRORS = 7168;

/** Arrays of a part that become words of a vertex record, after the position. */
const RECORD = { normals: 3, uv0: 2, uv1: 2, colours: 4, joints: 4, weights: 4 };

/** The vertices of one object for every view. */
export class Views {
  /**
   * @param wgsl text of the view shader with its prelude
   * @param object `{ parts, levels }` of `geometry.js`
   */
  constructor(device, wgsl, { parts, levels }) {
    this.vertices = levels.records + 1;
    this.layout = layout(parts);
    const { stride } = this.layout;
    const { points, links, source } = records(parts, levels, this.layout, this.vertices);
    this.table = byError(levels);
    this.scale = 2 ** -Math.round(Math.log2(levels.diagonal || 1));
    const kernel = (morph) => ({
      name: 'view', wgsl, constants: { criterion: 1, morph: morph ? 1 : 0, stride },
    });
    const buffer = (name, words) => ({ name, length: words.length, words });
    this.session = new Session(device, {
      kernels: [kernel(false), kernel(true)],
      buffers: [
        buffer('points', points), buffer('links', links), buffer('by_error', this.table.lods),
        buffer('source', source), buffer('vertices', source),
      ],
    });
    // Corners by numbers in the collapse order.
    this.corners = parts.map(({ submesh: { source: corners, numbers } }) => (
      corners.map((v) => numbers[v])));
  }

  /**
   * Vertex records for an eye in the object's own space, where a level errs by at most `slope` at
   * distance 1, and for each part the triangles that are left.
   */
  async show(eye, slope, morph) {
    const bits = new Uint32Array(new Float32Array([...eye, this.scale, slope / this.scale]).buffer);
    const parameters = [this.vertices, this.table.lowest, 0, 0, ...bits, 0, 0, 0];
    const buffers = [0, 1, 2, 3, 4];
    this.session.run([{ kernel: morph ? 1 : 0, buffers, threads: this.vertices, parameters }]);
    const { stride } = this.layout;
    const words = await this.session.read(4, 0, this.vertices * stride);
    return { words, indices: this.corners.map((corners) => filtered(corners, words, stride)) };
  }
}

/** Words of a record, and where each array starts in it. */
function layout(parts) {
  const offsets = { positions: 0 };
  let stride = 3;
  for (const [name, width] of Object.entries(RECORD)) {
    if (!parts.some((part) => arrayOf(part, name))) continue;
    offsets[name] = stride;
    stride += width;
  }
  return { offsets, stride };
}

function arrayOf(part, name) {
  return { uv0: part.uvs[0], uv1: part.uvs[1] }[name] ?? part[name];
}

/** Points, links and records by numbers in the collapse order. */
function records(parts, levels, { offsets, stride }, vertices) {
  const points = new Float32Array(4 * vertices);
  const links = new Uint32Array(2 * vertices);
  const source = new Float32Array(stride * vertices);
  for (let v = 0; v < vertices; v++) links.set([v, 0xffffffff], 2 * v);
  for (const part of parts) {
    const { numbers, targets } = part.submesh;
    for (let v = 0; v < numbers.length; v++) {
      const number = numbers[v];
      points.set(part.positions.subarray(3 * v, 3 * v + 3), 4 * number);
      source.set(part.positions.subarray(3 * v, 3 * v + 3), stride * number);
      for (const [name, width] of Object.entries(RECORD)) {
        const values = arrayOf(part, name);
        const at = stride * number + offsets[name];
        if (values) source.set(values.subarray(width * v, width * (v + 1)), at);
        else if (name === 'colours' && name in offsets) source.fill(1, at, at + 4);
      }
      if (number < levels.records && targets[v] !== v) {
        const step = levels.ends[partition(levels.ends.length, (s) => levels.ends[s] > number)];
        links.set([numbers[targets[v]], step], 2 * number);
      }
    }
  }
  return {
    points: new Uint32Array(points.buffer), links, source: new Uint32Array(source.buffer),
  };
}

/** The coarsest LOD for each error: 512 of them from one power of two to the next. */
function byError(levels) {
  const float = new Float32Array(1);
  const word = new Uint32Array(float.buffer);
  float[0] = levels.errors.at(-1) ?? 0;
  const lowest = Math.max((word[0] >>> 14) + 2 - ERRORS, 0);
  const lods = new Uint32Array(ERRORS);
  for (let i = 0; i < ERRORS; i++) {
    word[0] = (lowest + i) << 14;
    lods[i] = levels.forError(i === 0 ? 0 : float[0]);
  }
  return { lowest, lods };
}

/** Corners of the triangles whose three corners are at different places. */
function filtered(corners, words, stride) {
  const left = new Uint32Array(corners.length);
  let count = 0;
  const alike = (a, b) => words[a] === words[b] && words[a + 1] === words[b + 1]
    && words[a + 2] === words[b + 2];
  for (let t = 0; t < corners.length; t += 3) {
    const [a, b, c] = [corners[t] * stride, corners[t + 1] * stride, corners[t + 2] * stride];
    if (alike(a, b) || alike(b, c) || alike(c, a)) continue;
    left[count] = corners[t];
    left[count + 1] = corners[t + 1];
    left[count + 2] = corners[t + 2];
    count += 3;
  }
  return left.subarray(0, count);
}
