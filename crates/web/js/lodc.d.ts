import type { Levels, Submesh } from './levels.js';
import type { Selection } from './selection.js';

/** Bytes of a file or of a piece of a stream. */
export type Bytes = ArrayBuffer | ArrayBufferView;

/** A GLB: its glTF document, and accessors as typed arrays. */
export interface Glb {
  /** The glTF document. */
  readonly json: any;
  /** The bytes of its binary chunk. */
  readonly binary: Uint8Array;
  /** The bytes of a buffer view. */
  view(index: number): Uint8Array;
  /** The components of an accessor one behind the other, in their own type. */
  raw(index: number):
    Int8Array | Uint8Array | Int16Array | Uint16Array | Uint32Array | Float32Array;
  /** An accessor as floats; integers that stand for fractions become fractions. */
  floats(index: number): Float32Array;
  /** An accessor of single whole numbers. */
  words(index: number): Uint32Array;
  /** The number of components of an accessor's elements. */
  width(index: number): number;
  /** The image of a texture; null if it is not in the file. */
  picture(texture: number): Blob | null;
}

/** The vertices of one primitive, with an entry for each in every array, and its triangles. */
export interface Part {
  /** The material's number in the document, or −1. */
  readonly material: number;
  /** Three for each vertex, as all that follows in the object's units. */
  readonly positions: Float32Array;
  readonly normals: Float32Array;
  /** Whether the normals are made here, of a surface with many edges: draw it with flat ones. */
  readonly edgy: boolean;
  readonly uvs: [Float32Array | null, Float32Array | null];
  /** Four for each vertex, in linear light. */
  readonly colours: Float32Array | null;
  readonly joints: Float32Array | null;
  readonly weights: Float32Array | null;
  readonly morphs: Array<{ positions: Float32Array | null; normals: Float32Array | null }>;
  /** The triangles at the present level: `indices[0 .. 3 * triangles)`. */
  readonly submesh: Submesh;
  /** Strips for a vertex cache, if the file has them. */
  readonly strips: Uint32Array | null;
}

/** An object of a file: a mesh with its levels. */
export interface LodcObject {
  readonly name: string;
  readonly parts: Part[];
  readonly levels: Levels;
  /** The weights of morph targets at rest. */
  readonly weights: number[];
}

/** The WebAssembly module, ready to open files and streams. */
export class Lodc {
  private constructor();
  /** @param wasm the address of `lodc.wasm` (that beside the module), a `Response`, or its bytes */
  static create(wasm?: URL | string | Response | Bytes): Promise<Lodc>;
  /** A `.lodc` file as the bytes of a GLB with all levels. Throws if it is no such file. */
  glb(file: Bytes): Uint8Array;
  /** A `.lodc` file as objects with levels, and a selection over all of them. */
  open(file: Bytes): { glb: Glb; objects: LodcObject[]; selection: Selection };
  /** A `.lods` stream that is fed piece by piece. */
  stream(): Stream;
}

/** How much of a stream has come: pairs are so far, and in all. */
export interface StreamProgress {
  complete: boolean;
  bytes: number;
  objects: Array<{
    vertices: [number, number];
    triangles: [number, number];
    steps: [number, number];
    /** The error of what has come, in world units. */
    error: number;
  }>;
}

/** A stream, coarse to fine: after any piece it has a mesh. */
export class Stream {
  private constructor();
  readonly progress: StreamProgress;
  /** Takes the next bytes. Throws if they are damaged. */
  feed(bytes: Bytes): StreamProgress;
  /** Triangles so far, and in all. */
  triangles(): [number, number];
  /** The scene so far as the bytes of a GLB; null before the first block. */
  mesh(): Uint8Array | null;
  /** Frees the memory. */
  close(): void;
}
