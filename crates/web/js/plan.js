// The project's compute shaders on WebGPU: buffers, kernels and passes as plain data, run and read
// back. A plan also says which words must come out.

const WORKGROUP = 256;
/** Bytes between the parameters of two passes: what every device accepts as an offset. */
const SLOT = 256;

const pipelines = new WeakMap();

/** The layout that a kernel declares. Derived by the device, it would lack bindings that some
 * values of constants leave unused. */
function bindings(device, wgsl) {
  const declared = wgsl.matchAll(/@binding\((\d+)\) var<(uniform|storage)(, read_write)?/g);
  const entries = Array.from(declared, ([, binding, space, written]) => {
    const type = space === 'uniform' ? 'uniform' : written ? 'storage' : 'read-only-storage';
    return { binding: Number(binding), visibility: GPUShaderStage.COMPUTE, buffer: { type } };
  });
  return device.createBindGroupLayout({ entries });
}

/** A WebGPU device with enough storage buffers for every kernel; null where there is none. */
export async function openDevice() {
  const adapter = await navigator.gpu?.requestAdapter();
  if (!adapter) return null;
  const names = [
    'maxStorageBuffersPerShaderStage', 'maxStorageBufferBindingSize', 'maxBufferSize'];
  const requiredLimits = Object.fromEntries(names.map((name) => [name, adapter.limits[name]]));
  return adapter.requestDevice({ requiredLimits });
}

/**
 * A program on a device. `program` has `buffers`, each `{ name, length, words }` with `words` a
 * `Uint32Array` or absent for zeros, and `kernels`, each `{ name, wgsl, constants }`.
 */
export class Session {
  constructor(device, { buffers, kernels }) {
    this.device = device;
    this.kernels = kernels;
    this.buffers = buffers.map(({ name, length, words }) => {
      const { STORAGE, COPY_SRC, COPY_DST, INDIRECT, INDEX, VERTEX } = GPUBufferUsage;
      const buffer = device.createBuffer({
        label: name,
        // No binding is smaller than a vector of four words.
        size: 4 * Math.max(length, 4),
        usage: STORAGE | COPY_SRC | COPY_DST | INDIRECT | INDEX | VERTEX,
      });
      if (words?.length > 0) device.queue.writeBuffer(buffer, 0, words);
      return buffer;
    });
  }

  /** The pipeline of a kernel, which all sessions of a device share. */
  pipeline(number) {
    const { device } = this;
    const { name, wgsl, constants } = this.kernels[number];
    if (!pipelines.has(device)) pipelines.set(device, new Map());
    const known = pipelines.get(device);
    const key = `${JSON.stringify(constants)}${wgsl}`;
    if (!known.has(key)) {
      const module = device.createShaderModule({ label: name, code: wgsl });
      const layout = device.createPipelineLayout({ bindGroupLayouts: [bindings(device, wgsl)] });
      const compute = { module, entryPoint: 'main', constants };
      known.set(key, device.createComputePipeline({ label: name, layout, compute }));
    }
    return known.get(key);
  }

  /** Runs passes `{ kernel, buffers, threads, parameters }`; each sees what those before wrote. */
  run(passes) {
    const { device } = this;
    const words = new Uint32Array((SLOT / 4) * Math.max(passes.length, 1));
    passes.forEach(({ parameters }, i) => words.set(parameters, (SLOT / 4) * i));
    const { UNIFORM, COPY_DST } = GPUBufferUsage;
    const uniform = device.createBuffer({ size: words.byteLength, usage: UNIFORM | COPY_DST });
    device.queue.writeBuffer(uniform, 0, words);
    const encoder = device.createCommandEncoder();
    const compute = encoder.beginComputePass();
    passes.forEach(({ kernel, buffers, threads }, i) => {
      const groups = Math.ceil(threads / WORKGROUP);
      if (groups === 0) return;
      const rows = Math.ceil(groups / device.limits.maxComputeWorkgroupsPerDimension);
      const pipeline = this.pipeline(kernel);
      const parameters = { buffer: uniform, offset: SLOT * i, size: SLOT };
      const entries = [{ binding: 0, resource: parameters }, ...buffers.map((b, k) => (
        { binding: k + 1, resource: { buffer: this.buffers[b] } }))];
      compute.setPipeline(pipeline);
      compute.setBindGroup(0, device.createBindGroup({
        layout: pipeline.getBindGroupLayout(0), entries,
      }));
      compute.dispatchWorkgroups(Math.ceil(groups / rows), rows);
    });
    compute.end();
    device.queue.submit([encoder.finish()]);
    uniform.destroy();
  }

  /** Words of a buffer. */
  async read(buffer, first, count) {
    const { device } = this;
    const { MAP_READ, COPY_DST } = GPUBufferUsage;
    const staging = device.createBuffer({ size: 4 * count, usage: MAP_READ | COPY_DST });
    const encoder = device.createCommandEncoder();
    encoder.copyBufferToBuffer(this.buffers[buffer], 4 * first, staging, 0, 4 * count);
    device.queue.submit([encoder.finish()]);
    await staging.mapAsync(GPUMapMode.READ);
    const words = new Uint32Array(staging.getMappedRange()).slice();
    staging.destroy();
    return words;
  }

  destroy() {
    for (const buffer of this.buffers) buffer.destroy();
  }
}

/**
 * Runs a plan `{ program, steps }` and compares every word. Each step has `at`, `counts`, `passes`
 * and `checks`, each `{ buffer, first, words }`. Returns `{ lods, words, difference }`.
 */
export async function replay(device, { program, steps }) {
  const session = new Session(device, program);
  const done = { lods: 0, words: 0, difference: null };
  try {
    for (const { at, counts, passes, checks } of steps) {
      session.run(passes);
      for (const { buffer, first, words } of checks.filter((check) => check.words.length > 0)) {
        const found = await session.read(buffer, first, words.length);
        const word = words.findIndex((expected, i) => expected !== found[i]);
        done.words += words.length;
        if (word >= 0) {
          const { name } = program.buffers[buffer];
          const what = `is ${found[word]} on the device and ${words[word]} on the CPU`;
          return { ...done, difference: `${at}: word ${first + word} of ${name} ${what}` };
        }
      }
      done.lods += counts ? 1 : 0;
    }
    return done;
  } finally {
    session.destroy();
  }
}
