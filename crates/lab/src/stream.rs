//! An object as a progressive stream: its size, how fast it is written and read, and what a part of
//! it looks like.

use crate::baseline::ProgressiveMesh;
use crate::error::LabError;
use crate::prepared::Prepared;
use crate::report::{PrefixReport, StreamReport, StreamTimings};
use crate::timings::Timings;
use lodc::{LodFile, LodObject};
use lodc_formats::lodc::Layout;
use lodc_formats::lods::{PackOptions, Quantize, Unpacker, pack};
use lodc_formats::{Document, FormatError, Limits, ObjDocument, Source, SourceFormat};
use lodc_measure::{
    Sampling, ShadingOptions, Surface, Viewing, compare_pictures, distances, pictures,
};
use lodc_mesh::Mesh;
use rayon::ThreadPoolBuilder;
use std::hint::black_box;
use std::sync::Arc;
use std::time::Instant;

/// Parts of the stream, in percent of its bytes, whose meshes are measured. Chosen by hand.
const PERCENTS: [u32; 6] = [1, 2, 5, 10, 25, 50];
/// How distances of such meshes are sampled. The numbers are chosen by hand: more
/// samples take more time.
const SAMPLING: Sampling = Sampling { samples: 50_000, lattice: 50_000, ..Sampling::DEFAULT };

/// Measures the streams of an object: lossless in batches and in the exact order, and quantised.
///
/// # Errors
/// If one cannot be packed or unpacked: a bug.
pub(crate) fn measure(prepared: &Prepared, rounds: Option<u32>) -> Result<StreamReport, LabError> {
    let object = &prepared.object;
    let file = file_of(object);
    let bug = |e: FormatError| LabError::Bug(format!("{}: {e}", object.info.name));
    // Normals and texture coordinates need fewer bits than positions do. Chosen by hand.
    let packed = |bits: Option<u8>, exact: bool| {
        let quantize = Quantize {
            position: bits,
            normal: bits.map(|b| b.min(10)),
            uv: bits.map(|b| b.min(12)),
        };
        pack(&file, &PackOptions { quantize, exact, ..PackOptions::default() }).map_err(bug)
    };
    let whole = packed(None, false)?;
    let (exact, quantized) = (packed(None, true)?, packed(Some(16), false)?);
    let vertices = object.simplified.mesh().vertex_count().max(1) as f64;
    let bits = |bytes: u64| 8.0 * bytes as f64 / vertices;
    let speed = |rounds: u32| -> Result<StreamTimings, LabError> {
        let one_thread = ThreadPoolBuilder::new().num_threads(1).build();
        let one_thread =
            one_thread.map_err(|e| LabError::Limit(format!("no thread to work with: {e}")))?;
        let encode =
            one_thread.install(|| timed(rounds, || packed(None, false).map(|p| p.bytes.len())))?;
        let decode =
            one_thread.install(|| timed(rounds, || index_list(&whole.bytes).map_err(bug)))?;
        let triangles = object.simplified.mesh().triangles().len() as f64;
        let rate = |timings: &Timings| triangles / timings.best() / 1e3;
        Ok(StreamTimings {
            encode_ms: encode.best(),
            decode_ms: decode.best(),
            encode_spread: encode.spread(),
            decode_spread: decode.spread(),
            encode_million_triangles_per_second: rate(&encode),
            decode_million_triangles_per_second: rate(&decode),
        })
    };
    let progressive = ProgressiveMesh::build(&object.simplified)
        .map_err(|e| LabError::Bug(format!("{}: {e}", object.info.name)))?;
    Ok(StreamReport {
        bytes: whole.bytes.len() as u64,
        lossless: bits(whole.objects[0].bytes),
        lossless_exact: bits(exact.objects[0].bytes),
        quantized: bits(quantized.objects[0].bytes),
        packages: bits(whole.objects[0].package_bytes),
        packages_normals: bits(whole.objects[0].package_bytes_with_normals),
        progressive_mesh: bits(progressive.packages(false)),
        progressive_mesh_normals: bits(progressive.packages(true)),
        speed: rounds.map(speed).transpose()?,
        prefixes: prefixes(&whole.bytes).map_err(bug)?,
    })
}

/// An object as a file of its own, without models.
fn file_of(object: &LodObject) -> LodFile {
    let object = LodObject {
        info: object.info.clone(),
        simplified: Arc::clone(&object.simplified),
        models: Vec::new(),
    };
    LodFile {
        source: Source { format: SourceFormat::Obj, content_hash: 0 },
        document: Document::Obj(ObjDocument::default()),
        objects: vec![object],
        made_from: None,
        layout: Layout::Packed,
        left_out: Vec::new(),
    }
}

/// Milliseconds of all rounds.
fn timed<T>(rounds: u32, work: impl Fn() -> Result<T, LabError>) -> Result<Timings, LabError> {
    let round = |_| {
        let start = Instant::now();
        black_box(work()?);
        Ok(start.elapsed().as_secs_f64() * 1e3)
    };
    (0..rounds).map(round).collect()
}

/// Decodes a stream to the index list of its finest level.
fn index_list(bytes: &[u8]) -> Result<Vec<[u32; 3]>, FormatError> {
    let mut unpacker = Unpacker::new(Limits::DEFAULT);
    unpacker.feed(bytes)?;
    Ok(unpacker.decoder(0).triangles().collect())
}

/// Measures how far the mesh that each prefix of a stream shows is from the whole, in space and in
/// pictures; shape only.
fn prefixes(bytes: &[u8]) -> Result<Vec<PrefixReport>, FormatError> {
    let mesh_of = |bytes: &[u8]| -> Result<Option<Mesh>, FormatError> {
        let mut unpacker = Unpacker::new(Limits::DEFAULT);
        unpacker.feed(bytes)?;
        (unpacker.objects() > 0).then(|| unpacker.mesh(0).map(|(mesh, _)| mesh)).transpose()
    };
    let Some(whole) = mesh_of(bytes)?.as_ref().map(surface) else { return Ok(Vec::new()) };
    let diagonal = whole.diagonal();
    let (cameras, shading) = (Viewing::DEFAULT.cameras(&whole), ShadingOptions::default());
    let whole_pictures = pictures(&whole, &cameras, shading);
    let report = |percent: u32| {
        let cut = (bytes.len() as u64 * u64::from(percent)).div_ceil(100);
        let part = mesh_of(&bytes[..cut as usize])?
            .as_ref()
            .map(surface)
            .filter(|s| !s.triangles.is_empty());
        let triangles = part.as_ref().map_or(0, |s| s.triangles.len()) as u64;
        let Some(part) = part.filter(|_| diagonal > 0.0) else {
            return Ok(PrefixReport {
                percent,
                bytes: cut,
                triangles,
                rms: None,
                hausdorff: None,
                image: None,
            });
        };
        let both_ways = distances(&whole, &part, &SAMPLING);
        let percent_of_diagonal = |d: [f64; 2]| Some(100.0 * d[0].max(d[1]) / diagonal);
        let image =
            Some(compare_pictures(&whole_pictures, &pictures(&part, &cameras, shading)).rmse);
        Ok(PrefixReport {
            percent,
            bytes: cut,
            triangles,
            rms: percent_of_diagonal(both_ways.rms),
            hausdorff: percent_of_diagonal(both_ways.hausdorff),
            image,
        })
    };
    PERCENTS.into_iter().map(report).collect()
}

fn surface(mesh: &Mesh) -> Surface {
    Surface {
        positions: mesh.positions().iter().map(|&p| p.into()).collect(),
        triangles: mesh.triangles().to_vec(),
        ..Surface::default()
    }
}
