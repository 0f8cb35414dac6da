// The messages of the decoder (`src/decoder/message.rs`): typed arrays over their bytes.

const COMPONENTS = [Int8Array, Uint8Array, Int16Array, Uint16Array, Uint32Array, Float32Array];

/** A vertex attribute's name in three.js; null for what it does not draw. */
function attributeName(meaning, set, name) {
  if (meaning === 3) return set === 0 ? 'uv' : `uv${set}`;
  if (meaning > 3 && meaning < 7 && set > 0) return null;
  if (meaning === 7) return name.toLowerCase();
  return ['position', 'normal', 'tangent', null, 'color', 'skinIndex', 'skinWeight'][meaning];
}

/** Reads words and arrays one after another. */
class Reader {
  constructor(buffer, at, end) {
    Object.assign(this, { buffer, at, end });
    this.view = new DataView(buffer);
  }
  word() {
    this.at += 4;
    return this.view.getUint32(this.at - 4, true);
  }
  float() {
    this.at += 4;
    return this.view.getFloat32(this.at - 4, true);
  }
  list(length, read) {
    return Array.from({ length }, () => read());
  }
  words(length) {
    return this.list(length, () => this.word());
  }
  /** Numbers of a type; the next value begins at a multiple of four bytes. */
  array(Type, length) {
    const array = new Type(this.buffer, this.at, length);
    this.at += (array.byteLength + 3) & ~3;
    return array;
  }
  rest(Type) {
    return this.array(Type, (this.end - this.at) / Type.BYTES_PER_ELEMENT);
  }
  text(length = this.word()) {
    return new TextDecoder().decode(this.array(Uint8Array, length));
  }
}

function attribute(reader) {
  const [meaning, set, target, component, width, normalized] = reader.words(6);
  const name = attributeName(meaning, set, reader.text());
  const Type = COMPONENTS[component];
  return { name, target: target - 1, Type, width, normalized: normalized === 1 };
}

function object(reader) {
  const [number, mesh, vertices, triangles] = reader.words(4);
  const scale = reader.float();
  const name = reader.text();
  const attributes = reader.list(reader.word(), () => attribute(reader));
  const submeshes = reader.list(reader.word(), () => {
    const [primitive, named] = reader.words(2);
    const material = reader.text();
    return {
      primitive, material: named ? material : null, streams: reader.words(reader.word()),
    };
  });
  return { number, mesh, vertices, triangles, scale, name, attributes, submeshes };
}

const MATERIALS = (reader) => {
  const objects = reader.word();
  const materials = [];
  while (reader.at < reader.end) {
    materials.push({ name: reader.text(), lines: reader.list(reader.word(), () => reader.text()) });
  }
  return { document: null, objects, buffer: 0, materials };
};

/**
 * Calls a function of `to` for each part of a message: `document`, `buffer`, `object`, `vertices`,
 * `levels`, `complete`. `headers` has the objects' headers, by number, from message to message.
 */
export function read(buffer, headers, to) {
  const all = new Reader(buffer, 0, buffer.byteLength);
  while (all.at < all.end) {
    const [tag, length] = all.words(2);
    const reader = new Reader(buffer, all.at, all.at + length);
    all.at += (length + 3) & ~3;
    if (tag === 1) {
      const [objects, bytes] = reader.words(2);
      const text = reader.text(reader.end - reader.at);
      to.document?.({ document: JSON.parse(text), objects, buffer: bytes, materials: [] });
    } else if (tag === 2) {
      to.document?.(MATERIALS(reader));
    } else if (tag === 3) {
      to.buffer?.(reader.word(), new Uint8Array(buffer, reader.at, reader.end - reader.at));
    } else if (tag === 4) {
      const header = object(reader);
      headers[header.number] = header;
      to.object?.(header);
    } else if (tag === 5) {
      const [number, first, count] = reader.words(3);
      const positions = reader.array(Float32Array, 3 * count);
      const arrays = headers[number].attributes.map(({ Type, width }) => (
        reader.array(Type, width * count)));
      to.vertices?.(number, first, count, [positions, ...arrays]);
    } else if (tag === 6) {
      const [number, count] = reader.words(2);
      const parts = headers[number].submeshes.length;
      const levels = reader.list(count, () => ({
        error: reader.float(), triangles: reader.words(parts),
      }));
      const first = reader.word();
      to.levels?.(number, levels, first, reader.rest(Uint32Array));
    } else if (tag === 7) {
      to.complete?.();
    }
  }
}
