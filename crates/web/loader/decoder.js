// The WebAssembly of files and streams, without three.js and without a worker.

/** Decodes one `.lodc` file or `.lods` stream. Its memory goes with it. */
export class Decoder {
  /** @param wasm the address of `decoder.wasm`, or its `WebAssembly.Module` */
  static async create(wasm = new URL('./decoder.wasm', import.meta.url)) {
    const module = wasm instanceof WebAssembly.Module ? wasm : await Decoder.module(wasm);
    return new Decoder((await WebAssembly.instantiate(module, {})).exports);
  }

  /** Compiles the WebAssembly, for several decoders. */
  static async module(address) {
    const response = await fetch(address);
    if (!response.ok) throw new Error(`${address}: ${response.status}`);
    return WebAssembly.compile(await response.arrayBuffer());
  }

  constructor(exports) {
    this.exports = exports;
  }

  /** A whole `.lodc` file as a message (`read` of `message.js`). Throws if it is damaged. */
  open(...pieces) {
    return this.call('lodc_open', pieces);
  }

  /** Takes the next bytes of a `.lods` stream. Throws if they are damaged. */
  feed(bytes) {
    this.call('lodc_feed', [bytes]);
  }

  /** A message of what has come of a stream since the last one. */
  grown() {
    return this.call('lodc_grown');
  }

  call(name, pieces) {
    const { exports } = this;
    if (pieces) {
      let at = exports.lodc_input(pieces.reduce((sum, piece) => sum + piece.byteLength, 0));
      for (const piece of pieces) {
        new Uint8Array(exports.memory.buffer, at, piece.byteLength).set(piece);
        at += piece.byteLength;
      }
    }
    const status = exports[name]();
    const at = exports.lodc_output();
    const output = exports.memory.buffer.slice(at, at + exports.lodc_output_length());
    // Values of messages are left out.
    if (status !== 0) throw new Error(new TextDecoder().decode(output).replace(/\{.*?\}/g, '…'));
    return output;
  }
}
