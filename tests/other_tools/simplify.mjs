// Simplifies a mesh to 10 % by meshoptimizer; prints its version and the least time of some turns.
//
//   node simplify.mjs FOLDER MESH TURNS
//
// FOLDER has node_modules; MESH is two counts, positions as singles and indices as words.
import { readFileSync } from "node:fs";
import { resolve } from "node:path";
import { pathToFileURL } from "node:url";

const [folder, mesh, turns] = process.argv.slice(2);
const home = resolve(folder, "node_modules/meshoptimizer");
const { MeshoptSimplifier } = await import(pathToFileURL(`${home}/index.js`).href);
await MeshoptSimplifier.ready;
const { version } = JSON.parse(readFileSync(`${home}/package.json`, "utf8"));

const bytes = readFileSync(mesh).buffer;
const [vertices, triangles] = new Uint32Array(bytes, 0, 2);
const positions = new Float32Array(bytes, 8, 3 * vertices);
const indices = new Uint32Array(bytes, 8 + 12 * vertices, 3 * triangles);
let best = Infinity;
for (let turn = 0; turn < Number(turns); turn++) {
  const begun = process.cpuUsage();
  MeshoptSimplifier.simplify(indices, positions, 3, 3 * Math.floor(triangles / 10), 1.0);
  const { user, system } = process.cpuUsage(begun);
  best = Math.min(best, (user + system) / 1e6);
}
console.log(`${version}: ${best.toFixed(3)} s`);
