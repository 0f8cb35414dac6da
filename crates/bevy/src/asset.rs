//! A `.lodc` file as an asset.

use crate::mesh::submesh_mesh;
use bevy_asset::io::Reader;
use bevy_asset::{Asset, AssetLoader, Handle, LoadContext};
use bevy_ecs::error::BevyError;
use bevy_math::{Mat4, Vec3};
use bevy_mesh::Mesh;
use bevy_reflect::TypePath;
use bevy_transform::components::Transform;
use lodc::formats::{Document, Limits, ObjectInfo, scene_graph};
use lodc::level_mesh::{MeshOptions, meshes};
use lodc::scene::{Arrangement, Placement};
use lodc::{LodFile, Select, scene_levels};
use serde::{Deserialize, Serialize};

/// The objects of a file, each at some levels.
#[derive(Asset, TypePath, Debug)]
pub struct Lodc {
    /// In the order of the file.
    pub objects: Vec<LodcObject>,
    /// Where the default scene shows them, at rest.
    pub placements: Vec<LodcPlacement>,
}

/// An object at some levels.
#[derive(Debug)]
pub struct LodcObject {
    /// Its name in the input.
    pub name: String,
    /// The name of each submesh's material, if the input has one.
    pub materials: Vec<Option<String>>,
    /// Its levels, the finest first.
    pub levels: Vec<LodcLevel>,
    /// Middle of the box around LOD 0, in the mesh's units.
    pub centre: Vec3,
    /// Radius of a sphere around it that holds everything, in the mesh's units.
    pub radius: f32,
}

/// An object at one level.
#[derive(Debug)]
pub struct LodcLevel {
    /// Largest distance from LOD 0, in the mesh's units: times the scale of any placement a bound
    /// of what that placement errs.
    pub error: f32,
    /// Triangles of all submeshes.
    pub triangles: u32,
    /// The mesh of each submesh; the default handle, which shows nothing, where none of its
    /// triangles is left.
    pub meshes: Vec<Handle<Mesh>>,
}

/// An object where the scene shows it.
#[derive(Clone, Copy, Debug)]
pub struct LodcPlacement {
    /// Index of the object.
    pub object: usize,
    /// From the mesh's units to the scene. Shear, which Bevy's transforms do not have, is left out.
    pub transform: Transform,
}

/// A level that is wanted, as options of `lodc extract` say it. Of several objects, those lose
/// triangles first that lose least by it.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub enum LevelTarget {
    /// At most this share of the triangles.
    Ratio(f64),
    /// The most triangles.
    Triangles(u64),
    /// An error of at most that, in world units.
    Error(f64),
}

/// The levels that a file is loaded with, the finest first.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct LodcSettings {
    /// Each takes the memory of its meshes.
    pub levels: Vec<LevelTarget>,
}

impl Default for LodcSettings {
    /// From all triangles to a hundredth, each level about half of the one before: together they
    /// take twice the memory of the finest.
    fn default() -> Self {
        let shares = [1.0, 0.5, 0.25, 0.12, 0.06, 0.03, 0.01];
        Self { levels: shares.map(LevelTarget::Ratio).to_vec() }
    }
}

/// Loads `.lodc` files.
#[derive(Clone, Copy, Debug, Default, TypePath)]
pub struct LodcLoader;

impl AssetLoader for LodcLoader {
    type Asset = Lodc;
    type Settings = LodcSettings;
    type Error = BevyError;

    async fn load(
        &self,
        reader: &mut dyn Reader,
        settings: &LodcSettings,
        context: &mut LoadContext<'_>,
    ) -> Result<Lodc, BevyError> {
        let mut bytes = Vec::new();
        reader.read_to_end(&mut bytes).await?;
        let file = lodc::read(&bytes)?;
        let objects =
            file.objects.iter().map(|o| object_without_levels(&o.info, o.simplified.mesh()));
        let mut objects: Vec<LodcObject> = objects.collect();
        for (number, target) in settings.levels.iter().enumerate() {
            add_level(&file, number, *target, &mut objects, context)?;
        }
        let infos: Vec<&ObjectInfo> = file.objects.iter().map(|o| &o.info).collect();
        name_materials(&mut objects, &file.document, &infos)?;
        Ok(Lodc { objects, placements: placements(&file.document, &infos)? })
    }

    fn extensions(&self) -> &[&str] {
        &["lodc"]
    }
}

/// An object without levels.
pub(crate) fn object_without_levels(info: &ObjectInfo, mesh: &lodc::mesh::Mesh) -> LodcObject {
    let (low, high) = mesh.bounds();
    let [low, high] = [low, high].map(Vec3::from_array);
    LodcObject {
        name: info.name.clone(),
        materials: vec![None; info.submeshes.len()],
        levels: Vec::new(),
        centre: low.midpoint(high),
        radius: low.distance(high) / 2.0,
    }
}

/// Names the materials of objects.
///
/// # Errors
/// If the document is damaged.
pub(crate) fn name_materials(
    objects: &mut [LodcObject],
    document: &Document,
    infos: &[&ObjectInfo],
) -> Result<(), BevyError> {
    let materials = lodc::formats::materials(document, infos, &Limits::DEFAULT)?;
    for (object, numbers) in objects.iter_mut().zip(&materials.of_submesh) {
        let name = |number: &Option<usize>| number.map(|n| materials.list[n].name.clone());
        object.materials = numbers.iter().map(name).collect();
    }
    Ok(())
}

/// Adds a level of each object, with meshes as assets labelled by the level's `number`.
fn add_level(
    file: &LodFile,
    number: usize,
    target: LevelTarget,
    objects: &mut [LodcObject],
    context: &mut LoadContext<'_>,
) -> Result<(), BevyError> {
    let select = match target {
        LevelTarget::Ratio(share) => Select::Ratio(share),
        LevelTarget::Triangles(most) => Select::Triangles(most),
        LevelTarget::Error(error) => Select::Error(error),
    };
    let scene = scene_levels(&file.objects, &file.document, &Limits::DEFAULT)?;
    let lods = scene.select(select)?.lods;
    let unevenness: Vec<f64> = scene.objects().iter().map(|o| o.unevenness).collect();
    let v_is_upward = matches!(file.document, Document::Obj(_));
    let levels = meshes(&file.objects, &lods, MeshOptions::default())?;
    for (at, (object, level)) in objects.iter_mut().zip(levels).enumerate() {
        let mesh = &level.mesh;
        let mut handle = |submesh: usize| match mesh.submeshes()[submesh].triangle_count {
            0 => Handle::default(),
            _ => {
                let label = format!("object{at}/level{number}/submesh{submesh}");
                context.add_labeled_asset(label, submesh_mesh(mesh, submesh, v_is_upward))
            }
        };
        object.levels.push(LodcLevel {
            error: (unevenness[at] * level.error) as f32,
            triangles: mesh.triangles().len() as u32,
            meshes: (0..mesh.submeshes().len()).map(&mut handle).collect(),
        });
    }
    Ok(())
}

/// Where the default scene of a document shows objects.
pub(crate) fn placements(
    document: &Document,
    infos: &[&ObjectInfo],
) -> Result<Vec<LodcPlacement>, BevyError> {
    let graph = scene_graph(document, infos, &Limits::DEFAULT)?;
    let scene = Arrangement::new(&graph, &graph.rest_pose(), infos.len());
    let as_transform = |placement: &Placement| {
        let columns = placement.transform.to_cols_array_2d().map(|c| c.map(|v| v as f32));
        let [x, y, z, t] = columns.map(|[x, y, z]| Vec3::new(x, y, z));
        let matrix = Mat4::from_cols(x.extend(0.0), y.extend(0.0), z.extend(0.0), t.extend(1.0));
        LodcPlacement { object: placement.object, transform: Transform::from_matrix(matrix) }
    };
    Ok(scene.placements().iter().map(as_transform).collect())
}
