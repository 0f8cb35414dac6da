//! The golden files, `fixtures/golden/v1/*.lodc`, give their facts and are written as ever.
//!
//! They are made by `cargo test -p lodc-formats make_golden_files -- --ignored`, and not again
//! unless the format changes.

use super::tests::{all_models_file, gltf_file, measured_file, two_parts_file, wide};
use super::*;
use crate::testing::{read, write};
use lodc_model::Model;
use std::fmt::Write as _;
use std::path::PathBuf;

fn root() -> PathBuf {
    PathBuf::from(env!("CARGO_MANIFEST_DIR")).join("..")
}

fn golden() -> PathBuf {
    root().join("fixtures/golden/v1")
}

/// Expected facts of a file: one line for the file, one for each object. `tests/second_reader.py`
/// prints the same.
fn facts(name: &str, bytes: &[u8]) -> String {
    let file = read(bytes).expect("a golden file");
    let format = format!("{:?}", file.source.format).to_lowercase();
    let mut text = format!(
        "{name} {format} {:032x} objects {}{}\n",
        file.source.content_hash,
        file.objects.len(),
        if file.layout == Layout::Gpu { " layout gpu" } else { "" }
    );
    for o in &file.objects {
        let (mesh, collapses) = (o.simplified.mesh(), o.simplified.collapses());
        let attributes: u64 =
            mesh.attributes().iter().flat_map(|a| &a.bytes).map(|&b| u64::from(b)).sum();
        let half = collapses.lod_for_triangles(mesh.triangles().len() as u32 / 2);
        let measured = collapses.rms_at(half).map(|rms| {
            let error = collapses.error_at(half);
            format!(" error {:08x} rms {:08x}", error.to_bits(), rms.to_bits())
        });
        let _ = writeln!(
            text,
            "{name} {} vertices {} triangles {} submeshes {} attributes {} sum {attributes} \
             records {} steps {} half {} {} models {}{}",
            o.info.name,
            mesh.vertex_count(),
            mesh.triangles().len(),
            mesh.submeshes().len(),
            mesh.attributes().len(),
            collapses.records(),
            collapses.steps(),
            half.0,
            collapses.triangles_at(half),
            o.models.iter().map(Model::name).collect::<Vec<_>>().join(","),
            measured.unwrap_or_default(),
        );
    }
    text
}

fn files() -> Vec<(String, Vec<u8>)> {
    let mut files: Vec<(String, Vec<u8>)> = std::fs::read_dir(golden())
        .expect("the folder of golden files")
        .map(|entry| entry.expect("an entry").path())
        .filter(|path| path.extension().is_some_and(|e| e == "lodc"))
        .map(|path| {
            let name = path.file_name().expect("a file").to_string_lossy().into_owned();
            (name, std::fs::read(path).expect("a golden file"))
        })
        .collect();
    files.sort();
    files
}

#[test]
fn golden_files_give_their_facts_and_the_same_bytes_again() {
    let files = files();
    assert_eq!(files.len(), 8);
    let all: String = files.iter().map(|(name, bytes)| facts(name, bytes)).collect();
    assert_eq!(all, std::fs::read_to_string(golden().join("facts.txt")).expect("the facts"));
    for (name, bytes) in files {
        let again = write(&read(&bytes).expect("a golden file"));
        assert!(again == bytes, "{name} is written otherwise than it was");
    }
}

/// Bytes that a page shows of a file, and which of them it has shown.
struct GoldenFile {
    name: String,
    bytes: Vec<u8>,
    seen: Vec<bool>,
}

impl GoldenFile {
    fn new(name: &str) -> Self {
        let bytes = std::fs::read(golden().join(name)).expect("a golden file");
        Self { name: name.to_owned(), seen: vec![false; bytes.len()], bytes }
    }

    /// Compares a line: an offset of four digits, two spaces, bytes, a remark.
    fn check(&mut self, line: &str) {
        let Some((offset, rest)) = line.split_once("  ").filter(|(o, _)| o.len() == 4) else {
            return;
        };
        let Ok(offset) = usize::from_str_radix(offset, 16) else { return };
        let shown = rest.split_whitespace().map_while(|word| {
            (word.len() == 2).then(|| u8::from_str_radix(word, 16).ok()).flatten()
        });
        for (at, byte) in (offset..).zip(shown) {
            assert_eq!(self.bytes[at], byte, "{}: the byte at {at:04x}: {line}", self.name);
            self.seen[at] = true;
        }
    }

    /// Asserts that only zeros were left out.
    fn finish(&self) {
        let hidden = (0..self.bytes.len()).find(|&at| !self.seen[at] && self.bytes[at] != 0);
        assert_eq!(hidden, None, "{}: a byte that the page does not show", self.name);
    }
}

#[test]
fn the_page_shows_golden_files_byte_by_byte() {
    let page = std::fs::read_to_string(root().join("docs/FORMAT.md")).expect("the page");
    let mut files: Vec<GoldenFile> = Vec::new();
    for line in page.lines() {
        if let Some((name, _)) =
            line.strip_prefix("`fixtures/golden/v1/").and_then(|rest| rest.split_once('`'))
        {
            files.push(GoldenFile::new(name));
        } else if let Some(file) = files.last_mut() {
            file.check(line);
        }
    }
    assert_eq!(files.len(), 3);
    // Of the last one the page shows what differs from the one before it.
    files[..2].iter().for_each(GoldenFile::finish);
    assert!(files[2].seen.iter().filter(|&&seen| seen).count() > 250);
}

#[test]
#[ignore = "writes the golden files; only when the format changes"]
fn make_golden_files() {
    let files = [
        ("all_models.lodc", all_models_file()),
        ("all_models_gpu.lodc", wide(&all_models_file())),
        ("cube_and_part.lodc", gltf_file(&["cube", "machine_part"])),
        ("measured_cube.lodc", measured_file("cube")),
        ("skinned_tube.lodc", gltf_file(&["skinned_tube_u8"])),
        ("triangle.lodc", measured_file("triangle")),
        ("two_parts.lodc", two_parts_file()),
        ("two_parts_gpu.lodc", wide(&two_parts_file())),
    ];
    std::fs::create_dir_all(golden()).expect("a folder");
    let mut all = String::new();
    for (name, file) in files {
        let bytes = write(&file);
        all += &facts(name, &bytes);
        std::fs::write(golden().join(name), bytes).expect("a file");
    }
    std::fs::write(golden().join("facts.txt"), all).expect("a file");
}
