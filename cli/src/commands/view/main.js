// Opens the model of the page and shows it.

import { Glb } from '../../../../crates/web/js/glb.js';
import { Scene } from '../../../../crates/web/js/scene.js';
import { ViewDependent } from '../../../../crates/web/js/viewdependent.js';
import { WebglRenderer } from '../../../../crates/web/js/webgl.js';
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
  const renderer = await WebglRenderer.create(canvas, scene);
  if (!renderer) throw new Error('This browser does not offer WebGL 2.');
  const viewer = new (exported ? ExportedViewer : Viewer)(canvas, scene, renderer);
  const controls = new (exported ? ExportedControls : Controls)(viewer);
  Object.assign(window, { viewer, controls });
  // At once: a page in the background gets no frames.
  viewer.frame(performance.now());
  if (exported) return;
  const wgsl = document.getElementById('view-shader').textContent;
  const viewDependent = await ViewDependent.create(scene, wgsl);
  if (viewDependent) {
    viewer.set({ viewDependent });
    controls.bindViews();
  }
}

start().catch((error) => {
  const failure = document.getElementById('failure');
  failure.textContent = `The model cannot be shown: ${error.message}`;
  failure.hidden = false;
  throw error;
});
