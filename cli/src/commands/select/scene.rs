//! Reads the instances of a scene: a JSON document in each line, with file, position and scale.

use super::model::Model;
use crate::exit::{Failure, Outcome, Status};
use crate::jobs::{is_standard_stream, json_object};
use crate::limits::LimitArgs;
use lodc_select::Instance;
use serde::de::Error;
use serde::{Deserialize, Deserializer};
use std::collections::BTreeMap;
use std::path::{Path, PathBuf};

/// One instance.
#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
struct Line {
    #[serde(deserialize_with = "file")]
    file: PathBuf,
    #[serde(deserialize_with = "position")]
    position: [f64; 3],
    #[serde(default = "default_scale", deserialize_with = "scale")]
    scale: f32,
}

fn file<'de, D: Deserializer<'de>>(value: D) -> Result<PathBuf, D::Error> {
    must_be(value, "file must be a path")
}

fn position<'de, D: Deserializer<'de>>(value: D) -> Result<[f64; 3], D::Error> {
    must_be(value, "position must be three numbers: [X, Y, Z]")
}

fn scale<'de, D: Deserializer<'de>>(value: D) -> Result<f32, D::Error> {
    must_be(value, "scale must be a number")
}

/// Reads a value; if it is of another type, the error says what it must be.
fn must_be<'de, D: Deserializer<'de>, T: Deserialize<'de>>(
    value: D,
    what: &str,
) -> Result<T, D::Error> {
    T::deserialize(value).map_err(|_| D::Error::custom(what))
}

fn default_scale() -> f32 {
    1.0
}

/// Instances and the models that they show, each read once.
#[derive(Debug, Default)]
pub(super) struct Scene {
    pub(super) models: Vec<Model>,
    pub(super) instances: Vec<Instance>,
}

/// A point relative to the eye.
pub(super) fn about(eye: [f64; 3], point: [f64; 3]) -> [f32; 3] {
    std::array::from_fn(|i| (point[i] - eye[i]) as f32)
}

/// Reads a scene, with positions relative to the eye; blank lines are skipped. Paths are relative
/// to the current folder.
///
/// # Errors
/// If a line is no valid document, or a file cannot be read.
pub(super) fn read(path: &Path, eye: [f64; 3], limits: &LimitArgs) -> Outcome<Scene> {
    let failure = |what: String| Failure::new(Status::Input, format!("{}: {what}", path.display()));
    let text = match is_standard_stream(path) {
        true => std::io::read_to_string(std::io::stdin()),
        false => std::fs::read_to_string(path),
    };
    let text = text.map_err(|e| failure(e.to_string()))?;
    let mut scene = Scene::default();
    let mut model_of_file: BTreeMap<PathBuf, u32> = BTreeMap::new();
    for (number, line) in (1..).zip(text.lines()).filter(|(_, line)| !line.trim().is_empty()) {
        let line: Line = json_object(line, number).map_err(failure)?;
        let is_finite = line.position.iter().all(|c| c.is_finite());
        if !is_finite || !line.scale.is_finite() || line.scale <= 0.0 {
            let what = "position needs finite numbers, scale one above 0";
            return Err(failure(format!("line {number}: {what}")));
        }
        let model = match model_of_file.get(&line.file) {
            Some(&model) => model,
            None => {
                scene.models.push(Model::read(&line.file, limits)?);
                let model = scene.models.len() as u32 - 1;
                model_of_file.insert(line.file, model);
                model
            }
        };
        // `lodc_select` is given the error curves of models, in their order.
        let position = about(eye, line.position);
        scene.instances.push(Instance { curve: model, position, scale: line.scale });
    }
    Ok(scene)
}
