//! One level of all objects as the files of a mesh format.

use crate::LodObject;
use crate::level_mesh::{LevelMesh, largest_of_meshes, written_distances};
use lodc_formats::export::{
    ExportFormat, ExportObject, ExportOptions, LevelFacts, Provenance, export_with, left_out,
};
use lodc_formats::{Document, FormatError, OutputFile};
use lodc_mesh::Lod;
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
    /// Error and rms: the largest of all objects, in world units, with what writing rounds. The
    /// files state them, but no rms that is not finite.
    pub distances: (f64, Option<f64>),
    /// A line on what of the asset the format cannot hold.
    pub left_out: Option<String>,
}

impl LevelOf<'_> {
    /// Makes the files of the level at `path` from the meshes of its objects, one each. Adds what
    /// writing rounds to the meshes' `error` and `rms`, in mesh units: called twice with the same
    /// meshes, it adds twice. Any provenance in `options` is replaced.
    ///
    /// # Errors
    /// If the format cannot hold the level, or the document is damaged.
    pub fn files(
        &self,
        meshes: &mut [LevelMesh],
        path: &Path,
        format: ExportFormat,
        options: &ExportOptions,
    ) -> Result<WrittenLevel, FormatError> {
        let Self { objects, document, source, lod } = *self;
        let written = written_distances(objects, document, meshes, format, options.precision)?;
        for (mesh, (error, rms)) in meshes.iter_mut().zip(written) {
            (mesh.error, mesh.rms) = (error, rms);
        }
        let (error, rms) = largest_of_meshes(objects, meshes);
        let lod = lod.map(|lod| lod.0);
        let stated_rms = rms.filter(|rms| rms.is_finite());
        let provenance = Provenance {
            source,
            levels: vec![LevelFacts { lod, error, rms: stated_rms, geomorph: None }],
            refitted: meshes.iter().any(|mesh| mesh.refitted),
            screen: None,
            next: None,
            poses: Some(objects.iter().map(|o| o.info.poses.clone()).collect()),
        };
        let options = ExportOptions { provenance: Some(provenance), ..options.clone() };
        let exported: Vec<ExportObject<'_>> = objects
            .iter()
            .zip(&*meshes)
            .map(|(object, level)| ExportObject { info: &object.info, mesh: &level.mesh })
            .collect();
        Ok(WrittenLevel {
            left_out: left_out(format, document, &exported),
            files: export_with(path, format, document, &exported, &options)?,
            distances: (error, rms),
        })
    }
}
