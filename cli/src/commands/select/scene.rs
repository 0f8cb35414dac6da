//! Reads the instances of a scene: a JSON document in each line, with file, position and scale.

use super::model::Model;
use crate::exit::{Failure, Outcome, Status};
use crate::limits::LimitArgs;
use lodc_select::Instance;
use serde::Deserialize;
use std::collections::BTreeMap;
use std::path::{Path, PathBuf};

/// One instance.
#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
struct Line {
    file: PathBuf,
    position: [f64; 3],
    #[serde(default = "default_scale")]
    scale: f32,
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

/// A point about the eye.
pub(super) fn about(eye: [f64; 3], point: [f64; 3]) -> [f32; 3] {
    std::array::from_fn(|i| (point[i] - eye[i]) as f32)
}

/// Reads a scene, with positions about the eye; blank lines are skipped. Paths are relative to the
/// current folder.
///
/// # Errors
/// If a line is no valid document, or a file cannot be read.
pub(super) fn read(path: &Path, eye: [f64; 3], limits: &LimitArgs) -> Outcome<Scene> {
    let failure = |what: String| Failure::new(Status::Input, format!("{}: {what}", path.display()));
    let text = std::fs::read_to_string(path).map_err(|e| failure(e.to_string()))?;
    let mut scene = Scene::default();
    let mut model_of_file: BTreeMap<PathBuf, u32> = BTreeMap::new();
    for (number, line) in (1..).zip(text.lines()).filter(|(_, line)| !line.trim().is_empty()) {
        let line: Line = serde_json::from_str(line).map_err(|e| {
            failure(format!("line {number}, column {}: not an instance", e.column()))
        })?;
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
