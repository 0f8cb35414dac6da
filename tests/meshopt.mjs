// Decodes compressed GLB files with the reference decoder and compares them with uncompressed ones, accessor by accessor,
// byte for byte (triangles may be turned). Prints {file: number of accessors that were compared}.
//
//   node meshopt.mjs MODULES LIST.json
//
// MODULES is a node_modules folder with meshoptimizer; LIST.json an array of [compressed, plain].
import { deepStrictEqual } from "node:assert";
import { readFileSync } from "node:fs";
import { join, resolve } from "node:path";
import { pathToFileURL } from "node:url";

const [modules, list] = process.argv.slice(2);
const { MeshoptDecoder } = await import(pathToFileURL(join(resolve(modules), "meshoptimizer/index.js")).href);
await MeshoptDecoder.ready;

/** The document of a GLB and the bytes of its buffer views, decoded where they are compressed. */
function glb(name) {
  const bytes = readFileSync(name);
  const length = bytes.readUInt32LE(12);
  const json = JSON.parse(bytes.subarray(20, 20 + length));
  const bin = bytes.subarray(28 + length);
  const views = (json.bufferViews ?? []).map((view) => {
    const packed = view.extensions?.EXT_meshopt_compression;
    if (!packed) return bin.subarray(view.byteOffset ?? 0, (view.byteOffset ?? 0) + view.byteLength);
    const { byteOffset = 0, byteLength, count, byteStride, mode, filter } = packed;
    const out = new Uint8Array(count * byteStride);
    MeshoptDecoder.decodeGltfBuffer(out, count, byteStride, bin.subarray(byteOffset, byteOffset + byteLength), mode, filter);
    return Buffer.from(out.buffer);
  });
  return { json, views };
}

const SIZES = { 5120: 1, 5121: 1, 5122: 2, 5123: 2, 5125: 4, 5126: 4 };
const COMPONENTS = { SCALAR: 1, VEC2: 2, VEC3: 3, VEC4: 4, MAT4: 16 };

/** The elements of an accessor, as bytes without gaps. */
function elements({ json, views }, index) {
  const accessor = json.accessors[index];
  const view = json.bufferViews[accessor.bufferView];
  const size = SIZES[accessor.componentType] * COMPONENTS[accessor.type];
  const stride = view.byteStride ?? size;
  const at = (i) => (accessor.byteOffset ?? 0) + i * stride;
  const bytes = views[accessor.bufferView];
  return Array.from({ length: accessor.count }, (_, i) => bytes.subarray(at(i), at(i) + size).toString("hex"));
}

/** The accessors of samples of animations and of matrices of skins. */
function samples({ json }) {
  const samplers = (json.animations ?? []).flatMap((animation) => animation.samplers);
  const matrices = (json.skins ?? []).map((skin) => skin.inverseBindMatrices);
  return [...samplers.flatMap((s) => [s.input, s.output]), ...matrices.filter((m) => m !== undefined)];
}

/** Triangles with their least corner first. */
function turned(indices) {
  const out = [];
  for (let i = 0; i < indices.length; i += 3) {
    const t = indices.slice(i, i + 3);
    const least = t.indexOf([...t].sort()[0]);
    out.push([t[least], t[(least + 1) % 3], t[(least + 2) % 3]].join());
  }
  return out;
}

const result = {};
for (const [compressed, plain] of JSON.parse(readFileSync(list, "utf8"))) {
  const [a, b] = [glb(compressed), glb(plain)];
  let count = 0;
  if (!a.json.bufferViews.some((view) => view.extensions?.EXT_meshopt_compression)) {
    result[compressed] = 0;
    continue;
  }
  a.json.meshes.forEach((mesh, m) =>
    mesh.primitives.forEach((primitive, p) => {
      const other = b.json.meshes[m].primitives[p];
      for (const [name, accessor] of Object.entries(primitive.attributes)) {
        deepStrictEqual(elements(a, accessor), elements(b, other.attributes[name]));
        count++;
      }
      deepStrictEqual(turned(elements(a, primitive.indices)), turned(elements(b, other.indices)));
      count++;
    }),
  );
  const others = samples(b);
  samples(a).forEach((accessor, i) => {
    deepStrictEqual(elements(a, accessor), elements(b, others[i]));
    count++;
  });
  result[compressed] = count;
}
console.log(JSON.stringify(result));
