/** First index in `[0 .. length)` for which `holds` is true; it stays true behind it. */
export function partition(length: number, holds: (index: number) => boolean): number;

/** The part of an object with one material, and its triangles at the present LOD. */
export class Submesh {
  constructor(arrays: {
    /** Three vertices for each triangle of LOD 0. */
    source: Uint32Array;
    /** The number of each vertex in the collapse order, falling. */
    numbers: Uint32Array;
    /** The earlier vertex that each vertex becomes. */
    targets: Uint32Array;
    /** The LOD at which each triangle goes, not rising. */
    removals: Uint32Array;
    /** Triangles as they are drawn; as they stand without it. */
    order?: Uint32Array | null;
  });
  /** Those of the present LOD are `indices[0 .. 3 * triangles)`. */
  readonly indices: Uint32Array;
  readonly lod: number;
  /** Vertices of the present LOD: the first ones. */
  readonly vertices: number;
  readonly triangles: number;
  /** Goes to a LOD at the end of a step. Linear in what is drawn. */
  seek(lod: number): void;
  /** The numbers of the triangles that are drawn, in the order of the file. */
  drawn(): number[];
}

/**
 * The levels of an object, fine to coarse. A LOD is the number of records that are done: 0 is the
 * input, and a level is shown at the end of a step. Errors are in the object's units.
 */
export class Levels {
  constructor(stored: {
    records: number;
    triangles: number;
    /** The LOD, the triangles and the error after each step. */
    ends: Uint32Array;
    counts: Uint32Array;
    errors: Float32Array;
    /** World units per unit. */
    scale: number;
    diagonal: number;
    submeshes: Submesh[];
    /** Where, in the order over the objects of a scene, this one gives up triangles. */
    ranks?: { places: Uint32Array; lods: Uint32Array } | null;
  });
  readonly records: number;
  readonly triangles: number;
  readonly ends: Uint32Array;
  readonly counts: Uint32Array;
  readonly errors: Float32Array;
  readonly scale: number;
  readonly diagonal: number;
  readonly submeshes: Submesh[];
  /** The present LOD. */
  readonly lod: number;
  /** The number of complete steps at a LOD. */
  steps(lod: number): number;
  /** The LOD rounded down to the end of a step. */
  shown(lod: number): number;
  trianglesAt(lod: number): number;
  /** Upper bound of the distance from LOD 0; Infinity where no triangle is left. */
  errorAt(lod: number): number;
  /** The coarsest LOD that still has a triangle. */
  lastVisible(): number;
  /** The finest LOD with at most `most` triangles. */
  forTriangles(most: number): number;
  /** The coarsest LOD with triangles whose error is at most `error`. */
  forError(error: number): number;
  /** Shows a LOD, rounded down to a step. Returns whether anything has changed. */
  seek(lod: number): boolean;
}
