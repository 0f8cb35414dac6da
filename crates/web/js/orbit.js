// An orbiting camera moved by mouse, touch and keys.

import { add, clamp, cross, lookAt, normalized, perspective, scaled, sub } from './math.js';

const FOVY = (35 * Math.PI) / 180;
const UP = [0, 1, 0];

export class Orbit {
  /** @param changed called after each move */
  constructor(canvas, { low, high }, changed) {
    this.changed = changed;
    this.home = home(low, high);
    this.covered = 0;
    this.beside = 0;
    this.fovy = FOVY;
    this.aspect = 1;
    this.pointers = new Map();
    this.reset();
    this.listen(canvas);
  }

  /** Goes around another box. */
  around({ low, high }) {
    this.home = home(low, high);
    this.reset();
  }

  reset() {
    this.azimuth = 0.6;
    this.elevation = 0.28;
    this.target = this.home.centre;
    this.distance = this.fitting();
    this.touched = false;
    this.changed();
  }

  /** The distance from which all is seen however it is turned, in a narrow picture too. */
  fitting() {
    const { wide, high } = this.home;
    const half = Math.tan(this.fovy / 2);
    const across = wide / Math.sin(Math.atan(half * this.aspect * (1 - this.beside)));
    const upward = (high + 0.35 * wide) / (half * (1 - this.covered)) + 0.6 * wide;
    return Math.max(across, upward, this.home.radius * 0.5) * 1.06;
  }

  /**
   * `covered` is the share of the picture's height, at the bottom, where something stands, `beside`
   * that of its width, on the right.
   */
  resize(aspect, covered = 0, beside = 0) {
    this.aspect = aspect;
    this.covered = Math.min(covered, 0.6);
    this.beside = Math.min(beside, 0.6);
    if (!this.touched) this.distance = this.fitting();
  }

  eye() {
    const level = Math.cos(this.elevation);
    const back = [
      Math.sin(this.azimuth) * level, Math.sin(this.elevation), Math.cos(this.azimuth) * level];
    return add(this.target, scaled(back, this.distance));
  }

  /** View and projection; `reach` is how far from the centre anything is drawn. */
  matrices(reach = this.home.radius) {
    const eye = this.eye();
    const far = Math.hypot(...sub(eye, this.home.centre)) + 1.1 * reach;
    const near = Math.max(far - 2.4 * reach, far / 4000);
    const projection = perspective(this.fovy, this.aspect, near, far);
    projection[8] = this.beside;
    projection[9] = -this.covered;
    return { eye, view: lookAt(eye, this.target, UP), projection };
  }

  turn(dx, dy) {
    this.azimuth -= dx;
    this.elevation = clamp(this.elevation + dy, -1.5, 1.5);
    this.move();
  }

  zoom(factor) {
    const { radius } = this.home;
    this.distance = clamp(this.distance * factor, radius * 0.02, radius * 200);
    this.move();
  }

  pan(dx, dy) {
    const back = normalized(sub(this.eye(), this.target));
    const right = normalized(cross(UP, back));
    const step = 2 * this.distance * Math.tan(this.fovy / 2);
    const by = add(scaled(right, -dx * step), scaled(cross(back, right), dy * step));
    this.target = add(this.target, by);
    this.move();
  }

  move() {
    this.touched = true;
    this.changed();
  }

  listen(canvas) {
    const { pointers } = this;
    const release = (event) => pointers.delete(event.pointerId);
    canvas.addEventListener('pointerdown', (event) => {
      canvas.setPointerCapture(event.pointerId);
      pointers.set(event.pointerId, [event.clientX, event.clientY]);
    });
    canvas.addEventListener('pointermove', (event) => this.drag(event, canvas.clientHeight));
    canvas.addEventListener('pointerup', release);
    canvas.addEventListener('pointercancel', release);
    canvas.addEventListener('contextmenu', (event) => event.preventDefault());
    canvas.addEventListener('dblclick', () => this.reset());
    canvas.addEventListener('wheel', (event) => {
      event.preventDefault();
      this.zoom(Math.exp(clamp(event.deltaY, -120, 120) * 0.0016));
    }, { passive: false });
    canvas.addEventListener('keydown', (event) => this.key(event));
  }

  /** One pointer turns (with Shift or the right button moves), two move and zoom. */
  drag(event, height) {
    const { pointers } = this;
    const before = pointers.get(event.pointerId);
    if (!before) return;
    const now = [event.clientX, event.clientY];
    const [dx, dy] = [(now[0] - before[0]) / height, (now[1] - before[1]) / height];
    if (pointers.size === 2) {
      const other = [...pointers].find(([id]) => id !== event.pointerId)[1];
      const apart = (p) => Math.hypot(p[0] - other[0], p[1] - other[1]) || 1;
      this.pan(dx / 2, dy / 2);
      this.zoom(apart(before) / apart(now));
    } else if (event.shiftKey || event.buttons & 6) this.pan(dx, dy);
    else this.turn(dx * 4.5, dy * 3.5);
    pointers.set(event.pointerId, now);
  }

  key(event) {
    const moves = {
      ArrowLeft: () => this.turn(0.12, 0),
      ArrowRight: () => this.turn(-0.12, 0),
      ArrowUp: () => this.turn(0, 0.1),
      ArrowDown: () => this.turn(0, -0.1),
      '+': () => this.zoom(0.88),
      '=': () => this.zoom(0.88),
      '-': () => this.zoom(1.14),
      Home: () => this.reset(),
    };
    if (!moves[event.key] || event.ctrlKey || event.metaKey) return;
    event.preventDefault();
    moves[event.key]();
  }
}

/** Centre and size of a box. */
function home(low, high) {
  const size = sub(high, low);
  return {
    centre: scaled(add(low, high), 0.5),
    radius: Math.hypot(...size) / 2 || 1,
    wide: Math.hypot(size[0], size[2]) / 2,
    high: size[1] / 2,
  };
}
