// Decodes away from the page's thread. Takes `{ id, wasm }` to begin, `{ id, bytes }` with the next
// ones, `{ id, end }`, `{ id, next }` for what has come since the last message, `{ id, drop }`.

import { Decoder } from './decoder.js';
import { read } from './message.js';

const LODS = [0x89, 0x4c, 0x4f, 0x44, 0x53];
let module = null;
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
    this.id = id;
    this.headers = [];
    this.pieces = [];
    this.isStream = null;
    this.asked = true;
    this.told = true;
    module ??= Decoder.module(wasm);
    this.queue = module.then(Decoder.create).then((decoder) => {
      this.decoder = decoder;
    });
  }

  /** Takes bytes; several pieces that wait are fed at once. */
  take(bytes) {
    if (this.isStream === null) {
      const first = this.pieces.length ? joined([...this.pieces, bytes]) : bytes;
      if (first.length >= LODS.length) this.isStream = LODS.every((byte, i) => first[i] === byte);
    }
    this.pieces.push(bytes);
    if (!this.isStream) return;
    this.told = false;
    this.decoder.feed(joined(this.pieces.splice(0)));
    this.tell();
  }

  end() {
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
  const act = () => {
    if (!files.has(id)) return;
    if (data.bytes) file.take(data.bytes);
    if (data.end) file.end();
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
