//! Origin of an export, stated in the file itself.

use serde_json::{Map, Value, json};

/// The name and version of this program.
const GENERATOR: &str = concat!("lodc ", env!("CARGO_PKG_VERSION"));

/// A level of detail as its file states it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct LevelFacts {
    /// Its number of records; none if several objects each have their own.
    pub lod: Option<u32>,
    /// Its error, in mesh units for one object, in world units for several.
    pub error: f64,
    /// Its root mean square distance, in the same units, if it was measured.
    pub rms: Option<f64>,
}

/// Origin of an export.
#[derive(Clone, Debug, PartialEq)]
pub struct Provenance {
    /// XXH3-128 of the source (`Source::content_hash`).
    pub source: u128,
    /// The levels in the file, the finest first.
    pub levels: Vec<LevelFacts>,
    /// True if vertices were moved to where they fit best.
    pub refitted: bool,
}

impl Provenance {
    /// Puts `asset.generator` and `extras.lodc` into a glTF document. Extras that are not an
    /// object stay as they are.
    pub(super) fn put(&self, root: &mut Map<String, Value>) {
        if let Some(asset) = root.get_mut("asset").and_then(Value::as_object_mut) {
            asset.insert("generator".to_owned(), GENERATOR.into());
        }
        let extras = root.entry("extras").or_insert_with(|| json!({}));
        if let Some(extras) = extras.as_object_mut() {
            extras.insert("lodc".to_owned(), self.json());
        }
    }

    fn json(&self) -> Value {
        let finite = |x: f64| x.is_finite().then_some(x);
        let level =
            |l: &LevelFacts| json!({ "lod": l.lod, "error": finite(l.error), "rms": l.rms });
        let mut all = match &self.levels[..] {
            [one] => level(one),
            several => json!({ "levels": several.iter().map(level).collect::<Vec<_>>() }),
        };
        all["refitted"] = self.refitted.into();
        all["source"] = format!("{:032x}", self.source).into();
        all
    }

    /// One line for text formats.
    pub(super) fn line(&self) -> String {
        let mut line = GENERATOR.to_owned();
        for l in &self.levels {
            if let Some(lod) = l.lod {
                line += &format!(", LOD {lod}");
            }
            if l.error.is_finite() {
                line += &format!(", error {}", l.error);
            }
            if let Some(rms) = l.rms {
                line += &format!(", rms {rms}");
            }
        }
        if self.refitted {
            line += ", refitted";
        }
        format!("{line}, source {:032x}", self.source)
    }
}
