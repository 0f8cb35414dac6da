// `<lodc-view src="chair.lods" alt="A chair">`: a model in a page that writes no three.js.

import * as THREE from 'three';
import { OrbitControls } from 'three/addons/controls/OrbitControls.js';
import { LodcLoader } from './loader.js';

const STYLE = `
:host { display: block; position: relative; aspect-ratio: 4 / 3; overflow: hidden; }
:host([hidden]), [hidden] { display: none !important; }
canvas, img { position: absolute; inset: 0; width: 100%; height: 100%; }
canvas:focus-visible { outline: 2px solid currentColor; outline-offset: -2px; }
img { object-fit: contain; pointer-events: none; }
p { position: absolute; inset: auto 0 0; margin: 0; padding: 0.5em 0.75em;
  font: 14px/1.4 system-ui, sans-serif; overflow-wrap: anywhere; color: #8a1010; background: #fff; }
`;
/** Where the camera stands first: the direction, and its angle of view in degrees. */
const FIRST = new THREE.Vector3(0.6, 0.45, 1).normalize();
const FOV = 35;
/** Radians that an arrow key turns, and the factor of + and −. */
const TURN = Math.PI / 24;
const ZOOM = 1.2;
const KEYS = {
  ArrowLeft: [-TURN, 0, 1], ArrowRight: [TURN, 0, 1], ArrowUp: [0, TURN, 1],
  ArrowDown: [0, -TURN, 1], '+': [0, 0, ZOOM], '=': [0, 0, ZOOM], '-': [0, 0, 1 / ZOOM],
};

/** The number that an attribute says, if it says one. */
function numberOr(other, value) {
  const number = Number.parseFloat(value);
  return Number.isNaN(number) ? other : number;
}

/** Light from all around, which metals show, too: a bright sky, a window in it, a darker floor. */
function sky() {
  const [width, height] = [64, 32];
  const data = new Float32Array(4 * width * height);
  for (let y = 0; y < height; y++) {
    for (let x = 0; x < width; x++) {
      const isWindow = y > 18 && y < 28 && x > 8 && x < 24;
      const light = isWindow ? 6 : 0.4 + 0.9 * (y / height);
      data.set([light, light, light, 1], 4 * (y * width + x));
    }
  }
  const texture = new THREE.DataTexture(data, width, height, THREE.RGBAFormat, THREE.FloatType);
  texture.mapping = THREE.EquirectangularReflectionMapping;
  texture.needsUpdate = true;
  return texture;
}

/** A canvas and what is drawn on it, while an element is in a document. */
class Stage {
  constructor(host, canvas) {
    Object.assign(this, { host, canvas });
    const renderer = new THREE.WebGLRenderer({ canvas, antialias: true, alpha: true });
    this.renderer = renderer;
    renderer.setPixelRatio(Math.min(devicePixelRatio, 2));
    this.scene = new THREE.Scene();
    this.scene.environment = sky();
    this.camera = new THREE.PerspectiveCamera(FOV);
    this.controls = new OrbitControls(this.camera, canvas);
    // A finger that moves up or down scrolls the page.
    canvas.style.touchAction = 'pan-y';
    this.controls.addEventListener('change', () => this.draw());
    canvas.addEventListener('webglcontextrestored', () => this.draw());
    canvas.addEventListener('keydown', (event) => this.key(event));
    this.sizes = new ResizeObserver(() => this.resize());
    this.sizes.observe(host);
    this.resize();
  }

  resize() {
    const { clientWidth: width, clientHeight: height } = this.host;
    if (width === 0 || height === 0) return;
    this.renderer.setSize(width, height, false);
    this.camera.aspect = width / height;
    this.camera.updateProjectionMatrix();
    this.render();
  }

  /** Puts the camera where it sees all of a model. */
  frame(model) {
    model.updateWorldMatrix(true, true);
    const sphere = new THREE.Box3().setFromObject(model).getBoundingSphere(new THREE.Sphere());
    const radius = sphere.radius || 1;
    const upright = THREE.MathUtils.degToRad(FOV / 2);
    const narrow = Math.min(upright, Math.atan(Math.tan(upright) * this.camera.aspect));
    const distance = radius / Math.sin(narrow);
    Object.assign(this.camera, { near: radius / 100, far: radius * 100 });
    this.camera.position.copy(FIRST).multiplyScalar(distance).add(sphere.center);
    this.camera.updateProjectionMatrix();
    Object.assign(this.controls, { minDistance: radius / 20, maxDistance: radius * 50 });
    this.controls.target.copy(sphere.center);
    this.controls.update();
  }

  key(event) {
    const move = KEYS[event.key];
    if (!move || event.ctrlKey || event.metaKey || event.altKey) return;
    event.preventDefault();
    const [across, up, nearer] = move;
    const { camera, controls } = this;
    const from = camera.position.clone().sub(controls.target);
    const place = new THREE.Spherical().setFromVector3(from);
    place.theta += across;
    place.phi -= up;
    place.radius /= nearer;
    camera.position.setFromSpherical(place.makeSafe()).add(controls.target);
    controls.update();
  }

  /** Draws with the next picture of the page. */
  draw() {
    this.due ??= requestAnimationFrame(() => this.render());
  }

  render() {
    cancelAnimationFrame(this.due);
    this.due = null;
    this.renderer.render(this.scene, this.camera);
  }

  dispose() {
    cancelAnimationFrame(this.due);
    this.sizes.disconnect();
    this.controls.dispose();
    this.scene.environment.dispose();
    this.renderer.dispose();
    // A page has few contexts, and would keep this one until its memory is collected.
    this.renderer.forceContextLoss();
    this.canvas.remove();
  }
}

/** The element. Events: `load` with the first picture, `complete`, `error`. */
export class LodcView extends (globalThis.HTMLElement ?? Object) {
  static observedAttributes = ['src', 'level', 'pixels', 'poster', 'up', 'alt'];

  constructor() {
    super();
    /** The model that is shown. */
    this.model = null;
    const root = this.attachShadow({ mode: 'open' });
    const style = new CSSStyleSheet();
    style.replaceSync(STYLE);
    root.adoptedStyleSheets = [style];
    this.image = Object.assign(document.createElement('img'), { alt: '', hidden: true });
    this.told = Object.assign(document.createElement('p'), { role: 'alert', hidden: true });
    root.append(this.image, this.told);
  }

  connectedCallback() {
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
    this.model?.removeFromParent();
    this.model?.dispose();
    this.model = null;
    this.told.hidden = true;
    this.follow('poster');
    this.stage?.draw();
  }

  async load(source) {
    this.abort = new AbortController();
    const { signal } = this.abort;
    try {
      this.stage ??= this.start();
      this.follow('alt');
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

  start() {
    const canvas = Object.assign(document.createElement('canvas'), { role: 'img', tabIndex: 0 });
    this.shadowRoot.prepend(canvas);
    try {
      return new Stage(this, canvas);
    } catch (error) {
      canvas.remove();
      throw error;
    }
  }

  show(model) {
    this.model = model;
    for (const name of ['level', 'pixels', 'up']) this.follow(name);
    this.stage.scene.add(model);
    this.stage.frame(model);
    for (const type of ['grown', 'complete']) {
      model.addEventListener(type, () => this.stage?.draw());
    }
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
    if (name === 'alt') stage?.canvas.setAttribute('aria-label', value ?? '3D model');
    if (!model) return;
    if (name === 'level') model.level = numberOr(null, value);
    if (name === 'pixels') model.pixels = numberOr(1, value);
    if (name === 'up') {
      model.rotation.x = value?.toLowerCase() === 'z' ? -Math.PI / 2 : 0;
      if (model.parent) stage.frame(model);
    }
    stage.draw();
  }
}

globalThis.customElements?.define('lodc-view', LodcView);
