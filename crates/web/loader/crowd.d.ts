import type { Camera, Group, Matrix4 } from 'three';
import type { LodcModel } from './loader.js';

/**
 * Copies of a model, each at the level that its size on the screen needs, in as many draw calls as
 * levels are seen, times meshes of the model. For models without skins and morph targets.
 */
export class LodcCrowd extends Group {
  /** Throws if the model has skins or morph targets. */
  constructor(model: LodcModel, count: number);
  readonly model: LodcModel;
  readonly count: number;
  /** The most that a level may err, in pixels; all triangles are drawn below 0. */
  pixels: number;
  /** The level of every copy, counted from the finest, 0; chosen by `pixels` if it is null. */
  level: number | null;
  /** Triangles that were drawn last. */
  readonly triangles: number;
  /** Places a copy, relative to the crowd. */
  setMatrixAt(index: number, matrix: Matrix4): void;
  getMatrixAt(index: number, matrix: Matrix4): Matrix4;
  /** Call it in every frame: chooses levels for a camera and a picture `height` pixels high. */
  update(camera: Camera, height: number): void;
  /** Frees what belongs to the crowd; the model stays. */
  dispose(): void;
}
