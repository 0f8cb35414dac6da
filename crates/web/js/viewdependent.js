// The scene by views: vertices chosen on WebGPU for the camera as it stands, for the renderer.

import { inverted, moved, stretch } from './math.js';
import { openDevice } from './plan.js';
import { Views } from './views.js';

export class ViewDependent {
  /** Null where there is no WebGPU, or for objects with morph targets, which move vertices anew. */
  static async create(scene, wgsl) {
    const parts = scene.objects.flatMap((object) => object?.parts ?? []);
    if (!wgsl || parts.some((part) => part.morphs.length > 0)) return null;
    const device = await openDevice().catch(() => null);
    return device && new ViewDependent(scene, device, wgsl);
  }

  constructor(scene, device, wgsl) {
    Object.assign(this, { scene, device, wgsl });
    this.views = new Map();
    this.shown = null;
    this.busy = false;
  }

  /** Results by the number of the placement; `done` is called when they are there. */
  async choose(eye, slope, morph, done) {
    if (this.busy) return;
    this.busy = true;
    try {
      // All at once: each run is submitted with its copy before the next one begins.
      const placements = this.scene.placements();
      const scaleOf = errorScales(placements);
      const shown = await Promise.all(placements.map(async ({ object, world }) => {
        if (!this.views.has(object)) {
          this.views.set(object, new Views(this.device, this.wgsl, object));
        }
        const views = this.views.get(object);
        // Distances in the object's own space are world distances by its narrowest at least.
        const back = inverted(world);
        const own = slope / (stretch(back) * scaleOf({ object, world }));
        const result = await views.show(moved(back, eye), own, morph);
        return { ...result, layout: views.layout };
      }));
      this.shown = shown;
      this.triangles = shown.reduce((sum, { indices }) => (
        sum + indices.reduce((n, list) => n + list.length / 3, 0)), 0);
    } finally {
      this.busy = false;
    }
    done();
  }
}

/** How far placements may differ from even scaling, and from each other, to count as alike. */
const ROUNDING = 1e-4;

/**
 * Makes a function that returns what an object errs in a placement, in world units, for each unit
 * of its error: its stretch if the object's largest placement is scaled evenly, else the object's
 * scale, which bounds all.
 */
export function errorScales(placements) {
  const even = new Set();
  for (const { object, world } of placements) {
    const widest = stretch(world);
    const isLargest = widest >= object.levels.scale * (1 - ROUNDING);
    if (isLargest && widest * stretch(inverted(world)) <= 1 + ROUNDING) even.add(object);
  }
  return ({ object, world }) => (even.has(object) ? stretch(world) : object.levels.scale);
}
