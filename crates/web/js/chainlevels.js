// The levels of a chain as `lodc chain` states them: which one a distance needs, and how far it is
// on its way to the next one.

/** The morph target that takes a level to the next one. */
export const TARGET = 'lodc:next';

/** A level is given up this much before its distance, so that nothing flickers between two. */
const HYSTERESIS = 0.05;

/** A chain's levels at distances, as `extras.lodc` of its file states them. */
export class ChainLevels {
  constructor(json) {
    const { levels, screen } = json.extras?.lodc ?? {};
    if (!(levels?.length > 1) || levels[0].distance === undefined) {
      throw new Error('no chain that states distances: make it with lodc chain --geomorph');
    }
    this.levels = levels;
    this.screen = screen;
  }

  /** The level at a distance and the weight of its way to the next one; `before` is shown now. */
  at(distance, before = 0) {
    const from = (k) => this.levels[k]?.distance ?? Infinity;
    let level = this.levels.findLastIndex((_, k) => from(k) <= distance);
    if (level < 0) level = 0;
    if (level === before - 1 && distance > from(before) * (1 - HYSTERESIS)) level = before;
    const { morph_from: start } = this.levels[level];
    const end = from(level + 1);
    const known = start !== null && start !== undefined && end > start;
    const way = known ? (distance - start) / (end - start) : 0;
    return { level, weight: Math.min(Math.max(way, 0), 1) };
  }
}
