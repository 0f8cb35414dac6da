// Levels as a glTF of `lodc chain` holds them, shown as an engine shows them: one at a time, on its
// way to the next one where levels morph.

import { ChainLevels, TARGET } from '../../../../crates/web/js/chainlevels.js';
import { completeNormals, vertexArrays } from '../../../../crates/web/js/geometry.js';
import { Levels } from '../../../../crates/web/js/levels.js';
import { Scene } from '../../../../crates/web/js/scene.js';
import { pixelSize } from '../../../../crates/web/js/selection.js';
import { Controls, length3 } from './controls.js';
import { Viewer } from './viewer.js';

/** Whether a GLB holds levels as they were exported, not all of them as pages do. */
export function isExported({ json }) {
  return !(json.meshes ?? []).some((mesh) => mesh.extras?.lodc?.records !== undefined);
}

/** Triangles that are there at one level and at no other. */
class LevelPart {
  constructor(indices, level) {
    Object.assign(this, { indices, level, numbers: [], lod: -1, triangles: 0 });
  }

  seek(level) {
    this.lod = level;
    this.triangles = level === this.level || this.level === null ? this.indices.length / 3 : 0;
  }

  drawn() {
    return Array.from({ length: this.triangles }, (_, t) => t);
  }
}

/** The scene of such a file. */
export class ExportedScene extends Scene {
  constructor(glb) {
    const stated = glb.json.extras?.lodc ?? {};
    const levels = stated.levels ?? [stated];
    super(glb, shippedObjects(glb, levels));
    Object.assign(this, { stated, chain: levels, weight: 0 });
    const { low, high } = this.bounds();
    const diagonal = Math.hypot(...high.map((h, i) => h - low[i]));
    for (const object of this.objects) if (object) object.levels.diagonal = diagonal;
  }

  placements() {
    return super.placements().map((placed) => {
      const { next } = placed.object;
      if (next === undefined) return placed;
      const weights = Array.from({ length: next + 1 }, (_, i) => placed.weights[i] ?? 0);
      weights[next] = this.weight;
      return { ...placed, weights };
    });
  }
}

/** Objects by the meshes of level 0; null for those of other levels. */
function shippedObjects(glb, stated) {
  const { meshes = [], nodes = [] } = glb.json;
  const all = meshes.map(() => null);
  const coarser = new Set(nodes.flatMap((node) => node.extensions?.MSFT_lod?.ids ?? []));
  nodes.forEach((node, number) => {
    if (node.mesh === undefined || coarser.has(number)) return;
    const ids = node.extensions?.MSFT_lod?.ids ?? [];
    all[node.mesh] ??= shippedObject(glb, [node, ...ids.map((id) => nodes[id])], stated);
  });
  return all;
}

function shippedObject(glb, nodes, stated) {
  const meshes = nodes.map((node) => glb.json.meshes[node.mesh]);
  // A mesh without levels is there at all of them.
  const levelOf = (k) => (meshes.length > 1 || stated.length === 1 ? k : null);
  const triangles = (p) => (p.mode ?? 4) === 4 && p.attributes.POSITION !== undefined;
  const parts = meshes.flatMap((mesh, k) => mesh.primitives.filter(triangles).flatMap((p) => {
    const ranges = p.extras?.lodc?.levels;
    const indices = p.indices === undefined
      ? Uint32Array.from({ length: glb.json.accessors[p.attributes.POSITION].count }, (_, i) => i)
      : glb.words(p.indices);
    if (!ranges) return { ...vertexArrays(glb, p), submesh: new LevelPart(indices, levelOf(k)) };
    return ranges.map(({ first, count }, level) => ({
      ...vertexArrays(glb, p),
      submesh: new LevelPart(indices.slice(first, first + count), level),
    }));
  }));
  if (parts.length === 0) return null;
  parts.forEach((part) => Object.assign(part, { strips: null }));
  const submeshes = parts.map((part) => part.submesh);
  const count = (level) => {
    submeshes.forEach((part) => part.seek(level));
    return submeshes.reduce((sum, part) => sum + part.triangles, 0);
  };
  const coarser = stated.slice(1).map((_, k) => k + 1);
  const counts = coarser.map(count);
  const levels = new Levels({
    records: coarser.length,
    triangles: count(0),
    ends: coarser,
    counts,
    errors: stated.slice(1).map((level) => level.error ?? Infinity),
    scale: 1,
    submeshes,
  });
  for (const level of [0, ...coarser]) {
    count(level);
    completeNormals(parts.filter((part) => part.submesh.triangles > 0));
  }
  count(0);
  const next = meshes[0].extras?.targetNames?.indexOf(TARGET) ?? -1;
  const weights = meshes[0].weights ?? [];
  const name = meshes[0].name ?? '';
  return { name, parts, levels, weights, next: next < 0 ? undefined : next };
}

/** The distances of levels: as stated, or those at which their errors are a pixel. */
function distances(scene) {
  const pixel = pixelSize(Math.PI / 3, 1080);
  const levels = scene.chain.map((level) => ({ distance: level.error / pixel, ...level }));
  return levels.length > 1 ? new ChainLevels({ extras: { lodc: { levels } } }) : null;
}

export class ExportedViewer extends Viewer {
  constructor(canvas, scene, renderer) {
    super(canvas, scene, renderer);
    this.by = 'level';
    this.morphs = true;
    this.chain = distances(scene);
    /** Places of the slider: levels, and the way behind the last one if it morphs to a file. */
    this.places = scene.chain.length - 1 + (scene.stated.next ? 1 : 0);
    const farthest = scene.chain.at(-1).distance ?? this.chain?.levels.at(-1).distance ?? 1;
    const first = this.chain?.levels[1].distance ?? farthest;
    this.span = [4 * farthest, Math.max(first, farthest / 1e4) / 4];
  }

  /** The distance that the slider stands for, in the units of the file. */
  distance() {
    const [far, near] = this.span;
    return far * (near / far) ** this.share;
  }

  lods() {
    const { asked, selection } = this;
    const level = this.level ?? 0;
    let shown;
    if (asked?.lod !== undefined) {
      const whole = Math.min(Math.floor(asked.lod), this.scene.chain.length - 1);
      shown = { level: whole, weight: Math.min(asked.lod - whole, 1) };
    } else if (asked) shown = { level: Math.max(...super.lods()), weight: 0 };
    else if (this.by === 'distance') shown = this.chain.at(this.distance(), level);
    else {
      const place = (1 - this.share) * this.places;
      const whole = Math.min(this.morphs ? Math.floor(place) : Math.round(place),
        this.scene.chain.length - 1);
      shown = { level: whole, weight: this.morphs ? place - whole : 0 };
    }
    this.level = Math.min(shown.level, this.scene.chain.length - 1);
    this.scene.weight = this.morphs && this.copies === 1 ? shown.weight : 0;
    return selection.byLod(this.level);
  }

  shareShown() {
    return this.places > 0 ? 1 - (this.level + this.scene.weight) / this.places : 1;
  }

  /** A level is shown as it is, however long that takes. */
  sparing(now, since, whole) {
    this.drawn = whole;
    return { triangles: whole, more: false };
  }
}

export class ExportedControls extends Controls {
  constructor(viewer) {
    const by = document.querySelector('footer .segments');
    const choices = viewer.chain ? ['Level', 'Distance'] : ['Level'];
    by.replaceChildren(...choices.map((text, i) => choice('by', text, i === 0)));
    const morphs = viewer.scene.objects.some((object) => object?.next !== undefined);
    super(viewer);
    for (const name of ['error', 'strips']) {
      document.querySelector(`input[value="${name}"]`).parentElement.hidden = true;
    }
    viewer.set({ morphs });
    const { box, row } = toggle('Geomorph', morphs);
    row.hidden = !morphs;
    box.addEventListener('change', () => viewer.set({ morphs: box.checked }));
    document.getElementById('turntable').closest('section').append(row);
  }

  /** Addresses name levels, as those of other pages do; a crowd has its levels by distance. */
  by(name) {
    const known = { triangles: 'level', pixels: this.viewer.chain ? 'distance' : 'level' };
    super.by(known[name] ?? name);
  }

  texts({ triangles, drawn, error, percent }) {
    const { viewer } = this;
    const { selection, scene, level } = viewer;
    const last = scene.chain.length - 1;
    const next = level < last ? `level ${level + 1}` : scene.stated.next;
    const way = scene.weight > 0 ? `, ${percent(scene.weight)} on its way to ${next}` : '';
    const away = length3(viewer.distance());
    const value = viewer.by === 'distance' && !viewer.asked
      ? `${away} away: level ${level}${way}` : `level ${level} of ${last}${way}`;
    const whole = selection.triangles * viewer.copies;
    const { distance } = viewer.chain?.levels[level] ?? scene.chain[level];
    const rows = [
      ['Triangles', Math.round(drawn).toLocaleString('en')],
      ['Share', percent(drawn / Math.max(1, whole))],
      ['Error', `${length3(error)} (${percent(error / (selection.diagonal || 1))} of the size)`],
      ['From', distance === undefined ? '–' : `${length3(distance)} away`],
    ];
    Object.assign(document.documentElement.dataset, {
      level, weight: scene.weight.toFixed(3), whole: triangles,
    });
    return { value, rows };
  }

  describe() {
    const { selection, scene } = this.viewer;
    const count = (n, word) => `${n.toLocaleString('en')} ${word}${n === 1 ? '' : 's'}`;
    const levels = count(scene.chain.length, 'level');
    return `${count(selection.triangles, 'triangle')} · ${levels} as exported`;
  }
}

function choice(name, text, checked) {
  const label = document.createElement('label');
  const value = text.toLowerCase();
  const input = Object.assign(document.createElement('input'), {
    type: 'radio', name, value, checked,
  });
  label.append(input, Object.assign(document.createElement('span'), { textContent: text }));
  return label;
}

function toggle(text, checked) {
  const row = Object.assign(document.createElement('label'), { className: 'switch' });
  const box = Object.assign(document.createElement('input'), { type: 'checkbox', checked });
  box.id = 'geomorph';
  row.append(Object.assign(document.createElement('span'), { textContent: text }), box);
  return { box, row };
}
