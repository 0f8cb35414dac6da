// Vectors, quaternions and column-major 4 × 4 matrices as plain arrays.

export const add = (a, b) => a.map((x, i) => x + b[i]);
export const sub = (a, b) => a.map((x, i) => x - b[i]);
export const scaled = (a, s) => a.map((x) => x * s);
export const dot = (a, b) => a.reduce((sum, x, i) => sum + x * b[i], 0);
export const length = (a) => Math.hypot(...a);
export const normalized = (a) => scaled(a, 1 / (length(a) || 1));
export const clamp = (x, low, high) => Math.min(Math.max(x, low), high);
export const cross = (a, b) => [
  a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0],
];

export const IDENTITY = [1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1];

/** The matrix that applies `b` first, then `a`. */
export function times(a, b) {
  const out = new Array(16);
  for (let column = 0; column < 4; column++) {
    for (let row = 0; row < 4; row++) {
      let sum = 0;
      for (let k = 0; k < 4; k++) sum += a[4 * k + row] * b[4 * column + k];
      out[4 * column + row] = sum;
    }
  }
  return out;
}

/** A point moved by an affine matrix. */
export function moved(m, p) {
  return [0, 1, 2].map((row) => (
    m[row] * p[0] + m[4 + row] * p[1] + m[8 + row] * p[2] + m[12 + row]));
}

/** The matrix of translation, rotation (quaternion) and scale. */
export function composed([x, y, z], [a, b, c, w], [i, j, k]) {
  return [
    (1 - 2 * (b * b + c * c)) * i, 2 * (a * b + c * w) * i, 2 * (a * c - b * w) * i, 0,
    2 * (a * b - c * w) * j, (1 - 2 * (a * a + c * c)) * j, 2 * (b * c + a * w) * j, 0,
    2 * (a * c + b * w) * k, 2 * (b * c - a * w) * k, (1 - 2 * (a * a + b * b)) * k, 0,
    x, y, z, 1,
  ];
}

export function determinant3(m) {
  return dot([m[0], m[1], m[2]], cross([m[4], m[5], m[6]], [m[8], m[9], m[10]]));
}

/** The largest factor by which the upper 3 × 3 part of a matrix stretches a vector. */
export function stretch(m) {
  const columns = [[m[0], m[1], m[2]], [m[4], m[5], m[6]], [m[8], m[9], m[10]]];
  const gram = columns.map((a) => columns.map((b) => dot(a, b)));
  // The largest eigenvalue of a symmetric matrix (Smith 1961).
  const mean = (gram[0][0] + gram[1][1] + gram[2][2]) / 3;
  const rest = gram.map((row, i) => row.map((x, j) => (i === j ? x - mean : x)));
  const spread = Math.sqrt(rest.flat().reduce((sum, x) => sum + x * x, 0) / 6);
  if (!(spread > 1e-12 * mean)) return Math.sqrt(mean);
  const [a, b, c] = rest.map((row) => scaled(row, 1 / spread));
  const angle = Math.acos(clamp(dot(a, cross(b, c)) / 2, -1, 1)) / 3;
  return Math.sqrt(mean + 2 * spread * Math.cos(angle));
}

/** The inverse of an affine matrix; of one without an inverse the identity. */
export function inverted(m) {
  const [x, y, z] = [[m[0], m[1], m[2]], [m[4], m[5], m[6]], [m[8], m[9], m[10]]];
  const size = dot(x, cross(y, z));
  if (!size) return IDENTITY;
  const rows = [cross(y, z), cross(z, x), cross(x, y)].map((row) => scaled(row, 1 / size));
  const back = rows.map((row) => -dot(row, [m[12], m[13], m[14]]));
  return [0, 1, 2].flatMap((c) => [rows[0][c], rows[1][c], rows[2][c], 0]).concat(back, 1);
}

/** The view matrix of an eye that looks at a point. */
export function lookAt(eye, target, up) {
  const back = normalized(sub(eye, target));
  const right = normalized(cross(up, back));
  const above = cross(back, right);
  return [
    right[0], above[0], back[0], 0, right[1], above[1], back[1], 0,
    right[2], above[2], back[2], 0, -dot(right, eye), -dot(above, eye), -dot(back, eye), 1,
  ];
}

/** Perspective with depths from -1 to 1, as WebGL wants; `fovy` in radians. */
export function perspective(fovy, aspect, near, far) {
  const f = 1 / Math.tan(fovy / 2);
  const depth = 1 / (near - far);
  return [
    f / aspect, 0, 0, 0, 0, f, 0, 0,
    0, 0, (near + far) * depth, -1, 0, 0, 2 * near * far * depth, 0,
  ];
}

/** Turns depths from -1 to 1, as WebGL wants them, into depths from 0 to 1, as WebGPU does. */
export const WEBGPU_DEPTH = [1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 0.5, 0, 0, 0, 0.5, 1];

/** Between two quaternions along the shorter arc. */
export function slerp(a, b, t) {
  let cosine = dot(a, b);
  const sign = cosine < 0 ? -1 : 1;
  cosine *= sign;
  if (cosine > 0.9995) return normalized(a.map((x, i) => x + (sign * b[i] - x) * t));
  const angle = Math.acos(cosine);
  const [u, v] = [Math.sin((1 - t) * angle), sign * Math.sin(t * angle)];
  return scaled(a.map((x, i) => u * x + v * b[i]), 1 / Math.sin(angle));
}
