/** `GPUDevice`, where its types are there: those of `@webgpu/types`, or of a later TypeScript. */
export type WebGpuDevice =
  typeof globalThis extends { GPUDevice: { prototype: infer Device } } ? Device : any;

/** Buffers and kernels on a device. */
export interface Program {
  /** Buffers of `length` words; zeros without `words`. */
  buffers: Array<{ name: string; length: number; words?: Uint32Array | null }>;
  kernels: Array<{ name: string; wgsl: string; constants?: Record<string, number> }>;
}

/** One dispatch: a kernel and buffers by their numbers, threads, words of its parameters. */
export interface Pass {
  kernel: number;
  buffers: number[];
  threads: number;
  parameters: ArrayLike<number>;
}

/** A program, and steps with the words that must come out. */
export interface Plan {
  program: Program;
  steps: Array<{
    at: string;
    /** Whether the step is counted as a LOD. */
    counts: boolean;
    passes: Pass[];
    checks: Array<{ buffer: number; first: number; words: Uint32Array }>;
  }>;
}

/** A WebGPU device with enough storage buffers for every kernel; null where there is none. */
export function openDevice(): Promise<WebGpuDevice | null>;

/** A program on a device. */
export class Session {
  constructor(device: WebGpuDevice, program: Program);
  /** Runs passes; each sees what those before wrote. */
  run(passes: Pass[]): void;
  /** Words of a buffer. */
  read(buffer: number, first: number, count: number): Promise<Uint32Array>;
  destroy(): void;
}

/** Runs a plan and compares every word; `difference` says the first that is another. */
export function replay(
  device: WebGpuDevice,
  plan: Plan,
): Promise<{ lods: number; words: number; difference: string | null }>;
