// Pipelines of the WebGPU renderer, made when a combination is first needed.

import { SHADERS } from './wgsl.js';

/** Arrays of a vertex, in the order of their locations; components and bytes of each. */
export const VERTEX_ARRAYS = {
  positions: [3, 12], normals: [3, 12], uvs: [4, 16], colours: [4, 16], joints: [4, 16],
  weights: [4, 16], paint: [4, 4], copy: [4, 16],
};
export const NAMES = Object.keys(VERTEX_ARRAYS);
/** Samples of a pixel. */
export const SAMPLES = 4;

const BLEND = {
  color: { srcFactor: 'src-alpha', dstFactor: 'one-minus-src-alpha' },
  alpha: { srcFactor: 'zero', dstFactor: 'one' },
};

export class Pipelines {
  /** @param layouts of the bind groups; `format` is that of the target */
  constructor(device, layouts, format) {
    Object.assign(this, { device, format });
    this.module = device.createShaderModule({ code: SHADERS });
    this.layout = device.createPipelineLayout({ bindGroupLayouts: layouts });
    this.known = new Map();
  }

  /** The pipeline of a draw: by arrays, topology, culling, blending and offset. */
  of({ buffers, stride = 0, lines, cull, clockwise, blend, behind }) {
    const has = NAMES.map((name) => (buffers[name] ? 1 : 0)).join('');
    const key = [has, stride, lines, cull, clockwise, blend, behind].join();
    if (!this.known.has(key)) {
      const layouts = NAMES.map((name, shaderLocation) => {
        const [width, bytes] = VERTEX_ARRAYS[name];
        const format = name === 'paint' ? 'unorm8x4' : `float32x${width}`;
        const own = name !== 'copy' && name !== 'paint' ? stride || bytes : bytes;
        return {
          arrayStride: buffers[name] ? own : 0,
          stepMode: name === 'copy' ? 'instance' : 'vertex',
          attributes: [{ format, offset: 0, shaderLocation }],
        };
      });
      this.known.set(key, this.device.createRenderPipeline({
        layout: this.layout,
        vertex: { module: this.module, buffers: layouts },
        fragment: { module: this.module, targets: [{
          format: this.format, blend: blend ? BLEND : undefined,
        }] },
        primitive: {
          topology: lines ? 'line-list' : 'triangle-list',
          cullMode: cull ? 'back' : 'none', frontFace: clockwise ? 'cw' : 'ccw',
        },
        depthStencil: {
          format: 'depth24plus', depthCompare: 'less-equal',
          depthWriteEnabled: !(blend && !lines),
          ...(behind ? { depthBias: 1, depthBiasSlopeScale: 1 } : {}),
        },
        multisample: { count: SAMPLES },
      }));
    }
    return this.known.get(key);
  }
}
