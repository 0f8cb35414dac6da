//! Options for parts of an asset: for objects or materials whose names match globs.

use crate::jobs::error::JobError;
use crate::jobs::folder::globs;
use globset::GlobSet;
use lodc_formats::{ObjectInfo, PartNames, Scene};
use lodc_select::Target as LevelTarget;
use lodc_select::parse::{share, size};
use lodc_simplify::{MetricKind, Options, Weights};
use serde::Deserialize;
use std::collections::BTreeSet;

/// The options of one part.
#[derive(Clone, Debug)]
pub(crate) struct Part {
    /// Globs of the objects' names; none if it is for all objects.
    objects: Option<GlobSet>,
    /// Globs of the names of materials within those objects; none if it is for whole objects.
    materials: Option<GlobSet>,
    /// Whether its vertices stay.
    lock: bool,
    metric: Option<MetricKind>,
    weights: Option<Weights>,
    lock_border: Option<bool>,
    preserve_topology: Option<bool>,
    no_attributes: Option<bool>,
    /// The share of its triangles that `extract` keeps, 0 to 1.
    ratio: Option<f64>,
    /// The levels of its objects that `chain` takes, in order; empty if it has none of its own.
    levels: Vec<LevelTarget>,
    /// The globs as they were given, for messages; none if assets may lack the part.
    required: Option<Globs>,
}

/// Globs as they were given.
#[derive(Clone, Debug)]
struct Globs {
    objects: Vec<String>,
    materials: Vec<String>,
}

/// A part as JSON.
#[derive(Debug, Default, Deserialize)]
#[serde(default, deny_unknown_fields, rename_all = "kebab-case")]
struct PartDocument {
    objects: Vec<String>,
    materials: Vec<String>,
    lock: bool,
    metric: Option<String>,
    weight: Option<String>,
    lock_border: Option<bool>,
    preserve_topology: Option<bool>,
    no_attributes: Option<bool>,
    ratio: Option<NumberOrText>,
    levels: Vec<NumberOrText>,
}

/// The key that marks a part of a configuration: this is for many assets, and some may lack the
/// part.
pub(super) const IF_THERE: &str = "if-there";

/// A number, or a text that is read as one.
#[derive(Debug, Deserialize)]
#[serde(untagged)]
enum NumberOrText {
    Number(serde_json::Number),
    Text(String),
}

impl NumberOrText {
    fn text(&self) -> String {
        match self {
            Self::Number(number) => number.to_string(),
            Self::Text(text) => text.clone(),
        }
    }
}

impl Part {
    /// Reads a part from a JSON object: globs of `objects` or `materials` and the options for them.
    /// `weights` reads the value of `weight`.
    ///
    /// # Errors
    /// If the text is no such object, names no part, or gives a material what only objects have.
    pub(crate) fn parse(
        text: &str,
        weights: impl Fn(&str) -> Result<Weights, String>,
    ) -> Result<Self, String> {
        let mut object: serde_json::Map<String, serde_json::Value> =
            serde_json::from_str(text).map_err(|e| e.to_string())?;
        let if_there = object.remove(IF_THERE).is_some();
        let document = PartDocument::deserialize(serde_json::Value::Object(object));
        let document = document.map_err(|e| e.to_string())?;
        if document.objects.is_empty() && document.materials.is_empty() {
            return Err("names neither objects nor materials".to_owned());
        }
        let names = |names: &[String]| match names {
            [] => Ok(None),
            names => globs(names).map(Some).map_err(|e| e.to_string()),
        };
        let metric = document.metric.as_deref().map(metric_named).transpose()?;
        let part = Self {
            objects: names(&document.objects)?,
            materials: names(&document.materials)?,
            lock: document.lock,
            metric,
            weights: document.weight.as_deref().map(weights).transpose()?,
            lock_border: document.lock_border,
            preserve_topology: document.preserve_topology,
            no_attributes: document.no_attributes,
            ratio: document.ratio.map(|r| share(&r.text())).transpose()?,
            levels: document.levels.iter().map(|l| size(&l.text())).collect::<Result<_, _>>()?,
            required: (!if_there)
                .then_some(Globs { objects: document.objects, materials: document.materials }),
        };
        if part.materials.is_some() && (part.has_object_options() || part.has_level()) {
            let why = "the materials of an object collapse together, by one metric to one level";
            return Err(format!("of a material, only lock and weight can be given: {why}"));
        }
        Ok(part)
    }

    /// Returns whether it has options that decide the collapse sequence and are for whole objects.
    fn has_object_options(&self) -> bool {
        let switches = [self.lock_border, self.preserve_topology, self.no_attributes];
        self.metric.is_some() || switches.iter().any(Option::is_some)
    }

    fn has_level(&self) -> bool {
        self.ratio.is_some() || !self.levels.is_empty()
    }

    /// Returns whether an object of this name belongs to it, with all or some of its materials.
    fn matches_object(&self, object: &str) -> bool {
        self.objects.as_ref().is_none_or(|names| names.is_match(object))
    }

    /// Returns whether a material of an object belongs to it.
    fn matches_material(&self, object: &str, material: &str) -> bool {
        let matches = self.materials.as_ref().is_none_or(|names| names.is_match(material));
        matches && self.matches_object(object)
    }
}

/// All parts that were given for an asset, in order: later ones win.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Parts<'a>(pub &'a [Part]);

impl Parts<'_> {
    /// The options for simplifying an object: `options`, those of the asset, with those of the
    /// object's parts in their place.
    #[must_use]
    pub(crate) fn object_options(&self, object: &str, mut options: Options) -> Options {
        for part in self.0.iter().filter(|p| p.materials.is_none() && p.matches_object(object)) {
            options.metric = part.metric.unwrap_or(options.metric);
            options.weights = part.weights.unwrap_or(options.weights);
            options.lock_border = part.lock_border.unwrap_or(options.lock_border);
            options.preserve_topology = part.preserve_topology.unwrap_or(options.preserve_topology);
            options.attributes = part.no_attributes.map_or(options.attributes, |no| !no);
        }
        options
    }

    /// The weights of attributes by object and submesh; the list of an object is empty if no part
    /// has weights for its materials. `options` are those of the objects.
    ///
    /// # Errors
    /// If the stored document is damaged.
    pub(crate) fn material_weights(
        &self,
        scene: &Scene,
        options: &[Options],
    ) -> Result<Vec<Vec<Weights>>, JobError> {
        let mut all = vec![Vec::new(); scene.objects.len()];
        let by_material = |part: &Part| part.materials.is_some() && part.weights.is_some();
        if !self.0.iter().any(by_material) {
            return Ok(all);
        }
        let materials = materials_by_submesh(scene)?;
        let objects = scene.objects.iter().zip(options).zip(&materials);
        for (list, ((object, options), materials)) in all.iter_mut().zip(objects) {
            let name = &object.info.name;
            let last = |material: &String| {
                let mut parts = self.0.iter().rev().filter(|p| p.weights.is_some());
                parts.find(|p| p.matches_material(name, material))
            };
            let last_parts: Vec<Option<&Part>> = materials.iter().map(last).collect();
            if last_parts.iter().flatten().any(|part| by_material(part)) {
                let weights = |part: Option<&Part>| part.and_then(|p| p.weights);
                let by_submesh = last_parts.into_iter().map(weights);
                *list = by_submesh.map(|weights| weights.unwrap_or(options.weights)).collect();
            }
        }
        Ok(all)
    }

    /// Refuses parts that a scene does not have, except those of configurations.
    ///
    /// # Errors
    /// If there is such a part; the message lists what it has. If the stored document is damaged.
    pub(crate) fn check_names(&self, scene: &Scene) -> Result<(), JobError> {
        if self.0.iter().all(|part| part.required.is_none()) {
            return Ok(());
        }
        let materials = materials_by_submesh(scene)?;
        let objects = || scene.objects.iter().map(|o| &o.info.name).zip(&materials);
        for part in self.0 {
            let Some(names) = &part.required else { continue };
            let has = |(object, all): (&String, &Vec<String>)| {
                all.iter().any(|material| part.matches_material(object, material))
            };
            if objects().any(has) {
                continue;
            }
            let (kind, given, present): (_, _, Vec<&String>) = match &part.materials {
                None => ("object", &names.objects, objects().map(|(object, _)| object).collect()),
                Some(_) => {
                    let within = objects().filter(|(object, _)| part.matches_object(object));
                    ("material", &names.materials, within.flat_map(|(_, all)| all).collect())
                }
            };
            return Err(JobError::Usage(format!(
                "--part: no {kind} is named {} (there are: {})",
                given.join(" or "),
                name_list(present.into_iter().map(String::as_str))
            )));
        }
        Ok(())
    }

    /// Marks the vertices of locked parts in `locked`, by object and vertex. The list of an object
    /// without locked vertices may be empty.
    ///
    /// # Errors
    /// If the stored document is damaged.
    pub(crate) fn lock_vertices(
        &self,
        scene: &Scene,
        locked: &mut [Vec<bool>],
    ) -> Result<(), JobError> {
        if self.0.iter().all(|part| !part.lock) {
            return Ok(());
        }
        let materials = materials_by_submesh(scene)?;
        for part in self.0.iter().filter(|part| part.lock) {
            for ((object, list), materials) in
                scene.objects.iter().zip(&mut *locked).zip(&materials)
            {
                let has = |material: &String| part.matches_material(&object.info.name, material);
                let stays: Vec<bool> = materials.iter().map(has).collect();
                if stays.contains(&true) {
                    list.resize(object.mesh.vertex_count(), false);
                    let submeshes = object.mesh.vertex_submesh();
                    list.iter_mut().zip(submeshes).for_each(|(v, &s)| *v |= stays[s as usize]);
                }
            }
        }
        Ok(())
    }

    /// The level of an object that `extract` takes, if a part has one for it.
    #[must_use]
    pub(crate) fn extract_level(&self, object: &str) -> Option<LevelTarget> {
        let last = self.0.iter().rev().find(|p| p.ratio.is_some() && p.matches_object(object));
        last.and_then(|part| part.ratio).map(LevelTarget::Ratio)
    }

    /// The level of an object that is number `number`, from 0, of the chain, if a part lists levels
    /// for it; beyond the end of that list its last one.
    #[must_use]
    pub(crate) fn chain_level(&self, object: &str, number: usize) -> Option<LevelTarget> {
        let mut parts =
            self.0.iter().rev().filter(|p| !p.levels.is_empty() && p.matches_object(object));
        parts.next().and_then(|part| part.levels.get(number).or(part.levels.last())).copied()
    }

    /// Refuses options that decide a collapse sequence, for an input that has one already.
    ///
    /// # Errors
    /// If there are any.
    pub(crate) fn refuse_sequence_options(&self, input: &str) -> Result<(), JobError> {
        let decides_sequence =
            |part: &Part| part.lock || part.weights.is_some() || part.has_object_options();
        if !self.0.iter().any(decides_sequence) {
            return Ok(());
        }
        let what = "its order of collapses is fixed: metric, weight and lock of parts belong to \
                    `lodc build`";
        Err(JobError::Usage(format!("{input}: {what}")))
    }
}

/// Names in order, each once, for a message; `none` if there are none.
pub(crate) fn name_list<'a>(names: impl Iterator<Item = &'a str>) -> String {
    let unique: BTreeSet<&str> = names.filter(|name| !name.is_empty()).collect();
    if unique.is_empty() {
        return "none".to_owned();
    }
    unique.into_iter().collect::<Vec<_>>().join(", ")
}

/// The names of the materials of every object, by submesh.
fn materials_by_submesh(scene: &Scene) -> Result<Vec<Vec<String>>, JobError> {
    let infos: Vec<&ObjectInfo> = scene.objects.iter().map(|o| &o.info).collect();
    Ok(PartNames::new(&scene.document, &infos)?.materials)
}

fn metric_named(name: &str) -> Result<MetricKind, String> {
    let found = MetricKind::ALL.into_iter().find(|kind| kind.name() == name);
    found.ok_or_else(|| {
        let names = MetricKind::ALL.map(MetricKind::name).join(", ");
        format!("no metric {name}; there are: {names}")
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    fn parse(text: &str) -> Result<Part, String> {
        Part::parse(text, |text| Err(format!("no weights: {text}")))
    }

    #[test]
    fn later_parts_win_and_others_stay() {
        let parts = [
            r#"{"objects": ["he*"], "metric": "hybrid", "no-attributes": true, "ratio": 0.5}"#,
            r#"{"objects": ["head"], "metric": "kl", "levels": ["50%", 100]}"#,
        ];
        let parts = parts.map(|text| parse(text).expect("a part"));
        let parts = Parts(&parts);
        let options = |name: &str| parts.object_options(name, Options::DEFAULT);
        assert_eq!(options("arm"), Options::DEFAULT);
        assert_eq!(
            (options("helm").metric, options("helm").attributes),
            (MetricKind::Hybrid, false)
        );
        assert_eq!(
            (options("head").metric, options("head").attributes),
            (MetricKind::Divergence, false)
        );
        assert_eq!(parts.extract_level("head"), Some(LevelTarget::Ratio(0.5)));
        assert_eq!((parts.extract_level("arm"), parts.chain_level("helm", 0)), (None, None));
        assert_eq!(parts.chain_level("head", 0), Some(LevelTarget::Ratio(0.5)));
        assert_eq!(parts.chain_level("head", 7), Some(LevelTarget::Triangles(100)));
    }

    #[test]
    fn malformed_parts_are_refused() {
        for (wrong, why) in [
            (r#"{"lock": true}"#, "neither objects nor materials"),
            (r#"{"objects": ["a"], "metrik": "kl"}"#, "metrik"),
            (r#"{"objects": ["a"], "metric": "x"}"#, "there are: quadric"),
            (r#"{"objects": ["a["]}"#, "glob"),
            (r#"{"materials": ["a"], "metric": "kl"}"#, "only lock and weight"),
            (r#"{"materials": ["a"], "ratio": 0.5}"#, "only lock and weight"),
            (r#"{"materials": ["a"], "weight": "size=2"}"#, "no weights: size=2"),
            (r#"{"objects": ["a"], "ratio": 3}"#, "share"),
            ("3", "invalid"),
        ] {
            let error = parse(wrong).expect_err(wrong);
            assert!(error.contains(why), "{wrong}: {error}");
        }
    }
}
