// How a WebGPU picture comes to the screen: drawn into the canvas's own texture, or, where that is
// not to be had (software adapters of headless browsers lose the device over it), copied.

export class Presenter {
  constructor(device, canvas) {
    Object.assign(this, { device, canvas });
    const { adapterInfo: info } = device;
    this.copies = Boolean(info?.isFallbackAdapter || info?.architecture === 'swiftshader');
    this.format = this.copies ? 'rgba8unorm' : navigator.gpu.getPreferredCanvasFormat();
    this.context = canvas.getContext(this.copies ? '2d' : 'webgpu', { alpha: false });
    if (!this.copies) this.context.configure({ device, format: this.format });
    // What is given the size of the next frame: a canvas that shows copies keeps its picture until
    // the next one is there.
    this.surface = this.copies ? { width: 1, height: 1 } : canvas;
    this.waiting = 0;
  }

  texture(size, format, sampleCount, more = 0) {
    const usage = GPUTextureUsage.RENDER_ATTACHMENT | more;
    return this.device.createTexture({ size, format, sampleCount, usage });
  }

  /** Views to draw into: of several samples, resolved, and of depth. */
  target(width, height, samples) {
    if (this.width !== width || this.height !== height) {
      for (const old of [this.colour, this.depth, this.own]) old?.destroy();
      Object.assign(this, { width, height });
      const size = [width, height];
      this.colour = this.texture(size, this.format, samples);
      this.depth = this.texture(size, 'depth24plus', samples);
      this.own = this.copies ? this.texture(size, this.format, 1, GPUTextureUsage.COPY_SRC) : null;
    }
    const resolved = this.own ?? this.context.getCurrentTexture();
    return {
      colour: this.colour.createView(),
      depth: this.depth.createView(),
      resolved: resolved.createView(),
    };
  }

  /** Submits a frame and shows it. */
  present(encoder) {
    const { device, width, height } = this;
    this.waiting += 1;
    const done = () => { this.waiting -= 1; };
    if (!this.copies) {
      device.queue.submit([encoder.finish()]);
      this.shown = device.queue.onSubmittedWorkDone().then(done, done);
      return;
    }
    const bytesPerRow = Math.ceil((4 * width) / 256) * 256;
    const { COPY_DST, MAP_READ } = GPUBufferUsage;
    const buffer = device.createBuffer({ size: bytesPerRow * height, usage: COPY_DST | MAP_READ });
    encoder.copyTextureToBuffer({ texture: this.own }, { buffer, bytesPerRow }, [width, height]);
    device.queue.submit([encoder.finish()]);
    this.shown = this.copy(buffer, width, height, bytesPerRow).then(done, done);
  }

  async copy(buffer, width, height, bytesPerRow) {
    await buffer.mapAsync(GPUMapMode.READ);
    const rows = new Uint8Array(buffer.getMappedRange());
    const image = new ImageData(width, height);
    for (let y = 0; y < height; y++) {
      image.data.set(rows.subarray(y * bytesPerRow, y * bytesPerRow + 4 * width), 4 * width * y);
    }
    buffer.destroy();
    this.last = image;
    Object.assign(this.canvas, { width, height });
    this.context.putImageData(image, 0, 0);
  }

  /** Shows the last frame once more. */
  again() {
    if (this.copies && this.last) this.context.putImageData(this.last, 0, 0);
  }

  /** Waits until the last frame is drawn and shown. */
  async finished() {
    await this.shown;
  }
}
