// The package's decoder under damaged files: `node mutations.mjs PACKAGE COUNT FILE...` changes
// each .lodc or .lods file COUNT times, from a fixed seed. An error or a mesh is right; a trap, a
// decoder that cannot be told from one, or memory without bound is not. Prints what came.

import { readFileSync } from 'node:fs';
import { join } from 'node:path';
import { pathToFileURL } from 'node:url';

/** Memory that a decoder may take beside 64 times its input: the module's own, and a start. */
const ROOM = 32 << 20;
/** Milliseconds that a damaged file may take: a hang, not a slow machine. */
const LONGEST = 20_000;

const [folder, count, ...files] = process.argv.slice(2);
const loader = join(folder, 'loader');
const { Decoder, isStream, read } = await import(pathToFileURL(join(loader, 'decoder.js')));
const modules = Object.fromEntries(['file', 'stream'].map((kind) => (
  [kind, new WebAssembly.Module(readFileSync(join(loader, `${kind}.wasm`)))])));

let state = 0x2545f491;
/** A number from 0 to below `n` (xorshift, 32 bits). */
function random(n) {
  state ^= state << 13;
  state ^= state >>> 17;
  state ^= state << 5;
  return (state >>> 0) % n;
}

/** Changes some bytes, cuts, repeats or leaves out a piece. */
function mutated(bytes) {
  const at = random(bytes.length);
  const to = at + random(Math.min(bytes.length - at, 64)) + 1;
  switch (random(4)) {
    case 0: return bytes.subarray(0, at);
    case 1: return Buffer.concat([bytes.subarray(0, at), bytes.subarray(to)]);
    case 2: return Buffer.concat([bytes.subarray(0, to), bytes.subarray(at)]);
    default: {
      const changed = Buffer.from(bytes);
      for (let k = random(8); k >= 0; k--) changed[random(bytes.length)] = random(256);
      return changed;
    }
  }
}

/** Decodes bytes as the worker does, a stream in pieces. */
async function decode(bytes) {
  const stream = isStream(bytes);
  const decoder = await Decoder.create(modules[stream ? 'stream' : 'file']);
  try {
    const headers = [];
    if (!stream) {
      read(decoder.open(bytes), headers, {});
      return 'read';
    }
    const piece = Math.max(1, Math.ceil(bytes.length / (1 + random(5))));
    for (let at = 0; at < bytes.length; at += piece) {
      decoder.feed(bytes.subarray(at, at + piece));
      const message = decoder.grown();
      if (message.byteLength > 0) read(message, headers, {});
    }
    return 'read';
  } finally {
    const taken = decoder.exports.memory.buffer.byteLength;
    if (taken > ROOM + 64 * bytes.length) throw new WebAssembly.RuntimeError(`${taken} bytes`);
  }
}

const came = { read: 0, refused: 0 };
for (const file of files) {
  const bytes = readFileSync(file);
  for (let i = 0; i < Number(count); i++) {
    const damaged = mutated(bytes);
    const begun = Date.now();
    try {
      await decode(damaged);
      came.read += 1;
    } catch (error) {
      // What the decoder says of a file is an Error with words; a trap is a RuntimeError, and
      // whatever else JavaScript throws is a message that was believed.
      if (error.constructor !== Error || error.message.length < 8) {
        console.error(`${file}, mutation ${i}: ${error.stack}`);
        process.exit(1);
      }
      came.refused += 1;
    }
    if (Date.now() - begun > LONGEST) {
      console.error(`${file}, mutation ${i}: ${Date.now() - begun} ms`);
      process.exit(1);
    }
  }
}
console.log(JSON.stringify(came));
