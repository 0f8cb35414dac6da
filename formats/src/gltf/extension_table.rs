//! Which numbers in extensions are indices of what, from their specifications: the Khronos registry
//! (github.com/KhronosGroup/glTF/tree/main/extensions), 3D Tiles Next, VRM 0.x and 1.0
//! (github.com/vrm-c/vrm-specification), OMI (github.com/omigroup/gltf-extensions), Mozilla Hubs,
//! and drafts that files use. docs/EXTENSIONS.md shows the table.

use super::pool::Pool::{
    self, Accessors, BufferViews, Buffers, Images, Lights, Materials, Meshes, Nodes, Textures,
};

/// An extension: its name, and the paths of its indices as `schema` has them. Those that lead
/// nowhere are left alone: many avatars have −1 for nothing.
pub(super) type Entry = (&'static str, &'static [(&'static str, Pool)]);

/// Every extension whose numbers are known. Numbers that no path leads to are no indices of the
/// document's own lists: they mean something else, or index lists of the extension.
pub(super) const EXTENSIONS: &[Entry] = &[
    // Geometry.
    ("CESIUM_RTC", &[]),
    (
        "CESIUM_primitive_outline",
        &[("meshes[].primitives[].extensions.CESIUM_primitive_outline.indices", Accessors)],
    ),
    (
        "EXT_mesh_gpu_instancing",
        &[
            ("nodes[].extensions.EXT_mesh_gpu_instancing.attributes{}", Accessors),
            ("nodes[].extensions.EXT_mesh_gpu_instancing.mesh", Meshes),
        ],
    ),
    (
        "EXT_mesh_manifold",
        &[
            ("meshes[].extensions.EXT_mesh_manifold.manifoldPrimitive.indices", Accessors),
            ("meshes[].extensions.EXT_mesh_manifold.manifoldPrimitive.attributes{}", Accessors),
            ("meshes[].extensions.EXT_mesh_manifold.manifoldPrimitive.material", Materials),
            ("meshes[].extensions.EXT_mesh_manifold.mergeIndices", Accessors),
            ("meshes[].extensions.EXT_mesh_manifold.mergeValues", Accessors),
        ],
    ),
    (
        "EXT_mesh_primitive_edge_visibility",
        &[
            (
                "meshes[].primitives[].extensions.EXT_mesh_primitive_edge_visibility.visibility",
                Accessors,
            ),
            (
                "meshes[].primitives[].extensions.EXT_mesh_primitive_edge_visibility\
                 .silhouetteNormals",
                Accessors,
            ),
            (
                "meshes[].primitives[].extensions.EXT_mesh_primitive_edge_visibility\
                 .lineStrings[].indices",
                Accessors,
            ),
            (
                "meshes[].primitives[].extensions.EXT_mesh_primitive_edge_visibility\
                 .lineStrings[].material",
                Materials,
            ),
            (
                "meshes[].primitives[].extensions.EXT_mesh_primitive_edge_visibility.material",
                Materials,
            ),
        ],
    ),
    (
        "EXT_mesh_primitive_restart",
        &[("meshes[].extensions.EXT_mesh_primitive_restart.primitiveGroups[].indices", Accessors)],
    ),
    (
        "EXT_meshopt_compression",
        &[("bufferViews[].extensions.EXT_meshopt_compression.buffer", Buffers)],
    ),
    ("FB_geometry_metadata", &[]),
    ("FB_ngon_encoding", &[]),
    (
        "KHR_draco_mesh_compression",
        &[("meshes[].primitives[].extensions.KHR_draco_mesh_compression.bufferView", BufferViews)],
    ),
    ("KHR_gaussian_splatting", &[]),
    ("KHR_mesh_quantization", &[]),
    (
        "KHR_meshopt_compression",
        &[("bufferViews[].extensions.KHR_meshopt_compression.buffer", Buffers)],
    ),
    (
        "MPEG_mesh_linking",
        &[
            ("meshes[].extensions.MPEG_mesh_linking.correspondence", Accessors),
            ("meshes[].extensions.MPEG_mesh_linking.pose", Accessors),
            ("meshes[].extensions.MPEG_mesh_linking.weights", Accessors),
            ("meshes[].extensions.MPEG_mesh_linking.mesh", Meshes),
        ],
    ),
    (
        "MSFT_lod",
        &[
            ("nodes[].extensions.MSFT_lod.ids[]", Nodes),
            ("materials[].extensions.MSFT_lod.ids[]", Materials),
        ],
    ),
    // Materials, textures, lights.
    ("EXT_lights_ies", &[("extensions.EXT_lights_ies.lights[].bufferView", BufferViews)]),
    (
        "EXT_lights_image_based",
        &[("extensions.EXT_lights_image_based.lights[].specularImages[][]", Images)],
    ),
    ("EXT_texture_astc", &[("textures[].extensions.EXT_texture_astc.source", Images)]),
    ("EXT_texture_avif", &[("textures[].extensions.EXT_texture_avif.source", Images)]),
    ("EXT_texture_webp", &[("textures[].extensions.EXT_texture_webp.source", Images)]),
    ("KHR_lights_punctual", &[("nodes[].extensions.KHR_lights_punctual.light", Lights)]),
    (
        "KHR_materials_anisotropy",
        &[("materials[].extensions.KHR_materials_anisotropy.anisotropyTexture.index", Textures)],
    ),
    (
        "KHR_materials_clearcoat",
        &[
            ("materials[].extensions.KHR_materials_clearcoat.clearcoatTexture.index", Textures),
            (
                "materials[].extensions.KHR_materials_clearcoat.clearcoatRoughnessTexture.index",
                Textures,
            ),
            (
                "materials[].extensions.KHR_materials_clearcoat.clearcoatNormalTexture.index",
                Textures,
            ),
        ],
    ),
    (
        "KHR_materials_diffuse_transmission",
        &[
            (
                "materials[].extensions.KHR_materials_diffuse_transmission\
                 .diffuseTransmissionTexture.index",
                Textures,
            ),
            (
                "materials[].extensions.KHR_materials_diffuse_transmission\
                 .diffuseTransmissionColorTexture.index",
                Textures,
            ),
        ],
    ),
    (
        "KHR_materials_iridescence",
        &[
            ("materials[].extensions.KHR_materials_iridescence.iridescenceTexture.index", Textures),
            (
                "materials[].extensions.KHR_materials_iridescence\
                 .iridescenceThicknessTexture.index",
                Textures,
            ),
        ],
    ),
    (
        "KHR_materials_pbrSpecularGlossiness",
        &[
            (
                "materials[].extensions.KHR_materials_pbrSpecularGlossiness.diffuseTexture.index",
                Textures,
            ),
            (
                "materials[].extensions.KHR_materials_pbrSpecularGlossiness\
                 .specularGlossinessTexture.index",
                Textures,
            ),
        ],
    ),
    (
        "KHR_materials_sheen",
        &[
            ("materials[].extensions.KHR_materials_sheen.sheenColorTexture.index", Textures),
            ("materials[].extensions.KHR_materials_sheen.sheenRoughnessTexture.index", Textures),
        ],
    ),
    (
        "KHR_materials_specular",
        &[
            ("materials[].extensions.KHR_materials_specular.specularTexture.index", Textures),
            ("materials[].extensions.KHR_materials_specular.specularColorTexture.index", Textures),
        ],
    ),
    (
        "KHR_materials_transmission",
        &[(
            "materials[].extensions.KHR_materials_transmission.transmissionTexture.index",
            Textures,
        )],
    ),
    (
        "KHR_materials_variants",
        &[(
            "meshes[].primitives[].extensions.KHR_materials_variants.mappings[].material",
            Materials,
        )],
    ),
    (
        "KHR_materials_volume",
        &[("materials[].extensions.KHR_materials_volume.thicknessTexture.index", Textures)],
    ),
    (
        "KHR_techniques_webgl",
        &[
            ("extensions.KHR_techniques_webgl.shaders[].bufferView", BufferViews),
            ("extensions.KHR_techniques_webgl.techniques[].uniforms{}.node", Nodes),
            ("extensions.KHR_techniques_webgl.techniques[].uniforms{}.value.index", Textures),
            ("materials[].extensions.KHR_techniques_webgl.values{}.index", Textures),
        ],
    ),
    ("KHR_texture_basisu", &[("textures[].extensions.KHR_texture_basisu.source", Images)]),
    ("KHR_texture_transform", &[]),
    ("MOZ_alt_materials", &[("materials[].extensions.MOZ_alt_materials{}", Materials)]),
    ("MOZ_lightmap", &[("materials[].extensions.MOZ_lightmap.index", Textures)]),
    ("MOZ_texture_rgbe", &[("textures[].extensions.MOZ_texture_rgbe.source", Images)]),
    ("MPEG_texture_video", &[("textures[].extensions.MPEG_texture_video.accessor", Accessors)]),
    (
        "MSFT_packing_normalRoughnessMetallic",
        &[(
            "materials[].extensions.MSFT_packing_normalRoughnessMetallic\
             .normalRoughnessMetallicTexture.index",
            Textures,
        )],
    ),
    (
        "MSFT_packing_occlusionRoughnessMetallic",
        &[
            (
                "materials[].extensions.MSFT_packing_occlusionRoughnessMetallic\
                 .occlusionRoughnessMetallicTexture.index",
                Textures,
            ),
            (
                "materials[].extensions.MSFT_packing_occlusionRoughnessMetallic\
                 .roughnessMetallicOcclusionTexture.index",
                Textures,
            ),
            (
                "materials[].extensions.MSFT_packing_occlusionRoughnessMetallic\
                 .normalTexture.index",
                Textures,
            ),
        ],
    ),
    ("MSFT_texture_dds", &[("textures[].extensions.MSFT_texture_dds.source", Images)]),
    (
        "NV_materials_mdl",
        &[
            ("extensions.NV_materials_mdl.modules[].bufferView", BufferViews),
            ("extensions.NV_materials_mdl.bsdfMeasurements[].bufferView", BufferViews),
        ],
    ),
    (
        "OMI_environment_sky",
        &[
            ("extensions.OMI_environment_sky.skies[].panorama.cubemap[]", Textures),
            ("extensions.OMI_environment_sky.skies[].panorama.equirectangular", Textures),
        ],
    ),
    (
        "VRMC_materials_mtoon",
        &[
            ("materials[].extensions.VRMC_materials_mtoon.shadeMultiplyTexture.index", Textures),
            ("materials[].extensions.VRMC_materials_mtoon.shadingShiftTexture.index", Textures),
            ("materials[].extensions.VRMC_materials_mtoon.matcapTexture.index", Textures),
            ("materials[].extensions.VRMC_materials_mtoon.rimMultiplyTexture.index", Textures),
            (
                "materials[].extensions.VRMC_materials_mtoon.outlineWidthMultiplyTexture.index",
                Textures,
            ),
            ("materials[].extensions.VRMC_materials_mtoon.uvAnimationMaskTexture.index", Textures),
        ],
    ),
    ("VRMC_materials_hdr_emissiveMultiplier", &[]),
    // Features of 3D Tiles, data of buildings.
    ("AGI_articulations", &[]),
    ("AGI_stk_metadata", &[]),
    (
        "EXT_feature_metadata",
        &[
            (
                "extensions.EXT_feature_metadata.featureTables{}.properties{}.bufferView",
                BufferViews,
            ),
            (
                "extensions.EXT_feature_metadata.featureTables{}.properties{}\
                 .arrayOffsetBufferView",
                BufferViews,
            ),
            (
                "extensions.EXT_feature_metadata.featureTables{}.properties{}\
                 .stringOffsetBufferView",
                BufferViews,
            ),
            (
                "extensions.EXT_feature_metadata.featureTextures{}.properties{}.texture.index",
                Textures,
            ),
            (
                "meshes[].primitives[].extensions.EXT_feature_metadata.featureIdTextures[]\
                 .featureIds.texture.index",
                Textures,
            ),
        ],
    ),
    ("EXT_instance_features", &[]),
    (
        "EXT_mesh_features",
        &[(
            "meshes[].primitives[].extensions.EXT_mesh_features.featureIds[].texture.index",
            Textures,
        )],
    ),
    (
        "EXT_structural_metadata",
        &[
            (
                "extensions.EXT_structural_metadata.propertyTables[].properties{}.values",
                BufferViews,
            ),
            (
                "extensions.EXT_structural_metadata.propertyTables[].properties{}.arrayOffsets",
                BufferViews,
            ),
            (
                "extensions.EXT_structural_metadata.propertyTables[].properties{}.stringOffsets",
                BufferViews,
            ),
            ("extensions.EXT_structural_metadata.propertyTextures[].properties{}.index", Textures),
        ],
    ),
    (
        "GRIFFEL_bim_data",
        &[
            ("extensions.GRIFFEL_bim_data.nodeProperties[].node", Nodes),
            ("nodes[].extensions.GRIFFEL_bim_data.bufferView", BufferViews),
        ],
    ),
    // Sound, motion, streams.
    ("KHR_animation_pointer", &[]),
    ("KHR_audio", &[("extensions.KHR_audio.audio[].bufferView", BufferViews)]),
    ("KHR_audio_emitter", &[("extensions.KHR_audio_emitter.audio[].bufferView", BufferViews)]),
    ("KHR_interactivity", &[]),
    (
        "MPEG_accessor_timed",
        &[("accessors[].extensions.MPEG_accessor_timed.bufferView", BufferViews)],
    ),
    ("MPEG_animation_timing", &[("extensions.MPEG_animation_timing.accessor", Accessors)]),
    (
        "MPEG_audio_spatial",
        &[("nodes[].extensions.MPEG_audio_spatial.sources[].accessors[]", Accessors)],
    ),
    ("MPEG_buffer_circular", &[]),
    ("MPEG_media", &[]),
    ("MPEG_scene_dynamic", &[]),
    (
        "MPEG_viewport_recommended",
        &[
            ("extensions.MPEG_viewport_recommended.viewports[].translation", Accessors),
            ("extensions.MPEG_viewport_recommended.viewports[].rotation", Accessors),
            ("extensions.MPEG_viewport_recommended.viewports[].parameters", Accessors),
        ],
    ),
    ("MSFT_audio_emitter", &[("extensions.MSFT_audio_emitter.clips[].bufferView", BufferViews)]),
    (
        "OMI_audio_emitter",
        &[
            ("extensions.OMI_audio_emitter.audio[].bufferView", BufferViews),
            ("extensions.OMI_audio_emitter.audioSources[].bufferView", BufferViews),
        ],
    ),
    ("OMI_audio_ogg_vorbis", &[]),
    ("OMI_audio_opus", &[]),
    // Bodies and their shapes.
    (
        "KHR_collision_shapes",
        &[
            ("extensions.KHR_collision_shapes.shapes[].convex.mesh", Meshes),
            ("extensions.KHR_collision_shapes.shapes[].trimesh.mesh", Meshes),
        ],
    ),
    ("KHR_implicit_shapes", &[]),
    (
        "KHR_physics_rigid_bodies",
        &[
            ("nodes[].extensions.KHR_physics_rigid_bodies.collider.geometry.node", Nodes),
            ("nodes[].extensions.KHR_physics_rigid_bodies.collider.geometry.mesh", Meshes),
            ("nodes[].extensions.KHR_physics_rigid_bodies.trigger.geometry.node", Nodes),
            ("nodes[].extensions.KHR_physics_rigid_bodies.trigger.geometry.mesh", Meshes),
            ("nodes[].extensions.KHR_physics_rigid_bodies.trigger.nodes[]", Nodes),
            ("nodes[].extensions.KHR_physics_rigid_bodies.joint.connectedNode", Nodes),
        ],
    ),
    (
        "OMI_collider",
        &[
            ("extensions.OMI_collider.colliders[].mesh", Meshes),
            ("nodes[].extensions.OMI_collider.mesh", Meshes),
        ],
    ),
    ("OMI_physics_body", &[("nodes[].extensions.OMI_physics_body.trigger.nodes[]", Nodes)]),
    ("OMI_physics_gravity", &[]),
    (
        "OMI_physics_joint",
        &[
            ("nodes[].extensions.OMI_physics_joint.connectedNode", Nodes),
            ("nodes[].extensions.OMI_physics_joint.nodeA", Nodes),
            ("nodes[].extensions.OMI_physics_joint.nodeB", Nodes),
        ],
    ),
    (
        "OMI_physics_shape",
        &[
            ("extensions.OMI_physics_shape.shapes[].convex.mesh", Meshes),
            ("extensions.OMI_physics_shape.shapes[].trimesh.mesh", Meshes),
            ("extensions.OMI_physics_shape.shapes[].mesh", Meshes),
        ],
    ),
    ("OMI_seat", &[]),
    ("OMI_spawn_point", &[]),
    ("OMI_vehicle_body", &[("nodes[].extensions.OMI_vehicle_body.pilotSeat", Nodes)]),
    ("OMI_vehicle_hover_thruster", &[]),
    ("OMI_vehicle_thruster", &[]),
    ("OMI_vehicle_wheel", &[]),
    // Avatars.
    (
        "VRM",
        &[
            ("extensions.VRM.meta.texture", Textures),
            ("extensions.VRM.humanoid.humanBones[].node", Nodes),
            ("extensions.VRM.firstPerson.firstPersonBone", Nodes),
            ("extensions.VRM.firstPerson.meshAnnotations[].mesh", Meshes),
            ("extensions.VRM.blendShapeMaster.blendShapeGroups[].binds[].mesh", Meshes),
            ("extensions.VRM.secondaryAnimation.boneGroups[].center", Nodes),
            ("extensions.VRM.secondaryAnimation.boneGroups[].bones[]", Nodes),
            ("extensions.VRM.secondaryAnimation.colliderGroups[].node", Nodes),
            ("extensions.VRM.materialProperties[].textureProperties{}", Textures),
        ],
    ),
    (
        "VRMC_node_constraint",
        &[
            ("nodes[].extensions.VRMC_node_constraint.constraint.roll.source", Nodes),
            ("nodes[].extensions.VRMC_node_constraint.constraint.aim.source", Nodes),
            ("nodes[].extensions.VRMC_node_constraint.constraint.rotation.source", Nodes),
        ],
    ),
    (
        "VRMC_springBone",
        &[
            ("extensions.VRMC_springBone.colliders[].node", Nodes),
            ("extensions.VRMC_springBone.springs[].joints[].node", Nodes),
            ("extensions.VRMC_springBone.springs[].center", Nodes),
        ],
    ),
    ("VRMC_springBone_extended_collider", &[]),
    (
        "VRMC_vrm",
        &[
            ("extensions.VRMC_vrm.meta.thumbnailImage", Images),
            ("extensions.VRMC_vrm.humanoid.humanBones{}.node", Nodes),
            ("extensions.VRMC_vrm.firstPerson.meshAnnotations[].node", Nodes),
            ("extensions.VRMC_vrm.expressions.preset{}.morphTargetBinds[].node", Nodes),
            ("extensions.VRMC_vrm.expressions.custom{}.morphTargetBinds[].node", Nodes),
            ("extensions.VRMC_vrm.expressions.preset{}.materialColorBinds[].material", Materials),
            ("extensions.VRMC_vrm.expressions.custom{}.materialColorBinds[].material", Materials),
            (
                "extensions.VRMC_vrm.expressions.preset{}.textureTransformBinds[].material",
                Materials,
            ),
            (
                "extensions.VRMC_vrm.expressions.custom{}.textureTransformBinds[].material",
                Materials,
            ),
        ],
    ),
    (
        "VRMC_vrm_animation",
        &[
            ("extensions.VRMC_vrm_animation.humanoid.humanBones{}.node", Nodes),
            ("extensions.VRMC_vrm_animation.expressions.preset{}.node", Nodes),
            ("extensions.VRMC_vrm_animation.expressions.custom{}.node", Nodes),
            ("extensions.VRMC_vrm_animation.lookAt.node", Nodes),
        ],
    ),
    // Everything else.
    ("GODOT_single_root", &[]),
    ("KHR_node_hoverability", &[]),
    ("KHR_node_selectability", &[]),
    ("KHR_node_visibility", &[]),
    ("KHR_xmp", &[]),
    ("KHR_xmp_json_ld", &[]),
];

/// Beginnings of names of further extensions that refer to nothing but nodes, meshes, materials
/// and textures, which keep their numbers.
pub(super) const PREFIXES: &[&str] = &[
    "ADOBE_materials_",
    "EXT_materials_",
    "EXT_texture_",
    "GODOT_",
    "KHR_materials_",
    "KHR_physics_",
    "KHR_techniques_",
    "KHR_texture_",
    "MOZ_",
    "MSFT_materials_",
    "MSFT_texture_",
    "OMI_",
    "VRMC_",
];

/// Lists of which an entry is about one mesh or node, and goes with it.
pub(super) const LISTS_OF_BINDS: [&str; 3] = ["binds", "meshAnnotations", "morphTargetBinds"];

/// Extensions of a primitive that count or name its vertices or triangles, which change: dropped
/// from primitives with triangles.
pub(super) const DROPPED_FROM_PRIMITIVES: [&str; 4] = [
    "KHR_draco_mesh_compression",
    "CESIUM_primitive_outline",
    "EXT_mesh_primitive_edge_visibility",
    "FB_ngon_encoding",
];

/// The same of a mesh.
pub(super) const DROPPED_FROM_MESHES: [&str; 3] =
    ["EXT_mesh_manifold", "EXT_mesh_primitive_restart", "MPEG_mesh_linking"];

#[cfg(test)]
mod tests {
    use super::*;
    use std::collections::BTreeSet;
    use std::fmt::Write;

    /// The rows of docs/EXTENSIONS.md.
    fn page() -> String {
        let mut page = String::new();
        let mut all: Vec<&Entry> = EXTENSIONS.iter().collect();
        all.sort_unstable_by_key(|(name, _)| *name);
        for (name, paths) in all {
            let row = |(path, pool): &(&str, Pool)| format!("`{path}` → {}", pool.name());
            let cell = match paths {
                [] => "none".to_owned(),
                _ => paths.iter().map(row).collect::<Vec<_>>().join("<br>"),
            };
            writeln!(page, "| {name} | {cell} |").expect("a String takes everything");
        }
        page
    }

    #[test]
    fn the_page_shows_the_table() {
        let path = concat!(env!("CARGO_MANIFEST_DIR"), "/../docs/EXTENSIONS.md");
        let text = std::fs::read_to_string(path).expect("the page is there");
        let (head, table) = text.split_once("| --- | --- |\n").expect("a table");
        let (rows, tail) = table.split_once("\n\n").expect("text after the table");
        if std::env::var_os("UPDATE").is_some() {
            let page = page();
            let text = format!("{head}| --- | --- |\n{}\n\n{tail}", page.trim_end());
            std::fs::write(path, text).expect("the page can be written");
            return;
        }
        assert_eq!(rows, page().trim_end(), "UPDATE=1 writes docs/EXTENSIONS.md anew");
    }

    #[test]
    fn paths_lead_through_their_extension_and_names_are_unique() {
        let names: BTreeSet<&str> = EXTENSIONS.iter().map(|(name, _)| *name).collect();
        assert_eq!(names.len(), EXTENSIONS.len());
        for (name, paths) in EXTENSIONS {
            for (path, _) in *paths {
                let inside = format!("extensions.{name}");
                assert!(path.contains(&inside), "{path} is no place of {name}");
                assert!(!path.contains(' '), "{path}");
            }
        }
    }
}
