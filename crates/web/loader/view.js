// `<lodc-view src="chair.lods" alt="A chair">`: a model in a page that writes no three.js.

import { LodcLoader } from './loader.js';
import { Stage } from './stage.js';

const STYLE = `
:host { display: block; position: relative; aspect-ratio: 4 / 3; overflow: hidden; }
:host([hidden]), [hidden] { display: none !important; }
canvas, img { position: absolute; inset: 0; width: 100%; height: 100%; }
canvas:focus-visible { outline: 2px solid currentColor; outline-offset: -2px; }
img { object-fit: contain; pointer-events: none; }
p { position: absolute; inset: auto 0 0; margin: 0; padding: 0.5em 0.75em; max-height: 100%;
  box-sizing: border-box; overflow: auto; font: 14px/1.4 system-ui, sans-serif;
  overflow-wrap: anywhere; color: #8a1010; background: #fff; }
`;
/** Attributes with properties of the same name: text, numbers, those that are there or not. */
const TEXTS = ['src', 'alt', 'poster', 'up', 'animation'];
const NUMBERS = ['level', 'pixels'];
const FLAGS = ['autoplay'];

/** The number that an attribute says, if it says one. */
function numberOr(other, value) {
  const number = Number.parseFloat(value);
  return Number.isNaN(number) ? other : number;
}

/** The element. Events: `load` with the first picture, `complete`, `error`. */
export class LodcView extends (globalThis.HTMLElement ?? Object) {
  static observedAttributes = [...TEXTS, ...NUMBERS, ...FLAGS];

  constructor() {
    super();
    /** The model that is shown. */
    this.model = null;
    const root = this.attachShadow({ mode: 'open', delegatesFocus: true });
    const style = new CSSStyleSheet();
    style.replaceSync(STYLE);
    root.adoptedStyleSheets = [style];
    this.canvas = Object.assign(document.createElement('canvas'), { role: 'img', tabIndex: 0 });
    this.image = Object.assign(document.createElement('img'), { alt: '', hidden: true });
    this.told = Object.assign(document.createElement('p'), { role: 'alert', hidden: true });
    root.append(this.canvas, this.image, this.told);
    this.follow('alt');
  }

  connectedCallback() {
    // What a script set before the element was defined hides its properties.
    for (const name of LodcView.observedAttributes) {
      if (!Object.hasOwn(this, name)) continue;
      const value = this[name];
      delete this[name];
      this[name] = value;
    }
    this.change();
  }

  disconnectedCallback() {
    this.change();
  }

  attributeChangedCallback(name) {
    if (name !== 'src') {
      this.follow(name);
      return;
    }
    // The same address again is loaded again.
    this.source = undefined;
    this.change();
  }

  /** Whether an animation runs. */
  get paused() {
    return !this.stage?.playing;
  }

  /** Plays the animation that `animation` names, or the first one, over and over. */
  play() {
    this.wants = true;
    const clips = this.model?.animations ?? [];
    const { animation } = this;
    const clip = clips.find(({ name }) => name === animation) ?? (animation ? null : clips[0]);
    this.stage?.play(clip ?? null);
  }

  /** Stops where it is. */
  pause() {
    this.wants = false;
    this.stage?.pause();
  }

  /** Loads or frees when the page's script has done what it does: an element may only move. */
  change() {
    this.changing ??= Promise.resolve().then(() => {
      this.changing = null;
      const source = this.isConnected ? this.getAttribute('src') : null;
      if (source !== this.source) {
        this.clear();
        this.source = source;
        if (source) this.load(source);
      }
      if (!this.isConnected) {
        this.stage?.dispose();
        this.stage = null;
      }
    });
  }

  clear() {
    this.abort?.abort();
    this.stage?.show(null);
    this.model?.dispose();
    this.model = null;
    this.told.hidden = true;
    this.follow('poster');
  }

  async load(source) {
    this.abort = new AbortController();
    const { signal } = this.abort;
    try {
      this.stage ??= new Stage(this, this.canvas);
      this.wants = this.autoplay && !matchMedia('(prefers-reduced-motion: reduce)').matches;
      const model = await LodcLoader.load(source, { signal });
      if (signal.aborted) {
        model.dispose();
        return;
      }
      this.show(model);
      await model.whenComplete;
      this.dispatchEvent(new Event('complete'));
    } catch (error) {
      if (signal.aborted) return;
      this.told.textContent = error.message;
      this.told.hidden = false;
      this.dispatchEvent(new ErrorEvent('error', { error, message: error.message }));
    }
  }

  show(model) {
    this.model = model;
    for (const name of ['level', 'pixels', 'up']) this.follow(name);
    this.stage.show(model);
    this.follow('animation');
    for (const type of ['grown', 'complete']) {
      model.addEventListener(type, () => this.stage?.draw());
    }
    model.addEventListener('animations', () => this.follow('animation'));
    this.stage.render();
    this.image.hidden = true;
    this.dispatchEvent(new Event('load'));
  }

  /** Does what an attribute says. */
  follow(name) {
    const { model, stage, image } = this;
    const value = this.getAttribute(name);
    if (name === 'poster') {
      image.hidden = value === null || model !== null;
      if (value !== null && image.getAttribute('src') !== value) image.src = value;
    }
    if (name === 'alt') this.canvas.setAttribute('aria-label', value ?? '3D model');
    if (!model) return;
    if (name === 'level') model.level = numberOr(null, value);
    if (name === 'pixels') model.pixels = numberOr(1, value);
    if (name === 'up') {
      model.rotation.x = value?.toLowerCase() === 'z' ? -Math.PI / 2 : 0;
      if (model.parent) stage.frame(model);
    }
    if (name === 'autoplay' && value !== null) this.play();
    if (name === 'animation' && this.wants) this.play();
    stage.draw();
  }
}

/** A property that is its attribute: `read` of its text, null and undefined take it away. */
function reflect(name, read, write = String) {
  Object.defineProperty(LodcView.prototype, name, {
    configurable: true,
    enumerable: true,
    get() {
      return read(this.getAttribute(name));
    },
    set(value) {
      const text = value === null || value === undefined ? null : write(value);
      if (text === null) this.removeAttribute(name);
      else this.setAttribute(name, text);
    },
  });
}
for (const name of TEXTS) reflect(name, (text) => text ?? '');
for (const name of NUMBERS) reflect(name, (text) => numberOr(null, text));
for (const name of FLAGS) reflect(name, (text) => text !== null, (value) => (value ? '' : null));

globalThis.customElements?.define('lodc-view', LodcView);
