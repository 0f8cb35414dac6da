// Smooth normals of LOD 0 for files without normals: means by angle over all faces at a position.

/** A normal for each vertex of each part of one object. */
export function smoothNormals(parts) {
  const places = numbered(parts);
  const sums = new Float64Array(3 * places.count);
  parts.forEach(({ positions, submesh: { source } }, p) => {
    for (let t = 0; t < source.length; t += 3) addFace(sums, positions, source, t, places.of[p]);
  });
  return parts.map(({ positions }, p) => {
    const normals = new Float32Array(positions.length);
    for (let v = 0; v < normals.length / 3; v++) {
      const at = 3 * places.of[p][v];
      const size = Math.hypot(sums[at], sums[at + 1], sums[at + 2]);
      for (let i = 0; i < 3; i++) normals[3 * v + i] = size > 0 ? sums[at + i] / size : +(i === 1);
    }
    return normals;
  });
}

/** Share of corners whose face turns more than 32 degrees away from the vertex normal. */
export function edginess(parts, normals) {
  let [corners, turned] = [0, 0];
  parts.forEach(({ positions, submesh: { source } }, p) => {
    for (let t = 0; t < source.length; t += 3) {
      const { normal } = face(positions, source, t);
      if (!normal) continue;
      for (let k = 0; k < 3; k++) {
        const v = 3 * source[t + k];
        const of = normals[p];
        const cosine = normal[0] * of[v] + normal[1] * of[v + 1] + normal[2] * of[v + 2];
        corners += 1;
        turned += cosine < 0.848;
      }
    }
  });
  return turned / Math.max(corners, 1);
}

/** The unit edges of a face and its unit normal; no normal without an area. */
function face(positions, source, t) {
  const corner = (k) => {
    const v = 3 * source[t + (k % 3)];
    return [positions[v], positions[v + 1], positions[v + 2]];
  };
  const edge = (from) => {
    const [a, b] = [corner(from), corner(from + 1)];
    const e = [b[0] - a[0], b[1] - a[1], b[2] - a[2]];
    const size = Math.hypot(e[0], e[1], e[2]) || 1;
    return [e[0] / size, e[1] / size, e[2] / size];
  };
  const edges = [edge(0), edge(1), edge(2)];
  const [a, b] = edges;
  const n = [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]];
  const size = Math.hypot(n[0], n[1], n[2]);
  return { edges, normal: size > 0 ? n.map((c) => c / size) : null };
}

/** Adds a face's unit normal to its three corners, each weighted by the angle there. */
function addFace(sums, positions, source, t, place) {
  const { edges, normal } = face(positions, source, t);
  if (!normal) return;
  for (let k = 0; k < 3; k++) {
    const [u, v] = [edges[k], edges[(k + 2) % 3]];
    const cosine = -(u[0] * v[0] + u[1] * v[1] + u[2] * v[2]);
    const angle = Math.acos(Math.min(Math.max(cosine, -1), 1));
    const at = 3 * place[source[t + k]];
    for (let i = 0; i < 3; i++) sums[at + i] += angle * normal[i];
  }
}

/** Numbers positions over all parts of an object; equal ones have one number. */
function numbered(parts) {
  const vertices = parts.reduce((sum, { positions }) => sum + positions.length / 3, 0);
  const size = 1 << Math.ceil(Math.log2(2 * vertices + 2));
  const table = new Int32Array(size).fill(-1);
  const known = new Float32Array(3 * vertices);
  const bits = new Uint32Array(known.buffer);
  let count = 0;
  const of = parts.map(({ positions }) => {
    const place = new Uint32Array(positions.length / 3);
    for (let v = 0; v < place.length; v++) {
      // Adding zero makes -0 a 0.
      for (let i = 0; i < 3; i++) known[3 * count + i] = positions[3 * v + i] + 0;
      const [x, y, z] = [bits[3 * count], bits[3 * count + 1], bits[3 * count + 2]];
      let slot = Math.imul(x, 73856093) ^ Math.imul(y, 19349663) ^ Math.imul(z, 83492791);
      slot = (slot ^ (slot >>> 15)) & (size - 1);
      const differs = (p) => bits[3 * p] !== x || bits[3 * p + 1] !== y || bits[3 * p + 2] !== z;
      while (table[slot] >= 0 && differs(table[slot])) slot = (slot + 1) & (size - 1);
      if (table[slot] < 0) table[slot] = count++;
      place[v] = table[slot];
    }
    return place;
  });
  return { of, count };
}
