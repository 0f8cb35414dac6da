// What the tests do with `<lodc-view>`.

import 'lodc/view';

let view;
let told;
/** What is left of the element that was there last. */
let left;

const task = () => new Promise((resolve) => setTimeout(resolve));

/** Puts an element with attributes into the page, instead of the one before. */
async function element(attributes) {
  await remove();
  view = document.createElement('lodc-view');
  view.style.cssText = 'position: fixed; inset: 0; background: #fff';
  told = [];
  for (const type of ['load', 'complete', 'error']) {
    view.addEventListener(type, () => told.push(type));
  }
  const own = view;
  for (const [name, value] of Object.entries(attributes)) own.setAttribute(name, value);
  document.body.append(own);
  await task();
}

/** Changes attributes; those that are null go. */
async function change(attributes) {
  told.length = 0;
  for (const [name, value] of Object.entries(attributes)) {
    if (value === null) view.removeAttribute(name);
    else view.setAttribute(name, value);
  }
  await task();
  view.stage.render();
}

/** Waits for an event; all so far. */
async function events(type) {
  if (!told.includes(type)) {
    await new Promise((resolve, reject) => {
      view.addEventListener(type, resolve, { once: true });
      if (type !== 'error') view.addEventListener('error', ({ error }) => reject(error));
    });
  }
  return told;
}

/** What an element shows. */
function shown() {
  const { image, told: error, stage, model } = view;
  return {
    label: stage.canvas.ariaLabel, poster: !image.hidden,
    error: error.hidden ? null : error.textContent,
    triangles: model?.triangles ?? 0, geometries: stage.renderer.info.memory.geometries,
  };
}

function image() {
  view.stage.render();
  return view.stage.canvas.toDataURL();
}

function press(key) {
  view.stage.canvas.dispatchEvent(new KeyboardEvent('keydown', { key, bubbles: true }));
}

/** Takes the element out of the page. */
async function remove() {
  if (!view) return;
  const { stage, model } = view;
  view.remove();
  await task();
  const gl = stage.renderer.getContext();
  const canvases = view.shadowRoot.querySelectorAll('canvas').length;
  left = { canvases, isLost: gl.isContextLost(), model: new WeakRef(model ?? {}) };
  view = null;
}

/** What became of the element that was taken out. */
const freed = () => ({ canvases: left.canvases, isLost: left.isLost });
const lives = () => left.model.deref() !== undefined;

Object.assign(window, { element, change, events, shown, image, press, remove, freed, lives });
