// Decodes away from the page's thread. Takes `{ id, wasm }` with the addresses to begin,
// `{ id, bytes }` with the next ones, `{ id, end }`, `{ id, next }` for what has come since the
// last message, `{ id, drop }`.

import { Decoder, FIRST, isStream } from './decoder.js';
import { read } from './message.js';

/** The WebAssemblies that were needed, by their addresses. */
const modules = new Map();
const files = new Map();

/** Makes the sum of each vertex's joint weights one, as three.js does. */
function wholeWeights(array, width, normalized) {
  const one = normalized ? 2 ** (8 * array.BYTES_PER_ELEMENT) - 1 : 1;
  for (let v = 0; v < array.length; v += width) {
    let sum = 0;
    for (let k = 0; k < width; k++) sum += array[v + k];
    if (sum === one) continue;
    for (let k = 0; k < width; k++) {
      const whole = sum > 0 ? (array[v + k] / sum) * one : Number(k === 0) * one;
      array[v + k] = normalized ? Math.round(whole) : whole;
    }
  }
}

class File {
  constructor(id, wasm) {
    Object.assign(this, { id, wasm });
    this.headers = [];
    this.pieces = [];
    this.decoder = null;
    this.asked = true;
    this.told = true;
    this.queue = Promise.resolve();
  }

  /** Takes bytes, of a stream at once. */
  async take(bytes) {
    this.pieces.push(bytes);
    if (!this.decoder) {
      const first = joined(this.pieces);
      if (first.length < FIRST) return;
      await this.start(isStream(first));
    }
    if (!this.isStream) return;
    this.told = false;
    this.decoder.feed(joined(this.pieces.splice(0)));
    this.tell();
  }

  async start(stream) {
    const address = stream ? this.wasm.stream : this.wasm.file;
    if (!modules.has(address)) modules.set(address, Decoder.module(address));
    this.isStream = stream;
    this.decoder = await Decoder.create(await modules.get(address));
  }

  async end() {
    if (!this.decoder) await this.start(false);
    if (this.isStream) {
      this.ended = true;
      this.told = false;
      this.tell();
    } else {
      this.post(this.decoder.open(...this.pieces.splice(0)));
    }
  }

  /** Tells what has come, if the page has asked for it. */
  tell() {
    if (!this.asked || this.told) return;
    const message = this.decoder.grown();
    this.told = true;
    if (message.byteLength > 0 || this.ended) this.post(message);
  }

  post(message) {
    this.asked = false;
    let complete = false;
    read(message, this.headers, {
      vertices: (number, first, count, arrays) => {
        this.headers[number].attributes.forEach(({ name, target, width, normalized }, i) => {
          if (name === 'skinWeight' && target < 0) wholeWeights(arrays[i + 1], width, normalized);
        });
      },
      complete: () => {
        complete = true;
      },
    });
    postMessage({ id: this.id, message, ended: this.ended && !complete }, [message]);
    if (complete || this.ended) files.delete(this.id);
  }
}

function joined(pieces) {
  if (pieces.length === 1) return pieces[0];
  const all = new Uint8Array(pieces.reduce((sum, piece) => sum + piece.byteLength, 0));
  let at = 0;
  for (const piece of pieces) {
    all.set(piece, at);
    at += piece.byteLength;
  }
  return all;
}

onmessage = ({ data }) => {
  const { id } = data;
  if (data.wasm) files.set(id, new File(id, data.wasm));
  const file = files.get(id);
  if (!file) return;
  if (data.drop) files.delete(id);
  const act = async () => {
    if (!files.has(id)) return;
    if (data.bytes) await file.take(data.bytes);
    if (data.end) await file.end();
    if (data.next) {
      file.asked = true;
      file.tell();
    }
  };
  file.queue = file.queue.then(act).catch((error) => {
    files.delete(id);
    postMessage({ id, error: error.message });
  });
};
