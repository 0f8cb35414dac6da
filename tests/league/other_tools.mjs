// Simplifies a GLB by meshoptimizer, primitive by primitive, and by glTF-Transform.
//
//   node other_tools.mjs FOLDER INPUT RATIO WAY OUTPUT
//
// FOLDER has node_modules. WAY is `transform` (glTF-Transform's simplify), `attributes`
// (simplifyWithAttributes), `update` (simplifyWithUpdate), or `permissive` (the same, Permissive).
import { createRequire } from "node:module";
import { resolve } from "node:path";
import { pathToFileURL } from "node:url";

const [folder, input, ratioText, way, output] = process.argv.slice(2);
const ratio = Number(ratioText);
const { resolve: find } = createRequire(resolve(folder, "other_tools.js"));
const from = (name) => import(pathToFileURL(find(name)).href);
const { NodeIO } = await from("@gltf-transform/core");
const { ALL_EXTENSIONS } = await from("@gltf-transform/extensions");
const { weld, simplify } = await from("@gltf-transform/functions");
const { MeshoptSimplifier } = await from("meshoptimizer");
await MeshoptSimplifier.ready;

const io = new NodeIO().registerExtensions(ALL_EXTENSIONS);
const document = await io.read(input);
await document.transform(weld());
if (way === "transform") {
  await document.transform(simplify({ simplifier: MeshoptSimplifier, ratio, error: 1 }));
} else {
  const primitives = new Set(
    document.getRoot().listMeshes().flatMap((mesh) => mesh.listPrimitives()),
  );
  for (const primitive of primitives) simplifyOne(primitive);
}
await io.write(output, document);

function simplifyOne(primitive) {
  if (primitive.getMode() !== 4) return;
  const names = ["NORMAL", "TEXCOORD_0", "COLOR_0"].filter((name) => primitive.getAttribute(name));
  const widths = names.map((name) => (name === "TEXCOORD_0" ? 2 : 3));
  const positions = values(primitive.getAttribute("POSITION"), 3);
  const count = positions.length / 3;
  const stride = Math.max(widths.reduce((sum, width) => sum + width, 0), 1);
  const attributes = new Float32Array(count * stride);
  let at = 0;
  for (const [k, name] of names.entries()) {
    const own = values(primitive.getAttribute(name), widths[k]);
    for (let v = 0; v < count; v++)
      for (let c = 0; c < widths[k]; c++) attributes[v * stride + at + c] = own[v * widths[k] + c];
    at += widths[k];
  }
  const indices = new Uint32Array(primitive.getIndices().getArray());
  const wanted = Math.max(3, 3 * Math.floor((indices.length / 3) * ratio));
  const weights = new Array(stride).fill(names.length ? 1 : 0);
  const flags = way === "permissive" ? ["Prune", "Permissive"] : ["Prune"];
  const all = [indices, positions, 3, attributes, stride, weights, null, wanted, 1, flags];
  let kept;
  if (way === "attributes") {
    [kept] = MeshoptSimplifier.simplifyWithAttributes(...all);
  } else {
    const [left] = MeshoptSimplifier.simplifyWithUpdate(...all);
    kept = indices.slice(0, left);
    put(primitive, "POSITION", positions, 3);
    at = 0;
    for (const [k, name] of names.entries()) {
      const own = new Float32Array(count * widths[k]);
      for (let v = 0; v < count; v++) {
        const vector = attributes.slice(v * stride + at, v * stride + at + widths[k]);
        const length = name === "NORMAL" ? Math.hypot(...vector) || 1 : 1;
        for (let c = 0; c < widths[k]; c++) own[v * widths[k] + c] = vector[c] / length;
      }
      put(primitive, name, own, widths[k]);
      at += widths[k];
    }
  }
  const buffer = document.getRoot().listBuffers()[0];
  const accessor = document.createAccessor().setType("SCALAR").setBuffer(buffer);
  primitive.setIndices(accessor.setArray(new Uint32Array(kept)));
}

function values(accessor, width) {
  const all = new Float32Array(accessor.getCount() * width);
  const element = [];
  for (let i = 0; i < accessor.getCount(); i++) {
    accessor.getElement(i, element);
    for (let c = 0; c < width; c++) all[i * width + c] = element[c];
  }
  return all;
}

function put(primitive, name, array, width) {
  const buffer = document.getRoot().listBuffers()[0];
  const accessor = document.createAccessor().setType(`VEC${width}`).setBuffer(buffer);
  primitive.setAttribute(name, accessor.setArray(array));
}
