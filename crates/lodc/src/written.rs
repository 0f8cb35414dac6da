//! One level of all objects as the files of a mesh format.

use crate::level_mesh::{LevelMesh, largest_distance};
use crate::{LodObject, Rounding};
use lodc_formats::export::{
    ExportFormat, ExportObject, ExportOptions, LevelFacts, Provenance, export_with, left_out,
};
use lodc_formats::{Document, FormatError, OutputFile};
use lodc_mesh::Lod;
use rayon::prelude::*;
use std::path::Path;

/// One level of all objects of an asset.
#[derive(Clone, Copy, Debug)]
pub struct LevelOf<'a> {
    /// The objects of the asset.
    pub objects: &'a [LodObject],
    /// The document around them.
    pub document: &'a Document,
    /// The hash of the file that they came from: its XXH3-128.
    pub source: u128,
    /// The LOD to be stated; none where each object has its own, or in a view.
    pub lod: Option<Lod>,
}

/// The files of a level, and what they state.
#[derive(Debug)]
pub struct WrittenLevel {
    /// The files; the one that refers to the others first.
    pub files: Vec<OutputFile>,
    /// Error and rms of each object, in its mesh units, with what writing rounds.
    pub of_objects: Vec<(f64, Option<f64>)>,
    /// The largest of all objects, in world units. The files state them, but no rms that is not
    /// finite.
    pub largest: (f64, Option<f64>),
    /// A line on what of the asset the format cannot hold.
    pub left_out: Option<String>,
    /// One line for each thing that quantising could not do, or did to triangles.
    pub warnings: Vec<String>,
}

impl LevelOf<'_> {
    /// Makes the files of the level at `path` from the meshes of its objects, one each. Replaces
    /// the provenance in `options`.
    ///
    /// # Errors
    /// If the format cannot hold the level, or the document is damaged.
    pub fn files(
        &self,
        meshes: &[LevelMesh],
        path: &Path,
        format: ExportFormat,
        options: &mut ExportOptions,
    ) -> Result<WrittenLevel, FormatError> {
        let Self { objects, document, source, lod } = *self;
        let only_meshes = meshes.iter().map(|level| &level.mesh);
        let rounding = Rounding::new(objects, document, only_meshes, format, options.precision)?;
        let distances = |(o, level): (usize, &LevelMesh)| {
            rounding.distances(o, level.mesh.triangles(), (level.error, level.rms))
        };
        let of_objects: Vec<_> = meshes.par_iter().enumerate().map(distances).collect();
        let triangles: Vec<&[[u32; 3]]> = meshes.iter().map(|m| m.mesh.triangles()).collect();
        let (error, rms) = largest_distance(objects, of_objects.iter().copied());
        let lod = lod.map(|lod| lod.0);
        let stated_rms = rms.filter(|rms| rms.is_finite());
        options.provenance = Some(Provenance {
            source,
            levels: vec![LevelFacts { lod, error, rms: stated_rms, geomorph: None }],
            refitted: meshes.iter().any(|mesh| mesh.refitted),
            screen: None,
            next: None,
            poses: Some(objects.iter().map(|o| o.info.poses.clone()).collect()),
        });
        let exported: Vec<ExportObject<'_>> = objects
            .iter()
            .zip(meshes)
            .map(|(object, level)| ExportObject { info: &object.info, mesh: &level.mesh })
            .collect();
        Ok(WrittenLevel {
            warnings: [rounding.kept(), rounding.flattened(&triangles)].concat(),
            left_out: left_out(format, document, &exported),
            files: export_with(path, format, document, &exported, options)?,
            of_objects,
            largest: (error, rms),
        })
    }
}

/// What a scene of a single object has; none of several, which each have their own.
pub fn single<T: Copy>(of_objects: &[T]) -> Option<T> {
    match of_objects {
        [one] => Some(*one),
        _ => None,
    }
}
