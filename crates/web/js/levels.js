// Continuous level of detail of one object: a triangle list of any LOD from the collapse sequence.
//
// Vertices stand in reverse order of their disappearance and triangles in reverse order of their
// removal, so that at every LOD those alive are the first ones. Source: Interactive Meshes.

/** First index in `values[0..length)` for which `holds` is true; it stays true behind it. */
export function partition(length, holds) {
  let low = 0;
  let high = length;
  while (low < high) {
    const middle = (low + high) >>> 1;
    if (holds(middle)) high = middle;
    else low = middle + 1;
  }
  return low;
}

/** The part of an object with one material, and its triangles at the present LOD. */
export class Submesh {
  /**
   * All arrays are `Uint32Array`s.
   * @param source three vertices for each triangle of LOD 0
   * @param numbers number of each vertex in the collapse order, falling
   * @param targets the earlier vertex that each vertex becomes
   * @param removals LOD at which each triangle goes, not rising
   * @param order triangles as they are drawn (`order.js`); as they stand without it
   */
  constructor({ source, numbers, targets, removals, order = null }) {
    Object.assign(this, { numbers, targets, removals, order });
    this.source = order ? permuted(source, order, 3) : source;
    this.gone = order ? permuted(removals, order, 1) : removals;
    this.shown = new Uint32Array(numbers.length);
    this.indices = this.source.slice();
    this.lod = 0;
    this.vertices = numbers.length;
    this.triangles = removals.length;
  }

  /** Makes `indices[0 .. 3 * triangles)` the triangles at a LOD. Linear in what is drawn. */
  seek(lod) {
    const { source, numbers, targets, removals, shown, indices } = this;
    const live = partition(numbers.length, (v) => numbers[v] < lod);
    this.vertices = live;
    this.triangles = partition(removals.length, (t) => removals[t] <= lod);
    this.lod = lod;
    for (let v = 0; v < live; v++) shown[v] = v;
    // A target stands earlier, so it is resolved already.
    for (let v = live; v < shown.length; v++) shown[v] = shown[targets[v]];
    let to = 0;
    for (let t = 0; to < 3 * this.triangles; t++) {
      if (this.gone[t] <= lod) continue;
      indices[to] = shown[source[3 * t]];
      indices[to + 1] = shown[source[3 * t + 1]];
      indices[to + 2] = shown[source[3 * t + 2]];
      to += 3;
    }
  }

  /** The numbers of the triangles that are drawn, in the order of the file. */
  drawn() {
    const live = Array.from(this.gone.keys()).filter((t) => this.gone[t] > this.lod);
    return this.order ? live.map((t) => this.order[t]) : live;
  }
}

/** Rows of `width` words in another order. */
function permuted(words, order, width) {
  const out = new Uint32Array(words.length);
  for (let row = 0; row < order.length; row++) {
    for (let i = 0; i < width; i++) out[row * width + i] = words[order[row] * width + i];
  }
  return out;
}

/** The levels of an object: steps with their ends, triangles and errors, fine to coarse. */
export class Levels {
  /**
   * @param ranks `places` in the order over the objects of a scene where this one gives up
   *   triangles, and its `lods` after each; none for a single object
   */
  constructor({ records, triangles, ends, counts, errors, scale, diagonal, submeshes, ranks }) {
    Object.assign(this, { records, triangles, ends, counts, errors, scale, diagonal, submeshes });
    this.ranks = ranks ?? null;
    this.lod = 0;
  }

  /** The number of complete steps at a LOD. */
  steps(lod) {
    return partition(this.ends.length, (s) => this.ends[s] > lod);
  }

  /** The LOD rounded down to the end of a step. */
  shown(lod) {
    const steps = this.steps(Math.min(lod, this.records));
    return steps === 0 ? 0 : this.ends[steps - 1];
  }

  trianglesAt(lod) {
    const steps = this.steps(lod);
    return steps === 0 ? this.triangles : this.counts[steps - 1];
  }

  /** Upper bound of the distance from LOD 0, in the object's units. */
  errorAt(lod) {
    const steps = this.steps(lod);
    if (steps === 0) return 0;
    return this.counts[steps - 1] === 0 && this.triangles > 0 ? Infinity : this.errors[steps - 1];
  }

  /** The coarsest LOD that still has a triangle. */
  lastVisible() {
    const steps = partition(this.counts.length, (s) => this.counts[s] === 0);
    return steps === 0 ? 0 : this.ends[steps - 1];
  }

  /** The finest LOD with at most `most` triangles. */
  forTriangles(most) {
    if (this.triangles <= most) return 0;
    const step = partition(this.counts.length, (s) => this.counts[s] <= most);
    return step < this.ends.length ? this.ends[step] : this.records;
  }

  /** The coarsest LOD with triangles whose error is at most `error`, in the object's units. */
  forError(error) {
    const steps = partition(this.errors.length, (s) => this.errors[s] > error);
    return Math.min(steps === 0 ? 0 : this.ends[steps - 1], this.lastVisible());
  }

  /** Shows a LOD, rounded down to a step. Returns whether anything has changed. */
  seek(lod) {
    const wanted = this.shown(lod);
    if (wanted === this.lod) return false;
    for (const submesh of this.submeshes) submesh.seek(wanted);
    this.lod = wanted;
    return true;
  }
}
