// `.lodc` files and `.lods` streams in a browser or node: the project's Rust as WebAssembly.

import { Glb } from './glb.js';
import { objects } from './geometry.js';
import { Selection } from './selection.js';

/** The WebAssembly module, ready to open files and streams. */
export class Lodc {
  /** @param wasm the address of `lodc.wasm`, a `Response`, or its bytes */
  static async create(wasm = new URL('./lodc.wasm', import.meta.url)) {
    const isBytes = wasm instanceof ArrayBuffer || ArrayBuffer.isView(wasm);
    const response = isBytes || wasm instanceof Response ? wasm : await fetch(wasm);
    const bytes = isBytes ? wasm : await response.arrayBuffer();
    const { instance } = await WebAssembly.instantiate(bytes, {});
    return new Lodc(instance.exports);
  }

  constructor(exports) {
    this.exports = exports;
  }

  /** A `.lodc` file as the bytes of a GLB with all levels. Throws if it is no such file. */
  glb(file) {
    return this.session((call) => call('lodc_open', file));
  }

  /** A `.lodc` file as objects with `levels`, and a selection over all of them. */
  open(file) {
    const glb = new Glb(this.glb(file));
    const all = objects(glb).filter(Boolean);
    return { glb, objects: all, selection: new Selection(all.map((o) => o.levels)) };
  }

  /** A `.lods` stream that is fed piece by piece. */
  stream() {
    return new Stream(this);
  }

  /** Calls functions of one session, which is closed at the end. */
  session(act) {
    const number = this.exports.lodc_session();
    try {
      return act((name, input) => this.call(number, name, input));
    } finally {
      this.exports.lodc_close(number);
    }
  }

  /** Calls a function of a session with bytes; its output as bytes of its own. */
  call(number, name, input) {
    const { memory, lodc_input, lodc_output, lodc_output_length } = this.exports;
    if (input) {
      const address = lodc_input(number, input.byteLength);
      new Uint8Array(memory.buffer, address, input.byteLength).set(new Uint8Array(
        input.buffer ?? input, input.byteOffset ?? 0, input.byteLength));
    }
    const status = this.exports[name](number);
    const length = lodc_output_length(number);
    const output = new Uint8Array(memory.buffer, lodc_output(number), length).slice();
    if (status !== 0) throw new Error(new TextDecoder().decode(output));
    return output;
  }
}

/** A stream, coarse to fine: after any piece it has a mesh. */
export class Stream {
  constructor(lodc) {
    this.lodc = lodc;
    this.number = lodc.exports.lodc_session();
    this.progress = { complete: false, bytes: 0, objects: [] };
  }

  /**
   * Takes the next bytes. Returns `{ complete, bytes, objects }`, each object with `vertices`,
   * `triangles` and `steps` (so far and in all) and its `error`. Throws if they are damaged.
   */
  feed(bytes) {
    const text = this.lodc.call(this.number, 'lodc_feed', bytes);
    this.progress = JSON.parse(new TextDecoder().decode(text));
    return this.progress;
  }

  /** Triangles so far, and in all. */
  triangles() {
    return [0, 1].map((k) => this.progress.objects.reduce((sum, o) => sum + o.triangles[k], 0));
  }

  /** The scene so far as the bytes of a GLB; null before the first block. */
  mesh() {
    const glb = this.lodc.call(this.number, 'lodc_mesh');
    return glb.length > 0 ? glb : null;
  }

  /** Frees the memory. */
  close() {
    this.lodc.exports.lodc_close(this.number);
  }
}
