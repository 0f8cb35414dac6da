// The WebGPU renderer: what webgl.js draws, drawn by WebGPU. Uniforms of all draws of a frame are
// written at once; pipelines are made when a combination is first needed.

import { edges, morphed } from './geometry.js';
import { WEBGPU_DEPTH, determinant3, times } from './math.js';
import { inDrawingOrder, materialOf, texturesOf } from './material.js';
import { NAMES, Pipelines, SAMPLES, VERTEX_ARRAYS } from './gpupipelines.js';
import { openDevice } from './plan.js';
import { Presenter } from './presenter.js';
import { Textures } from './gputextures.js';

/** What stands for an array that a part has not. */
const MISSING = { colours: [1, 1, 1, 1] };
const GREY = new Uint8Array([158, 161, 168, 255]);
/** Bytes of the uniforms of a frame, and from those of one draw to the next. */
const FRAME = 144;
const BLOCK_BYTES = 256;
/** Frames that may be under way before another one is drawn. */
const MOST_WAITING = 1;
const [FLAT, EDGY, UNLIT] = [1, 2, 4];

export class WebgpuRenderer {
  static backend = 'webgpu';
  static waits = false;

  /** Makes a renderer; waits for device and textures. Null without WebGPU. */
  static async create(canvas, scene) {
    const device = await openDevice().catch(() => null);
    if (!device) return null;
    const renderer = new WebgpuRenderer(device, canvas, scene);
    await renderer.textures.load(scene.glb, texturesOf);
    return renderer;
  }

  constructor(device, canvas, scene) {
    Object.assign(this, { device, canvas, scene });
    this.presenter = new Presenter(device, canvas);
    this.surface = this.presenter.surface;
    this.textures = new Textures(device);
    this.layouts = [this.frameLayout(), this.textures.layout, this.jointLayout()];
    this.pipelines = new Pipelines(device, this.layouts, this.presenter.format);
    const { VERTEX, STORAGE } = GPUBufferUsage;
    this.missing = Object.fromEntries(NAMES.map((name) => [name, this.buffer(
      name === 'paint' ? GREY : new Float32Array(MISSING[name] ?? [0, 0, 0, 0]), VERTEX)]));
    this.noJoints = this.jointGroup(this.buffer(new Float32Array(16), STORAGE));
    this.parts = new Map();
    for (const object of scene.objects) {
      for (const part of object?.parts ?? []) this.parts.set(part, this.upload(part));
    }
  }

  buffer(values, usage) {
    const size = Math.max(16, Math.ceil(values.byteLength / 4) * 4);
    const buffer = this.device.createBuffer({ size, usage: usage | GPUBufferUsage.COPY_DST });
    if (values.byteLength > 0) this.write(buffer, values);
    return buffer;
  }

  write(buffer, values) {
    this.device.queue.writeBuffer(buffer, 0, values.buffer, values.byteOffset, values.byteLength);
  }

  frameLayout() {
    const visibility = GPUShaderStage.VERTEX | GPUShaderStage.FRAGMENT;
    return this.device.createBindGroupLayout({ entries: [
      { binding: 0, visibility, buffer: { type: 'uniform' } },
      { binding: 1, visibility, buffer: { type: 'uniform', hasDynamicOffset: true } },
    ] });
  }

  jointLayout() {
    const visibility = GPUShaderStage.VERTEX;
    return this.device.createBindGroupLayout({ entries: [
      { binding: 0, visibility, buffer: { type: 'read-only-storage' } },
    ] });
  }

  jointGroup(buffer) {
    const entries = [{ binding: 0, resource: { buffer } }];
    return this.device.createBindGroup({ layout: this.layouts[2], entries });
  }

  /** The buffers of a part. */
  upload(part) {
    const { VERTEX, INDEX } = GPUBufferUsage;
    const arrays = {
      positions: part.positions, normals: part.normals, uvs: joined(part.uvs),
      colours: part.colours, joints: part.joints, weights: part.weights,
    };
    const buffers = {};
    for (const [name, values] of Object.entries(arrays)) {
      if (values) buffers[name] = this.buffer(values, VERTEX);
    }
    const size = Math.max(16, part.submesh.indices.byteLength);
    return {
      buffers,
      indices: this.device.createBuffer({ size, usage: INDEX | GPUBufferUsage.COPY_DST }),
      lod: -1,
    };
  }

  /** Draws a frame, as `WebglRenderer.draw` does. */
  draw(frame) {
    const { surface, device } = this;
    this.blocks = [];
    this.draws = [];
    if (frame.crowd) this.putCopies(frame.crowd);
    for (const { placement, parts, number } of inDrawingOrder(this.scene, frame.colouring)) {
      this.place(placement, parts, { ...frame, view: frame.views?.[number], number });
    }
    const group = this.uniforms(frame);
    const encoder = device.createCommandEncoder();
    const target = this.presenter.target(surface.width, surface.height, SAMPLES);
    const render = encoder.beginRenderPass({
      colorAttachments: [{
        view: target.colour, resolveTarget: target.resolved, loadOp: 'clear', storeOp: 'discard',
        clearValue: [...frame.background, 1],
      }],
      depthStencilAttachment: {
        view: target.depth, depthLoadOp: 'clear', depthStoreOp: 'discard', depthClearValue: 1,
      },
    });
    for (const draw of this.draws.filter(isSeen)) this.encode(render, draw, group);
    render.end();
    this.presenter.present(encoder);
  }

  /** Uniforms of the frame and of all draws, bound with an offset for each. */
  uniforms(frame) {
    const { device } = this;
    const { view } = frame;
    const size = BLOCK_BYTES * (1 + Math.max(this.blocks.length, 1));
    const bytes = new ArrayBuffer(size);
    const put = (values, at) => new Float32Array(bytes, at).set(values);
    put(times(times(WEBGPU_DEPTH, frame.projection), view), 0);
    const [right, up, back] = [0, 1, 2].map((row) => [view[row], view[4 + row], view[8 + row]]);
    const key = right.map((r, i) => -0.45 * r + 0.75 * up[i] + 0.65 * back[i]);
    [frame.eye, frame.centre, key, right, up].forEach((v, i) => put(v, 64 + 16 * i));
    this.blocks.forEach((block, i) => new Uint8Array(bytes, BLOCK_BYTES * (i + 1)).set(block));
    if (!this.uniform || this.uniform.size < size) {
      this.uniform?.destroy();
      const { UNIFORM, COPY_DST } = GPUBufferUsage;
      this.uniform = device.createBuffer({ size: 2 * size, usage: UNIFORM | COPY_DST });
      this.uniformGroup = device.createBindGroup({ layout: this.layouts[0], entries: [
        { binding: 0, resource: { buffer: this.uniform, size: FRAME } },
        { binding: 1, resource: { buffer: this.uniform, size: BLOCK_BYTES } },
      ] });
    }
    device.queue.writeBuffer(this.uniform, 0, bytes);
    return this.uniformGroup;
  }

  encode(render, draw, group) {
    render.setPipeline(this.pipelines.of(draw));
    render.setBindGroup(0, group, [BLOCK_BYTES * (1 + draw.block)]);
    render.setBindGroup(1, draw.textures);
    render.setBindGroup(2, draw.joints);
    NAMES.forEach((name, slot) => {
      const at = draw.offsets?.[name] ?? 0;
      render.setVertexBuffer(slot, draw.buffers[name] ?? this.missing[name], at);
    });
    if (!draw.indices) render.draw(draw.count);
    else {
      render.setIndexBuffer(draw.indices, 'uint32');
      for (const { first, count, copies, from } of draw.ranges) {
        render.drawIndexed(count, copies, first, 0, from);
      }
    }
  }

  material(part) {
    return materialOf(this.scene.glb, part.material);
  }

  place(placement, parts, frame) {
    const { world } = placement;
    const joints = placement.joints
      ? this.putJoints(placement.joints, frame.number) : this.noJoints;
    const clockwise = !placement.joints && determinant3(world) < 0;
    for (const part of parts) {
      const own = this.parts.get(part);
      const number = placement.object.parts.indexOf(part);
      const view = frame.view && this.viewBuffers(frame.view, number);
      const moved = part.morphs.length > 0 && !view
        ? this.morphs(part, own, placement.weights, frame.number) : {};
      const buffers = view?.buffers ?? { ...own.buffers, ...moved };
      const skinned = placement.joints ? 1 : 0;
      const state = { part, own, view, buffers, world, joints, clockwise, skinned };
      this.triangles(state, frame);
      if (frame.wire && !frame.crowd) this.wires(state, frame);
    }
  }

  /** Adds the triangles of a part to the draws. */
  triangles(state, frame) {
    const { part, own, view, joints, clockwise } = state;
    const material = this.material(part);
    const painted = frame.colouring !== 'material';
    const strips = !view && frame.colouring === 'strips' && part.strips;
    if (strips && own.corners?.lod !== part.submesh.lod) this.putCorners(part, own, frame);
    const buffers = { ...(strips ? own.corners.buffers : state.buffers) };
    if (painted && frame.colouring === 'error' && !view) {
      own.error ??= this.buffer(frame.paints.error(part), GPUBufferUsage.VERTEX);
      buffers.paint = own.error;
    }
    if (frame.crowd) buffers.copy = this.copies.buffer;
    const shown = view ?? (strips ? own.corners : this.indexed(part, own, frame));
    this.draws.push({
      ...shown, buffers, joints, clockwise,
      textures: this.textures.group(painted ? null : material),
      block: this.block(state, frame, material, painted ? 1 : 0),
      cull: !material.doubleSided && !painted,
      blend: !painted && material.alphaMode === 'BLEND',
      behind: frame.wire,
    });
  }

  /** Indices of the present level, or of every copy at its own. */
  indexed(part, own, { crowd }) {
    const { submesh } = part;
    if (!crowd) {
      if (own.lod !== submesh.lod) {
        this.write(own.indices, submesh.indices.subarray(0, 3 * submesh.triangles));
        own.lod = submesh.lod;
      }
      const count = 3 * submesh.triangles;
      return { indices: own.indices, ranges: [{ first: 0, count, copies: 1, from: 0 }] };
    }
    const range = crowd.ranges.get(submesh);
    if (own.ranges !== range) {
      own.ladder?.destroy();
      own.ladder = this.buffer(range.indices, GPUBufferUsage.INDEX);
      own.ranges = range;
    }
    const ranges = crowd.byLevel.map((copies, level) => ({
      first: range.first[level], count: range.count[level],
      copies: copies.length / 4, from: this.copies.first[level],
    }));
    return { indices: own.ladder, ranges: ranges.filter(({ copies, count }) => copies && count) };
  }

  /** Offsets and turns of all copies, level by level. */
  putCopies({ byLevel }) {
    const first = [];
    const all = new Float32Array(byLevel.reduce((sum, list) => sum + list.length, 0));
    let at = 0;
    for (const list of byLevel) {
      first.push(at / 4);
      all.set(list, at);
      at += list.length;
    }
    this.copies?.buffer.destroy();
    this.copies = { first, buffer: this.buffer(all, GPUBufferUsage.VERTEX) };
  }

  /** Vertices and indices of a placement for a view, uploaded once for each result. */
  viewBuffers(view, number) {
    const { VERTEX, INDEX } = GPUBufferUsage;
    view.buffer ??= this.buffer(view.words, VERTEX);
    view.arrays ??= [];
    if (!view.arrays[number]) {
      const list = view.indices[number];
      const { offsets, stride } = view.layout;
      const at = { ...offsets, uvs: offsets.uv0 };
      const names = NAMES.filter((name) => at[name] !== undefined);
      view.arrays[number] = {
        buffers: Object.fromEntries(names.map((name) => [name, view.buffer])),
        offsets: Object.fromEntries(names.map((name) => [name, 4 * at[name]])),
        stride: 4 * stride,
        indices: this.buffer(list, INDEX),
        ranges: [{ first: 0, count: list.length, copies: 1, from: 0 }],
        submesh: { indices: list, triangles: list.length / 3 },
      };
    }
    return view.arrays[number];
  }

  /** Frees the buffers of results that are no longer shown. */
  release(views) {
    for (const { buffer, arrays = [] } of views ?? []) {
      buffer?.destroy();
      for (const own of arrays.filter(Boolean)) {
        own.indices.destroy();
        own.lines?.destroy();
      }
    }
  }

  /** Adds the edges of the present level to the draws. */
  wires(state, frame) {
    const { part, own, view, joints, clockwise } = state;
    const submesh = view?.submesh ?? part.submesh;
    const kept = view ?? own;
    if (kept.linesOf !== (submesh.lod ?? submesh)) {
      kept.lines?.destroy();
      kept.lines = this.buffer(edges(submesh), GPUBufferUsage.INDEX);
      kept.linesOf = submesh.lod ?? submesh;
    }
    const material = { ...this.material(part), baseColour: frame.wireColour };
    this.draws.push({
      buffers: state.buffers, offsets: view?.offsets, stride: view?.stride,
      joints, clockwise, textures: this.textures.group(null),
      block: this.block(state, frame, material, 2),
      indices: kept.lines,
      ranges: [{ first: 0, count: 6 * submesh.triangles, copies: 1, from: 0 }],
      lines: true, blend: true,
    });
  }

  /** Vertices of every corner by themselves, so that each triangle can have its colour. */
  putCorners(part, own, { paints }) {
    const { submesh } = part;
    for (const buffer of Object.values(own.corners?.buffers ?? {})) buffer.destroy();
    const count = 3 * submesh.triangles;
    const buffers = { paint: this.buffer(paints.strips(part), GPUBufferUsage.VERTEX) };
    for (const name of ['positions', 'normals', 'joints', 'weights']) {
      if (!part[name]) continue;
      const [width] = VERTEX_ARRAYS[name];
      const values = new Float32Array(count * width);
      for (let c = 0; c < count; c++) {
        const v = submesh.indices[c] * width;
        for (let i = 0; i < width; i++) values[c * width + i] = part[name][v + i];
      }
      buffers[name] = this.buffer(values, GPUBufferUsage.VERTEX);
    }
    own.corners = { buffers, count, lod: submesh.lod };
  }

  /** The uniforms of a draw, in the order of the shader's `Draw`. */
  block({ part, world, skinned }, frame, material, mode) {
    const bytes = new ArrayBuffer(BLOCK_BYTES);
    const [floats, words] = [new Float32Array(bytes), new Int32Array(bytes)];
    floats.set(world, 0);
    const m = material.uvTransform;
    [0, 1, 2].forEach((column) => floats.set(m.slice(3 * column, 3 * column + 3), 16 + 4 * column));
    floats.set(material.baseColour, 28);
    floats.set(material.emissive, 32);
    const cutoff = { MASK: material.alphaCutoff, BLEND: -1 }[material.alphaMode] ?? 0;
    floats[35] = mode === 0 ? cutoff : 0;
    const { metallic, roughness, normalScale, occlusionStrength } = material;
    floats.set([metallic, roughness, normalScale, occlusionStrength], 36);
    words.set(this.textures.sets(material), 40);
    const flags = (frame.flat ? FLAT : 0) | (part.edgy ? EDGY : 0) | (material.unlit ? UNLIT : 0);
    words.set([mode, skinned, flags], 45);
    this.blocks.push(new Uint8Array(bytes));
    return this.blocks.length - 1;
  }

  /** Joint matrices of a placement. Writes come before all draws of a frame: each has its own. */
  putJoints(joints, number) {
    this.jointBuffers ??= [];
    const values = new Float32Array(joints.flat());
    const own = this.jointBuffers[number];
    if (own && own.buffer.size >= values.byteLength) this.write(own.buffer, values);
    else {
      const buffer = this.buffer(values, GPUBufferUsage.STORAGE);
      this.jointBuffers[number] = { buffer, group: this.jointGroup(buffer) };
    }
    return this.jointBuffers[number].group;
  }

  /** Positions and normals of a part as a placement's weights move them. */
  morphs(part, own, weights, number) {
    own.morphs ??= [];
    const known = own.morphs[number] ??= { weights: null, buffers: {} };
    if (known.weights !== weights.join()) {
      known.weights = weights.join();
      for (const [name, values] of Object.entries(morphed(part, weights))) {
        if (known.buffers[name]) this.write(known.buffers[name], values);
        else known.buffers[name] = this.buffer(values, GPUBufferUsage.VERTEX);
      }
    }
    return known.buffers;
  }

  /** Whether another frame has to wait for those before it. */
  isBusy() {
    return this.presenter.waiting >= MOST_WAITING;
  }

  /** Frees everything. */
  close() {
    this.device.destroy();
  }

  /** Brings the last frame to the screen once more, without drawing it. */
  again() {
    this.presenter.again();
  }

  /** Nothing is waited for: the device shows a frame when it is there. */
  finish() {}

  /** Waits until everything is drawn. */
  async finished() {
    await this.presenter.finished();
  }
}

/** Whether a draw has anything in it. */
function isSeen({ count, ranges }) {
  return ranges ? ranges.some((range) => range.count > 0) : count > 0;
}

/** Two sets of texture coordinates as one array; null without either. */
function joined([first, second]) {
  if (!first && !second) return null;
  const out = new Float32Array(2 * (first ?? second).length);
  [first, second].forEach((set, k) => {
    for (let i = 0; i < (set?.length ?? 0) / 2; i++) {
      out[4 * i + 2 * k] = set[2 * i];
      out[4 * i + 2 * k + 1] = set[2 * i + 1];
    }
  });
  return out;
}
