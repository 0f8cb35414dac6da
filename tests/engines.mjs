// Reads chains as engines do, and prints how many triangles each level has: {file: {babylon: [...], three: [[...]]}}.
// Babylon.js knows MSFT_lod and is asked for one level after the other; three.js reaches the nodes through its parser.
//
//   node engines.mjs MODULES LIST.json
//
// MODULES is a node_modules folder with @babylonjs/core, @babylonjs/loaders and three; LIST.json an array of GLB files.
import { readFileSync } from "node:fs";
import { loaders } from "./loaders.mjs";

const [modules, list] = process.argv.slice(2);
const { NullEngine, Scene, LoadAssetContainerAsync, GLTFLoader } = await loaders(modules);

/** Triangles of each level, the finest first: the loader leaves the finest of the `most` coarsest levels. */
async function babylon(bytes, levels) {
  const triangles = [];
  for (let most = levels; most > 0; most--) {
    const engine = new NullEngine();
    const url = "data:;base64," + bytes.toString("base64");
    const extensionOptions = { MSFT_lod: { maxLODsToLoad: most } };
    const container = await LoadAssetContainerAsync(url, new Scene(engine), {
      pluginExtension: ".glb",
      pluginOptions: { gltf: { extensionOptions, skipMaterials: true } },
    });
    const shown = container.meshes.map((mesh) => (mesh.getTotalIndices?.() ?? 0) / 3);
    triangles.push(shown.reduce((a, b) => a + b, 0));
    engine.dispose();
  }
  return triangles;
}

/** For each node with levels the triangles of every one. */
async function three(bytes) {
  const buffer = bytes.buffer.slice(bytes.byteOffset, bytes.byteOffset + bytes.length);
  const loader = new GLTFLoader();
  const gltf = await new Promise((done, failed) => loader.parse(buffer, "", done, failed));
  const triangles = async (node) => {
    const object = await gltf.parser.getDependency("node", node);
    let count = 0;
    object.traverse((o) => (count += o.isMesh ? o.geometry.index.count / 3 : 0));
    return count;
  };
  const nodes = gltf.parser.json.nodes.map((node, i) => [i, node.extensions?.MSFT_lod?.ids]);
  return Promise.all(nodes.filter(([, ids]) => ids).map(([i, ids]) => Promise.all([i, ...ids].map(triangles))));
}

const result = {};
for (const name of JSON.parse(readFileSync(list, "utf8"))) {
  const bytes = readFileSync(name);
  const seen = await three(bytes);
  result[name] = { babylon: await babylon(bytes, seen[0]?.length ?? 1), three: seen };
}
console.log(JSON.stringify(result));
process.exit(0);
