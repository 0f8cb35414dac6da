// Tests of the built package under node: `node --test` with LODC_WEB naming the package's folder
// and LODC naming the program (tests/cli/web.rs runs it).

import assert from 'node:assert/strict';
import { execFileSync } from 'node:child_process';
import {
  mkdtempSync, readFileSync, rmSync, writeFileSync,
} from 'node:fs';
import { tmpdir } from 'node:os';
import { join } from 'node:path';
import test from 'node:test';
import { pathToFileURL } from 'node:url';

const folder = process.env.LODC_WEB;
const program = process.env.LODC;
const fixtures = new URL('../../../fixtures/', import.meta.url).pathname;
const module = (name) => import(pathToFileURL(join(folder, name)).href);
const { Lodc } = await module('lodc.js');
const lodc = await Lodc.create(readFileSync(join(folder, 'lodc.wasm')));
const scratch = mkdtempSync(join(tmpdir(), 'lodc-web-'));
test.after(() => rmSync(scratch, { recursive: true }));

function run(...args) {
  return execFileSync(program, args, { cwd: scratch, encoding: 'utf8' });
}

function built(input, ...options) {
  const name = `${input}.lodc`;
  run('build', join(fixtures, input), '-o', name, '-q', ...options);
  return readFileSync(join(scratch, name));
}

const extracted = (input, ...selector) => JSON.parse(
  run('extract', `${input}.lodc`, ...selector, '--no-refit', '-o', 'l.glb', '--json', '-q'));

const INPUTS = ['machine_part.glb', 'skinned_tube_u8.glb', 'morphing_sphere.glb', 'terrain.obj'];

test('levels are those of extract', () => {
  for (const input of INPUTS) {
    const { objects, selection } = lodc.open(built(input));
    const drawn = () => objects.reduce((sum, { parts }) => (
      sum + parts.reduce((n, { submesh }) => n + submesh.triangles, 0)), 0);
    const compare = (lods, ...selector) => {
      selection.seek(lods);
      const wanted = extracted(input, ...selector);
      assert.equal(drawn(), wanted.triangles, `${input} ${selector}`);
      const own = wanted.objects.map((object) => object.lod);
      assert.deepEqual(lods, own, `${input} ${selector}`);
    };
    const half = Math.floor(selection.triangles / 2);
    for (const lod of [0, 7, 50, 100, 1e6]) compare(selection.byLod(lod), '--lod', String(lod));
    compare(selection.byTriangles(half), '--triangles', String(half));
    compare(selection.byTriangles(9), '--triangles', '9');
    compare(selection.byError(0.01), '--error', '0.01');
    const parts = ({ objects }) => objects.map((object) => object.parts);
    const gpu = parts(lodc.open(built(input, '--layout', 'gpu')));
    assert.deepEqual(gpu, parts(lodc.open(built(input))), `${input} of the gpu layout`);
  }
});

/** A glTF of wavy sheets of some sizes, scaled by their nodes. */
function scene(sizes) {
  const [chunks, bufferViews, accessors, meshes, nodes] = [[], [], [], [], []];
  let length = 0;
  const accessor = (array, type, more) => {
    bufferViews.push({ buffer: 0, byteOffset: length, byteLength: array.byteLength });
    length += array.byteLength;
    chunks.push(Buffer.from(array.buffer));
    const count = type === 'VEC3' ? array.length / 3 : array.length;
    const componentType = type === 'VEC3' ? 5126 : 5125;
    accessors.push({ bufferView: accessors.length, count, type, componentType, ...more });
    return accessors.length - 1;
  };
  sizes.forEach((size, number) => {
    const [points, corners] = [[], []];
    for (let i = 0; i <= size; i++) {
      for (let j = 0; j <= size; j++) {
        points.push(i, j, Math.sin(i * (0.7 + number)) * Math.cos(0.9 * j));
        const at = i * (size + 1) + j;
        const [right, below] = [at + 1, at + size + 1];
        if (i < size && j < size) corners.push(at, below, below + 1, at, below + 1, right);
      }
    }
    const [min, max] = [[0, 0, -1], [size, size, 1]];
    const POSITION = accessor(new Float32Array(points), 'VEC3', { min, max });
    const indices = accessor(new Uint32Array(corners), 'SCALAR');
    meshes.push({ name: `sheet${number}`, primitives: [{ attributes: { POSITION }, indices }] });
    nodes.push({ mesh: number, scale: [[1, 1, 1], [0.25, 0.25, 0.25], [3, 1, 2]][number % 3] });
  });
  const uri = `data:application/octet-stream;base64,${Buffer.concat(chunks).toString('base64')}`;
  return JSON.stringify({
    asset: { version: '2.0' }, scene: 0, scenes: [{ nodes: nodes.map((_, i) => i) }], nodes,
    meshes, accessors, bufferViews, buffers: [{ byteLength: length, uri }],
  });
}

test('levels of ten scenes are those of extract', () => {
  for (let number = 0; number < 10; number++) {
    const sizes = Array.from({ length: 1 + number % 4 }, (_, i) => 4 + (5 * i + 3 * number) % 13);
    writeFileSync(join(scratch, 's.gltf'), scene(sizes));
    run('build', 's.gltf', '-o', 's.lodc', '--models', 'none', '-q');
    const { selection } = lodc.open(readFileSync(join(scratch, 's.lodc')));
    const lods = (...selector) => extracted('s', ...selector).objects.map(({ lod }) => lod);
    for (const share of [0.5, 0.25, 0.1, 0.05]) {
      const most = Math.floor(share * selection.triangles);
      const wanted = lods('--triangles', String(most));
      assert.deepEqual(selection.byTriangles(most), wanted, `scene ${number} at ${share}`);
    }
    for (const error of [0.05, 0.3]) {
      assert.deepEqual(selection.byError(error), lods('--error', String(error)), `${number}`);
    }
  }
});

test('placements err by their own stretch only if the largest is even', async () => {
  const [{ composed, stretch }, { errorScales }] = [
    await module('math.js'), await module('viewdependent.js'),
  ];
  const placed = (object, ...scale) => ({
    object, world: composed([1, 2, 3], [0.5, 0.5, -0.5, 0.5], scale),
  });
  const near = (a, b) => assert.ok(Math.abs(a - b) < 1e-9, `${a} ${b}`);
  near(stretch(placed(null, 2, -7, 3).world), 7);
  near(stretch([1, 0, 0, 0, 1, 1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1]), (1 + Math.sqrt(5)) / 2);
  const [even, flat] = [{ levels: { scale: 4 } }, { levels: { scale: 1 } }];
  const placements = [
    placed(even, 4, -4, 4), placed(even, 1, 0.5, 2), placed(flat, 1, 0.001, 1),
    placed(flat, 0.2, 0.2, 0.2),
  ];
  const scaleOf = errorScales(placements);
  placements.map(scaleOf).forEach((scale, i) => near(scale, [4, 2, 1, 1][i]));
});

test('a stream grows to the whole, whatever its pieces', () => {
  built('machine_part.glb');
  run('pack', 'machine_part.glb.lodc', '-o', 'part.lods', '-q');
  const bytes = readFileSync(join(scratch, 'part.lods'));
  for (const size of [1, 100, 1000, bytes.length]) {
    const stream = lodc.stream();
    let before = 0;
    for (let at = 0; at < bytes.length; at += size) {
      stream.feed(bytes.subarray(at, at + size));
      const [now] = stream.triangles();
      assert.ok(now >= before);
      before = now;
    }
    assert.ok(stream.progress.complete);
    assert.deepEqual(stream.triangles(), [480, 480]);
    assert.equal(new TextDecoder().decode(stream.mesh().subarray(0, 4)), 'glTF');
    stream.close();
  }
});

test('damage is an error in one line and other sessions go on', () => {
  assert.throws(() => lodc.open(new Uint8Array([1, 2, 3])), /^Error: [^\n]+$/);
  const file = built('terrain.obj');
  file[file.length >> 1] ^= 255;
  assert.throws(() => lodc.open(file));
  assert.throws(() => lodc.stream().feed(new TextEncoder().encode('not a stream')));
  assert.ok(lodc.open(built('terrain.obj')).selection.triangles > 0);
});
