import type { BufferGeometry } from 'three';
import { GLTFLoader } from 'three/addons/loaders/GLTFLoader.js';
import { ChainLevels, ChainModel, LodcChain } from 'lodc/chain';
import { LodcCrowd } from 'lodc/crowd';
import { LodcLoader } from 'lodc';
import { Lodc, type LodcObject, type Part } from 'lodc/full';
import { Levels, Submesh } from 'lodc/full/levels';
import { openDevice, replay, Session, type Plan } from 'lodc/full/plan';
import { Sections } from 'lodc/full/sections';
import { pixelSize, Selection } from 'lodc/full/selection';
const lodc = await Lodc.create();
const { objects, selection, glb } = lodc.open(new Uint8Array(4));
const object: LodcObject = objects[0];
selection.seek(selection.byTriangles(1000));
for (const { positions, submesh } of object.parts) positions.length + submesh.indices[3 * submesh.triangles - 1];
const part: Part = object.parts[0];
const one: Submesh = part.submesh;
one.seek(object.levels.shown(5));
const image: Blob | null = glb.picture(part.material);
const stream = lodc.stream();
const [now, all] = stream.feed(new ArrayBuffer(4)).objects[0].triangles;
const mesh: Uint8Array | null = stream.mesh();
const both = new Selection(objects.map(({ levels }: { levels: Levels }) => levels));
const size: number = both.error(both.byError(0.5)) / pixelSize(1, 1080);
const sections = new Sections(new ArrayBuffer(64));
const ends: number[] = sections.stepEnds(0);
const chain = new LodcChain(await ChainModel.of(await new GLTFLoader().loadAsync('helmet.glb')), 2);
chain.morphs = false;
chain.at(10);
const { level, weight } = new ChainLevels({}).at(3);
const crowd = new LodcCrowd(await LodcLoader.load('tree.lodc'), 200);
crowd.level = null;
const device = await openDevice();
if (device) {
  const plan: Plan = { program: { buffers: [], kernels: [] }, steps: [] };
  const { difference } = await replay(device, plan);
  new Session(device, plan.program).destroy();
  console.log(difference?.length);
}
// @ts-expect-error: an instance comes from `create`
new Lodc({});
// @ts-expect-error: a number of triangles is a number
selection.byTriangles('1000');
// @ts-expect-error: triangles are counted, not set
chain.triangles = 5;
export { now, all, mesh, size, ends, level, weight, image, type BufferGeometry };
