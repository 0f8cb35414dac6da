// Tests of the package as a user has it: packed, installed into a fresh folder, bundled by Vite,
// opened in Chromium. `node --test` with LODC_WEB naming the built package, LODC_WEB_TOOLS the
// node_modules with vite, typescript and three, LODC the program (tests/cli/web.rs).

import assert from 'node:assert/strict';
import { execFileSync } from 'node:child_process';
import {
  cpSync, mkdirSync, mkdtempSync, readFileSync, readdirSync, rmSync, statSync, symlinkSync,
  writeFileSync,
} from 'node:fs';
import { tmpdir } from 'node:os';
import { join } from 'node:path';
import test from 'node:test';
import { pathToFileURL } from 'node:url';
import { gzipSync } from 'node:zlib';
import { Chromium } from './chromium.mjs';
import { animated, ball, boards, separated } from './models.mjs';
import { serve } from './serve.mjs';

const { LODC_WEB, LODC_WEB_TOOLS, LODC } = process.env;
const fixtures = new URL('../../../fixtures/', import.meta.url).pathname;
const app = new URL('./app/', import.meta.url).pathname;
const scratch = mkdtempSync(join(tmpdir(), 'lodc-package-'));
const models = join(scratch, 'models');
const fresh = join(scratch, 'fresh');
const run = (cwd, program, ...args) => (
  execFileSync(program, args, { cwd, encoding: 'utf8', timeout: 120_000 }));
const lodc = (...args) => run(models, LODC, ...args);

mkdirSync(models);
cpSync(app, fresh, { recursive: true });
const quiet = ['--silent', '--offline', '--no-audit', '--no-fund', '--no-update-notifier'];
const packed = run(scratch, 'npm', 'pack', ...quiet, LODC_WEB);
const tarball = packed.trim().split('\n').at(-1);
writeFileSync(join(fresh, 'package.json'), '{ "private": true, "type": "module" }');
run(fresh, 'npm', 'install', ...quiet, '--legacy-peer-deps', join(scratch, tarball));
for (const name of readdirSync(LODC_WEB_TOOLS).filter((name) => !name.startsWith('.'))) {
  symlinkSync(join(LODC_WEB_TOOLS, name), join(fresh, 'node_modules', name));
}
const tool = (name, ...args) => run(fresh, 'node', join(LODC_WEB_TOOLS, name), ...args);
const installed = join(fresh, 'node_modules/lodc');
const axe = readFileSync(join(LODC_WEB_TOOLS, 'axe-core/axe.min.js'), 'utf8');

/** A fixture as a file, and as a stream. */
function built(name, ...options) {
  const [stem] = name.split('.');
  cpSync(join(fixtures, name), join(models, name));
  lodc('build', name, '-o', `${stem}.lodc`, '-q', '--models', 'none', ...options);
  lodc('pack', `${stem}.lodc`, '-o', `${stem}.lods`, '-q');
}

for (const stem of ['machine_part', 'skinned_tube_u8', 'morphing_sphere', 'terrain']) {
  built(`${stem}.glb`);
}
separated(models);
lodc('build', 'scene.gltf', '-o', 'scene.lodc', '-q', '--models', 'none');
lodc('pack', 'scene.lodc', '-o', 'scene.lods', '-q');
animated(models);
lodc('build', 'animated.gltf', '-o', 'animated.lodc', '-q', '--models', 'none');
lodc('pack', 'animated.lodc', '-o', 'animated.lods', '-q');
boards(models);
lodc('build', 'boards.obj', '-o', 'boards.lodc', '-q', '--models', 'none');
lodc('pack', 'boards.lodc', '-o', 'boards.lods', '-q');
ball(models);
lodc('build', 'ball.obj', '-o', 'ball.lodc', '-q', '--models', 'none');
tool('vite/bin/vite.js', 'build', '--logLevel', 'error');
const server = await serve(join(fresh, 'dist'), models);
const browser = await Chromium.start('--enable-unsafe-webgpu');
await browser.size(640, 480);
await browser.goto(`${server.url}/index.html`);
await browser.until("'ready' in document.documentElement.dataset");
test.after(async () => {
  await browser.close();
  rmSync(scratch, { recursive: true });
});
/** What was written to the console, but for what reading pixels back says. */
function said() {
  return browser.console.filter((line) => !line.includes('GPU stall due to ReadPixels'));
}
/** Calls a function of the page; nothing may be written to its console meanwhile. */
async function page(name, ...args) {
  browser.console.length = 0;
  const value = await browser.value(`${name}(${args.map((arg) => JSON.stringify(arg)).join()})`);
  assert.deepEqual(said(), [], `${name} ${args}`);
  return value;
}
/** Keeps a picture of the page where LODC_PICTURES says. */
async function keep(name) {
  const picture = await browser.picture();
  const folder = process.env.LODC_PICTURES;
  if (folder) writeFileSync(join(folder, `${name}.png`), picture);
}

test('the package is small', () => {
  const bytes = (name) => readFileSync(join(installed, 'loader', name));
  const size = (name) => gzipSync(bytes(name), { level: 9 }).length;
  const wasm = ['file.wasm', 'stream.wasm'].map(size);
  const element = size('view.js') + size('stage.js');
  const scripts = readdirSync(join(installed, 'loader')).filter((name) => name.endsWith('.js'));
  const loader = scripts.filter((name) => !['view.js', 'stage.js', 'crowd.js'].includes(name));
  const js = loader.reduce((sum, name) => sum + size(name), 0);
  console.log(`file.wasm, stream.wasm ${wasm} bytes, JavaScript ${js}, ${element} bytes with gzip`);
  assert.ok(element <= 5632, `the element: ${element} bytes`);
  // A page loads the one that its models need.
  assert.ok(Math.max(...wasm) <= 60 << 10, `WebAssembly: ${wasm} bytes`);
  assert.ok(js <= 15 << 10, `JavaScript: ${js} bytes`);
});

/** Compiles sources strictly, the declarations of all packages with them. */
function typed(resolution, ...words) {
  const [module, moduleResolution] = resolution;
  const options = ['--noEmit', '--strict', '--skipLibCheck', 'false', '--target', 'esnext'];
  options.push('--module', module, '--moduleResolution', moduleResolution);
  options.push('--lib', 'esnext,dom,dom.iterable');
  tool('typescript/bin/tsc', ...options, ...words);
}

test('its declarations hold, of every entry of package.json, and in JSX', () => {
  const { exports } = JSON.parse(readFileSync(join(installed, 'package.json')));
  const modules = Object.keys(exports).filter((name) => !name.endsWith('.wasm'));
  const lines = modules.map((name, i) => `import * as m${i} from '${name.replace('.', 'lodc')}';`);
  lines.push(`export { ${modules.map((_, i) => `m${i}`).join(', ')} };`);
  writeFileSync(join(fresh, 'all.ts'), lines.join('\n'));
  typed(['esnext', 'bundler'], 'types.ts', 'every.ts', 'all.ts');
  typed(['nodenext', 'nodenext'], 'all.ts');
  // React has JSX in its own module; others have it in the global scope.
  typed(['esnext', 'bundler'], '--jsx', 'react-jsx', 'react.tsx');
  typed(['esnext', 'bundler'], '--jsx', 'preserve', '--jsxFactory', 'h', 'jsx.tsx');
});

test('every entry of package.json is in the package', () => {
  const { exports } = JSON.parse(readFileSync(join(installed, 'package.json')));
  for (const entry of Object.values(exports)) {
    for (const file of [entry].flatMap((e) => (typeof e === 'string' ? e : Object.values(e)))) {
      assert.ok(readFileSync(join(installed, file)).length > 0, file);
    }
    if (!entry.default || !entry.types) continue;
    const [types, script] = ['types', 'default'].map((kind) => (
      readFileSync(join(installed, entry[kind]), 'utf8')));
    for (const [, name] of types.matchAll(/^export (?:class|function|const) (\w+)/gm)) {
      const made = new RegExp(`^export (async )?(class|function|const) ${name}\\b`
        + `|^export \\{[^}]*\\b${name}\\b`, 'm');
      assert.match(script, made, `${entry.default} exports ${name}`);
    }
  }
});

test('models look like the glTF they are made of, in motion, too, and so do copies', async () => {
  const cases = [
    ['machine_part.lodc', 'machine_part.glb', 0], ['terrain.lodc', 'terrain.glb', 0],
    ['skinned_tube_u8.lodc', 'skinned_tube_u8.glb', 0.4],
    ['morphing_sphere.lodc', 'morphing_sphere.glb', 0.4],
    ['scene.lodc', 'scene.gltf', 0], ['scene.lods', 'scene.gltf', 0],
    ['skinned_tube_u8.lods', 'skinned_tube_u8.glb', 0.4],
    ['morphing_sphere.lods', 'morphing_sphere.glb', 0.4],
  ];
  for (const [mine, plain, seconds] of cases) {
    const compared = await page('compare', `/${mine}`, `/${plain}`, seconds);
    const { differ, drawn, copied, clips, colours } = compared;
    await keep(mine);
    assert.ok(drawn > 5000, `${mine}: ${drawn} pixels are drawn`);
    // Of a stream only the order of triangles is another: seams of pixels may fall differently.
    assert.ok(differ <= drawn / 1000, `${mine}: ${differ} of ${drawn} pixels differ`);
    assert.ok(copied <= drawn / 1000, `${mine}: ${copied} pixels of a copy differ`);
    assert.equal(clips[0], clips[1], mine);
    if (mine.startsWith('scene')) assert.ok(colours[0] > 60, `${mine} is grey: ${colours}`);
  }
});

test('materials of an OBJ are those that three.js reads of its MTL', async () => {
  for (const name of ['/boards.lodc', '/boards.lods']) {
    const { differ, drawn, ends, missing } = await page('boards', name);
    await keep('boards');
    assert.ok(drawn > 5000, `${drawn} pixels are drawn`);
    assert.ok(differ <= drawn / 1000, `${name}: ${differ} of ${drawn} pixels differ`);
    assert.deepEqual(ends, [true, true], 'an image ends');
    assert.equal(missing, 1, 'what has no material is grey');
  }
});

test('a stream shows within its first block and grows in place', async () => {
  const gate = server.gate('/terrain.lods');
  gate.open(0.05);
  let { triangles } = await page('begin', '/terrain.lods');
  assert.ok(triangles > 0);
  await keep('stream-5');
  for (const share of [0.1, 0.3, 0.6]) {
    gate.open(share);
    const grown = await page('grown', triangles);
    assert.ok(grown > triangles);
    triangles = grown;
    await keep(`stream-${100 * share}`);
  }
  gate.open(1);
  const all = await page('whole');
  await keep('stream-100');
  assert.ok(all > triangles);
  const end = await page('finish');
  assert.equal(all, Math.max(...end.triangles));
  assert.deepEqual(end.triangles, [...end.triangles].sort((x, y) => x - y), 'it only grows');
  assert.ok(end.complete && end.last === 'complete');
  assert.equal(end.geometries[0], end.geometries[1], 'geometries are made once');
  assert.ok(end.near > end.far && end.far > 0, 'a stream that has come chooses levels');
});

test('a textured stream shows its images when they have come', async () => {
  const gate = server.gate('/scene.lods');
  gate.open(0.3);
  const begun = page('begin', '/scene.lods');
  gate.open(1);
  await begun;
  await page('whole');
  const end = await page('finish');
  assert.ok(end.colour > 60, `grey: ${end.colour}`);
});

test('a crowd of 200 shares one geometry, and each copy has a level of its own', async () => {
  const crowd = await page('crowd', '/terrain.lodc', 200);
  await keep('crowd');
  assert.equal(crowd.geometries, 1);
  assert.ok(crowd.near > 2 * crowd.far && crowd.far > 0, JSON.stringify(crowd));
  assert.ok(crowd.hit, 'a ray hits');
});

test('a crowd of 200 looks like clones, and takes a draw call for each level', async () => {
  const crowd = await page('crowdOf', '/terrain.lodc', 200);
  await keep('instances');
  assert.ok(crowd.drawn > 20_000 && crowd.differ < crowd.drawn / 500, JSON.stringify(crowd));
  assert.ok(crowd.calls[0] > 100 && crowd.calls[1] <= 40, JSON.stringify(crowd));
  assert.equal(crowd.triangles[0], crowd.triangles[1]);
  assert.equal(crowd.finest, crowd.whole);
  assert.ok(crowd.again.drawn > 5000, 'the model is still there');
  assert.equal(crowd.again.differ, 0);
});

test("the page's thread decodes nothing and copies nothing", async () => {
  const { size } = statSync(join(models, 'terrain.lodc'));
  const file = await page('aside', '/terrain.lodc');
  assert.deepEqual([file.compiled, file.sent, file.copied], [0, size, 0]);
  assert.ok(file.arrays > 1);
  assert.equal(file.buffers, 1, 'arrays lie where the message of the worker does');
  const stream = await page('aside', '/machine_part.lods');
  assert.deepEqual([stream.compiled, stream.copied], [0, 0]);
  assert.ok(stream.sent > 0);
});

test('damage, a cut, an abortion are errors', async () => {
  const bytes = readFileSync(join(models, 'terrain.lodc'));
  bytes[bytes.length >> 1] ^= 255;
  writeFileSync(join(models, 'damaged.lodc'), bytes);
  assert.match(await page('refused', '/damaged.lodc'), /^\/damaged\.lodc: section .*damaged/);
  const stream = readFileSync(join(models, 'terrain.lods'));
  writeFileSync(join(models, 'cut.lods'), stream.subarray(0, stream.length / 2));
  assert.match(await page('refused', '/cut.lods'), /the file is cut off, or came incomplete/);
  stream[stream.length >> 1] ^= 255;
  writeFileSync(join(models, 'damaged.lods'), stream);
  assert.match(await page('refused', '/damaged.lods'), /block \d*.*checksum|block .*checksum/);
  writeFileSync(join(models, 'text.lodc'), 'not a model');
  assert.match(await page('refused', '/text.lodc'), /not a/);
  writeFileSync(join(models, 'page.lodc'), '<!doctype html>\n<title>Not found</title>');
  assert.equal(await page('refused', '/page.lodc'), '/page.lodc is HTML, not a .lodc file');
  assert.equal(await page('aborted', '/terrain.lods'), 'AbortError');
});

test('an element shows a model, and does what its attributes say', async () => {
  const gate = server.gate('/machine_part.lods');
  const poster = '/images/greens.png';
  await page('element', { src: '/machine_part.lods', poster, alt: 'A part' });
  const before = await page('shown');
  assert.deepEqual([before.label, before.poster, before.triangles], ['A part', true, 0]);
  await keep('view-poster');
  gate.open(1);
  assert.deepEqual(await page('events', 'complete'), ['load', 'complete']);
  await page('change', { pixels: '-1' });
  await keep('view');
  const whole = await page('shown');
  assert.deepEqual([whole.poster, whole.error, whole.triangles], [false, null, 480]);
  const counts = [];
  for (const level of ['0', '1', '3', '1000']) {
    await page('change', { level });
    counts.push((await page('shown')).triangles);
  }
  assert.equal(counts[0], 480);
  for (let i = 1; i < counts.length; i++) assert.ok(counts[i] < counts[i - 1], `${counts}`);
  await page('change', { level: null, pixels: '100000' });
  assert.equal((await page('shown')).triangles, counts.at(-1), 'pixels choose');
  const upright = await page('image');
  await page('change', { up: 'z' });
  assert.notEqual(await page('image'), upright, 'it lies down');
  await page('change', { up: 'y' });
  assert.equal(await page('image'), upright);
  await page('press', 'ArrowLeft');
  assert.notEqual(await page('image'), upright, 'it turns');
});

test('an element says what is wrong, and what follows replaces it', async () => {
  await page('element', { src: '/text.lodc' });
  assert.deepEqual(await page('events', 'error'), ['error']);
  assert.match((await page('shown')).error, /^\/text\.lodc: .*not a/);
  await keep('view-error');
  const counts = [];
  for (const src of ['/terrain.lodc', '/machine_part.lodc', '/terrain.lodc']) {
    await page('change', { src, pixels: '-1' });
    await page('events', 'complete');
    const { error, geometries } = await page('shown');
    assert.equal(error, null);
    counts.push(geometries);
  }
  assert.equal(counts[0], counts[2], 'geometries of models before are gone');
});

test('properties of an element are its attributes', async () => {
  await page('element', { src: '/machine_part.lodc', alt: 'A part' });
  await page('events', 'complete');
  assert.deepEqual(await page('property', 'alt', 'Another'), ['Another', 'Another']);
  assert.equal((await page('shown')).label, 'Another');
  assert.deepEqual(await page('property', 'level', 2), [2, '2']);
  await page('image');
  assert.equal((await page('shown')).level, 2, 'levels are counted from the finest everywhere');
  assert.deepEqual(await page('property', 'level', null), [null, null]);
  assert.deepEqual(await page('property', 'autoplay', true), [true, '']);
  assert.deepEqual(await page('property', 'autoplay', false), [false, null]);
  assert.equal(await page('upgraded'), 'early');
  assert.deepEqual(await page('focused'), [true, true]);
  await page('change', {});
  await page('property', 'src', '/terrain.lodc');
  await page('events', 'complete');
  assert.ok((await page('shown')).triangles > 480);
});

test('an element plays animations, and stops', async () => {
  for (const src of ['/animated.lodc', '/animated.lods']) {
    await page('element', { src });
    await page('events', 'complete');
    assert.equal(await page('moves'), false, 'none is asked for');
    await page('element', { src, autoplay: '' });
    await page('events', 'complete');
    assert.equal(await page('moves'), true, `${src}: the first one`);
    await page('press', ' ');
    assert.equal(await page('moves'), false, 'the space bar stops it');
    await page('press', ' ');
    assert.equal(await page('moves'), true, 'and lets it go on');
    await page('change', { animation: 'Rise' });
    assert.equal(await page('moves'), true, 'the second one');
    await page('change', { animation: 'no such' });
    assert.equal(await page('moves'), false);
  }
});

test('a model without a texture is seen on white', async () => {
  for (const src of ['/morphing_sphere.lodc', '/ball.lodc']) {
    await page('element', { src });
    await page('events', 'complete');
    const light = await page('brightness');
    await keep(`view-neutral-${src.slice(1)}`);
    assert.ok(light.drawn > 10_000 && light.white < 0.02, `${src}: ${JSON.stringify(light)}`);
    assert.ok(light.light - light.dark > 20, `${src} is flat: ${JSON.stringify(light)}`);
  }
});

test('thirty elements share one context', async () => {
  await page('remove');
  assert.deepEqual(await page('many', '/machine_part.lodc', 30), { shown: 30, contexts: 1 });
});

test('an element that is taken out frees its memory', async () => {
  for (let i = 0; i < 20; i++) {
    await page('element', { src: '/machine_part.lodc' });
    await page('events', 'load');
  }
  await page('remove');
  assert.deepEqual(await page('freed'), { pixels: 0, isLost: true });
  await browser.send('HeapProfiler.collectGarbage');
  assert.equal(await page('lives'), false, 'the model is kept');
});

/** What axe finds in the page as it is; nothing may have been written to its console. */
async function findings(what, where = 'html') {
  await browser.value(`${axe}; null`);
  const found = await browser.value(`axe.run('${where}').then(({ violations }) => (
    violations.flatMap(({ id, nodes }) => nodes.map(({ target, failureSummary }) => (
      \`\${id}: \${target}: \${failureSummary}\`)))))`);
  assert.deepEqual(found, [], what);
  assert.deepEqual(said(), [], what);
}

test('axe finds nothing in an element', async () => {
  await page('element', { src: '/machine_part.lods', alt: 'A part' });
  await page('events', 'complete');
  await findings('a model', 'lodc-view');
  await page('change', { src: '/damaged.lodc' });
  await page('events', 'error');
  await findings('an error', 'lodc-view');
  await page('remove');
});

test("axe finds nothing in the viewer's page, wide and narrow, light and dark", async () => {
  lodc('chain', 'machine_part.glb', '-o', 'chain.glb', '--geomorph', '-q');
  for (const model of ['skinned_tube_u8.lodc', 'chain.glb']) {
    lodc('view', model, '-o', `${model}.html`, '-q');
    for (const [width, height] of [[1280, 800], [390, 844]]) {
      await browser.size(width, height);
      browser.console.length = 0;
      await browser.goto(pathToFileURL(join(models, `${model}.html`)).href);
      await browser.until("document.documentElement.dataset.ready === 'true'");
      const text = await browser.value("document.getElementById('level').ariaValueText");
      assert.match(text ?? '', /^([\d,]+ triangles|level 0 of \d+), 100 % of all$/);
      for (const axis of ['z', 'y']) {
        await browser.value(`document.querySelector('input[name="up"][value="${axis}"]').click()`);
        assert.equal(await browser.value('viewer.scene.up'), axis);
      }
      for (const value of ['light', 'dark']) {
        const features = [{ name: 'prefers-color-scheme', value }];
        await browser.send('Emulation.setEmulatedMedia', { features });
        const side = value === 'dark' ? '<' : '>';
        await browser.until(`viewer.shown.background[0] ${side} 0.5 && !viewer.due`);
        await findings(`${model}, ${width} pixels, ${value}`);
        await keep(`viewer-${model}-${width}-${value}`);
        await browser.value("document.getElementById('look').click()");
        await findings(`${model}, ${width} pixels, ${value}, options`);
        await keep(`viewer-${model}-${width}-${value}-options`);
        await browser.value("document.getElementById('look').click()");
      }
    }
  }
  await browser.size(640, 480);
});

test('the example shows a crowd by distance, and a stream', async () => {
  const example = await serve(LODC_WEB, models);
  browser.console.length = 0;
  const query = 'model=/skinned_tube_u8.lodc&stream=/terrain.lods&copies=100';
  await browser.goto(`${example.url}/example/index.html?${query}`);
  // Browsers ask for an icon.
  const written = () => said().filter((line) => !line.includes('/favicon.ico'));
  await browser.until("/stream: [1-9][0-9,]* triangles$/.test(document.body.innerText.trim())");
  await keep('example');
  const { copies, drawn, whole } = await browser.value('({ ...document.documentElement.dataset })');
  assert.equal(Number(copies), 100);
  assert.ok(0 < Number(drawn) && Number(drawn) < Number(whole), `${drawn} of ${whole}`);
  assert.deepEqual(written(), []);
});

test("the README's lines run", async () => {
  const readme = readFileSync(new URL('../../../README.md', import.meta.url), 'utf8');
  const [, lines] = /## In a browser\n[^]*?```js\n([^]*?)```/.exec(readme);
  const script = "import { Scene } from 'three';\nconst scene = new Scene();\n"
    + `${lines}\ndocument.body.textContent = scene.children.map((m) => m.isComplete).join();`;
  writeFileSync(join(fresh, 'readme.js'), script);
  const html = '<body><script type="module" src="./readme.js"></script>';
  writeFileSync(join(fresh, 'index.html'), html);
  cpSync(join(models, 'machine_part.lods'), join(models, 'part.lods'));
  tool('vite/bin/vite.js', 'build', '--logLevel', 'error', '--outDir', 'readme');
  const other = await serve(join(fresh, 'readme'), models);
  await browser.goto(`${other.url}/index.html`);
  await browser.until("document.body.textContent.trim() !== ''");
  assert.equal(await browser.value('document.body.textContent'), 'true,true');
});
