// Controls of the page, its keys, and the address part that names a level.

import { FIRST } from './viewer.js';

const element = (id) => document.getElementById(id);
const grouped = (n) => Math.round(n).toLocaleString('en');

/** A length with three digits. */
export function length3(x) {
  if (!Number.isFinite(x)) return '–';
  if (x === 0) return '0';
  return x >= 1e5 || x < 1e-4 ? x.toExponential(2) : String(Number(x.toPrecision(3)));
}

/** The level that an address asks for: `#lod=K`, `#triangles=N`, `#error=E`; else null. */
export function asked(hash) {
  const found = /^#(lod|triangles|error)=([0-9.eE+-]+)$/.exec(hash);
  const value = found ? Number(found[2]) : NaN;
  return Number.isFinite(value) && value >= 0 ? { [found[1]]: value } : null;
}

export class Controls {
  constructor(viewer) {
    this.viewer = viewer;
    this.level = element('level');
    this.bindLevel();
    this.bindOptions();
    this.bindAnimations();
    this.bindKeys();
    element('summary').textContent = this.describe();
    viewer.onframe = (shown) => this.show(shown);
    window.addEventListener('hashchange', () => this.follow());
    this.follow();
  }

  /** Shows the level that the address asks for. */
  follow() {
    const level = asked(location.hash);
    this.viewer.set({ asked: level });
    if (level) this.by('triangles');
    delete document.documentElement.dataset.ready;
  }

  by(name) {
    document.querySelector(`input[name="by"][value="${name}"]`).checked = true;
    this.viewer.set({ by: name });
  }

  bindLevel() {
    const { viewer, level } = this;
    level.addEventListener('input', () => this.slide(Number(level.value)));
    for (const radio of document.querySelectorAll('input[name="by"]')) {
      radio.addEventListener('change', () => {
        this.release();
        viewer.set({ by: radio.value, asked: null });
      });
    }
  }

  /** Moves the slider. */
  slide(share) {
    this.release();
    this.viewer.set({ share: Math.min(Math.max(share, 0), 1), asked: null });
  }

  /** The address no longer names what is shown. */
  release() {
    if (location.hash) history.replaceState(null, '', location.pathname + location.search);
  }

  bindOptions() {
    const { viewer } = this;
    for (const name of ['wire', 'flat', 'turntable']) {
      const box = element(name);
      box.addEventListener('change', () => viewer.set({ [name]: box.checked }));
    }
    const parts = viewer.scene.objects.flatMap((object) => object?.parts ?? []);
    const strips = document.querySelector('input[value="strips"]');
    strips.disabled = !parts.some((part) => part.strips);
    strips.parentElement.title = strips.disabled
      ? 'The file has no model that is made of strips' : '';
    for (const radio of document.querySelectorAll('input[name="colouring"]')) {
      radio.addEventListener('change', () => {
        element('legend').hidden = radio.value !== 'error';
        viewer.set({ colouring: radio.value });
      });
    }
    for (const radio of document.querySelectorAll('input[name="up"]')) {
      radio.addEventListener('change', () => this.stand(radio.value));
    }
    this.stand(viewer.scene.up);
    const crowd = element('crowd');
    crowd.addEventListener('input', () => {
      const copies = Math.round(2000 ** Number(crowd.value));
      crowd.style.setProperty('--fill', `${100 * crowd.value}%`);
      element('crowdcount').textContent = copies > 1 ? `${grouped(copies)} copies` : 'off';
      // A crowd is chosen by pixels: one at first.
      if (copies > 1 && viewer.by !== 'pixels') {
        this.by('pixels');
        this.slide(viewer.shareOfPixels(1));
      }
      viewer.set({ copies });
    });
    element('theme').addEventListener('click', () => this.theme());
    const system = matchMedia('(prefers-color-scheme: dark)');
    system.addEventListener('change', () => viewer.invalidate());
    element('look').addEventListener('click', () => this.toggleOptions());
    if (window.innerWidth > 1100) this.toggleOptions();
  }

  /** Switches that need WebGPU. */
  bindViews() {
    const { viewer } = this;
    element('viewing').hidden = false;
    for (const [id, name] of [['byview', 'byView'], ['morph', 'morph']]) {
      const box = element(id);
      box.addEventListener('change', () => {
        if (box.checked && viewer.by !== 'pixels') {
          this.by('pixels');
          this.slide(viewer.shareOfPixels(1));
        }
        if (name === 'morph' && box.checked && !viewer.byView) element('byview').click();
        viewer.set({ [name]: box.checked, asked: null });
      });
    }
  }

  toggleOptions() {
    const open = element('options').toggleAttribute('data-open');
    element('look').setAttribute('aria-expanded', String(open));
    // What is seen has room beside the panel.
    this.viewer.resize();
  }

  /** Stands the model on another axis. */
  stand(up) {
    const { viewer } = this;
    document.querySelector(`input[name="up"][value="${up}"]`).checked = true;
    if (viewer.scene.up !== up) viewer.stand(up);
  }

  theme() {
    const root = document.documentElement;
    const dark = getComputedStyle(root).colorScheme === 'dark';
    root.dataset.theme = dark ? 'light' : 'dark';
    this.viewer.invalidate();
  }

  bindAnimations() {
    const { viewer } = this;
    const { animations } = viewer.scene;
    if (animations.length === 0) return;
    element('animating').hidden = false;
    const select = element('animation');
    animations.forEach(({ name }, i) => select.add(new Option(name, i)));
    const play = (on) => {
      element('play').textContent = on ? '❚❚' : '▶';
      viewer.set({ animation: on ? animations[select.value] : null });
    };
    element('play').addEventListener('click', () => play(!viewer.animation));
    select.addEventListener('change', () => {
      viewer.set({ seconds: 0 });
      play(true);
    });
  }

  bindKeys() {
    const boxes = { w: 'wire', f: 'flat', r: 'turntable' };
    window.addEventListener('keydown', (event) => {
      if (event.ctrlKey || event.metaKey || event.altKey) return;
      const key = event.key.toLowerCase();
      if (boxes[key]) element(boxes[key]).click();
      else if (key === 't') this.theme();
      else if (key === 'o') this.toggleOptions();
      else if (key === 'u') this.stand(this.viewer.scene.up === 'z' ? 'y' : 'z');
      else if (key === '[') this.slide(this.viewer.share - 0.02);
      else if (key === ']') this.slide(this.viewer.share + 0.02);
    });
  }

  /** What the slider stands for, and facts of a frame: rows of a name and a text. */
  texts({ lods, triangles, drawn, error, allowed, percent }) {
    const { viewer } = this;
    const { selection } = viewer;
    const value = {
      triangles: `${grouped(triangles)} triangles`,
      error: `error ≤ ${length3(viewer.asked ? error : allowed)}`,
      pixels: `error ≤ ${length3(viewer.allowedPixels())} px`,
    }[viewer.by];
    const rows = [
      ['Triangles', grouped(drawn)],
      ['Share', percent(drawn / Math.max(1, viewer.copies * selection.triangles))],
      ['Error', `${length3(error)} (${percent(error / (selection.diagonal || 1))} of the size)`],
      lods.length === 1 ? ['LOD', grouped(lods[0])] : ['Objects', grouped(lods.length)],
    ];
    return { value, rows };
  }

  /** The line below the name of the model. */
  describe() {
    return summary(this.viewer);
  }

  /** Tells what a frame has shown, to people and to programs. */
  show({ lods, triangles: uniform, sparing, error, crowd, views }) {
    const { viewer } = this;
    const { selection } = viewer;
    const allowed = viewer.allowedError();
    if (viewer.asked) viewer.share = viewer.shareShown(uniform);
    this.level.value = viewer.share;
    this.level.style.setProperty('--fill', `${100 * viewer.share}%`);
    const percent = (share) => `${Number((100 * share).toPrecision(3))} %`;
    const one = lods.length === 1;
    const triangles = views ?? uniform;
    const drawn = crowd ? crowd.triangles : sparing ?? triangles;
    const shown = { lods, triangles, drawn, error, allowed, percent };
    const { value, rows } = this.texts(shown);
    element('value').textContent = value;
    this.level.setAttribute('aria-valuetext', `${value}, ${rows[1][1]} of all`);
    if (sparing) rows[0][1] += ' while moving';
    if (views) rows[3] = ['Levels', 'by view'];
    if (crowd) rows[2] = ['Without levels', grouped(viewer.copies * selection.triangles)];
    element('facts').replaceChildren(...rows.map(([name, text]) => {
      const row = document.createElement('div');
      row.append(Object.assign(document.createElement('dt'), { textContent: name }));
      row.append(Object.assign(document.createElement('dd'), { textContent: text }));
      return row;
    }));
    const page = document.documentElement.dataset;
    // The first frames are waited for, so that a picture taken of the page shows one.
    if (!page.ready || viewer.frames < FIRST) viewer.renderer.finish();
    Object.assign(page, {
      ready: 'true',
      lod: one ? lods[0] : viewer.asked?.lod ?? '',
      lods: lods.join(' '),
      triangles,
      drawn,
      backend: 'webgl2',
      milliseconds: viewer.frameTime.toFixed(1),
    });
  }
}

function summary({ selection, scene }) {
  const count = (n, word) => `${grouped(n)} ${word}${n === 1 ? '' : 's'}`;
  const parts = [count(selection.triangles, 'triangle')];
  if (selection.all.length > 1) parts.push(count(selection.all.length, 'object'));
  const steps = selection.all.reduce((sum, o) => sum + o.ends.length, 0);
  parts.push(count(steps + selection.all.length, 'level'));
  const images = scene.glb.json.images ?? [];
  const textures = images.filter((i) => i.bufferView !== undefined).length;
  if (textures > 0) parts.push(count(textures, 'image'));
  return parts.join(' · ');
}
