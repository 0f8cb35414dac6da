// A host of the compute shaders: a file of the gpu layout is uploaded as it lies there, levels are
// taken out on the device and drawn. docs/ENGINE.md quotes it; nothing is read back but counts.

import { WEBGPU_DEPTH, lookAt, perspective, times } from '../math.js';
import { Session, openDevice } from '../plan.js';
import { Sections } from '../sections.js';

/** Words of a vertex record: a position. */
const STRIDE = 3;
/** Words that a workgroup of scan.wgsl sums. */
const BLOCK = 1024;

const DRAW = `
@group(0) @binding(0) var<uniform> camera: mat4x4<f32>;
struct Corner { @builtin(position) place: vec4<f32>, @location(0) position: vec3<f32> }
@vertex fn vertex(@location(0) position: vec3<f32>) -> Corner {
  return Corner(camera * vec4(position, 1.0), position);
}
@fragment fn fragment(corner: Corner) -> @location(0) vec4<f32> {
  let normal = normalize(cross(dpdx(corner.position), dpdy(corner.position)));
  return vec4(vec3(0.35 + 0.6 * abs(dot(normal, normalize(vec3(0.3, 0.8, 0.5))))), 1.0);
}`;

export class Host {
  /**
   * @param file an `ArrayBuffer`: a .lodc file built with --layout gpu; its object 0 is shown
   * @param shaders text of each shader of `lodc shaders` by its name; null without WebGPU
   */
  static async create(canvas, file, shaders) {
    const device = await openDevice();
    return device && new Host(device, canvas, new Sections(file), shaders);
  }

  constructor(device, canvas, sections, shaders) {
    // [upload]
    const positions = sections.words('POSI');
    const triangles = sections.words('TRIS');
    const targets = sections.words('TARG');
    const submeshes = sections.submeshes();
    // [/upload]
    const vertices = positions.length / STRIDE;
    const lengths = listLengths(targets, vertices);
    const entries = lengths.reduce((sum, length) => sum + length, 0);
    Object.assign(this, {
      device, canvas, vertices, records: targets.length, lod: 0,
      ends: sections.stepEnds(), count: submeshes.length,
      longest: lengths.reduce((most, length) => Math.max(most, length), 1),
    });
    this.setUp(shaders, {
      source: positions, vertices: positions, triangles, collapseTo: targets,
      submeshes: Uint32Array.from(submeshes.flat()),
      offsets: vertices + 1, entries, current: vertices, errorFlag: 1, draws: 5 * this.count,
    });
    this.construct();
    this.bounds(new Float32Array(positions.buffer, positions.byteOffset, positions.length));
    this.pipeline = drawing(device, navigator.gpu.getPreferredCanvasFormat());
  }

  /** Buffers of words, or of a number of zeros, and the kernels that are used. */
  setUp(shaders, contents) {
    const names = ['lists_length', 'scan', 'scan_add', 'lists_fill', 'extract', 'live'];
    this.kernels = Object.fromEntries(names.map((name, number) => [name, number]));
    this.at = Object.fromEntries(Object.keys(contents).map((name, number) => [name, number]));
    const buffers = Object.entries(contents).map(([name, words]) => (
      typeof words === 'number' ? { name, length: words } : { name, length: words.length, words }));
    // Sums of blocks of the prefix sums, then sums of their blocks, down to one.
    this.sums = [];
    for (let count = this.vertices + 1; count > 1;) {
      count = Math.ceil(count / BLOCK);
      this.sums.push(buffers.length);
      buffers.push({ name: 'sums of blocks', length: count });
    }
    const kernels = names.map((name) => ({ name, wgsl: shaders[name], constants: {} }));
    this.session = new Session(this.device, { buffers, kernels });
  }

  pass(kernel, threads, parameters, buffers) {
    const numbers = buffers.map((b) => this.at[b] ?? b);
    return { kernel: this.kernels[kernel], threads, parameters, buffers: numbers };
  }

  /** The lists of collapses, once. */
  construct() {
    const { vertices, records, longest } = this;
    // [construction]
    this.session.run([
      this.pass('lists_length', vertices + 1, [vertices, records, longest],
        ['collapseTo', 'offsets', 'errorFlag']),
      ...this.scan('offsets', vertices + 1),
      this.pass('lists_fill', vertices, [vertices],
        ['collapseTo', 'offsets', 'entries', 'current']),
    ]);
    // [/construction]
  }

  /** Prefix sums of a buffer, in place. */
  scan(data, count, level = 0) {
    const blocks = Math.ceil(count / BLOCK);
    const buffers = [data, this.sums[level]];
    const down = this.pass('scan', Math.ceil(count / 4), [count], buffers);
    if (blocks <= 1) return [down];
    const up = this.pass('scan_add', count, [count], buffers);
    return [down, ...this.scan(this.sums[level], blocks, level + 1), up];
  }

  /** Shows a LOD, rounded down to the end of a step: any distance away, coarser or finer. */
  show(wanted) {
    const lod = this.ends.findLast((end) => end <= wanted) ?? 0;
    const touched = Math.max(this.lod, lod);
    // [extraction]
    this.session.run([
      this.pass('extract', touched, [touched, lod, STRIDE],
        ['offsets', 'entries', 'source', 'current', 'vertices', 'errorFlag']),
      this.pass('live', this.count, [this.count, STRIDE],
        ['submeshes', 'triangles', 'vertices', 'draws']),
    ]);
    // [/extraction]
    this.lod = lod;
    return lod;
  }

  /** Triangles that are drawn. */
  async triangles() {
    const draws = await this.session.read(this.at.draws, 0, 5 * this.count);
    return draws.reduce((sum, word, i) => sum + (i % 5 === 0 ? word / 3 : 0), 0);
  }

  bounds(positions) {
    const [low, high] = [[Infinity, Infinity, Infinity], [-Infinity, -Infinity, -Infinity]];
    positions.forEach((x, i) => {
      low[i % 3] = Math.min(low[i % 3], x);
      high[i % 3] = Math.max(high[i % 3], x);
    });
    this.centre = low.map((x, i) => (x + high[i]) / 2);
    this.radius = Math.hypot(...low.map((x, i) => high[i] - x)) / 2;
  }

  /** The camera, turned by an angle. */
  matrix(angle = 0) {
    const { canvas, centre, radius } = this;
    const eye = [Math.sin(angle), 0.3, Math.cos(angle)].map((x, i) => centre[i] + 3 * radius * x);
    const projection = perspective(0.7, canvas.width / canvas.height, radius, 6 * radius);
    const view = lookAt(eye, centre, [0, 1, 0]);
    return new Float32Array(times(times(WEBGPU_DEPTH, projection), view));
  }

  /** Draws into the canvas. */
  draw(angle) {
    const { device, canvas } = this;
    if (!this.context) {
      this.context = canvas.getContext('webgpu');
      this.context.configure({ device, format: navigator.gpu.getPreferredCanvasFormat() });
    }
    this.encode(this.context.getCurrentTexture().createView(), this.matrix(angle));
  }

  /** Draws into a texture of the canvas's size and format. */
  encode(view, matrix) {
    const { device, pipeline, session, at } = this;
    const uniform = device.createBuffer({
      size: 64, usage: GPUBufferUsage.UNIFORM | GPUBufferUsage.COPY_DST });
    device.queue.writeBuffer(uniform, 0, matrix);
    const depth = device.createTexture({
      size: [this.canvas.width, this.canvas.height], format: 'depth24plus',
      usage: GPUTextureUsage.RENDER_ATTACHMENT });
    const encoder = device.createCommandEncoder();
    const render = encoder.beginRenderPass({
      colorAttachments: [{ view, loadOp: 'clear', storeOp: 'store', clearValue: [0, 0, 0, 1] }],
      depthStencilAttachment: {
        view: depth.createView(), depthLoadOp: 'clear', depthStoreOp: 'discard', depthClearValue: 1,
      },
    });
    render.setPipeline(pipeline);
    render.setBindGroup(0, device.createBindGroup({
      layout: pipeline.getBindGroupLayout(0),
      entries: [{ binding: 0, resource: { buffer: uniform } }],
    }));
    // [draw]
    render.setVertexBuffer(0, session.buffers[at.vertices]);
    render.setIndexBuffer(session.buffers[at.triangles], 'uint32');
    for (let submesh = 0; submesh < this.count; submesh++) {
      render.drawIndexedIndirect(session.buffers[at.draws], 20 * submesh);
    }
    // [/draw]
    render.end();
    device.queue.submit([encoder.finish()]);
    depth.destroy();
  }
}

/** Entries of each vertex's list: one, and one more than its target's list has. */
function listLengths(targets, vertices) {
  const lengths = new Uint32Array(vertices).fill(1);
  for (let i = targets.length - 1; i >= 0; i--) lengths[i] = 1 + lengths[targets[i]];
  return lengths;
}

function drawing(device, format) {
  const module = device.createShaderModule({ code: DRAW });
  const position = { format: 'float32x3', offset: 0, shaderLocation: 0 };
  return device.createRenderPipeline({
    layout: 'auto',
    vertex: { module, buffers: [{ arrayStride: 4 * STRIDE, attributes: [position] }] },
    fragment: { module, targets: [{ format }] },
    depthStencil: { format: 'depth24plus', depthWriteEnabled: true, depthCompare: 'less' },
  });
}
