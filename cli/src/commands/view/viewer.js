// The state of the page: which level is shown, how it is coloured, when a frame is due.

import { Crowd } from '../../../../crates/web/js/crowd.js';
import { Motion } from '../../../../crates/web/js/motion.js';
import { Orbit } from '../../../../crates/web/js/orbit.js';
import { Selection, pixelSize } from '../../../../crates/web/js/selection.js';

/** Pixels that a level may err by, at the coarse end of the slider and at the fine one. */
const PIXELS = [100, 0.25];
/** Factors of ten between the largest error and the smallest of the slider. */
const DECADES = 5;
/** Frames at the beginning, so that one of them surely comes to the screen. */
export const FIRST = 8;

export class Viewer {
  constructor(canvas, scene, renderer) {
    Object.assign(this, { canvas, scene, renderer });
    this.viewDependent = null;
    this.selection = new Selection(scene.objects.filter(Boolean).map((o) => o.levels));
    this.by = 'triangles';
    this.share = 1;
    this.asked = null;
    this.colouring = 'material';
    this.wire = false;
    this.flat = false;
    this.turntable = false;
    this.animation = null;
    this.seconds = 0;
    this.copies = 1;
    this.byView = false;
    this.morph = false;
    this.paints = paints(scene, this.selection);
    this.motion = new Motion();
    this.scale = 1;
    this.frameTime = 0;
    this.frames = 0;
    this.changed = true;
    this.onframe = () => {};
    this.orbit = { matrices: () => null };
    this.orbit = new Orbit(canvas, scene.bounds(), () => this.move());
    const observer = new ResizeObserver(() => this.resize());
    observer.observe(canvas);
    observer.observe(document.querySelector('footer'));
    this.resize();
  }

  resize() {
    const scale = this.scale * Math.min(window.devicePixelRatio || 1, 2);
    const width = Math.max(1, Math.round(this.canvas.clientWidth * scale));
    const height = Math.max(1, Math.round(this.canvas.clientHeight * scale));
    // Setting a size, even the same, clears the canvas.
    if (this.canvas.width !== width) this.canvas.width = width;
    if (this.canvas.height !== height) this.canvas.height = height;
    this.orbit.resize(width / height, this.covered(), this.beside());
    this.invalidate();
  }

  /** Share of the canvas that is covered below: by the footer, on a narrow page by the options. */
  covered() {
    const all = [...document.querySelectorAll('footer, aside')];
    const boxes = all.map((one) => one.getBoundingClientRect());
    const below = boxes.filter(({ left, width }) => width > 0 && left <= window.innerWidth / 2);
    return 1 - Math.min(...below.map(({ top }) => top)) / window.innerHeight;
  }

  /** Share of the canvas that the options cover on the right; on a narrow page they stand below. */
  beside() {
    const { left, right, width } = document.querySelector('aside').getBoundingClientRect();
    const aside = width > 0 && left > window.innerWidth / 2;
    return aside ? 1 - (left - (window.innerWidth - right)) / window.innerWidth : 0;
  }

  /** Stands the scene on another axis, `y` or `z`. */
  stand(up) {
    this.scene.stand(up);
    this.orbit.around(this.scene.bounds());
    this.viewState = null;
    this.invalidate();
  }

  /** The camera has moved. */
  move() {
    this.motion.moved(performance.now());
    this.invalidate();
  }

  /** Asks for a frame; without a change the last one is shown again. */
  invalidate(changed = true) {
    this.changed ||= changed;
    if (this.due) return;
    this.due = true;
    requestAnimationFrame((now) => this.frame(now));
  }

  /** Changes the state and asks for a frame. */
  set(changes) {
    Object.assign(this, changes);
    this.invalidate();
  }

  /** Largest error in world units that the slider stands for. */
  allowedError() {
    return this.share >= 1 ? 0 : this.selection.largest * 10 ** (-DECADES * this.share);
  }

  allowedPixels() {
    return PIXELS[0] * (PIXELS[1] / PIXELS[0]) ** this.share;
  }

  /** The slider's value for a number of triangles that an address asks for. */
  shareShown(triangles) {
    return this.selection.shareOf(triangles);
  }

  /** The share that `allowedPixels` turns into a number of pixels. */
  shareOfPixels(pixels) {
    return Math.log(pixels / PIXELS[0]) / Math.log(PIXELS[1] / PIXELS[0]);
  }

  /** Error in world units that is as large as a pixel at distance 1. */
  pixel() {
    return pixelSize(this.orbit.fovy, this.canvas.clientHeight);
  }

  /** One LOD for each object, as `asked` or by the slider. */
  lods() {
    const { asked, selection } = this;
    if (asked?.lod !== undefined) return selection.byLod(asked.lod);
    if (asked?.triangles !== undefined) return selection.byTriangles(asked.triangles);
    if (asked?.error !== undefined) return selection.byError(asked.error);
    if (this.by === 'triangles') return selection.byTriangles(selection.ofShare(this.share));
    if (this.by === 'error') return selection.byError(this.allowedError());
    const { centre, radius } = this.orbit.home;
    const away = Math.hypot(...this.orbit.eye().map((e, i) => e - centre[i]));
    const distance = Math.max(away - radius, radius * 0.02);
    return selection.byError(this.allowedPixels() * this.pixel() * distance);
  }

  frame(now) {
    this.due = false;
    this.frames += 1;
    if (!this.changed) {
      this.renderer.again();
      if (this.frames < FIRST) this.invalidate(false);
      return;
    }
    this.changed = false;
    const since = now - (this.last ?? now);
    const passed = Math.min(since / 1000, 0.1);
    this.last = now;
    if (this.turntable) this.orbit.azimuth += passed * 0.5;
    if (this.turntable || this.animation) this.motion.moved(now);
    if (this.animation) {
      this.seconds = (this.seconds + passed) % (this.animation.seconds || 1);
      this.scene.pose(this.animation, this.seconds);
    }
    const started = performance.now();
    const lods = this.lods();
    const whole = this.selection.count(lods);
    const { triangles, more } = this.sparing(now, since, whole);
    this.selection.seek(triangles < whole ? this.selection.byTriangles(triangles) : lods);
    const crowd = this.copies > 1 ? this.crowd() : null;
    const views = crowd ? null : this.views();
    const { centre, radius } = this.orbit.home;
    const reach = crowd ? radius + crowd.reach : radius;
    const dark = getComputedStyle(document.documentElement).colorScheme === 'dark';
    this.shown = {
      ...this.orbit.matrices(reach),
      centre,
      background: dark ? [0.09, 0.098, 0.114] : [0.925, 0.933, 0.945],
      colouring: this.colouring,
      paints: this.paints,
      wire: this.wire,
      wireColour: dark && this.colouring !== 'material' ? [0, 0, 0, 0.55] : [0.02, 0.05, 0.1, 0.5],
      flat: this.flat,
      crowd,
      views,
    };
    this.renderer.draw(this.shown);
    this.frameTime = performance.now() - started;
    this.onframe({
      lods,
      triangles: whole,
      sparing: triangles < whole && !crowd && !views ? this.drawn : null,
      error: this.selection.error(lods),
      crowd,
      views: views && this.viewDependent.triangles,
    });
    if (this.frames < FIRST) this.motion.learn(performance.now() - started, this.drawn);
    if (this.turntable || this.animation || more) this.invalidate();
    else this.last = undefined;
    if (this.frames < FIRST) this.invalidate(false);
  }

  /** Triangles of the next frame: while something moves, as many as come in time. */
  sparing(now, since, whole) {
    const { motion } = this;
    const counted = this.copies === 1 && !this.byView;
    if (since > 0 && motion.isMoving(now)) motion.learn(since, this.drawn ?? whole);
    const { triangles, scale, more } = motion.next(now, whole);
    if (scale !== this.scale) {
      this.scale = scale;
      this.resize();
    }
    this.drawn = counted ? this.selection.count(this.selection.byTriangles(triangles)) : whole;
    return { triangles: counted ? triangles : whole, more };
  }

  /** Vertices by view, if asked for: those of the last result until the next one is there. */
  views() {
    const chooser = this.viewDependent;
    if (!this.byView || !chooser) return null;
    const slope = this.allowedPixels() * this.pixel();
    const state = [...this.orbit.eye(), slope, this.morph, this.seconds].join();
    if (state !== this.viewState && !chooser.busy) {
      this.viewState = state;
      const before = chooser.shown;
      chooser.choose(this.orbit.eye(), slope, this.morph, () => {
        this.renderer.release(before);
        this.invalidate();
      });
    } else if (state !== this.viewState) this.invalidate();
    return chooser.shown;
  }

  /** Copies by level, for the camera as it stands. */
  crowd() {
    this.ladder ??= new Crowd(this.selection);
    const { centre, radius } = this.orbit.home;
    const side = Math.ceil(Math.sqrt(this.copies));
    const spacing = 2.3 * radius;
    const allowed = (this.by === 'pixels' ? this.allowedPixels() : 1) * this.pixel();
    const eye = this.orbit.eye();
    const placed = this.ladder.placed(this.copies, spacing, eye, centre, radius, allowed);
    return { ...placed, ranges: this.ladder.ranges, reach: spacing * side };
  }
}

/** Colours, four bytes each, that stand for something. */
function paints(scene, selection) {
  const levelsOf = new Map();
  for (const object of scene.objects) {
    for (const part of object?.parts ?? []) levelsOf.set(part, object.levels);
  }
  return {
    /** Of vertices: the error of the level at which each disappears. */
    error(part) {
      const levels = levelsOf.get(part);
      const { numbers } = part.submesh;
      const colours = new Uint8Array(4 * numbers.length);
      for (let v = 0; v < numbers.length; v++) {
        const step = Math.min(levels.steps(numbers[v]), levels.errors.length - 1);
        const error = step < 0 ? 0 : levels.scale * levels.errors[step];
        const share = Math.log10(Math.max(error / (selection.largest || 1), 1e-5)) / DECADES + 1;
        colours.set([...heat(share), 255], 4 * v);
      }
      return colours;
    },
    /** Of corners: the strip of each triangle. */
    strips({ strips, submesh }) {
      const drawn = submesh.drawn();
      const colours = new Uint8Array(12 * drawn.length);
      drawn.forEach((t, at) => {
        const colour = [...distinct(strips[t]), 255];
        for (let k = 0; k < 3; k++) colours.set(colour, 12 * at + 4 * k);
      });
      return colours;
    },
  };
}

const HEAT = [[44, 79, 208], [42, 165, 192], [111, 193, 90], [233, 194, 50], [214, 64, 43]];

/** A colour between blue (0) and red (1). */
function heat(share) {
  const at = Math.min(Math.max(share, 0), 1) * (HEAT.length - 1);
  const below = Math.min(Math.floor(at), HEAT.length - 2);
  return HEAT[below].map((c, i) => c + (HEAT[below + 1][i] - c) * (at - below));
}

/** A colour far from those of the numbers near by: hues by the golden angle. */
function distinct(number) {
  const hue = (number * 137.508) % 360;
  const light = 0.52 + 0.13 * Math.sin(number * 1.7);
  return [0, 8, 4].map((n) => {
    const k = (n + hue / 30) % 12;
    const spread = 0.62 * Math.min(light, 1 - light);
    return 255 * (light - spread * Math.max(-1, Math.min(k - 3, 9 - k, 1)));
  });
}
