//! Options of parts of an asset: of objects and of materials, by their names.

use crate::error::AssetError;
use crate::folder::globs;
use globset::GlobSet;
use lodc_formats::{ObjectInfo, PartNames, Scene};
use lodc_select::{Target, share, size};
use lodc_simplify::{MetricKind, Options, Weights};
use serde::Deserialize;
use std::collections::BTreeSet;

/// Options of a part.
#[derive(Clone, Debug)]
pub struct Part {
    /// Names of objects; all if there are none.
    objects: Option<GlobSet>,
    /// Names of materials within them; all if there are none.
    materials: Option<GlobSet>,
    lock: bool,
    metric: Option<MetricKind>,
    weights: Option<Weights>,
    lock_border: Option<bool>,
    preserve_topology: Option<bool>,
    no_attributes: Option<bool>,
    ratio: Option<f64>,
    levels: Vec<Target>,
    /// The names as they were given, of a part that has to be there.
    required: Option<Names>,
}

/// Globs of names, as they were given.
#[derive(Clone, Debug)]
struct Names {
    objects: Vec<String>,
    materials: Vec<String>,
}

/// A part as text.
#[derive(Debug, Default, Deserialize)]
#[serde(default, deny_unknown_fields, rename_all = "kebab-case")]
struct Text {
    objects: Vec<String>,
    materials: Vec<String>,
    lock: bool,
    metric: Option<String>,
    weight: Option<String>,
    lock_border: Option<bool>,
    preserve_topology: Option<bool>,
    no_attributes: Option<bool>,
    ratio: Option<Number>,
    levels: Vec<Number>,
    /// True for parts of a configuration, which is for many assets: not each has them.
    if_there: bool,
}

/// A number, or a text that has one.
#[derive(Debug, Deserialize)]
#[serde(untagged)]
enum Number {
    Number(serde_json::Number),
    Text(String),
}

impl Number {
    fn text(&self) -> String {
        match self {
            Self::Number(number) => number.to_string(),
            Self::Text(text) => text.clone(),
        }
    }
}

impl Part {
    /// Reads the options of a part, a JSON object: globs of `objects` or `materials`, and those of
    /// `build` that the part has of its own. `weights` reads the value of `weight`.
    ///
    /// # Errors
    /// If the text is no such object, names no part, or gives a material what only objects have.
    pub fn parse(
        text: &str,
        weights: impl Fn(&str) -> Result<Weights, String>,
    ) -> Result<Self, String> {
        let text: Text = serde_json::from_str(text).map_err(|e| e.to_string())?;
        if text.objects.is_empty() && text.materials.is_empty() {
            return Err("names neither objects nor materials".to_owned());
        }
        let names = |names: &[String]| match names {
            [] => Ok(None),
            names => globs(names).map(Some).map_err(|e| e.to_string()),
        };
        let metric = text.metric.as_deref().map(metric).transpose()?;
        let part = Self {
            objects: names(&text.objects)?,
            materials: names(&text.materials)?,
            lock: text.lock,
            metric,
            weights: text.weight.as_deref().map(weights).transpose()?,
            lock_border: text.lock_border,
            preserve_topology: text.preserve_topology,
            no_attributes: text.no_attributes,
            ratio: text.ratio.map(|r| share(&r.text())).transpose()?,
            levels: text.levels.iter().map(|l| size(&l.text())).collect::<Result<_, _>>()?,
            required: (!text.if_there)
                .then_some(Names { objects: text.objects, materials: text.materials }),
        };
        if part.materials.is_some() && (part.is_of_objects() || part.has_level()) {
            let why = "the materials of an object collapse together, by one metric to one level";
            return Err(format!("of a material, only lock and weight can be given: {why}"));
        }
        Ok(part)
    }

    /// Returns whether it has options of the order of collapses that only whole objects have.
    fn is_of_objects(&self) -> bool {
        let switches = [self.lock_border, self.preserve_topology, self.no_attributes];
        self.metric.is_some() || switches.iter().any(Option::is_some)
    }

    fn has_level(&self) -> bool {
        self.ratio.is_some() || !self.levels.is_empty()
    }

    /// Returns whether an object of this name belongs to it, if perhaps not all of its materials.
    fn takes(&self, object: &str) -> bool {
        self.objects.as_ref().is_none_or(|names| names.is_match(object))
    }

    /// Returns whether a material of an object belongs to it.
    fn takes_material(&self, object: &str, material: &str) -> bool {
        let named = self.materials.as_ref().is_none_or(|names| names.is_match(material));
        named && self.takes(object)
    }
}

/// The parts of an asset that have options of their own. Later ones win.
#[derive(Clone, Copy, Debug)]
pub struct Parts<'a>(pub &'a [Part]);

impl Parts<'_> {
    /// Options of simplifying an object; without any of its own those of the asset.
    #[must_use]
    pub fn options(&self, object: &str, mut options: Options) -> Options {
        for part in self.0.iter().filter(|p| p.materials.is_none() && p.takes(object)) {
            options.metric = part.metric.unwrap_or(options.metric);
            options.weights = part.weights.unwrap_or(options.weights);
            options.lock_border = part.lock_border.unwrap_or(options.lock_border);
            options.preserve_topology = part.preserve_topology.unwrap_or(options.preserve_topology);
            options.attributes = part.no_attributes.map_or(options.attributes, |no| !no);
        }
        options
    }

    /// The weights of every object's materials, by submesh; objects none of whose materials has its
    /// own have no list. `options` are those of the objects.
    ///
    /// # Errors
    /// If the stored document is damaged.
    pub fn weights(
        &self,
        scene: &Scene,
        options: &[Options],
    ) -> Result<Vec<Vec<Weights>>, AssetError> {
        let mut all = vec![Vec::new(); scene.objects.len()];
        let by_material = |part: &Part| part.materials.is_some() && part.weights.is_some();
        if !self.0.iter().any(by_material) {
            return Ok(all);
        }
        let materials = materials(scene)?;
        let objects = scene.objects.iter().zip(options).zip(&materials);
        for (list, ((object, options), materials)) in all.iter_mut().zip(objects) {
            let name = &object.info.name;
            let last = |material: &String| {
                let mut parts = self.0.iter().rev().filter(|p| p.weights.is_some());
                parts.find(|p| p.takes_material(name, material))
            };
            let own: Vec<Option<&Part>> = materials.iter().map(last).collect();
            if own.iter().flatten().any(|part| by_material(part)) {
                let weights = |part: Option<&Part>| part.and_then(|p| p.weights);
                *list = own.into_iter().map(|p| weights(p).unwrap_or(options.weights)).collect();
            }
        }
        Ok(all)
    }

    /// Refuses parts that a scene does not have, unless a configuration names them.
    ///
    /// # Errors
    /// If there is such a part; the message lists what there is. If the stored document is damaged.
    pub fn check(&self, scene: &Scene) -> Result<(), AssetError> {
        if self.0.iter().all(|part| part.required.is_none()) {
            return Ok(());
        }
        let materials = materials(scene)?;
        let objects = || scene.objects.iter().map(|o| &o.info.name).zip(&materials);
        for part in self.0 {
            let Some(names) = &part.required else { continue };
            let has = |(object, all): (&String, &Vec<String>)| {
                all.iter().any(|material| part.takes_material(object, material))
            };
            if objects().any(has) {
                continue;
            }
            let (kind, given, there): (_, _, Vec<&String>) = match &part.materials {
                None => ("object", &names.objects, objects().map(|(object, _)| object).collect()),
                Some(_) => {
                    let within = objects().filter(|(object, _)| part.takes(object));
                    ("material", &names.materials, within.flat_map(|(_, all)| all).collect())
                }
            };
            return Err(AssetError::Usage(format!(
                "--part: no {kind} is named {} (there are: {})",
                given.join(" or "),
                listed(there.into_iter().map(String::as_str))
            )));
        }
        Ok(())
    }

    /// Adds the vertices of locked parts to those that stay, by object; objects without any have no
    /// list.
    ///
    /// # Errors
    /// If the stored document is damaged.
    pub fn lock(&self, scene: &Scene, locked: &mut [Vec<bool>]) -> Result<(), AssetError> {
        if self.0.iter().all(|part| !part.lock) {
            return Ok(());
        }
        let materials = materials(scene)?;
        for part in self.0.iter().filter(|part| part.lock) {
            for ((object, list), materials) in
                scene.objects.iter().zip(&mut *locked).zip(&materials)
            {
                let has = |material: &String| part.takes_material(&object.info.name, material);
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

    /// The level of an object that `extract` takes, if it has one of its own.
    #[must_use]
    pub fn ratio(&self, object: &str) -> Option<Target> {
        let own = self.0.iter().rev().find(|p| p.ratio.is_some() && p.takes(object));
        own.and_then(|part| part.ratio).map(Target::Ratio)
    }

    /// The level of an object that `chain` takes at a place from 0, if it has levels of its own;
    /// beyond the last of them that one.
    #[must_use]
    pub fn level(&self, object: &str, place: usize) -> Option<Target> {
        let mut own = self.0.iter().rev().filter(|p| !p.levels.is_empty() && p.takes(object));
        own.next().and_then(|part| part.levels.get(place).or(part.levels.last())).copied()
    }

    /// Refuses options of what has been simplified already.
    ///
    /// # Errors
    /// If there are any.
    pub fn refuse(&self, input: &str) -> Result<(), AssetError> {
        let shapes_order = |p: &Part| p.lock || p.weights.is_some() || p.is_of_objects();
        if !self.0.iter().any(shapes_order) {
            return Ok(());
        }
        let what = "has its order of collapses: give metric, weight and lock of parts to build";
        Err(AssetError::Usage(format!("{input}: {what}")))
    }
}

/// Names in order, each once, for a message.
pub fn listed<'a>(names: impl Iterator<Item = &'a str>) -> String {
    let unique: BTreeSet<&str> = names.filter(|name| !name.is_empty()).collect();
    match unique.is_empty() {
        true => "none".to_owned(),
        false => unique.into_iter().collect::<Vec<_>>().join(", "),
    }
}

/// The names of the materials of every object, by submesh.
fn materials(scene: &Scene) -> Result<Vec<Vec<String>>, AssetError> {
    let infos: Vec<&ObjectInfo> = scene.objects.iter().map(|o| &o.info).collect();
    Ok(PartNames::new(&scene.document, &infos)?.materials)
}

fn metric(name: &str) -> Result<MetricKind, String> {
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
        let of = |name: &str| parts.options(name, Options::DEFAULT);
        assert_eq!(of("arm"), Options::DEFAULT);
        assert_eq!((of("helm").metric, of("helm").attributes), (MetricKind::Hybrid, false));
        assert_eq!((of("head").metric, of("head").attributes), (MetricKind::Divergence, false));
        assert_eq!(parts.ratio("head"), Some(Target::Ratio(0.5)));
        assert_eq!((parts.ratio("arm"), parts.level("helm", 0)), (None, None));
        assert_eq!(parts.level("head", 0), Some(Target::Ratio(0.5)));
        assert_eq!(parts.level("head", 7), Some(Target::Triangles(100)));
    }

    #[test]
    fn what_is_no_part_is_refused() {
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
