// What the tests with engines load: Babylon.js and three.js, out of a node_modules folder. Both expect a browser.
import { join, resolve } from "node:path";
import { pathToFileURL } from "node:url";

globalThis.self = globalThis;
globalThis.ProgressEvent ??= class {};

/** The modules of both engines that read glTF. */
export async function loaders(modules) {
  const load = (path) => import(pathToFileURL(join(resolve(modules), path)).href);
  const { NullEngine } = await load("@babylonjs/core/Engines/nullEngine.js");
  const { Scene } = await load("@babylonjs/core/scene.js");
  const { LoadAssetContainerAsync } = await load("@babylonjs/core/Loading/sceneLoader.js");
  const { Logger } = await load("@babylonjs/core/Misc/logger.js");
  await load("@babylonjs/loaders/glTF/index.js");
  const { GLTFLoader } = await load("three/examples/jsm/loaders/GLTFLoader.js");
  const { Mesh, Vector3 } = await load("three/build/three.module.js");
  Logger.LogLevels = Logger.NoneLogLevel;
  return { NullEngine, Scene, LoadAssetContainerAsync, GLTFLoader, Mesh, Vector3 };
}
