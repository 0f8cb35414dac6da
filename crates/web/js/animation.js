// Animations of glTF: node transforms and morph weights at a moment (glTF 2.0, 3.11).

import { normalized, slerp } from './math.js';

/** The animations of a document as `{ name, seconds, channels }`. */
export function animations(glb) {
  return (glb.json.animations ?? []).map((animation, number) => {
    const channels = animation.channels
      .filter(({ target }) => target.node !== undefined)
      .map(({ sampler, target }) => {
        const { input, output, interpolation = 'LINEAR' } = animation.samplers[sampler];
        const times = glb.floats(input);
        const values = glb.floats(output);
        const knots = interpolation === 'CUBICSPLINE' ? 3 * times.length : times.length;
        const width = values.length / knots;
        return { node: target.node, path: target.path, times, values, interpolation, width };
      });
    const seconds = channels.reduce((most, { times }) => Math.max(most, times.at(-1) ?? 0), 0);
    return { name: animation.name || `Animation ${number + 1}`, seconds, channels };
  });
}

/** The value of a channel at a time, held before its first and after its last key. */
export function sampled({ path, times, values, interpolation, width }, seconds) {
  const cubic = interpolation === 'CUBICSPLINE';
  const key = (k, part = 1) => {
    const at = (cubic ? 3 * k + part : k) * width;
    return Array.from(values.subarray(at, at + width));
  };
  let next = 0;
  while (next < times.length && times[next] <= seconds) next++;
  if (next === 0) return key(0);
  if (next === times.length) return key(next - 1);
  const span = times[next] - times[next - 1];
  const t = (seconds - times[next - 1]) / span;
  if (interpolation === 'STEP') return key(next - 1);
  const [a, b] = [key(next - 1), key(next)];
  if (!cubic) {
    return path === 'rotation' ? slerp(a, b, t) : a.map((x, i) => x + (b[i] - x) * t);
  }
  const [out, into] = [key(next - 1, 2), key(next, 0)];
  const [t2, t3] = [t * t, t * t * t];
  const value = a.map((x, i) => (
    (2 * t3 - 3 * t2 + 1) * x + span * (t3 - 2 * t2 + t) * out[i]
    + (3 * t2 - 2 * t3) * b[i] + span * (t3 - t2) * into[i]));
  return path === 'rotation' ? normalized(value) : value;
}
