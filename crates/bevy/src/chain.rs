//! A GLB of `lodc chain`, which has several levels of a scene, as a [`Lodc`] asset.

use crate::asset::{
    Lodc, LodcLevel, LodcObject, name_materials, object_without_levels, placements,
};
use crate::mesh::submesh_mesh;
use bevy_asset::io::Reader;
use bevy_asset::{AssetLoader, Handle, LoadContext};
use bevy_ecs::error::BevyError;
use bevy_mesh::Mesh;
use bevy_reflect::TypePath;
use lodc::formats::import::{ImportOptions, levels_in};
use lodc::formats::{Document, Limits, ObjectInfo, SceneObject, scene_motion};
use serde_json::Value;
use std::path::Path;

/// Loads GLB files that `lodc chain` and `lodc extract` wrote, as `server.load::<Lodc>(path)`:
/// their levels as they are, with the errors that the file states. Other GLB files are refused.
#[derive(Clone, Copy, Debug, Default, TypePath)]
pub struct ChainLoader;

impl AssetLoader for ChainLoader {
    type Asset = Lodc;
    type Settings = ();
    type Error = BevyError;

    async fn load(
        &self,
        reader: &mut dyn Reader,
        (): &(),
        context: &mut LoadContext<'_>,
    ) -> Result<Lodc, BevyError> {
        let mut bytes = Vec::new();
        reader.read_to_end(&mut bytes).await?;
        // Everything lies in the file; its name is for messages.
        let chain = levels_in(bytes, Path::new("chain.glb"), &ImportOptions::default())?;
        let Some(finest) = chain.levels.first() else { return Err("no level".into()) };
        let mut objects: Vec<LodcObject> =
            finest.objects.iter().map(|o| object_without_levels(&o.info, &o.mesh)).collect();
        let infos: Vec<&ObjectInfo> = finest.objects.iter().map(|o| &o.info).collect();
        name_materials(&mut objects, &finest.document, &infos)?;
        let motion = scene_motion(&finest.document, &infos, &Limits::DEFAULT)?;
        let unevenness =
            |at: usize| motion.measured_placements(&finest.objects[at].mesh, at).unevenness;
        let unevenness: Vec<f64> = (0..infos.len()).map(unevenness).collect();
        // The number of each submesh's material, by which submeshes of levels are found again.
        let keys = |object: &SceneObject, document: &Document| {
            let primitives = &meshes(document)[object.info.document_mesh as usize]["primitives"];
            let of = |primitive: u32| primitives[primitive as usize]["material"].clone();
            object.info.submeshes.iter().map(|s| of(s.document_primitive)).collect::<Vec<Value>>()
        };
        for (number, (scene, stated)) in chain.levels.iter().zip(&chain.stated.levels).enumerate() {
            // What has no triangle left is not in the file: the others follow each other as before.
            let mut rest = scene.objects.iter().peekable();
            for (at, (object, whole)) in objects.iter_mut().zip(&finest.objects).enumerate() {
                let own = rest.next_if(|own| own.info.name == whole.info.name);
                let own_keys = own.map(|own| keys(own, &scene.document)).unwrap_or_default();
                let mut submeshes = own_keys.iter().enumerate().peekable();
                let mut mesh = |(submesh, key): (usize, &Value)| -> Handle<Mesh> {
                    let found = submeshes.next_if(|(_, own)| *own == key);
                    let Some(((found, _), own)) = found.zip(own) else { return Handle::default() };
                    let label = format!("object{at}/level{number}/submesh{submesh}");
                    context.add_labeled_asset(label, submesh_mesh(&own.mesh, found, false))
                };
                let all = keys(whole, &finest.document);
                object.levels.push(LodcLevel {
                    error: (unevenness[at] * stated.error / whole.info.world_scale) as f32,
                    triangles: own.map_or(0, |own| own.mesh.triangles().len() as u32),
                    meshes: all.iter().enumerate().map(&mut mesh).collect(),
                });
            }
        }
        Ok(Lodc { objects, placements: placements(&finest.document, &infos)? })
    }

    fn extensions(&self) -> &[&str] {
        &["glb"]
    }
}

/// The meshes of a document, whose primitives name their materials.
fn meshes(document: &Document) -> Value {
    let Document::Gltf(gltf) = document else { return Value::Null };
    let root: Value = serde_json::from_str(gltf.json()).unwrap_or_default();
    root["meshes"].clone()
}
