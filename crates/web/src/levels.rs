//! Objects with all their levels as one GLB, and the order in which they lose triangles: LODs of
//! each object, each with its *rank*, its place in the order over all objects. With a budget of
//! triangles, the objects are coarsened by rank.

use lodc_formats::gltf::{LevelsObject, export_levels};
use lodc_formats::images::Textures;
use lodc_formats::lodc::LodObject;
use lodc_formats::{Document, FormatError, Limits, ObjectInfo, OutputFile, scene_motion};
use lodc_select::{ObjectLevels, losses, ranks};
use std::path::Path;

/// Makes a GLB with all levels ([`export_levels`]), and a warning for each texture that is missing.
/// The GLB has the order of several objects, so that their levels for a number of triangles are
/// those of `lodc extract --no-refit`. `strips` may say the strip of each triangle of an object.
///
/// # Errors
/// If the document is damaged, or glTF cannot hold the scene.
pub fn levels<M>(
    path: &Path,
    document: &Document,
    objects: &[LodObject<M>],
    strips: impl Fn(&LodObject<M>) -> Option<Vec<u32>>,
    textures: Textures,
    limits: &Limits,
) -> Result<(OutputFile, Vec<String>), FormatError> {
    let strips: Vec<Option<Vec<u32>>> = objects.iter().map(strips).collect();
    let ranks = ranks_of_objects(document, objects, limits)?;
    let object = |((object, strips), ranks)| {
        let (object, strips): (&LodObject<M>, &Option<Vec<u32>>) = (object, strips);
        let ranks: &Vec<(u32, u32)> = ranks;
        LevelsObject {
            info: &object.info,
            simplified: &object.simplified,
            strips: strips.as_deref(),
            ranks,
        }
    };
    let objects: Vec<_> = objects.iter().zip(&strips).zip(&ranks).map(object).collect();
    export_levels(path, document, &objects, textures)
}

/// The ranks of each object as rank and LOD; none for a single object.
fn ranks_of_objects<'a, M>(
    document: &Document,
    objects: &'a [LodObject<M>],
    limits: &Limits,
) -> Result<Vec<Vec<(u32, u32)>>, FormatError> {
    if objects.len() < 2 {
        return Ok(vec![Vec::new(); objects.len()]);
    }
    let infos: Vec<&ObjectInfo> = objects.iter().map(|o| &o.info).collect();
    let scene = scene_motion(document, &infos, limits)?.largest();
    let levels = |o: &'a LodObject<M>| ObjectLevels {
        name: &o.info.name,
        simplified: &o.simplified,
        scale: o.info.world_scale,
        unevenness: 1.0,
        rounding: 0.0,
    };
    let levels: Vec<ObjectLevels<'_>> = objects.iter().map(levels).collect();
    let as_pairs = |ranks: Vec<lodc_select::RankedLod>| {
        ranks.into_iter().map(|rank| (rank.rank, rank.lod.0)).collect()
    };
    let simplified: Vec<_> = levels.iter().map(|o| o.simplified).collect();
    let candidates: Vec<_> = levels.iter().map(ObjectLevels::candidate).collect();
    let ranks = ranks(&candidates, &losses(&simplified, &scene));
    Ok(ranks.into_iter().map(as_pairs).collect())
}
