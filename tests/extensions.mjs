// Compares docs/EXTENSIONS.md with declarations of extensions in packages: each number that they declare is an index of the
// table, or is known to be none (NO_INDICES), and each index of the table is declared. Prints {numbers, indices, differences}.
//
//   node extensions.mjs MODULES EXTENSIONS.md
//
// MODULES is a node_modules folder with typescript and the packages of DECLARATIONS.
import { readFileSync } from "node:fs";
import { createRequire } from "node:module";
import { join, resolve } from "node:path";

const [modules, page] = process.argv.slice(2);
const ts = createRequire(join(resolve(modules), "here.js"))("typescript");

const vrm = (name) => `@pixiv/types-${name}.d.ts`;
const material = (name) => `materials[].extensions.${name}`;
const primitive = (name) => `meshes[].primitives[].extensions.${name}`;

/** File → path of an object → its type. */
const DECLARATIONS = {
  [vrm("vrm-0.0/types/VRM")]: { "extensions.VRM": "VRM" },
  [vrm("vrmc-vrm-1.0/types/VRMCVRM")]: { "extensions.VRMC_vrm": "VRMCVRM" },
  [vrm("vrmc-springbone-1.0/types/VRMCSpringBone")]: { "extensions.VRMC_springBone": "VRMCSpringBone" },
  [vrm("vrmc-springbone-extended-collider-1.0/types/VRMCSpringBoneExtendedCollider")]: {
    "extensions.VRMC_springBone.colliders[].extensions.VRMC_springBone_extended_collider": "VRMCSpringBoneExtendedCollider",
  },
  [vrm("vrmc-materials-mtoon-1.0/types/VRMCMaterialsMToon")]: { [material("VRMC_materials_mtoon")]: "VRMCMaterialsMToon" },
  [vrm("vrmc-materials-hdr-emissive-multiplier-1.0/types/VRMCMaterialsHDREmissiveMultiplier")]: {
    [material("VRMC_materials_hdr_emissiveMultiplier")]: "VRMCMaterialsHDREmissiveMultiplier",
  },
  [vrm("vrmc-node-constraint-1.0/types/VRMCNodeConstraint")]: { "nodes[].extensions.VRMC_node_constraint": "VRMCNodeConstraint" },
  [vrm("vrmc-vrm-animation-1.0/types/VRMCVRMAnimation")]: { "extensions.VRMC_vrm_animation": "VRMCVRMAnimation" },
  "babylonjs-gltf2interface/babylon.glTF2Interface.d.ts": {
    "extensions.EXT_lights_ies.lights[]": "IEXTLightsIES_Light",
    "nodes[].extensions.EXT_lights_ies": "IEXTLightsIES_LightReference",
    "extensions.EXT_lights_image_based": "IEXTLightsImageBased",
    "scenes[].extensions.EXT_lights_image_based": "IEXTLightsImageBased_LightReferenceImageBased",
    "nodes[].extensions.EXT_mesh_gpu_instancing": "IEXTMeshGpuInstancing",
    "bufferViews[].extensions.EXT_meshopt_compression": "IEXTMeshoptCompression",
    "textures[].extensions.EXT_texture_avif": "IEXTTextureAVIF",
    "textures[].extensions.EXT_texture_webp": "IEXTTextureWebP",
    [primitive("KHR_draco_mesh_compression")]: "IKHRDracoMeshCompression",
    [primitive("KHR_gaussian_splatting")]: "IKHRGaussianSplatting",
    "extensions.KHR_interactivity": "IKHRInteractivity",
    "extensions.KHR_lights_punctual": "IKHRLightsPunctual",
    "nodes[].extensions.KHR_lights_punctual": "IKHRLightsPunctual_LightReference",
    [material("KHR_materials_anisotropy")]: "IKHRMaterialsAnisotropy",
    [material("KHR_materials_clearcoat")]: "IKHRMaterialsClearcoat",
    [material("KHR_materials_diffuse_transmission")]: "IKHRMaterialsDiffuseTransmission",
    [material("KHR_materials_iridescence")]: "IKHRMaterialsIridescence",
    [material("KHR_materials_pbrSpecularGlossiness")]: "IKHRMaterialsPbrSpecularGlossiness",
    [material("KHR_materials_sheen")]: "IKHRMaterialsSheen",
    [material("KHR_materials_specular")]: "IKHRMaterialsSpecular",
    [material("KHR_materials_transmission")]: "IKHRMaterialsTransmission",
    [material("KHR_materials_volume")]: "IKHRMaterialsVolume",
    [primitive("KHR_materials_variants")]: "IKHRMaterialVariants_Mapping",
    "textures[].extensions.KHR_texture_basisu": "IKHRTextureBasisU",
    "nodes[].extensions.KHR_xmp_json_ld": "IKHRXmpJsonLd_Node",
    "extensions.MSFT_audio_emitter.clips[]": "IMSFTAudioEmitter_Clip",
    "extensions.MSFT_audio_emitter.emitters[]": "IMSFTAudioEmitter_Emitter",
    "nodes[].extensions.MSFT_audio_emitter": "IMSFTAudioEmitter_EmittersReference",
    "animations[].extensions.MSFT_audio_emitter.events[]": "IMSFTAudioEmitter_AnimationEvent",
    "nodes[].extensions.MSFT_lod": "IMSFTLOD",
    [material("MSFT_lod")]: "IMSFTLOD",
  },
  "@gltf-transform/extensions/src/ext-structural-metadata/structural-metadata.ts": {
    "extensions.EXT_structural_metadata": "StructuralMetadataDef",
    "nodes[].extensions.EXT_structural_metadata": "NodeStructuralMetadataDef",
    [primitive("EXT_structural_metadata")]: "MeshPrimitiveStructuralMetadataDef",
  },
  "@gltf-transform/extensions/src/ext-mesh-features/mesh-features.ts": { [primitive("EXT_mesh_features")]: "MeshFeaturesDef" },
  "@loaders.gl/gltf/dist/lib/types/gltf-ext-feature-metadata-schema.d.ts": {
    "extensions.EXT_feature_metadata": "GLTF_EXT_feature_metadata_GLTF",
    [primitive("EXT_feature_metadata")]: "GLTF_EXT_feature_metadata_Primitive",
  },
};

/** Ends of paths of numbers that are no index of a list of the document, by what they are. */
const NO_INDICES = {
  "a quantity": `
    x y z xRange yRange curve[] targetValue[] offsetFromHeadBone[] inputMaxValue outputScale offset[] offset scale[] scale
    normal[] tail[] radius hitRadius gravityDir[] gravityPower dragForce stiffness stiffiness axisLength armStretch legStretch
    upperArmTwist lowerArmTwist upperLegTwist lowerLegTwist feetSpacing weight renderQueue renderQueueOffsetNumber color[]
    multiplier emissiveMultiplier intensity range rotation[] specularImageSize irradianceCoefficients[][] spot.innerConeAngle
    spot.outerConeAngle byteOffset byteLength byteStride count componentCount featureCount divisor attenuationDistance
    attenuationColor[] anisotropyStrength anisotropyRotation iridescenceIor iridescenceThicknessMinimum
    iridescenceThicknessMaximum refDistance maxDistance innerAngle outerAngle volume time startOffset`,
  "a value of metadata or of a graph": `
    value value[] default default[] noData noData[] min min[] max max[] mean mean[] median median[] standardDeviation
    standardDeviation[] variance variance[] sum sum[] occurrences{} occurrences{}[] nullFeatureId constant offset[][] scale[][]
    min[][] max[][] default[][] noData[][]`,
  "a number of a set of attributes, a channel, a morph target, an attribute within Draco's bytes": `
    texCoord attribute channels[] binds[].index morphTargetBinds[].index KHR_draco_mesh_compression.attributes{}`,
  "an index of a list of its extension": `
    boneGroups[].colliderGroups[] springs[].colliderGroups[] colliderGroups[].colliders[] EXT_lights_ies.light
    EXT_lights_image_based.light KHR_materials_variants.mappings[].variants[] KHR_xmp_json_ld.packet propertyTable
    propertyTextures[] propertyAttributes[] clips[].clip emitters[] events[].emitter KHR_interactivity.graph
    KHR_interactivity.graphs[].nodes[].declaration KHR_interactivity.graphs[].nodes[].values{}.node
    KHR_interactivity.graphs[].nodes[].flows{}.node variables[].type values{}.type outputValueSockets{}.type
    inputValueSockets{}.type`,
};
const ends = Object.values(NO_INDICES).flatMap((text) => text.trim().split(/\s+/));
const unused = new Set(ends);

/** Whether a number is known to be no index. */
function isNoIndex(path) {
  if (/Factor(\[\])?$/.test(path)) return true;
  const found = ends.filter((end) => path.endsWith("." + end));
  for (const end of found) unused.delete(end);
  return found.length > 0;
}

const program = ts.createProgram(
  Object.keys(DECLARATIONS).map((file) => join(resolve(modules), file)),
  { strict: true, noEmit: true, types: [], module: ts.ModuleKind.ESNext, moduleResolution: ts.ModuleResolutionKind.Bundler },
);
const checker = program.getTypeChecker();

/** The type of a name that a file declares, inside of namespaces too. */
function declared(file, name) {
  let found;
  (function look(node) {
    if ((ts.isInterfaceDeclaration(node) || ts.isTypeAliasDeclaration(node)) && node.name.text === name) found = node;
    else ts.forEachChild(node, look);
  })(program.getSourceFile(join(resolve(modules), file)));
  if (!found) throw new Error(`${file} declares no ${name}`);
  return checker.getTypeAtLocation(found.name);
}

/** Paths of numbers; paths of which anything may be. */
const numbers = new Set();
const anything = new Set();

/** Collects what a type has: `[]` is every element of an array, `{}` every member of an object without names of its own. */
function collect(type, path, outer = []) {
  for (const part of type.isUnion() ? type.types : [type]) {
    if (part.flags & (ts.TypeFlags.Any | ts.TypeFlags.Unknown)) anything.add(path);
    if (part.flags & ts.TypeFlags.NumberLike) numbers.add(path);
    if (!(part.flags & ts.TypeFlags.Object) || outer.includes(part)) continue;
    const inner = [...outer, part];
    if (checker.isArrayType(part) || checker.isTupleType(part)) {
      for (const element of checker.getTypeArguments(part)) collect(element, path + "[]", inner);
      continue;
    }
    const member = checker.getIndexInfoOfType(part, ts.IndexKind.String);
    if (member) collect(member.type, path + "{}", inner);
    const mapped = part.objectFlags & ts.ObjectFlags.Mapped;
    for (const property of checker.getPropertiesOfType(part)) {
      if (property.name === "extensions" || property.name === "extras") continue;
      collect(checker.getTypeOfSymbol(property), mapped ? path + "{}" : `${path}.${property.name}`, inner);
    }
  }
}
const roots = [];
for (const [file, types] of Object.entries(DECLARATIONS)) {
  for (const [path, name] of Object.entries(types)) {
    collect(declared(file, name), path);
    roots.push(path);
  }
}

const table = new Set([...readFileSync(page, "utf8").matchAll(/`([^`]+)` → \w+/g)].map((row) => row[1]));
const differences = [];
for (const path of numbers) {
  if (!table.has(path) && !isNoIndex(path)) differences.push(`the table lacks ${path}`);
}
const covered = [...table].filter((path) => roots.some((root) => path.startsWith(root + ".")));
for (const path of covered) {
  if (!numbers.has(path) && ![...anything].some((place) => path.startsWith(place))) differences.push(`no package declares ${path}`);
}
for (const end of unused) differences.push(`no package declares a number ${end}`);
console.log(JSON.stringify({ numbers: numbers.size, indices: covered.length, differences }));
