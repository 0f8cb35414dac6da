//! One file or stream: its input, what has been read of it, and its output.

use crate::Status;
use lodc_formats::export::{ExportFormat, ExportObject, export};
use lodc_formats::images::Textures;
use lodc_formats::lodc::LodFile;
use lodc_formats::lods::Unpacker;
use lodc_formats::{FormatError, Limits, lodc};
use std::fmt::Write;
use std::path::Path;

/// A `.lodc` file, or a `.lods` stream that is fed piece by piece.
#[derive(Debug, Default)]
pub struct Session {
    input: Vec<u8>,
    output: Vec<u8>,
    stream: Option<Unpacker>,
}

impl Session {
    /// Room for the next input of `length` bytes.
    pub fn input(&mut self, length: usize) -> &mut [u8] {
        self.input.clear();
        self.input.resize(length, 0);
        &mut self.input
    }

    /// The result of the last call.
    #[must_use]
    pub fn output(&self) -> &[u8] {
        &self.output
    }

    /// Takes the input as a whole `.lodc` file. The output is a GLB with all levels
    /// ([`crate::levels()`]).
    pub fn open(&mut self) -> Status {
        let input = std::mem::take(&mut self.input);
        let glb = lodc::read(&input, &[]).and_then(|file| levels(&file));
        self.answer(glb)
    }

    /// Takes the input as the next bytes of a `.lods` stream. The output is the progress as JSON:
    /// `{"complete", "bytes", "objects": [{"vertices", "triangles", "steps", "error",
    /// "rms"}]}`, each count as `[so far, in all]`.
    pub fn feed(&mut self) -> Status {
        let stream = self.stream.get_or_insert_with(|| Unpacker::new(Limits::DEFAULT));
        let fed = stream.feed(&self.input);
        let state = fed.map(|()| progress(stream).into_bytes());
        self.answer(state)
    }

    /// The output is a GLB of the scene as far as the stream has come; empty before its first
    /// object.
    pub fn mesh(&mut self) -> Status {
        let glb = match &self.stream {
            Some(stream) => mesh(stream),
            None => Ok(Vec::new()),
        };
        self.answer(glb)
    }

    fn answer(&mut self, result: Result<Vec<u8>, FormatError>) -> Status {
        let (output, status) = match result {
            Ok(bytes) => (bytes, Status::Done),
            Err(e) => (e.to_string().into_bytes(), Status::Failed),
        };
        self.output = output;
        status
    }
}

/// A file as a GLB with all levels.
fn levels(file: &LodFile) -> Result<Vec<u8>, FormatError> {
    // A browser has no folder: images of other files cannot be read.
    let (path, textures) = (Path::new("levels.glb"), Textures::default());
    let (document, objects) = (&file.document, &file.objects);
    let (glb, _) = crate::levels(path, document, objects, |_| None, textures, &Limits::DEFAULT)?;
    Ok(glb.bytes)
}

/// The scene of a stream so far as a GLB; empty before its first object.
fn mesh(stream: &Unpacker) -> Result<Vec<u8>, FormatError> {
    let Some(arrived) = stream.arrived()? else { return Ok(Vec::new()) };
    if stream.objects() == 0 && !stream.is_complete() {
        return Ok(Vec::new());
    }
    let meshes: Vec<_> = (0..stream.objects())
        .map(|o| stream.mesh(o).map(|(mesh, _)| mesh))
        .collect::<Result<_, _>>()?;
    let objects: Vec<ExportObject<'_>> = meshes
        .iter()
        .enumerate()
        .map(|(o, mesh)| ExportObject { info: &arrived.infos[o], mesh })
        .collect();
    let files = export(Path::new("mesh.glb"), ExportFormat::Glb, &arrived.document, &objects)?;
    Ok(files.into_iter().next().map(|file| file.bytes).unwrap_or_default())
}

/// The JSON of [`Session::feed`].
fn progress(stream: &Unpacker) -> String {
    let mut json = format!(
        "{{\"complete\":{},\"bytes\":{},\"objects\":[",
        stream.is_complete(),
        stream.bytes()
    );
    for object in 0..stream.objects() {
        let p = stream.progress(object);
        let ([vertices, all_vertices], [triangles, all_triangles], [steps, all_steps]) =
            (p.vertices, p.triangles, p.steps);
        let comma = if object > 0 { "," } else { "" };
        let error = if p.error.is_finite() { p.error } else { f32::MAX };
        let rms = p.rms.map_or("null".to_owned(), |rms| rms.min(f32::MAX).to_string());
        // Writing to a string cannot fail.
        let _ = write!(
            json,
            "{comma}{{\"vertices\":[{vertices},{all_vertices}],\
             \"triangles\":[{triangles},{all_triangles}],\"steps\":[{steps},{all_steps}],\
             \"error\":{error},\"rms\":{rms}}}"
        );
    }
    json.push_str("]}");
    json
}
