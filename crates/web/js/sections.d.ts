/** A section of a file. */
export interface Section {
  /** Four letters: docs/FORMAT.md has the list. */
  tag: string;
  /** Whether every number in it is a u32. */
  wide: boolean;
  object: number;
  index: number;
  /** Bytes from the beginning of the file. */
  first: number;
  length: number;
}

/** Sections of a `.lodc` file as typed arrays over its own bytes. Checksums are not compared. */
export class Sections {
  /** Throws if the file is none, of a later version, or cut off. */
  constructor(buffer: ArrayBuffer);
  readonly buffer: ArrayBuffer;
  readonly entries: Section[];
  find(tag: string, object?: number, index?: number): Section | undefined;
  /** The bytes of a section; null if it is not there. */
  bytes(tag: string, object?: number, index?: number): Uint8Array | null;
  /** A section of the gpu layout as words, without a copy. Throws if it is missing. */
  words(tag: string, object?: number, index?: number): Uint32Array;
  /** The LOD after each step, fine to coarse. */
  stepEnds(object: number): number[];
  /** First triangle and number of triangles of each submesh. */
  submeshes(object: number): Array<[number, number]>;
}
