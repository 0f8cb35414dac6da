// Plays the morph target of each level of chains as engines do: prints for each file, by engine, how far each level is
// from the next one at weight 1, in area and first moments, relative to those of the next one.
//
//   node weights.mjs MODULES LIST.json
import { readFileSync } from "node:fs";
import { loaders } from "./loaders.mjs";

const [modules, list] = process.argv.slice(2);
const { NullEngine, Scene, LoadAssetContainerAsync, GLTFLoader, Mesh, Vector3 } = await loaders(modules);

/** Area and first moments of a surface, and twice the vectors of its area. */
function moments(positions, indices) {
  const sums = [0, 0, 0, 0, 0, 0, 0];
  for (let t = 0; t + 2 < indices.length; t += 3) {
    const [a, b, c] = [0, 1, 2].map((k) => positions[indices[t + k]]);
    const [u, v] = [b, c].map((p) => p.map((x, k) => x - a[k]));
    const n = [0, 1, 2].map((k) => u[(k + 1) % 3] * v[(k + 2) % 3] - u[(k + 2) % 3] * v[(k + 1) % 3]);
    const area = Math.hypot(...n) / 2;
    sums[0] += area;
    for (let k = 0; k < 3; k++) {
      sums[1 + k] += area * (a[k] + b[k] + c[k]) / 3;
      sums[4 + k] += n[k];
    }
  }
  return sums;
}

const added = (all) => all.reduce((a, b) => a.map((x, k) => x + b[k]));
const off = (a, b) => Math.max(...a.map((x, k) => Math.abs(x - b[k]))) / Math.max(...b.map(Math.abs));

async function three(bytes) {
  const buffer = bytes.buffer.slice(bytes.byteOffset, bytes.byteOffset + bytes.length);
  const gltf = await new Promise((done, failed) => new GLTFLoader().parse(buffer, "", done, failed));
  const { json } = gltf.parser;
  const node = json.nodes.findIndex((n) => n.extensions?.MSFT_lod);
  const ids = [node, ...json.nodes[node].extensions.MSFT_lod.ids];
  const shown = async (id, weight) => {
    const parts = [];
    (await gltf.parser.getDependency("node", id)).traverse((mesh) => {
      if (!mesh.isMesh) return;
      const target = mesh.morphTargetDictionary?.["lodc:next"];
      if (target !== undefined) mesh.morphTargetInfluences[target] = weight;
      // Before any skin.
      const place = (v) => Mesh.prototype.getVertexPosition.call(mesh, v, new Vector3()).toArray();
      const { position } = mesh.geometry.attributes;
      parts.push(moments(Array.from({ length: position.count }, (_, v) => place(v)), mesh.geometry.index.array));
    });
    return added(parts);
  };
  const differences = [];
  for (let k = 0; k + 1 < ids.length; k++) {
    differences.push(off(await shown(ids[k], 1), await shown(ids[k + 1], 0)));
  }
  return differences;
}

async function babylon(bytes, levels) {
  const shown = async (most, weight) => {
    const engine = new NullEngine();
    const url = "data:;base64," + bytes.toString("base64");
    const container = await LoadAssetContainerAsync(url, new Scene(engine), {
      pluginExtension: ".glb",
      pluginOptions: { gltf: { extensionOptions: { MSFT_lod: { maxLODsToLoad: most } }, skipMaterials: true } },
    });
    const parts = container.meshes.filter((mesh) => mesh.getTotalIndices?.() > 0).map((mesh) => {
      const manager = mesh.morphTargetManager;
      for (let t = 0; t < (manager?.numTargets ?? 0); t++) {
        const target = manager.getTarget(t);
        if (target.name === "lodc:next") target.influence = weight;
      }
      const flat = mesh.getPositionData(false, true);
      const positions = Array.from({ length: flat.length / 3 }, (_, v) => [...flat.slice(3 * v, 3 * v + 3)]);
      return moments(positions, mesh.getIndices());
    });
    engine.dispose();
    return added(parts);
  };
  const differences = [];
  for (let most = levels; most > 1; most--) {
    differences.push(off(await shown(most, 1), await shown(most - 1, 0)));
  }
  return differences;
}

const result = {};
for (const name of JSON.parse(readFileSync(list, "utf8"))) {
  const bytes = readFileSync(name);
  const seen = await three(bytes);
  result[name] = { babylon: await babylon(bytes, seen.length + 1), three: seen };
}
console.log(JSON.stringify(result));
process.exit(0);
