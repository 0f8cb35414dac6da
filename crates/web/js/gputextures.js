// Textures of materials for WebGPU: mipmaps made by the browser's own scaling, a bind group for
// each material.

/** Maps of a material, in the order of the shader's bindings. */
const SLOTS = ['base', 'metal', 'normal', 'occlusion', 'emissive'];

export class Textures {
  constructor(device) {
    this.device = device;
    const visibility = GPUShaderStage.FRAGMENT;
    this.layout = device.createBindGroupLayout({ entries: [
      ...SLOTS.map((_, binding) => ({ binding, visibility, texture: {} })),
      ...SLOTS.map((_, i) => ({ binding: SLOTS.length + i, visibility, sampler: {} })),
    ] });
    const { TEXTURE_BINDING, COPY_DST } = GPUTextureUsage;
    const blank = device.createTexture({
      size: [1, 1], format: 'rgba8unorm', usage: TEXTURE_BINDING | COPY_DST });
    device.queue.writeTexture({ texture: blank }, new Uint8Array(4).fill(255), {}, [1, 1]);
    this.blank = { texture: blank.createView(), sampler: device.createSampler() };
    this.all = [];
    this.groups = new Map();
  }

  /** Uploads all pictures; `texturesOf` is that of `material.js`. */
  async load(glb, texturesOf) {
    this.all = await texturesOf(glb, (image, sampler) => this.upload(image, sampler));
  }

  async upload(image, { wrapS = 10497, wrapT = 10497, magFilter = 9729 }) {
    const { device } = this;
    const [width, height] = [image.naturalWidth, image.naturalHeight];
    const mipLevelCount = 1 + Math.floor(Math.log2(Math.max(width, height)));
    const { TEXTURE_BINDING, COPY_DST, RENDER_ATTACHMENT } = GPUTextureUsage;
    const texture = device.createTexture({
      size: [width, height], mipLevelCount, format: 'rgba8unorm',
      usage: TEXTURE_BINDING | COPY_DST | RENDER_ATTACHMENT,
    });
    for (let mipLevel = 0; mipLevel < mipLevelCount; mipLevel++) {
      const size = [width, height].map((side) => Math.max(1, side >> mipLevel));
      const scaled = await createImageBitmap(image, {
        resizeWidth: size[0], resizeHeight: size[1], resizeQuality: 'medium',
        premultiplyAlpha: 'none', colorSpaceConversion: 'none',
      });
      device.queue.copyExternalImageToTexture({ source: scaled }, { texture, mipLevel }, size);
      scaled.close();
    }
    const modes = { 33071: 'clamp-to-edge', 33648: 'mirror-repeat' };
    const wrapping = (mode) => modes[mode] ?? 'repeat';
    const sharp = magFilter !== 9728;
    const sampler = device.createSampler({
      addressModeU: wrapping(wrapS), addressModeV: wrapping(wrapT),
      magFilter: sharp ? 'linear' : 'nearest', minFilter: 'linear', mipmapFilter: 'linear',
      maxAnisotropy: sharp ? 8 : 1,
    });
    return { texture: texture.createView(), sampler };
  }

  /** Set of texture coordinates of each map, -1 for one that is not there. */
  sets(material) {
    return SLOTS.map((slot) => {
      const map = material.maps[slot];
      return map && this.all[map.index] ? map.set : -1;
    });
  }

  /** The bind group of a material; of none without one. */
  group(material) {
    if (!this.groups.has(material)) {
      const maps = SLOTS.map((slot) => this.all[material?.maps[slot]?.index] ?? this.blank);
      const entries = [
        ...maps.map(({ texture }, binding) => ({ binding, resource: texture })),
        ...maps.map(({ sampler }, i) => ({ binding: SLOTS.length + i, resource: sampler })),
      ];
      this.groups.set(material, this.device.createBindGroup({ layout: this.layout, entries }));
    }
    return this.groups.get(material);
  }
}
