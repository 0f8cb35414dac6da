// How long the page's thread is busy at a stretch while a large model opens: `just web-long-tasks`,
// or `node longtasks.mjs [TRIANGLES]` with LODC naming the program and LODC_WEB the built package
// with three.js beside it. Opens a file and a stream five times each; all tasks above 50 ms count.

import { execFileSync } from 'node:child_process';
import { mkdtempSync, rmSync, writeFileSync } from 'node:fs';
import { tmpdir } from 'node:os';
import { join } from 'node:path';
import { Chromium } from './chromium.mjs';
import { serve } from './serve.mjs';

const { LODC, LODC_WEB } = process.env;
const RUNS = 5;
const side = Math.ceil(Math.sqrt(Number(process.argv[2] ?? 340_000) / 2));

/** A hilly square of side × side quads with texture coordinates, as OBJ. */
function hills() {
  const lines = [];
  for (let j = 0; j <= side; j++) {
    for (let i = 0; i <= side; i++) {
      const [u, v] = [i / side, j / side];
      const height = 0.06 * Math.sin(19 * u) * Math.cos(17 * v) + 0.01 * Math.sin(131 * u * v);
      lines.push(`v ${u} ${height} ${v}`, `vt ${u} ${v}`);
    }
  }
  const corner = (i, j) => j * (side + 1) + i + 1;
  for (let j = 0; j < side; j++) {
    for (let i = 0; i < side; i++) {
      const corners = [corner(i, j), corner(i, j + 1), corner(i + 1, j + 1), corner(i + 1, j)];
      lines.push(`f ${corners.map((c) => `${c}/${c}`).join(' ')}`);
    }
  }
  return `${lines.join('\n')}\n`;
}

const PAGE = `<!doctype html>
<link rel="icon" href="data:,">
<script type="importmap">
{ "imports": {
  "three": "/node_modules/three/build/three.module.js",
  "three/addons/": "/node_modules/three/examples/jsm/"
} }
</script>
<script type="module">
import * as THREE from 'three';
import { LodcLoader } from '/loader/loader.js';
const pause = () => new Promise((resolve) => setTimeout(resolve, 300));
/** Milliseconds of the longest task of this thread while something is done. */
async function longest(act) {
  const tasks = [];
  const take = (list) => tasks.push(...list.map(({ duration }) => duration));
  const observer = new PerformanceObserver((list) => take(list.getEntries()));
  observer.observe({ type: 'longtask' });
  await act();
  await pause();
  take(observer.takeRecords());
  observer.disconnect();
  return Math.max(0, ...tasks);
}
/** Does nothing for so many milliseconds, in a task of its own. */
window.busy = (milliseconds) => longest(async () => {
  await pause();
  for (const begun = performance.now(); performance.now() - begun < milliseconds;);
});
window.opened = async (url) => {
  const renderer = new THREE.WebGLRenderer();
  const scene = new THREE.Scene();
  scene.add(new THREE.HemisphereLight());
  const camera = new THREE.PerspectiveCamera();
  camera.position.set(0.5, 0.7, 2);
  let [model, shown, whole] = [];
  const opening = await longest(async () => {
    const begun = performance.now();
    model = await LodcLoader.load(url);
    shown = performance.now() - begun;
    await model.whenComplete;
    whole = performance.now() - begun;
  });
  scene.add(model);
  const drawing = await longest(async () => {
    await pause();
    renderer.render(scene, camera);
  });
  const triangles = model.objects.reduce((sum, { header }) => sum + header.triangles, 0);
  const drawn = renderer.info.render.triangles;
  model.dispose();
  renderer.dispose();
  renderer.forceContextLoss();
  return { triangles, drawn, shown, whole, opening, drawing };
};
document.documentElement.dataset.ready = '';
</script>
`;

const scratch = mkdtempSync(join(tmpdir(), 'lodc-tasks-'));
const lodc = (...args) => execFileSync(LODC, [...args, '-q'], { cwd: scratch, stdio: 'inherit' });
writeFileSync(join(scratch, 'index.html'), PAGE);
writeFileSync(join(scratch, 'hills.obj'), hills());
lodc('build', 'hills.obj', '-o', 'hills.lodc', '--models', 'none', '--metric', 'quadric');
lodc('pack', 'hills.lodc', '-o', 'hills.lods');
const server = await serve(scratch, LODC_WEB);
const browser = await Chromium.start();
await browser.goto(`${server.url}/index.html`);
await browser.until("'ready' in document.documentElement.dataset");
const busy = await browser.value('busy(120)');
if (busy < 100) throw new Error(`a task of 120 ms is seen as one of ${busy}`);
for (const name of ['hills.lodc', 'hills.lods']) {
  const runs = [];
  for (let i = 0; i < RUNS; i++) runs.push(await browser.value(`opened('/${name}')`));
  const most = (key) => Math.max(...runs.map((run) => run[key])).toFixed(0);
  const middle = (key) => (
    runs.map((run) => run[key]).sort((a, b) => a - b)[RUNS >> 1].toFixed(0));
  const tasks = (key) => (most(key) === '0' ? 'none above 50 ms' : `up to ${most(key)} ms`);
  console.log(`${name}: ${runs[0].triangles} triangles, there after ${middle('shown')} ms, `
    + `whole after ${middle('whole')} ms, long tasks: ${tasks('opening')}; `
    + `first picture (${runs[0].drawn} triangles): ${tasks('drawing')}`);
}
await browser.close();
rmSync(scratch, { recursive: true });
