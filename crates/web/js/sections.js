// Sections of a `.lodc` file as typed arrays over its own bytes (docs/FORMAT.md): those of the gpu
// layout are uploaded as they lie there. Sums are not compared: `Lodc.open` does that.

const MAGIC = [0x89, 0x4c, 0x4f, 0x44, 0x43, 0x0d, 0x0a, 0x1a];
const HEADER = 40;
const VERSION = 1;
const ENTRY = 40;
/** The flag of sections in which every number is a u32. */
const WIDE = 2;

/** The table of a file; `buffer` is an `ArrayBuffer`. */
export class Sections {
  constructor(buffer) {
    this.buffer = buffer;
    this.view = new DataView(buffer);
    const front = new Uint8Array(buffer, 0, Math.min(8, buffer.byteLength));
    const known = MAGIC.every((byte, i) => front[i] === byte) && buffer.byteLength >= HEADER;
    if (!known) throw new Error('not a .lodc file');
    const version = this.view.getUint16(8, true);
    // The lower half of the features are those without which a file cannot be read.
    if (version !== VERSION || this.view.getUint8(10) !== 0) {
      throw new Error(`a .lodc file of version ${version} that a newer lodc has written`);
    }
    const count = this.view.getUint32(12, true);
    if (this.view.getBigUint64(16, true) !== BigInt(buffer.byteLength)
      || HEADER + ENTRY * count > buffer.byteLength) throw new Error('the file is cut off');
    this.entries = Array.from({ length: count }, (_, i) => this.entry(HEADER + ENTRY * i));
  }

  entry(at) {
    const { view, buffer } = this;
    const word = (offset) => view.getUint32(at + offset, true);
    const tag = String.fromCharCode(...new Uint8Array(buffer, at, 4));
    const [first, length] = [16, 24].map((offset) => Number(view.getBigUint64(at + offset, true)));
    if (first + length > buffer.byteLength) throw new Error(`section ${tag} is cut off`);
    return { tag, wide: (word(4) & WIDE) !== 0, object: word(8), index: word(12), first, length };
  }

  find(tag, object = 0, index = 0) {
    return this.entries.find((e) => e.tag === tag && e.object === object && e.index === index);
  }

  /** The bytes of a section; null if it is not there. */
  bytes(tag, object, index) {
    const found = this.find(tag, object, index);
    return found ? new Uint8Array(this.buffer, found.first, found.length) : null;
  }

  /** A section as words, without a copy: positions' bits, or numbers of a wide section. */
  words(tag, object, index) {
    const found = this.find(tag, object, index);
    if (!found) throw new Error(`section ${tag} is missing`);
    if (tag !== 'POSI' && !found.wide) {
      throw new Error('not of the gpu layout: build the file with --layout gpu');
    }
    return new Uint32Array(this.buffer, found.first, found.length / 4);
  }

  /** The LOD after each step, fine to coarse. */
  stepEnds(object) {
    const records = this.words('TARG', object).length;
    const joined = this.bytes('JOIN', object);
    const ends = [];
    for (let k = 0; k < records; k++) if (!((joined[k >> 3] >> (k & 7)) & 1)) ends.push(k + 1);
    return ends;
  }

  /** First triangle and number of triangles of each submesh. */
  submeshes(object) {
    const triangles = this.words('TRIS', object);
    const vertices = this.words('POSI', object).length / 3;
    const stored = this.bytes('VSUB', object);
    const width = stored ? stored.length / vertices : 0;
    const of = (v) => {
      let number = 0;
      for (let i = width; i > 0; i--) number = 256 * number + stored[width * v + i - 1];
      return number;
    };
    const ranges = [];
    for (let t = 0; t < triangles.length / 3; t++) {
      const submesh = of(triangles[3 * t]);
      while (ranges.length <= submesh) ranges.push([t, 0]);
      ranges[submesh][1] += 1;
    }
    return ranges.length > 0 ? ranges : [[0, 0]];
  }
}
