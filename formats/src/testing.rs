//! Helpers that the tests of this package share.

use crate::FormatError;
use crate::lodc::{self, Layout, StoredModel};
use lodc_lod::{AnyModel, ModelKind};
use lodc_model::Model;
use std::path::{Path, PathBuf};

/// A file with models that work.
pub(crate) type LodFile = lodc::LodFile<AnyModel>;
/// An object of such a file.
pub(crate) type LodObject = lodc::LodObject<AnyModel>;

/// Reads a file and the models in it.
pub(crate) fn read(bytes: &[u8]) -> Result<LodFile, FormatError> {
    lodc::read(bytes, &ModelKind::ALL.map(ModelKind::name))?.with_models(|simplified, model| {
        let kind = model.name.parse().expect("only kinds that are known are read");
        AnyModel::load(kind, simplified, &model.arrays).map_err(|e| e.to_string())
    })
}

/// Lays out a file with its models.
pub(crate) fn write(file: &LodFile) -> Vec<u8> {
    lodc::write(file, stored)
}

/// A model as it is stored.
pub(crate) fn stored(model: &AnyModel, layout: Layout) -> StoredModel {
    StoredModel { name: model.name().to_owned(), arrays: model.arrays(layout) }
}

/// A folder of its own for one test, removed at the end.
#[derive(Debug)]
pub(crate) struct Scratch(PathBuf);

impl Scratch {
    /// Makes an empty folder; `name` is unique among the tests.
    pub(crate) fn new(name: &str) -> Self {
        let folder = std::env::temp_dir().join(format!("lodc-test-{}-{name}", std::process::id()));
        std::fs::create_dir_all(&folder).expect("a folder for temporary files");
        Self(folder.canonicalize().expect("it was just made"))
    }
    /// A path inside.
    pub(crate) fn path(&self, relative: &str) -> PathBuf {
        if relative.is_empty() { self.0.clone() } else { self.0.join(relative) }
    }
    /// Writes a file inside, with its folders.
    pub(crate) fn write(&self, relative: &str, bytes: &[u8]) {
        let path = self.path(relative);
        std::fs::create_dir_all(path.parent().expect("inside the folder")).expect("a folder");
        std::fs::write(path, bytes).expect("a file");
    }
}

impl Drop for Scratch {
    fn drop(&mut self) {
        // A test that failed for another reason must not fail twice.
        let _ = std::fs::remove_dir_all(&self.0);
    }
}

/// Says something that a person running the tests must see.
#[expect(clippy::print_stdout, reason = "a test that is skipped says so aloud")]
pub(crate) fn say(what: &str) {
    println!("{what}");
}

/// The folder of real models. None, said aloud, if it is not asked for, or if `LODC_CORPUS=none`
/// leaves it out.
pub(crate) fn corpus() -> Option<PathBuf> {
    if !lodc_fixtures::all_asked() {
        say("SKIPPED: needs real models (tests/run --all)");
        return None;
    }
    let folder: PathBuf = std::env::var_os("LODC_CORPUS").expect("LODC_CORPUS is set").into();
    (folder != Path::new("none")).then_some(folder)
}

/// A small generator of numbers that depend on the seed alone (SplitMix64).
#[derive(Debug)]
pub(crate) struct Random(pub(crate) u64);

impl Random {
    /// The next 64 bits.
    pub(crate) fn next(&mut self) -> u64 {
        self.0 = self.0.wrapping_add(0x9e37_79b9_7f4a_7c15);
        let mut x = self.0;
        x = (x ^ (x >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        x = (x ^ (x >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
        x ^ (x >> 31)
    }
    /// A number below `end`, which is at least 1.
    pub(crate) fn below(&mut self, end: usize) -> usize {
        usize::try_from(self.next() % end as u64).expect("below a usize")
    }
    /// A number from 0 up to 1.
    pub(crate) fn unit(&mut self) -> f32 {
        (self.next() >> 40) as f32 / (1u32 << 24) as f32
    }
}

/// Damages a file in one to three places: cut off, a byte changed, a bit turned, a number put in.
/// What is empty then becomes the byte `first`.
pub(crate) fn damage(bytes: &mut Vec<u8>, first: u8, random: &mut Random) {
    for _ in 0..1 + random.below(3) {
        let offset = random.below(bytes.len());
        match random.below(4) {
            0 => bytes.truncate(offset),
            1 => bytes[offset] = random.next() as u8,
            2 => bytes[offset] ^= 1 << random.below(8),
            _ => drop(bytes.splice(offset..offset, *b" 9 ")),
        }
        if bytes.is_empty() {
            bytes.push(first);
        }
    }
}
