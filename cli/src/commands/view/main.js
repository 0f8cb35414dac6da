// Opens the model of the page and shows it.

import { Glb } from '../../../../crates/web/js/glb.js';
import { Scene } from '../../../../crates/web/js/scene.js';
import { ViewDependent } from '../../../../crates/web/js/viewdependent.js';
import { WebglRenderer } from '../../../../crates/web/js/webgl.js';
import { WebgpuRenderer } from '../../../../crates/web/js/webgpu.js';
import { Controls } from './controls.js';
import { ExportedControls, ExportedScene, ExportedViewer, isExported } from './exported.js';
import { Viewer } from './viewer.js';

/** RFC 4648 base64 as bytes. */
function bytesOf(text) {
  if (Uint8Array.fromBase64) return Uint8Array.fromBase64(text);
  return Uint8Array.from(atob(text), (c) => c.charCodeAt(0));
}

async function start() {
  const canvas = document.getElementById('canvas');
  const model = document.getElementById('model');
  const glb = new Glb(bytesOf(model.textContent));
  const exported = isExported(glb);
  const { up } = document.documentElement.dataset;
  const scene = exported ? new ExportedScene(glb) : new Scene(glb);
  scene.stand(up);
  model.remove();
  // WebGL is there at once, WebGPU takes over when its device is.
  const renderer = await WebglRenderer.create(canvas, scene)
    ?? await WebgpuRenderer.create(canvas, scene);
  if (!renderer) throw new Error('This browser offers neither WebGL 2 nor WebGPU.');
  const viewer = new (exported ? ExportedViewer : Viewer)(canvas, scene, renderer);
  const controls = new (exported ? ExportedControls : Controls)(viewer);
  Object.assign(window, { viewer, controls });
  // At once: a page in the background gets no frames.
  viewer.frame(performance.now());
  const hasDevice = !(renderer instanceof WebglRenderer) || await upgrade(viewer, scene);
  // Where there is no device it is not asked for again: browsers complain of each time.
  if (exported || !hasDevice) return;
  const wgsl = document.getElementById('view-shader').textContent;
  const viewDependent = await ViewDependent.create(scene, wgsl);
  if (viewDependent) {
    viewer.set({ viewDependent });
    controls.bindViews();
  }
}

/** A canvas over the one that is there, which goes on receiving what is done to it. */
function overlay() {
  const canvas = document.createElement('canvas');
  canvas.className = 'overlay';
  canvas.hidden = true;
  document.getElementById('canvas').after(canvas);
  return canvas;
}

/** Goes on with WebGPU where it is there, and with WebGL if its device is lost; whether it is. */
async function upgrade(viewer, scene) {
  if (!navigator.gpu) return false;
  const canvas = overlay();
  const renderer = await WebgpuRenderer.create(canvas, scene).catch(() => null);
  if (!renderer) {
    canvas.remove();
    return false;
  }
  const before = viewer.use(renderer);
  renderer.device.lost.then(async () => {
    canvas.remove();
    const other = overlay();
    const webgl = await WebglRenderer.create(other, scene);
    other.hidden = false;
    if (webgl) viewer.use(webgl);
  });
  // Until it has a picture the one before stays.
  await renderer.finished();
  canvas.hidden = false;
  before.close();
  return true;
}

start().catch((error) => {
  const failure = document.getElementById('failure');
  failure.textContent = `The model cannot be shown: ${error.message}`;
  failure.hidden = false;
  throw error;
});
