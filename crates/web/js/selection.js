// Which LOD of every object fits a number of triangles, an error or a size in pixels.

import { clamp } from './math.js';

/** Objects whose levels are chosen together; errors are in world units. */
export class Selection {
  /** @param objects `Levels` of all objects */
  constructor(objects) {
    this.objects = objects.filter((levels) => levels.triangles > 0);
    this.all = objects;
    this.triangles = sum(objects, (o) => o.triangles);
    this.least = sum(this.objects, (o) => o.trianglesAt(o.lastVisible()));
    this.largest = this.objects.reduce((most, o) => (
      Math.max(most, o.scale * o.errorAt(o.lastVisible()))), 0);
    this.ranks = ranks(objects);
    this.diagonal = this.objects.reduce((most, o) => Math.max(most, o.scale * o.diagonal), 0);
  }

  /** The same number of records for every object. */
  byLod(lod) {
    return this.all.map((o) => o.shown(lod));
  }

  /** For each object the coarsest LOD whose error is at most `error`. */
  byError(error) {
    return this.all.map((o) => o.forError(error / o.scale));
  }

  /**
   * The finest levels with at most `most` triangles, as `lodc extract --triangles` has them:
   * several objects lose triangles in their order. Objects that have none, since they are of
   * several files, meet the smallest error in common.
   */
  byTriangles(most) {
    if (this.objects.length === 1) {
      return this.all.map((o) => Math.min(o.forTriangles(most), o.lastVisible()));
    }
    if (this.triangles <= most) return this.byLod(0);
    return this.ranks ? this.byRank(most) : this.inCommon(most);
  }

  byRank(most) {
    const lods = this.all.map(() => 0);
    let total = this.triangles;
    for (const { object, lod, spared } of this.ranks) {
      if (total <= most) break;
      if (total - spared < most) {
        // Within a ranked LOD steps are taken one by one.
        const levels = this.all[object];
        lods[object] = levels.forTriangles(levels.trianglesAt(lods[object]) - (total - most));
        break;
      }
      lods[object] = lod;
      total -= spared;
    }
    return lods;
  }

  inCommon(most) {
    let [low, high] = [0, this.largest];
    for (let i = 0; i < 48; i++) {
      const middle = (low + high) / 2;
      if (this.count(this.byError(middle)) > most) low = middle;
      else high = middle;
    }
    return this.byError(high);
  }

  /** The share 0 to 1 of a slider: 0 is the coarsest, 1 all triangles; equal steps are factors. */
  ofShare(share) {
    const least = Math.max(this.least, 1);
    return Math.round(least * (Math.max(this.triangles, 1) / least) ** clamp(share, 0, 1));
  }

  /** The share that `ofShare` turns into a number of triangles. */
  shareOf(triangles) {
    const least = Math.max(this.least, 1);
    const span = Math.log(Math.max(this.triangles, 1) / least);
    return span > 0 ? clamp(Math.log(Math.max(triangles, 1) / least) / span, 0, 1) : 1;
  }

  /** Triangles at one LOD for each object. */
  count(lods) {
    return sum(this.all, (o, i) => o.trianglesAt(lods[i]));
  }

  /** The largest error at one LOD for each object, in world units. */
  error(lods) {
    return this.all.reduce((most, o, i) => (
      o.triangles > 0 ? Math.max(most, o.scale * o.errorAt(lods[i])) : most), 0);
  }

  /** Shows one LOD for each object. Returns whether anything has changed. */
  seek(lods) {
    return this.all.map((o, i) => o.seek(lods[i])).some(Boolean);
  }
}

/**
 * The ranks of all objects in their order: the object's number, its LOD there and the
 * triangles that it gives up. Null if an object that has triangles to give has no ranks.
 */
function ranks(objects) {
  if (objects.some((o) => !o.ranks && o.lastVisible() > 0)) return null;
  const all = objects.flatMap((levels, object) => {
    if (!levels.ranks) return [];
    const { places, lods } = levels.ranks;
    const left = Array.from(lods, (lod) => levels.trianglesAt(lod));
    return left.map((triangles, i) => ({
      place: places[i],
      object,
      lod: lods[i],
      spared: (i === 0 ? levels.triangles : left[i - 1]) - triangles,
    }));
  });
  return all.sort((a, b) => a.place - b.place);
}

function sum(list, of) {
  return list.reduce((total, entry, i) => total + of(entry, i), 0);
}

/** Length in the world that is one pixel high at distance 1; `fovy` in radians. */
export function pixelSize(fovy, height) {
  return (2 * Math.tan(fovy / 2)) / height;
}
