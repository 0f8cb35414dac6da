/** The addresses of the two WebAssemblies, each of which is loaded when it is needed. */
export const WASM: { file: string; stream: string };

/** Whether bytes, five at least, are those of a `.lods` stream. */
export function isStream(bytes: Uint8Array): boolean;

/** Decodes one `.lodc` file or `.lods` stream, without three.js and without a worker. */
export class Decoder {
  /** @param wasm the address of `file.wasm` or `stream.wasm`, its bytes or its module */
  static create(wasm: URL | string | BufferSource | WebAssembly.Module): Promise<Decoder>;
  static module(wasm: URL | string | BufferSource): Promise<WebAssembly.Module>;
  /** A whole `.lodc` file, in pieces, as a message for {@link read}. Throws if it is damaged. */
  open(...pieces: Uint8Array[]): ArrayBuffer;
  /** Takes the next bytes of a `.lods` stream. Throws if they are damaged. */
  feed(bytes: Uint8Array): void;
  /** A message of what has come of a stream since the last one. */
  grown(): ArrayBuffer;
}

type Component = Int8Array | Uint8Array | Int16Array | Uint16Array | Uint32Array | Float32Array;

export interface Header {
  number: number;
  /** Its mesh in the document. */
  mesh: number;
  /** Vertices and triangles in all. */
  vertices: number;
  triangles: number;
  /** World units per unit. */
  scale: number;
  name: string;
  attributes: Array<{
    /** As three.js calls it; null for further sets. */
    name: string | null;
    /** The morph target that it belongs to, or −1. */
    target: number;
    width: number;
    normalized: boolean;
  }>;
  submeshes: Array<{ primitive: number; material: string | null; streams: number[] }>;
}

export interface Parts {
  /** The glTF document without its meshes' accessors; null for other sources. */
  document?(scene: {
    document: any;
    objects: number;
    buffer: number;
    materials: Array<{ name: string; lines: string[] }>;
  }): void;
  /** Bytes of buffer 0, and where they begin. */
  buffer?(at: number, bytes: Uint8Array): void;
  object?(header: Header): void;
  /** Vertices from `first` on: positions, then the attributes. */
  vertices?(number: number, first: number, count: number, arrays: Component[]): void;
  /** Levels, the coarsest first, with indices from `first` on; those that were there go. */
  levels?(
    number: number,
    levels: Array<{ error: number; triangles: number[] }>,
    first: number,
    indices: Uint32Array,
  ): void;
  complete?(): void;
}

/** Calls a function for each part of a message. `headers` is kept from message to message. */
export function read(message: ArrayBuffer, headers: Header[], parts: Parts): void;
