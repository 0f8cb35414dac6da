// Materials of a GLB with every default filled in, and its textures.

const known = new WeakMap();

/** A material by its number; -1 is the default one. */
export function materialOf(glb, number) {
  if (!known.has(glb)) known.set(glb, new Map());
  const ofGlb = known.get(glb);
  if (!ofGlb.has(number)) ofGlb.set(number, material(glb, glb.json.materials?.[number] ?? {}));
  return ofGlb.get(number);
}

/** What is drawn, blended parts last: a placement, some of its parts, and its number. */
export function* inDrawingOrder(scene, colouring) {
  const blended = (part) => (
    colouring === 'material' && materialOf(scene.glb, part.material).alphaMode === 'BLEND');
  const placements = scene.placements();
  for (const late of [false, true]) {
    for (const [number, placement] of placements.entries()) {
      const parts = placement.object.parts.filter((part) => blended(part) === late);
      if (parts.length > 0) yield { placement, parts, number };
    }
  }
}

function material(glb, source) {
  const pbr = source.pbrMetallicRoughness ?? {};
  const old = source.extensions?.KHR_materials_pbrSpecularGlossiness;
  const base = pbr.baseColorTexture ?? old?.diffuseTexture;
  // A picture that is missing is left out, with the factors that count on it.
  const map = (texture) => (
    texture && glb.picture(texture.index) && { index: texture.index, set: texture.texCoord ?? 0 });
  const lacks = (texture) => texture && !map(texture);
  const bare = !source.pbrMetallicRoughness || lacks(pbr.metallicRoughnessTexture);
  const { emissiveStrength = 1 } = source.extensions?.KHR_materials_emissive_strength ?? {};
  const glow = lacks(source.emissiveTexture) ? 0 : emissiveStrength;
  return {
    baseColour: pbr.baseColorFactor ?? old?.diffuseFactor ?? [1, 1, 1, 1],
    metallic: bare ? 0 : pbr.metallicFactor ?? 1,
    roughness: bare ? 0.6 : pbr.roughnessFactor ?? 1,
    emissive: (source.emissiveFactor ?? [0, 0, 0]).map((c) => c * glow),
    normalScale: source.normalTexture?.scale ?? 1,
    occlusionStrength: source.occlusionTexture?.strength ?? 1,
    alphaMode: source.alphaMode ?? 'OPAQUE',
    alphaCutoff: source.alphaCutoff ?? 0.5,
    // Files of other kinds than glTF do not say which faces have a back.
    doubleSided: source.doubleSided ?? glb.json.asset?.generator === 'lodc',
    unlit: Boolean(source.extensions?.KHR_materials_unlit),
    uvTransform: uvTransform(base?.extensions?.KHR_texture_transform),
    maps: {
      base: map(base),
      metal: map(pbr.metallicRoughnessTexture),
      normal: map(source.normalTexture),
      occlusion: map(source.occlusionTexture),
      emissive: map(source.emissiveTexture),
    },
  };
}

/** A column-major 3 × 3 matrix; that of the base colour holds for all maps. */
function uvTransform({ offset = [0, 0], rotation = 0, scale = [1, 1] } = {}) {
  const [c, s] = [Math.cos(rotation), Math.sin(rotation)];
  return [c * scale[0], -s * scale[0], 0, s * scale[1], c * scale[1], 0, offset[0], offset[1], 1];
}

/** All textures by their number, made of pictures by `upload`; null for one that is not there. */
export async function texturesOf(glb, upload) {
  const samplers = glb.json.samplers ?? [];
  return Promise.all((glb.json.textures ?? []).map(async (texture, number) => {
    const picture = glb.picture(number);
    if (!picture) return null;
    const image = await loaded(picture);
    return image && upload(image, samplers[texture.sampler] ?? {});
  }));
}

/** A picture as an element; null if it cannot be decoded. */
function loaded(picture) {
  return new Promise((resolve) => {
    const image = new Image();
    const done = (result) => {
      URL.revokeObjectURL(image.src);
      resolve(result);
    };
    image.onload = () => done(image);
    image.onerror = () => done(null);
    image.src = URL.createObjectURL(picture);
  });
}
