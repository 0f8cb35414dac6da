import type { Levels } from './levels.js';

/** Objects whose levels are chosen together: one LOD for each. Errors are in world units. */
export class Selection {
  constructor(objects: Levels[]);
  /** Triangles of all objects at LOD 0. */
  readonly triangles: number;
  /** Triangles and error at the coarsest levels that show every object. */
  readonly least: number;
  readonly largest: number;
  /** The diagonal of the largest object. */
  readonly diagonal: number;
  /** The same number of records for every object. */
  byLod(lod: number): number[];
  /** For each object the coarsest LOD whose error is at most `error`. */
  byError(error: number): number[];
  /** The finest levels with at most `most` triangles, as `lodc extract --triangles` has them. */
  byTriangles(most: number): number[];
  /** Triangles at the share 0 to 1 of a slider: 0 is the coarsest; equal steps are factors. */
  ofShare(share: number): number;
  /** The share that `ofShare` turns into a number of triangles. */
  shareOf(triangles: number): number;
  /** Triangles at one LOD for each object. */
  count(lods: ArrayLike<number>): number;
  /** The largest error at one LOD for each object. */
  error(lods: ArrayLike<number>): number;
  /** Shows one LOD for each object. Returns whether anything has changed. */
  seek(lods: ArrayLike<number>): boolean;
}

/** Length in the world that is one pixel high at distance 1; `fovy` in radians. */
export function pixelSize(fovy: number, height: number): number;
