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
    label: stage.canvas.ariaLabel, level: model?.meshes[0].level, poster: !image.hidden,
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
  const { stage, model, canvas } = view;
  view.remove();
  await task();
  const gl = stage.renderer.getContext();
  left = { pixels: canvas.width, isLost: gl.isContextLost(), model: new WeakRef(model ?? {}) };
  view = null;
}

/** What became of the element that was taken out. */
const freed = () => ({ pixels: left.pixels, isLost: left.isLost });
const lives = () => left.model.deref() !== undefined;

/** Sets a property; what it and its attribute are then. */
function property(name, value) {
  view[name] = value;
  return [view[name], view.getAttribute(name)];
}

/** A property that was set before the element was defined, as a script does that comes first. */
function upgraded() {
  const early = document.createElement('lodc-view');
  Object.defineProperty(early, 'alt', { value: 'early', configurable: true, writable: true });
  document.body.append(early);
  const value = early.getAttribute('alt');
  early.remove();
  return value;
}

function focused() {
  view.focus();
  return [document.activeElement === view, view.shadowRoot.activeElement === view.canvas];
}

/** Whether pictures at two moments differ. */
async function moves() {
  view.stage.render();
  const before = view.canvas.toDataURL();
  await new Promise((resolve) => setTimeout(resolve, 500));
  return view.canvas.toDataURL() !== before;
}

/** Brightness of what is drawn over white: shares of it that are white, the darkest tenth. */
function brightness() {
  view.stage.render();
  const { canvas } = view;
  const { data } = canvas.getContext('2d').getImageData(0, 0, canvas.width, canvas.height);
  const values = [];
  for (let i = 0; i < data.length; i += 4) {
    if (data[i + 3] === 255) values.push((data[i] + data[i + 1] + data[i + 2]) / 3);
  }
  values.sort((a, b) => a - b);
  const white = values.filter((value) => value > 245).length / values.length;
  const at = (share) => values[Math.floor(share * (values.length - 1))];
  return { drawn: values.length, white, dark: at(0.1), middle: at(0.5), light: at(0.9) };
}

/** Many elements at once: how many of them show something. */
async function many(src, count) {
  const all = [];
  for (let i = 0; i < count; i++) {
    const one = document.createElement('lodc-view');
    one.style.cssText = `position: fixed; left: ${30 * (i % 8)}px; top: ${30 * (i >> 3)}px;
      width: ${20 + (i % 3)}px; aspect-ratio: 1`;
    const loaded = new Promise((resolve, reject) => {
      one.addEventListener('load', resolve);
      one.addEventListener('error', ({ error }) => reject(error));
    });
    one.src = src;
    document.body.append(one);
    all.push(loaded.then(() => one));
  }
  const views = await Promise.all(all);
  await new Promise((resolve) => setTimeout(resolve, 200));
  const shows = ({ canvas }) => {
    const { data } = canvas.getContext('2d').getImageData(0, 0, canvas.width, canvas.height);
    return data.some((value, i) => i % 4 === 3 && value === 255);
  };
  const contexts = new Set(views.map(({ stage }) => stage.renderer)).size;
  const result = { shown: views.filter(shows).length, contexts };
  for (const one of views) one.remove();
  await task();
  return result;
}

Object.assign(window, {
  element, change, events, shown, image, press, remove, freed, lives, property, upgraded, focused,
  moves, brightness, many,
});
