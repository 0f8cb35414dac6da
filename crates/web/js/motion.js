// How much is drawn while something moves: fewer triangles first, then fewer pixels, if frames come
// too late; at rest everything again, in a few steps that a new move cuts short.

import { clamp } from './math.js';

/** Milliseconds between frames that are aimed at. */
const WANTED = 40;
/** Fewer triangles than this are not drawn to be faster: pixels cost more then. */
const LEAST = 4000;
/** Milliseconds without a move after which everything stands. */
const REST = 160;
/** Factor between the triangles of the frames on the way to the whole level. */
const STEP = 5;

export class Motion {
  constructor() {
    this.most = Infinity;
    this.scale = 1;
    this.movedAt = -Infinity;
    this.moves = false;
    this.refining = Infinity;
  }

  /** Something has moved. */
  moved(now) {
    this.movedAt = now;
    this.moves = true;
    this.refining = 0;
  }

  /** Whether something has moved since the last frame, or a moment ago. */
  isMoving(now) {
    return this.moves || now - this.movedAt < REST;
  }

  /** Learns how many milliseconds a frame of a number of triangles took. */
  learn(milliseconds, triangles) {
    if (milliseconds > 1.5 * WANTED) {
      const most = triangles * clamp(WANTED / milliseconds, 0.05, 0.8);
      if (triangles > LEAST) this.most = Math.max(most, LEAST);
      else this.scale = 0.5;
    } else if (milliseconds < 0.6 * WANTED && triangles >= 0.7 * this.most) {
      this.most = triangles * 1.4;
    }
  }

  /**
   * What the next frame shows of a level of `whole` triangles: how many of them, at which scale of
   * pixels, and whether another frame is needed.
   */
  next(now, whole) {
    const moving = this.isMoving(now);
    this.moves = false;
    if (moving) {
      const triangles = Math.min(whole, this.most);
      // Frames follow each other as long as it moves, so that their times are known.
      return { triangles, scale: this.scale, more: true };
    }
    this.refining = Math.max(this.refining, Math.min(this.most, whole)) * STEP;
    const triangles = Math.min(whole, this.refining);
    return { triangles, scale: 1, more: triangles < whole };
  }
}
