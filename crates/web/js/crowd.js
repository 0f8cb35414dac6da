// A crowd: many copies of the scene, each at a level by its distance.
//
// Levels that copies may show stand one behind the other in one index list for each part, each
// with about three quarters of the triangles of the one before; a copy only names a range.

import { sub } from './math.js';

const FACTOR = 0.75;
/** More indices than this, over all levels and parts, are not made. */
const MOST_INDICES = 24e6;

export class Crowd {
  /** @param selection levels of the objects, which are moved and put back */
  constructor(selection) {
    const before = selection.all.map((o) => o.lod);
    this.levels = rungs(selection);
    const parts = selection.all.flatMap((o) => o.submeshes);
    this.ranges = new Map(parts.map((part) => [part, { lists: [], first: [], count: [] }]));
    for (const level of this.levels) {
      selection.seek(level.lods);
      for (const part of parts) {
        const { lists, first, count } = this.ranges.get(part);
        first.push(first.length === 0 ? 0 : first.at(-1) + count.at(-1));
        count.push(3 * part.triangles);
        lists.push(part.indices.slice(0, 3 * part.triangles));
      }
    }
    for (const range of this.ranges.values()) {
      range.indices = new Uint32Array(range.first.at(-1) + range.count.at(-1));
      range.lists.forEach((list, level) => range.indices.set(list, range.first[level]));
      delete range.lists;
    }
    selection.seek(before);
  }

  /**
   * Copies by level: for each level four floats a copy (offset, turn). Copies stand in a square
   * around the first one; a level's error is at most `pixels` high where its copy stands.
   */
  placed(amount, spacing, eye, centre, radius, allowed) {
    const side = Math.ceil(Math.sqrt(amount));
    const byLevel = this.levels.map(() => []);
    for (let i = 0; i < amount; i++) {
      const [row, column] = [Math.floor(i / side), i % side];
      const offset = [(column - (side - 1) / 2) * spacing, 0, (row - (side - 1) / 2) * spacing];
      const away = sub(eye, centre.map((c, k) => c + offset[k]));
      const distance = Math.max(Math.hypot(...away) - radius, radius * 0.02);
      const fits = this.levels.findLastIndex(({ error }) => error <= allowed * distance);
      byLevel[Math.max(fits, 0)].push(...offset, ((i * 2654435761) % 628) / 100);
    }
    const triangles = byLevel.reduce((sum, copies, level) => (
      sum + (copies.length / 4) * this.levels[level].triangles), 0);
    return { byLevel: byLevel.map((copies) => new Float32Array(copies)), triangles };
  }
}

/** The levels of a crowd, the finest first: LODs, triangles, error in world units. */
function rungs(selection) {
  let most = Math.min(selection.triangles, (MOST_INDICES / 3) * (1 - FACTOR));
  const levels = [];
  while (levels.length < 48) {
    const lods = selection.byTriangles(Math.floor(most));
    const triangles = selection.count(lods);
    const error = selection.error(lods);
    if (triangles !== levels.at(-1)?.triangles) levels.push({ lods, triangles, error });
    if (triangles <= selection.least || most < 1) break;
    most = Math.min(most, triangles) * FACTOR;
  }
  return levels;
}
