import { Scene, PerspectiveCamera, WebGLRenderer, AnimationMixer } from 'three';
import { LodcLoader, LodcModel } from 'lodc';
import { LodcView } from 'lodc/view';
import { Decoder, WASM, read, type Header } from 'lodc/decoder';
const controller = new AbortController();
const model: LodcModel = await LodcLoader.load('a.lods', { signal: controller.signal, onProgress: (e) => e.loaded });
model.pixels = 2;
new Scene().add(model, model.clone());
model.addEventListener('animations', () => new AnimationMixer(model).clipAction(model.animations[0]).play());
const triangles: number = (await model.whenComplete).triangles;
const loader = new LodcLoader().setPath('models/');
loader.load('b.lodc', (m) => m.update(new PerspectiveCamera(), 1080), undefined, console.error);
const decoder = await Decoder.create(WASM.file);
const headers: Header[] = [];
read(decoder.open(new Uint8Array(4)), headers, { levels: (number, levels) => levels[0].error + number });
// @ts-expect-error: a level is a number
model.meshes[0].level = 'fine';
// @ts-expect-error: there is no such option
LodcLoader.load('a.lodc', { sigal: controller.signal });
const view: LodcView = document.createElement('lodc-view');
view.addEventListener('error', ({ message }) => message.length);
view.addEventListener('load', () => view.model?.triangles.toFixed());
// @ts-expect-error: a model comes from `src`
view.model = model;
view.src = 'chair.lods';
view.level = null;
view.autoplay = true;
view.focus();
// @ts-expect-error: what an element plays is named
view.animation = 3;
export { triangles, WebGLRenderer };
