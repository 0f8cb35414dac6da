import type {
  AnimationClip, Camera, Group, Loader, LoadingManager, Mesh, Object3DEventMap, SkinnedMesh,
} from 'three';
import type { GLTFLoader, GLTFParser } from 'three/addons/loaders/GLTFLoader.js';

export interface LodcLoadOptions {
  /** Ends loading: the promises fail with its reason. */
  signal?: AbortSignal;
}

export interface LodcStaticLoadOptions extends LodcLoadOptions {
  manager?: LoadingManager;
  /** Called as bytes come. */
  onProgress?: (event: ProgressEvent) => void;
}

/** Loads `.lodc` files and `.lods` streams. The file says which of them it is. */
export class LodcLoader extends Loader<LodcModel> {
  /** Makes materials, nodes, skins, animations and images; its own loaders can be set. */
  readonly gltf: GLTFLoader;
  constructor(manager?: LoadingManager);
  /** A model, when it can be drawn: of a stream after its first blocks. */
  static load(url: string, options?: LodcStaticLoadOptions): Promise<LodcModel>;
  load(
    url: string,
    onLoad: (model: LodcModel) => void,
    onProgress?: (event: ProgressEvent) => void,
    onError?: (error: unknown) => void,
    options?: LodcLoadOptions,
  ): void;
  loadAsync(
    url: string,
    onProgress?: (event: ProgressEvent) => void,
    options?: LodcLoadOptions,
  ): Promise<LodcModel>;
  /** Stops all that this loader is loading. Models stay as they are. */
  abort(): this;
}

export interface LodcModelEventMap extends Object3DEventMap {
  /** More triangles, or an image, have come: a picture is due. */
  grown: {};
  /** `animations` is filled. */
  animations: {};
  /** Everything has come. */
  complete: {};
}

/**
 * What a loader gives: a group to be added to a scene. Each mesh chooses its level when it is
 * drawn. `clone` shares all buffers.
 */
export class LodcModel extends Group<LodcModelEventMap> {
  readonly isLodcModel: true;
  /** The most that a level may err, in pixels; all triangles are drawn below 0. */
  pixels: number;
  /** The level, counted from the finest, 0; chosen by `pixels` if it is null. */
  level: number | null;
  animations: AnimationClip[];
  cameras: Camera[];
  /** Whether everything has come: all triangles, images, animations. */
  readonly isComplete: boolean;
  /** Resolves with the model when everything has come; fails if it does not. */
  readonly whenComplete: Promise<LodcModel>;
  readonly parser: GLTFParser;
  /** All meshes with levels. */
  readonly meshes: Array<LodcMesh | LodcSkinnedMesh>;
  /** Triangles at the levels that were drawn last. */
  readonly triangles: number;
  /**
   * Chooses all levels for a camera and a picture `height` pixels high, for rays and shadows
   * before the first picture. Drawing does it by itself.
   */
  update(camera: Camera, height: number): void;
  /** Frees buffers, materials and textures of this model and all its copies. */
  dispose(): void;
}

export class LodcMesh extends Mesh {
  /** The level that was drawn last, counted from the finest, 0. */
  readonly level: number;
  readonly triangles: number;
  readonly model: LodcModel | null;
}

export class LodcSkinnedMesh extends SkinnedMesh {
  /** The level that was drawn last, counted from the finest, 0. */
  readonly level: number;
  readonly triangles: number;
  readonly model: LodcModel | null;
}
