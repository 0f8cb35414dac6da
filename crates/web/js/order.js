// An order of triangles in which neighbours follow each other, so that a device's vertex cache is
// of use, and in which every level is still found near the front.

/**
 * Numbers of triangles as they are drawn. Halves stay apart: the first half of the triangles, which
 * live longest, stands before the second, and so on within the first. At every level at most one
 * of these groups is drawn in part.
 */
export function drawingOrder(source, positions) {
  const triangles = source.length / 3;
  const code = curve(positions);
  const order = new Uint32Array(triangles);
  let end = triangles;
  while (end > 0) {
    const start = end > 256 ? end >>> 1 : 0;
    // A sort of floats is the fastest that there is: 30 bits of the curve, 23 of the triangle.
    const keys = new Float64Array(end - start);
    for (let t = start; t < end; t++) {
      keys[t - start] = code(source[3 * t]) * 2 ** 23 + (t - start) % 2 ** 23;
    }
    keys.sort();
    for (let t = start; t < end; t++) order[t] = start + (keys[t - start] % 2 ** 23);
    end = start;
  }
  return order;
}

/** The place of a vertex on a curve through the bounding box (Morton 1966): 10 bits an axis. */
function curve(positions) {
  const low = [Infinity, Infinity, Infinity];
  const high = [-Infinity, -Infinity, -Infinity];
  for (let i = 0; i < positions.length; i++) {
    low[i % 3] = Math.min(low[i % 3], positions[i]);
    high[i % 3] = Math.max(high[i % 3], positions[i]);
  }
  const scale = 1023 / Math.max(high[0] - low[0], high[1] - low[1], high[2] - low[2], 1e-30);
  const spread = (x) => {
    let bits = (x | (x << 16)) & 0x030000ff;
    bits = (bits | (bits << 8)) & 0x0300f00f;
    bits = (bits | (bits << 4)) & 0x030c30c3;
    return (bits | (bits << 2)) & 0x09249249;
  };
  const axis = (v, i) => spread(Math.floor((positions[3 * v + i] - low[i]) * scale));
  return (v) => axis(v, 0) | (axis(v, 1) << 1) | (axis(v, 2) << 2);
}
