// A GLB file: its document, and accessors as typed arrays (glTF 2.0, chapters 3.6 and 4).

const ARRAYS = {
  5120: Int8Array, 5121: Uint8Array, 5122: Int16Array, 5123: Uint16Array,
  5125: Uint32Array, 5126: Float32Array,
};
const COMPONENTS = { SCALAR: 1, VEC2: 2, VEC3: 3, VEC4: 4, MAT2: 4, MAT3: 9, MAT4: 16 };
const LARGEST = { 5120: 127, 5121: 255, 5122: 32767, 5123: 65535, 5125: 4294967295 };

export class Glb {
  /** @param bytes a `Uint8Array` that holds the whole file */
  constructor(bytes) {
    const view = new DataView(bytes.buffer, bytes.byteOffset, bytes.byteLength);
    if (bytes.byteLength < 20 || view.getUint32(0, true) !== 0x46546c67) {
      throw new Error('not a GLB file');
    }
    const length = view.getUint32(12, true);
    this.json = JSON.parse(new TextDecoder().decode(bytes.subarray(20, 20 + length)));
    this.binary = bytes.subarray(Math.min(28 + length, bytes.byteLength));
  }

  /** The bytes of a buffer view. */
  view(index) {
    const { byteOffset = 0, byteLength } = this.json.bufferViews[index];
    return this.binary.subarray(byteOffset, byteOffset + byteLength);
  }

  /** The components of an accessor one behind the other, in their own type. */
  raw(index) {
    const accessor = this.json.accessors[index];
    const { bufferView, byteOffset = 0, componentType, count, type, sparse } = accessor;
    const width = COMPONENTS[type];
    let values = new ARRAYS[componentType](count * width);
    if (bufferView !== undefined) {
      const stride = this.json.bufferViews[bufferView].byteStride;
      values = this.read(bufferView, byteOffset, componentType, count, width, stride);
    }
    if (sparse) {
      const { indices, values: told } = sparse;
      const at = this.read(
        indices.bufferView, indices.byteOffset ?? 0, indices.componentType, sparse.count, 1);
      const put = this.read(
        told.bufferView, told.byteOffset ?? 0, componentType, sparse.count, width);
      at.forEach((element, i) => {
        values.set(put.subarray(i * width, (i + 1) * width), element * width);
      });
    }
    return values;
  }

  read(bufferView, offset, componentType, count, width, stride) {
    const array = ARRAYS[componentType];
    const bytes = this.view(bufferView);
    const row = width * array.BYTES_PER_ELEMENT;
    const step = stride ?? row;
    const packed = new Uint8Array(count * row);
    if (step === row) packed.set(bytes.subarray(offset, offset + packed.length));
    else {
      for (let i = 0; i < count; i++) {
        const from = offset + i * step;
        packed.set(bytes.subarray(from, from + row), i * row);
      }
    }
    return new array(packed.buffer);
  }

  /** An accessor as floats; integers that stand for fractions become fractions. */
  floats(index) {
    const { componentType, normalized } = this.json.accessors[index];
    const values = this.raw(index);
    if (values instanceof Float32Array) return values;
    const floats = Float32Array.from(values);
    if (normalized) {
      const most = LARGEST[componentType];
      for (let i = 0; i < floats.length; i++) floats[i] = Math.max(floats[i] / most, -1);
    }
    return floats;
  }

  /** An accessor of single whole numbers. */
  words(index) {
    const values = this.raw(index);
    return values instanceof Uint32Array ? values : Uint32Array.from(values);
  }

  width(index) {
    return COMPONENTS[this.json.accessors[index].type];
  }

  /** The image of a texture as a `Blob`; none if it could not be embedded. */
  picture(texture) {
    const entry = this.json.textures?.[texture];
    const source = entry?.extensions?.EXT_texture_webp?.source ?? entry?.source;
    const image = this.json.images?.[source];
    if (image?.bufferView === undefined) return null;
    return new Blob([this.view(image.bufferView)], { type: image.mimeType });
  }
}
