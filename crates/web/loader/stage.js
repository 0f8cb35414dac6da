// What an element shows: a scene, a camera that is turned, pictures. All elements of a page share
// one WebGL context, of which a browser gives a page few, and copy their pictures from it.

import * as THREE from 'three';
import { OrbitControls } from 'three/addons/controls/OrbitControls.js';

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

/** The renderer of all stages, while there are any. */
const shared = { renderer: null, sky: null, stages: new Set() };

/**
 * Light from all around, which metals show, too: a sky, a window in it, a darker floor. A white
 * surface without a texture is light grey in it, and its sides differ.
 */
function sky() {
  const [width, height] = [64, 32];
  const data = new Float32Array(4 * width * height);
  for (let y = 0; y < height; y++) {
    for (let x = 0; x < width; x++) {
      const isWindow = y > 18 && y < 28 && x > 8 && x < 24;
      const light = isWindow ? 5 : 0.35 + 0.7 * (y / height);
      data.set([light, light, light, 1], 4 * (y * width + x));
    }
  }
  const texture = new THREE.DataTexture(data, width, height, THREE.RGBAFormat, THREE.FloatType);
  texture.mapping = THREE.EquirectangularReflectionMapping;
  texture.needsUpdate = true;
  return texture;
}

function join(stage) {
  if (!shared.renderer) {
    const renderer = new THREE.WebGLRenderer({ antialias: true, alpha: true });
    // Colours stay what they are; only what is brighter than white is compressed.
    renderer.toneMapping = THREE.NeutralToneMapping;
    renderer.setScissorTest(true);
    renderer.domElement.addEventListener('webglcontextrestored', () => {
      for (const one of shared.stages) one.draw();
    });
    Object.assign(shared, { renderer, sky: sky() });
  }
  shared.stages.add(stage);
  return shared;
}

function leave(stage) {
  shared.stages.delete(stage);
  if (shared.stages.size > 0) return;
  shared.sky.dispose();
  shared.renderer.dispose();
  // A page would keep the context until its memory is collected.
  shared.renderer.forceContextLoss();
  Object.assign(shared, { renderer: null, sky: null });
}

/** What an element shows on its canvas while it is in a document. */
export class Stage {
  constructor(host, canvas) {
    Object.assign(this, { host, canvas, model: null, playing: false, seen: true });
    const { renderer, sky: environment } = join(this);
    this.renderer = renderer;
    this.picture = canvas.getContext('2d');
    this.scene = new THREE.Scene();
    this.scene.environment = environment;
    this.camera = new THREE.PerspectiveCamera(FOV);
    this.controls = new OrbitControls(this.camera, canvas);
    // A finger that moves up or down scrolls the page.
    canvas.style.touchAction = 'pan-y';
    this.controls.addEventListener('change', () => this.draw());
    canvas.onkeydown = (event) => this.key(event);
    this.sizes = new ResizeObserver(() => this.resize());
    this.sizes.observe(host);
    this.sight = new IntersectionObserver((entries) => {
      this.seen = entries.at(-1).isIntersecting;
      // An animation goes on where it was.
      this.before = null;
      this.draw();
    });
    this.sight.observe(host);
    this.resize();
  }

  resize() {
    const { clientWidth: width, clientHeight: height } = this.host;
    if (width === 0 || height === 0) return;
    const ratio = Math.min(devicePixelRatio, 2);
    this.canvas.width = Math.round(width * ratio);
    this.canvas.height = Math.round(height * ratio);
    this.camera.aspect = width / height;
    this.camera.updateProjectionMatrix();
    this.render();
  }

  /** Shows a model instead of the one before; none: nothing. */
  show(model) {
    this.model?.removeFromParent();
    this.mixer?.uncacheRoot(this.model);
    Object.assign(this, { model, mixer: null, playing: false });
    if (model) {
      this.scene.add(model);
      this.frame(model);
    }
    this.draw();
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
    if (event.ctrlKey || event.metaKey || event.altKey) return;
    const move = KEYS[event.key];
    const isPlay = event.key === ' ' && this.model?.animations.length > 0;
    if (!move && !isPlay) return;
    event.preventDefault();
    if (isPlay) {
      if (this.playing) this.host.pause();
      else this.host.play();
      return;
    }
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

  /** Plays an animation from where it is, or from its beginning if it is another; null: none. */
  play(clip) {
    if (!this.mixer || this.clip !== clip) {
      this.mixer?.stopAllAction();
      this.mixer ??= new THREE.AnimationMixer(this.model);
      this.clip = clip;
      if (clip) this.mixer.clipAction(clip).play();
    }
    this.playing = clip !== null;
    this.before = null;
    this.draw();
  }

  pause() {
    this.playing = false;
  }

  /** Draws with the next picture of the page, if the element is seen. */
  draw() {
    this.due ??= requestAnimationFrame((now) => this.render(now));
  }

  render(now = null) {
    cancelAnimationFrame(this.due);
    this.due = null;
    if (!this.seen) return;
    if (this.playing && now !== null) {
      this.mixer.update((now - (this.before ?? now)) / 1000);
      this.before = now;
    }
    const { renderer, canvas: { width, height }, picture } = this;
    const { width: across, height: up } = renderer.domElement;
    // The context is as large as the largest element; each draws into a corner of it.
    if (width > across || height > up) {
      renderer.setSize(Math.max(width, across), Math.max(height, up), false);
    }
    renderer.setViewport(0, 0, width, height);
    renderer.setScissor(0, 0, width, height);
    renderer.render(this.scene, this.camera);
    const top = renderer.domElement.height - height;
    picture.clearRect(0, 0, width, height);
    picture.drawImage(renderer.domElement, 0, top, width, height, 0, 0, width, height);
    if (this.playing) this.draw();
  }

  dispose() {
    this.show(null);
    cancelAnimationFrame(this.due);
    this.sizes.disconnect();
    this.sight.disconnect();
    this.controls.dispose();
    this.canvas.onkeydown = null;
    this.canvas.width = 0;
    leave(this);
  }
}
