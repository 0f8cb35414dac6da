import type { AnimationClip, Group, Object3D, PerspectiveCamera } from 'three';
import type { GLTF } from 'three/addons/loaders/GLTFLoader.js';

/** A level of a chain as `extras.lodc` of its file states it; lengths are in units of the file. */
export interface ChainLevel {
  triangles: number;
  error: number;
  /** From where on it is shown. */
  distance: number;
  /** From where on it is on its way to the next one; none if it does not morph. */
  morph_from?: number | null;
}

/** A chain's levels at distances. Level 0 is the finest. */
export class ChainLevels {
  /** @param json the glTF document. Throws if it states no distances. */
  constructor(json: any);
  readonly levels: ChainLevel[];
  /** What the distances are for. */
  readonly screen: { pixels: number; height: number; fovy: number };
  /** The level at a distance and how far it is to the next one, 0 to 1; `before` is shown now. */
  at(distance: number, before?: number): { level: number; weight: number };
}

/** What all copies of a chain share. */
export class ChainModel {
  private constructor();
  /** @param gltf what three's `GLTFLoader` made of a file of `lodc chain` */
  static of(gltf: GLTF): Promise<ChainModel>;
  readonly scene: Group;
  readonly animations: AnimationClip[];
  readonly levels: ChainLevels;
}

/** One copy of a chain, at one of its levels, on its way to the next one. */
export class LodcChain extends Group {
  /** @param pixels the most that a level may err, in pixels */
  constructor(model: ChainModel, pixels?: number);
  readonly model: ChainModel;
  pixels: number;
  /** Levels morph; false: they switch. */
  morphs: boolean;
  /** The copy: what an `AnimationMixer` moves. */
  readonly content: Object3D;
  /** The present level, 0 is the finest, and how far it is on its way to the next one, 0 to 1. */
  readonly level: number;
  readonly weight: number;
  /** Triangles of the present level. */
  readonly triangles: number;
  /** Shows the level that a camera needs, in a picture `height` pixels high. */
  update(camera: PerspectiveCamera, height: number): void;
  /** Shows the level at a distance in the units of the file. Call it after animation mixers. */
  at(distance: number): void;
  /** Shows a level, a weight's part of the way to the next one. */
  show(level: number, weight: number): void;
}
