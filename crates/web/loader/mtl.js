// Materials of an OBJ as those of a glTF.

const linear = (c) => (c <= 0.04045 ? c / 12.92 : ((c + 0.055) / 1.055) ** 2.4);
const clamp = (value) => Math.min(Math.max(value, 0), 1);
const MOST = { '-o': 3, '-s': 3, '-t': 3, '-mm': 2 };
const ONE = /^-(blendu|blendv|boost|texres|clamp|bm|imfchan|type|cc)$/;

/** `[-option value...]... FILE` as options and a file's name. */
function map(rest) {
  const options = {};
  let words = rest.trim();
  const next = () => /^(\S+)\s+(.*)$/.exec(words);
  for (let match = next(); words.startsWith('-') && match; match = next()) {
    const name = match[1];
    const most = MOST[name] ?? (ONE.test(name) ? 1 : 0);
    options[name] = [];
    words = match[2];
    while (options[name].length < most) {
      const value = next();
      if (!value || (most > 1 && Number.isNaN(Number(value[1])))) break;
      options[name].push(value[1]);
      words = value[2];
    }
  }
  return { options, file: words.replaceAll('\\', '/') };
}

/** A glTF document of one object whose submeshes name materials of an OBJ. */
export function documentOf({ materials }, { submeshes, attributes }) {
  const textures = [];
  const all = materials.map(({ name, lines }) => {
    const say = {};
    for (const line of lines) {
      const [, word, rest] = /^\s*(\S+)\s*(.*?)\s*$/.exec(line) ?? [];
      if (word) say[word.toLowerCase()] = rest;
    }
    const [r, g = r, b = r] = (say.kd ?? '').split(/\s+/).filter(Boolean).map(Number);
    let colour = r === undefined ? [0.6, 0.6, 0.6] : [r, g, b].map((c) => linear(clamp(c)));
    const dissolve = say.d !== undefined
      ? Number(say.d.replace(/^-halo\s+/, '')) : 1 - Number(say.tr ?? 0);
    const pbr = { metallicFactor: 0, roughnessFactor: 0.9 };
    if (say.map_kd) {
      if (r === undefined || colour.every((c) => c === 0)) colour = [1, 1, 1];
      const { options, file } = map(say.map_kd);
      const [u = 1, v = 1] = (options['-s'] ?? []).map(Number);
      const [x = 0, y = 0] = (options['-o'] ?? []).map(Number);
      const wrap = options['-clamp']?.[0] === 'on' ? 33071 : 10497;
      // The first row of an image is its top, the texture coordinate 0 its bottom.
      const KHR_texture_transform = { offset: [x, 1 - y], scale: [u, -v] };
      const extensions = { KHR_texture_transform };
      pbr.baseColorTexture = { index: textures.length, extensions };
      textures.push({ uri: file.split('/').map(encodeURIComponent).join('/'), wrap });
    }
    // Writers that mean nothing by it say 0.
    const opacity = dissolve > 0 ? clamp(dissolve) : 1;
    pbr.baseColorFactor = [...colour, opacity];
    const cut = say.map_d !== undefined && pbr.baseColorTexture;
    const alphaMode = opacity < 1 ? 'BLEND' : cut ? 'MASK' : 'OPAQUE';
    return { name, pbrMetallicRoughness: pbr, alphaMode, doubleSided: true };
  });
  const plain = all.length;
  const grey = { baseColorFactor: [0.6, 0.6, 0.6, 1], metallicFactor: 0, roughnessFactor: 0.9 };
  all.push({ pbrMetallicRoughness: grey, doubleSided: true });
  // Where vertices have colours, these alone are seen.
  const white = { ...grey, baseColorFactor: [1, 1, 1, 1] };
  all.push({ pbrMetallicRoughness: white, doubleSided: true });
  const isPainted = (streams) => (
    streams.some((s) => attributes[s].name === 'color' && attributes[s].target < 0));
  const number = ({ material: name, streams }) => {
    const at = materials.findIndex((material) => material.name === name);
    return at < 0 ? plain + isPainted(streams) : at;
  };
  const primitives = submeshes.map((submesh) => (
    { attributes: {}, material: number(submesh) }));
  return {
    asset: { version: '2.0' },
    extensionsUsed: ['KHR_texture_transform'],
    scene: 0,
    scenes: [{ nodes: [0] }],
    nodes: [{ mesh: 0 }],
    meshes: [{ primitives }],
    materials: all,
    textures: textures.map((_, i) => ({ source: i, sampler: i })),
    samplers: textures.map(({ wrap }) => ({ wrapS: wrap, wrapT: wrap })),
    images: textures.map(({ uri }) => ({ uri })),
  };
}
