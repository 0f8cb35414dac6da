// The WebGL 2 renderer: every part has its vertices once; only its indices follow the level.

import { program, uniforms } from './glprogram.js';
import { edges, morphed } from './geometry.js';
import { determinant3, times } from './math.js';
import { inDrawingOrder, materialOf, texturesOf } from './material.js';

/** Attribute locations of the vertex shader. */
const AT = {
  positions: 0, normals: 1, uv0: 2, uv1: 3, colours: 4, joints: 5, weights: 6, paint: 7, copy: 8,
};
const WIDTH = {
  positions: 3, normals: 3, uv0: 2, uv1: 2, colours: 4, joints: 4, weights: 4, paint: 4,
};

export class WebglRenderer {
  /** Makes a renderer; waits for the textures. Null without WebGL 2. */
  static async create(canvas, scene) {
    // Kept, the picture can be saved and printed after its frame.
    const options = { antialias: true, alpha: false, preserveDrawingBuffer: true };
    const gl = canvas.getContext('webgl2', options);
    if (!gl) return null;
    const renderer = new WebglRenderer(gl, scene);
    renderer.textures = await texturesOf(scene.glb, (image, sampler) => (
      renderer.texture(image, sampler)));
    return renderer;
  }

  constructor(gl, scene) {
    this.gl = gl;
    this.scene = scene;
    this.program = program(gl);
    this.uniforms = uniforms(gl, this.program);
    this.blank = this.texture(null, {});
    this.jointTexture = gl.createTexture();
    this.copies = gl.createBuffer();
    this.parts = new Map();
    for (const object of scene.objects) {
      for (const part of object?.parts ?? []) this.parts.set(part, this.upload(part));
    }
  }

  /** The buffers of a part. */
  upload(part) {
    const { gl } = this;
    const arrays = {
      positions: part.positions, normals: part.normals, uv0: part.uvs[0], uv1: part.uvs[1],
      colours: part.colours, joints: part.joints, weights: part.weights,
    };
    const own = { array: gl.createVertexArray(), buffers: {}, lod: -1, ranges: null };
    gl.bindVertexArray(own.array);
    for (const [name, values] of Object.entries(arrays)) {
      if (values) own.buffers[name] = this.attribute(AT[name], WIDTH[name], values);
    }
    own.indices = gl.createBuffer();
    gl.bindBuffer(gl.ELEMENT_ARRAY_BUFFER, own.indices);
    gl.bufferData(gl.ELEMENT_ARRAY_BUFFER, part.submesh.indices.byteLength, gl.DYNAMIC_DRAW);
    gl.bindVertexArray(null);
    return own;
  }

  attribute(at, width, values) {
    const { gl } = this;
    const buffer = gl.createBuffer();
    gl.bindBuffer(gl.ARRAY_BUFFER, buffer);
    gl.bufferData(gl.ARRAY_BUFFER, values, gl.STATIC_DRAW);
    gl.enableVertexAttribArray(at);
    const bytes = values instanceof Uint8Array;
    gl.vertexAttribPointer(at, width, bytes ? gl.UNSIGNED_BYTE : gl.FLOAT, bytes, 0, 0);
    return buffer;
  }

  texture(image, { wrapS = 10497, wrapT = 10497, magFilter = 9729 }) {
    const { gl } = this;
    const texture = gl.createTexture();
    gl.bindTexture(gl.TEXTURE_2D, texture);
    const white = new Uint8Array([255, 255, 255, 255]);
    gl.pixelStorei(gl.UNPACK_COLORSPACE_CONVERSION_WEBGL, gl.NONE);
    if (image) gl.texImage2D(gl.TEXTURE_2D, 0, gl.RGBA, gl.RGBA, gl.UNSIGNED_BYTE, image);
    else gl.texImage2D(gl.TEXTURE_2D, 0, gl.RGBA, 1, 1, 0, gl.RGBA, gl.UNSIGNED_BYTE, white);
    gl.generateMipmap(gl.TEXTURE_2D);
    gl.texParameteri(gl.TEXTURE_2D, gl.TEXTURE_WRAP_S, wrapS);
    gl.texParameteri(gl.TEXTURE_2D, gl.TEXTURE_WRAP_T, wrapT);
    gl.texParameteri(gl.TEXTURE_2D, gl.TEXTURE_MAG_FILTER, magFilter);
    gl.texParameteri(gl.TEXTURE_2D, gl.TEXTURE_MIN_FILTER, gl.LINEAR_MIPMAP_LINEAR);
    const sharp = gl.getExtension('EXT_texture_filter_anisotropic');
    if (sharp) gl.texParameterf(gl.TEXTURE_2D, sharp.TEXTURE_MAX_ANISOTROPY_EXT, 8);
    return texture;
  }

  /**
   * Draws a frame: `{ eye, view, projection, background, colouring, wire, flat, crowd }`.
   * `colouring` is material, plain, strips or error; `crowd` is null or copies by level.
   */
  draw(frame) {
    const { gl, uniforms: u } = this;
    gl.viewport(0, 0, gl.drawingBufferWidth, gl.drawingBufferHeight);
    gl.clearColor(...frame.background, 1);
    gl.clear(gl.COLOR_BUFFER_BIT | gl.DEPTH_BUFFER_BIT);
    gl.enable(gl.DEPTH_TEST);
    gl.depthFunc(gl.LEQUAL);
    gl.useProgram(this.program);
    const { view } = frame;
    u.viewProjection(times(frame.projection, view));
    u.eye(frame.eye);
    u.centre(frame.centre);
    const [right, up, back] = [0, 1, 2].map((row) => [view[row], view[4 + row], view[8 + row]]);
    u.cameraRight(right);
    u.cameraUp(up);
    u.keyLight(right.map((r, i) => -0.45 * r + 0.75 * up[i] + 0.65 * back[i]));
    u.flatShaded(frame.flat);
    for (const { placement, parts, number } of inDrawingOrder(this.scene, frame.colouring)) {
      this.place(placement, parts, { ...frame, view: frame.views?.[number] });
    }
    gl.bindVertexArray(null);
  }

  material(part) {
    return materialOf(this.scene.glb, part.material);
  }

  place(placement, parts, frame) {
    const { gl, uniforms: u } = this;
    u.world(placement.world);
    u.skinned(Boolean(placement.joints));
    if (placement.joints) this.putJoints(placement.joints);
    gl.frontFace(!placement.joints && determinant3(placement.world) < 0 ? gl.CW : gl.CCW);
    for (const part of parts) {
      let own = this.parts.get(part);
      const number = placement.object.parts.indexOf(part);
      if (frame.view) own = { ...own, ...this.viewArray(frame.view, number) };
      gl.bindVertexArray(own.array);
      if (!frame.view) this.morph(part, own, placement.weights);
      this.part(part, own, frame);
      if (frame.wire) this.wires(part, own, frame);
    }
  }

  part(part, own, frame) {
    const { gl, uniforms: u } = this;
    const material = this.material(part);
    const painted = frame.colouring !== 'material';
    u.mode(painted ? 1 : 0);
    u.edgy(part.edgy);
    u.alphaCutoff(0);
    if (painted) this.paint(part, own, frame);
    else this.bindMaterial(material);
    const culled = !material.doubleSided && !painted;
    if (culled) gl.enable(gl.CULL_FACE);
    if (frame.wire) {
      gl.enable(gl.POLYGON_OFFSET_FILL);
      gl.polygonOffset(1, 1);
    }
    const transparent = !painted && material.alphaMode === 'BLEND';
    if (transparent) {
      gl.enable(gl.BLEND);
      gl.blendFuncSeparate(gl.SRC_ALPHA, gl.ONE_MINUS_SRC_ALPHA, gl.ZERO, gl.ONE);
      gl.depthMask(false);
    }
    const { corners } = this.parts.get(part);
    if (corners && frame.colouring === 'strips' && !own.viewed) this.drawCorners(own);
    else this.drawTriangles(part, own, frame);
    gl.disable(gl.BLEND);
    gl.disable(gl.CULL_FACE);
    gl.disable(gl.POLYGON_OFFSET_FILL);
    gl.depthMask(true);
  }

  /** Vertices and indices of a placement for a view, uploaded once for each result. */
  viewArray(view, number) {
    const { gl } = this;
    if (!view.buffer) {
      view.buffer = gl.createBuffer();
      gl.bindBuffer(gl.ARRAY_BUFFER, view.buffer);
      gl.bufferData(gl.ARRAY_BUFFER, view.words, gl.STREAM_DRAW);
      view.arrays = [];
    }
    view.arrays[number] ??= this.viewIndices(view, number);
    return view.arrays[number];
  }

  viewIndices({ buffer, layout: { offsets, stride }, indices }, number) {
    const { gl } = this;
    const array = gl.createVertexArray();
    gl.bindVertexArray(array);
    gl.bindBuffer(gl.ARRAY_BUFFER, buffer);
    for (const [name, offset] of Object.entries(offsets)) {
      gl.enableVertexAttribArray(AT[name]);
      gl.vertexAttribPointer(AT[name], WIDTH[name], gl.FLOAT, false, 4 * stride, 4 * offset);
    }
    const list = gl.createBuffer();
    gl.bindBuffer(gl.ELEMENT_ARRAY_BUFFER, list);
    gl.bufferData(gl.ELEMENT_ARRAY_BUFFER, indices[number], gl.STREAM_DRAW);
    const triangles = indices[number].length / 3;
    return { array, viewed: { list, indices: indices[number], triangles } };
  }

  /** Frees the buffers of results that are no longer shown. */
  release(views) {
    const { gl } = this;
    for (const { buffer, arrays = [] } of views ?? []) {
      gl.deleteBuffer(buffer ?? null);
      for (const { array, viewed } of arrays.filter(Boolean)) {
        gl.deleteVertexArray(array);
        gl.deleteBuffer(viewed.list);
        gl.deleteBuffer(viewed.lines ?? null);
      }
    }
  }

  /** Triangles of the present level, or of every copy at its own. */
  drawTriangles(part, own, { crowd }) {
    const { gl } = this;
    if (own.viewed) {
      gl.bindBuffer(gl.ELEMENT_ARRAY_BUFFER, own.viewed.list);
      gl.vertexAttrib4f(AT.copy, 0, 0, 0, 0);
      gl.drawElements(gl.TRIANGLES, own.viewed.indices.length, gl.UNSIGNED_INT, 0);
      return;
    }
    if (!crowd) {
      gl.bindBuffer(gl.ELEMENT_ARRAY_BUFFER, own.indices);
      if (own.lod !== part.submesh.lod) {
        const live = part.submesh.indices.subarray(0, 3 * part.submesh.triangles);
        gl.bufferSubData(gl.ELEMENT_ARRAY_BUFFER, 0, live);
        own.lod = part.submesh.lod;
      }
      gl.vertexAttrib4f(AT.copy, 0, 0, 0, 0);
      gl.drawElements(gl.TRIANGLES, 3 * part.submesh.triangles, gl.UNSIGNED_INT, 0);
      return;
    }
    const range = crowd.ranges.get(part.submesh);
    if (own.ranges !== range) {
      own.ladder ??= gl.createBuffer();
      gl.bindBuffer(gl.ELEMENT_ARRAY_BUFFER, own.ladder);
      gl.bufferData(gl.ELEMENT_ARRAY_BUFFER, range.indices, gl.STATIC_DRAW);
      own.ranges = range;
    }
    gl.bindBuffer(gl.ELEMENT_ARRAY_BUFFER, own.ladder);
    gl.bindBuffer(gl.ARRAY_BUFFER, this.copies);
    gl.enableVertexAttribArray(AT.copy);
    gl.vertexAttribPointer(AT.copy, 4, gl.FLOAT, false, 0, 0);
    gl.vertexAttribDivisor(AT.copy, 1);
    crowd.byLevel.forEach((copies, level) => {
      if (copies.length === 0 || range.count[level] === 0) return;
      gl.bufferData(gl.ARRAY_BUFFER, copies, gl.STREAM_DRAW);
      gl.drawElementsInstanced(gl.TRIANGLES, range.count[level], gl.UNSIGNED_INT,
        4 * range.first[level], copies.length / 4);
    });
    gl.disableVertexAttribArray(AT.copy);
  }

  /** Edges of the present level over its triangles. */
  wires(part, own, frame) {
    if (frame.crowd) return;
    const { gl, uniforms: u } = this;
    const submesh = own.viewed ?? part.submesh;
    const lines = own.viewed ?? (this.parts.get(part).edges ??= {});
    gl.bindBuffer(gl.ELEMENT_ARRAY_BUFFER, lines.lines ??= gl.createBuffer());
    if (lines.of !== (submesh.lod ?? submesh)) {
      lines.of = submesh.lod ?? submesh;
      gl.bufferData(gl.ELEMENT_ARRAY_BUFFER, edges(submesh), gl.DYNAMIC_DRAW);
    }
    gl.vertexAttrib4f(AT.copy, 0, 0, 0, 0);
    u.mode(2);
    u.baseColour(frame.wireColour);
    gl.enable(gl.BLEND);
    gl.blendFunc(gl.SRC_ALPHA, gl.ONE_MINUS_SRC_ALPHA);
    gl.drawElements(gl.LINES, 6 * submesh.triangles, gl.UNSIGNED_INT, 0);
    gl.disable(gl.BLEND);
  }

  /** Colours that stand for something: of vertices, or of corners where triangles differ. */
  paint(part, own, { colouring, paints }) {
    const { gl } = this;
    gl.disableVertexAttribArray(AT.paint);
    gl.vertexAttrib4f(AT.paint, 0.62, 0.63, 0.66, 1);
    if (own.viewed) return;
    if (colouring === 'error') {
      own.buffers.error ??= this.attribute(AT.paint, 4, paints.error(part));
      gl.bindBuffer(gl.ARRAY_BUFFER, own.buffers.error);
      gl.enableVertexAttribArray(AT.paint);
      gl.vertexAttribPointer(AT.paint, 4, gl.UNSIGNED_BYTE, true, 0, 0);
    }
    if (colouring === 'strips' && part.strips && own.corners?.lod !== part.submesh.lod) {
      for (const buffer of own.corners?.buffers ?? []) gl.deleteBuffer(buffer);
      own.corners = this.corners(part, paints.strips(part));
    }
  }

  /** Vertices of every corner by themselves, so that each triangle can have its colour. */
  corners(part, colours) {
    const { gl } = this;
    const { submesh } = part;
    const array = gl.createVertexArray();
    gl.bindVertexArray(array);
    const count = 3 * submesh.triangles;
    const buffers = ['positions', 'normals', 'joints', 'weights'].filter((name) => part[name])
      .map((name) => {
        const width = WIDTH[name];
        const values = new Float32Array(count * width);
        for (let c = 0; c < count; c++) {
          const v = submesh.indices[c] * width;
          for (let i = 0; i < width; i++) values[c * width + i] = part[name][v + i];
        }
        return this.attribute(AT[name], width, values);
      });
    buffers.push(this.attribute(AT.paint, 4, colours));
    return { array, buffers, count, lod: submesh.lod };
  }

  drawCorners({ corners, array }) {
    const { gl } = this;
    gl.bindVertexArray(corners.array);
    gl.vertexAttrib4f(AT.copy, 0, 0, 0, 0);
    gl.drawArrays(gl.TRIANGLES, 0, corners.count);
    gl.bindVertexArray(array);
  }

  bindMaterial(material) {
    const { gl, uniforms: u } = this;
    gl.vertexAttrib4f(AT.colours, 1, 1, 1, 1);
    const slots = ['base', 'metal', 'normal', 'occlusion', 'emissive'];
    const sets = slots.map((slot, unit) => {
      const map = material.maps[slot];
      const texture = map && this.textures?.[map.index];
      gl.activeTexture(gl.TEXTURE0 + unit);
      gl.bindTexture(gl.TEXTURE_2D, texture || this.blank);
      return texture ? map.set : -1;
    });
    u.textureSets(sets.slice(0, 4));
    u.emissiveSet(sets[4]);
    u.baseColour(material.baseColour);
    u.emissive(material.emissive);
    u.metallic(material.metallic);
    u.roughness(material.roughness);
    u.normalScale(material.normalScale);
    u.occlusionStrength(material.occlusionStrength);
    u.alphaCutoff({ MASK: material.alphaCutoff, BLEND: -1 }[material.alphaMode] ?? 0);
    u.uvTransform(material.uvTransform);
    u.unlit(material.unlit);
  }

  /** Joint matrices as a texture of four texels a row. */
  putJoints(joints) {
    const { gl } = this;
    gl.activeTexture(gl.TEXTURE5);
    gl.bindTexture(gl.TEXTURE_2D, this.jointTexture);
    gl.texImage2D(gl.TEXTURE_2D, 0, gl.RGBA32F, 4, joints.length, 0, gl.RGBA, gl.FLOAT,
      new Float32Array(joints.flat()));
    gl.texParameteri(gl.TEXTURE_2D, gl.TEXTURE_MIN_FILTER, gl.NEAREST);
    gl.texParameteri(gl.TEXTURE_2D, gl.TEXTURE_MAG_FILTER, gl.NEAREST);
  }

  morph(part, own, weights) {
    if (part.morphs.length === 0 || own.weights === weights.join()) return;
    const { gl } = this;
    const { positions, normals } = morphed(part, weights);
    gl.bindBuffer(gl.ARRAY_BUFFER, own.buffers.positions);
    gl.bufferSubData(gl.ARRAY_BUFFER, 0, positions);
    gl.bindBuffer(gl.ARRAY_BUFFER, own.buffers.normals);
    gl.bufferSubData(gl.ARRAY_BUFFER, 0, normals);
    own.weights = weights.join();
  }

  /** Frees everything. */
  close() {
    this.gl.getExtension('WEBGL_lose_context')?.loseContext();
  }

  /** Brings the last frame to the screen once more, without drawing it. */
  again() {
    const { gl } = this;
    gl.enable(gl.SCISSOR_TEST);
    gl.scissor(0, 0, 0, 0);
    gl.clear(gl.COLOR_BUFFER_BIT);
    gl.disable(gl.SCISSOR_TEST);
  }

  /** Waits until everything is drawn. */
  finish() {
    this.gl.readPixels(0, 0, 1, 1, this.gl.RGBA, this.gl.UNSIGNED_BYTE, new Uint8Array(4));
  }
}
