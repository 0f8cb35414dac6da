//! Statements of MTL files: what a material's colours and textures are, and which files they name.

use crate::ObjMaterial;
use lodc_scene::{AlphaMode, to_linear};
use std::collections::BTreeMap;

/// The file that a line of a material names: what follows the options. It may contain spaces. None
/// for lines that name no file.
pub(crate) fn file(line: &str) -> Option<&str> {
    let (word, rest) = line.trim().split_once(char::is_whitespace)?;
    let word = word.to_ascii_lowercase();
    let names_file = word.starts_with("map_")
        || matches!(&*word, "bump" | "disp" | "decal" | "refl" | "norm" | "bump_map");
    if !names_file || word == "map_aat" {
        return None;
    }
    options_and_file(rest).map(|(_, file)| file)
}

/// An option of a texture, with its dash, and its arguments.
type MapOption<'a> = (&'a str, Vec<&'a str>);

/// The options of a statement `map_Kd -s 2 2 wood.png`, of which `rest` follows the first word, and
/// the file that it names; none if there is none.
fn options_and_file(rest: &str) -> Option<(Vec<MapOption<'_>>, &str)> {
    let mut words = rest.trim();
    let mut options = Vec::new();
    while words.starts_with('-') {
        let (option, after) = words.split_once(char::is_whitespace)?;
        let most = match option {
            "-o" | "-s" | "-t" => 3,
            "-mm" => 2,
            "-blendu" | "-blendv" | "-boost" | "-texres" | "-clamp" | "-bm" | "-imfchan"
            | "-type" | "-cc" => 1,
            _ => 0,
        };
        words = after.trim_start();
        let mut arguments = Vec::new();
        while arguments.len() < most {
            // The last word is the file.
            let Some((word, after)) = words.split_once(char::is_whitespace) else { break };
            // -o, -s and -t take one to three numbers.
            if most > 1 && word.parse::<f64>().is_err() {
                break;
            }
            arguments.push(word);
            words = after.trim_start();
        }
        options.push((option, arguments));
    }
    (!words.is_empty()).then_some((options, words))
}

/// A texture as `map_Kd [-option value...]... FILE` says it.
pub(crate) struct TextureMap<'a> {
    /// As written.
    pub(crate) file: &'a str,
    /// `-s`: what texture coordinates are multiplied by.
    pub(crate) scale: [f32; 2],
    /// `-o`: what is added to them afterwards.
    pub(crate) offset: [f32; 2],
    /// `-clamp on`: the picture is not repeated.
    pub(crate) clamped: bool,
}

impl<'a> TextureMap<'a> {
    /// Reads what follows `map_Kd`; none if it names no file.
    pub(crate) fn of(rest: &'a str) -> Option<Self> {
        let (options, file) = options_and_file(rest)?;
        let mut map = Self { file, scale: [1.0; 2], offset: [0.0; 2], clamped: false };
        for (option, values) in options {
            let numbers = |default: f32| {
                let number = |text: &&str| text.parse().ok().filter(|v: &f32| v.is_finite());
                [0, 1].map(|i| values.get(i).and_then(number).unwrap_or(default))
            };
            match option {
                "-s" => map.scale = numbers(1.0),
                "-o" => map.offset = numbers(0.0),
                "-clamp" => map.clamped = values == ["on"],
                _ => {}
            }
        }
        Some(map)
    }
}

/// The line with another file in its place.
pub(crate) fn with_file(line: &str, file: &str) -> String {
    let line = line.trim_end();
    match self::file(line) {
        Some(old) => format!("{}{file}", &line[..line.len() - old.len()]),
        None => line.to_owned(),
    }
}

/// The numbers of materials by their names. Of several with one name the first counts.
pub(crate) fn numbers(materials: &[ObjMaterial]) -> BTreeMap<&str, usize> {
    materials.iter().enumerate().rev().map(|(number, m)| (&*m.name, number)).collect()
}

/// Red, green and blue, linear, where neither `Kd` nor a texture says a colour: a light grey.
pub(crate) const UNSAID: f32 = 0.6;

/// What is read of a material; the last of several statements holds.
#[derive(Debug, Default, PartialEq)]
pub(crate) struct Meaning {
    /// `Kd`, as written.
    pub(crate) diffuse: Option<[f64; 3]>,
    /// `Ke`, as written.
    pub(crate) emissive: Option<[f64; 3]>,
    /// `d`, or what `Tr` leaves, as written.
    pub(crate) dissolve: Option<f64>,
    /// What follows `map_Kd`.
    pub(crate) texture: Option<String>,
    /// True if there is a `map_d`.
    pub(crate) cut: bool,
}

impl Meaning {
    /// Reads the lines of a material; those with too few numbers say nothing.
    pub(crate) fn of(material: &ObjMaterial) -> Self {
        let finite = |color: &[f64; 3]| color.iter().all(|c| c.is_finite());
        let mut meaning = Self::default();
        for said in material.lines.iter().filter_map(|line| statement(line)) {
            meaning.diffuse = said.diffuse.filter(finite).or(meaning.diffuse);
            meaning.emissive = said.emissive.filter(finite).or(meaning.emissive);
            let through = said.unknown_param.get("Tr").and_then(|t| first_number(t));
            let opaque = through.map(|t| 1.0 - t.clamp(0.0, 1.0)).or(said.dissolve);
            meaning.dissolve = opaque.filter(|d| d.is_finite()).or(meaning.dissolve);
            meaning.texture = said.diffuse_texture.or(meaning.texture);
            meaning.cut |= said.dissolve_texture.is_some();
        }
        meaning
    }

    /// The texture of the base colour; none if no file is named.
    pub(crate) fn map(&self) -> Option<TextureMap<'_>> {
        self.texture.as_deref().and_then(TextureMap::of)
    }

    /// The base colour as glTF means it: linear red, green and blue, and opacity, from 0 to 1.
    ///
    /// `Kd` has no colour space of its own; programs show it as they show texels, hence as sRGB.
    pub(crate) fn base_colour(&self, textured: bool) -> [f32; 4] {
        let unit = |v: f64| (v as f32).clamp(0.0, 1.0);
        // Many writers leave `Kd` black or out where a texture says the colour.
        let said = self.diffuse.filter(|kd| !textured || *kd != [0.0; 3]);
        let unsaid = [if textured { 1.0 } else { UNSAID }; 3];
        let [r, g, b] = said.map_or(unsaid, |kd| kd.map(|v| to_linear(unit(v))));
        // Exporters that mean nothing by `d` write 0, and a thing that cannot be seen is no
        // material.
        let opacity = self.dissolve.map(unit).filter(|&d| d > 0.0).unwrap_or(1.0);
        [r, g, b, opacity]
    }

    /// How opacity is shown: by blending where `d` says so; by cutting where there is a `map_d`.
    pub(crate) fn alpha_mode(&self) -> AlphaMode {
        match self.base_colour(false)[3] {
            d if d < 1.0 => AlphaMode::Blend,
            _ if self.cut && self.dissolve != Some(0.0) => AlphaMode::Mask(0.5),
            _ => AlphaMode::Opaque,
        }
    }
}

/// A statement as a material of its own: to tobj one that it cannot read spoils all others.
fn statement(line: &str) -> Option<tobj::Material> {
    let words: Vec<&str> = line.split_whitespace().collect();
    let line = match words[..] {
        ["Kd", grey] => format!("Kd {grey} {grey} {grey}"),
        // tobj panics where a number is missing.
        ["Ka" | "Kd" | "Ks" | "Ke", ..] if words.len() < 4 => return None,
        _ => line.to_owned(),
    };
    let (materials, _) = tobj::load_mtl_buf(&mut format!("newmtl m\n{line}").as_bytes()).ok()?;
    materials.into_iter().next()
}

fn first_number(text: &str) -> Option<f64> {
    text.split_whitespace().next()?.parse().ok()
}
