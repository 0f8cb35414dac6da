// A textured scene with separate images: a floor and two boards of other materials.

import { mkdirSync, readFileSync, writeFileSync } from 'node:fs';
import { join } from 'node:path';
import { deflateSync } from 'node:zlib';

/** The checksum of a PNG's chunk. */
function crc32(bytes) {
  let crc = -1;
  for (const byte of bytes) {
    crc ^= byte;
    for (let k = 0; k < 8; k++) crc = (crc >>> 1) ^ (crc & 1 ? 0xedb88320 : 0);
  }
  return ~crc >>> 0;
}

/** A PNG of coloured squares. */
function picture(size, colours) {
  const rows = [];
  for (let y = 0; y < size; y++) {
    rows.push(0);
    for (let x = 0; x < size; x++) {
      rows.push(...colours[(Math.floor(x / 16) + Math.floor(y / 16)) % colours.length]);
    }
  }
  const chunk = (type, data) => {
    const body = Buffer.concat([Buffer.from(type), data]);
    const out = Buffer.alloc(body.length + 8);
    out.writeUInt32BE(data.length, 0);
    body.copy(out, 4);
    out.writeUInt32BE(crc32(body), body.length + 4);
    return out;
  };
  const side = [0, 0, size >> 8, size & 255];
  const header = Buffer.from([...side, ...side, 8, 2, 0, 0, 0]);
  const signature = Buffer.from([137, 80, 78, 71, 13, 10, 26, 10]);
  const data = deflateSync(Buffer.from(rows));
  const end = chunk('IEND', Buffer.alloc(0));
  return Buffer.concat([signature, chunk('IHDR', header), chunk('IDAT', data), end]);
}

/** A wavy sheet of n × n quads as arrays. */
function sheet(n) {
  const [positions, uvs, normals, indices] = [[], [], [], []];
  for (let j = 0; j <= n; j++) {
    for (let i = 0; i <= n; i++) {
      const [u, v] = [i / n, j / n];
      positions.push(u - 0.5, 0.08 * Math.sin(7 * u) * Math.cos(5 * v), v - 0.5);
      uvs.push(2 * u, 2 * v);
      normals.push(0, 1, 0);
      if (i < n && j < n) {
        const a = j * (n + 1) + i;
        indices.push(a, a + n + 1, a + 1, a + 1, a + n + 1, a + n + 2);
      }
    }
  }
  return { positions, uvs, normals, indices };
}

const MTL = `newmtl floor
Kd 1 1 1
map_Kd -s 2 3 1 -o 0.25 0.1 0 images/greens.png
newmtl board
Kd 0.9 0.2 0.1
d 0.5
newmtl clamped
map_Kd -clamp on -s 2 2 images/greens.png
`;

/**
 * Writes `boards.obj` and its materials into the folder of `scene.gltf`: one with an image that is
 * repeated and shifted, a transparent one, one whose image ends, none.
 */
export function boards(folder) {
  const lines = ['mtllib boards.mtl'];
  ['floor', 'board', 'clamped', 'missing'].forEach((material, n) => {
    const { positions, uvs, indices } = sheet(12);
    const first = n * 169 + 1;
    for (let v = 0; v < 169; v++) {
      const [x, y, z] = positions.slice(3 * v, 3 * v + 3);
      lines.push(`v ${x + (n % 2) * 1.1} ${y + 0.2 * n} ${z + (n >> 1) * 1.1}`);
      lines.push(`vt ${uvs[2 * v]} ${uvs[2 * v + 1]}`);
    }
    lines.push(`usemtl ${material}`);
    for (let i = 0; i < indices.length; i += 3) {
      const corners = indices.slice(i, i + 3).map((index) => `${first + index}/${first + index}`);
      lines.push(`f ${corners.join(' ')}`);
    }
  });
  writeFileSync(join(folder, 'boards.obj'), `${lines.join('\n')}\n`);
  writeFileSync(join(folder, 'boards.mtl'), MTL);
  // What three.js does not know would be a file's name to it.
  writeFileSync(join(folder, 'plain.mtl'), MTL.replace(/^.*-clamp.*$/m, ''));
}

/** Writes `scene.gltf`, `scene.bin` and its images into a folder. */
export function separated(folder) {
  const { positions, uvs, normals, indices } = sheet(40);
  const floats = [positions, normals, uvs].map((values) => new Float32Array(values));
  const arrays = [...floats, new Uint32Array(indices)];
  const bytes = arrays.map((array) => Buffer.from(array.buffer));
  let at = 0;
  const bufferViews = bytes.map(({ length }) => {
    at += length;
    return { buffer: 0, byteOffset: at - length, byteLength: length };
  });
  const count = positions.length / 3;
  const extreme = (of) => [0, 1, 2].map((k) => (
    positions.filter((_, i) => i % 3 === k).reduce((a, b) => of(a, b))));
  const accessor = (bufferView, componentType, type, number) => (
    { bufferView, componentType, type, count: number });
  const accessors = [
    { ...accessor(0, 5126, 'VEC3', count), min: extreme(Math.min), max: extreme(Math.max) },
    accessor(1, 5126, 'VEC3', count), accessor(2, 5126, 'VEC2', count),
    accessor(3, 5125, 'SCALAR', indices.length),
  ];
  const attributes = { POSITION: 0, NORMAL: 1, TEXCOORD_0: 2 };
  const mesh = (material) => ({ primitives: [{ attributes, indices: 3, material }] });
  const material = (index) => ({
    pbrMetallicRoughness: { baseColorTexture: { index }, metallicFactor: 0 }, doubleSided: true,
  });
  const board = Math.SQRT1_2;
  const gltf = {
    asset: { version: '2.0' }, scene: 0, scenes: [{ nodes: [0, 1] }],
    nodes: [
      { mesh: 0, scale: [3, 3, 3] },
      { mesh: 1, rotation: [board, 0, 0, board], translation: [0, 1, -0.5] },
    ],
    meshes: [mesh(0), mesh(1)], materials: [material(0), material(1)],
    textures: [{ source: 0 }, { source: 1 }],
    images: [{ uri: 'images/red%20and%20blue.png' }, { uri: 'images/greens.png' }],
    accessors, bufferViews, buffers: [{ uri: 'scene.bin', byteLength: at }],
  };
  writeFileSync(join(folder, 'scene.bin'), Buffer.concat(bytes));
  writeFileSync(join(folder, 'scene.gltf'), JSON.stringify(gltf));
  mkdirSync(join(folder, 'images'));
  const red = picture(128, [[220, 30, 30], [30, 40, 220]]);
  writeFileSync(join(folder, 'images/red and blue.png'), red);
  writeFileSync(join(folder, 'images/greens.png'), picture(64, [[20, 200, 40], [240, 220, 30]]));
}

/** A ball without a texture or a material. */
export function ball(folder) {
  const [rows, columns] = [24, 48];
  const lines = [];
  for (let j = 0; j <= rows; j++) {
    for (let i = 0; i < columns; i++) {
      const [a, b] = [(Math.PI * j) / rows, (2 * Math.PI * i) / columns];
      lines.push(`v ${Math.sin(a) * Math.cos(b)} ${Math.cos(a)} ${Math.sin(a) * Math.sin(b)}`);
    }
  }
  for (let j = 0; j < rows; j++) {
    for (let i = 0; i < columns; i++) {
      const [here, next] = [i, (i + 1) % columns].map((k) => 1 + j * columns + k);
      if (j > 0) lines.push(`f ${here} ${next} ${here + columns}`);
      if (j < rows - 1) lines.push(`f ${next} ${next + columns} ${here + columns}`);
    }
  }
  writeFileSync(join(folder, 'ball.obj'), `${lines.join('\n')}\n`);
}

/** A copy of `scene.gltf` that has two animations: a board turns, or the floor rises. */
export function animated(folder) {
  const gltf = JSON.parse(readFileSync(join(folder, 'scene.gltf'), 'utf8'));
  const half = Math.SQRT1_2;
  const arrays = [
    ['SCALAR', [0, 2]], ['VEC4', [half, 0, 0, half, half, 0, half, 0]],
    ['VEC3', [0, 0, 0, 0, 2, 0]],
  ];
  const bytes = Buffer.concat(arrays.map(([, values]) => (
    Buffer.from(new Float32Array(values).buffer))));
  const uri = `data:application/octet-stream;base64,${bytes.toString('base64')}`;
  const buffer = gltf.buffers.push({ uri, byteLength: bytes.length }) - 1;
  let at = 0;
  const [time, turn, rise] = arrays.map(([type, { length }]) => {
    const view = { buffer, byteOffset: at, byteLength: 4 * length };
    at += view.byteLength;
    const bufferView = gltf.bufferViews.push(view) - 1;
    const accessor = { bufferView, componentType: 5126, type, count: 2, min: [0], max: [2] };
    if (type !== 'SCALAR') ['min', 'max'].forEach((bound) => delete accessor[bound]);
    return gltf.accessors.push(accessor) - 1;
  });
  const animation = (name, node, path, output) => ({
    name, channels: [{ sampler: 0, target: { node, path } }], samplers: [{ input: time, output }],
  });
  gltf.animations = [
    animation('Turn', 1, 'rotation', turn), animation('Rise', 0, 'translation', rise),
  ];
  writeFileSync(join(folder, 'animated.gltf'), JSON.stringify(gltf));
}
