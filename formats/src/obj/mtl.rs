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

/// What may stand around a name.
pub(crate) const QUOTES: [char; 2] = ['"', '\''];

/// A name without the quotes that some programs put around it.
pub(crate) fn unquoted(name: &str) -> &str {
    let name = name.trim();
    let inner = QUOTES.iter().find_map(|&quote| {
        let inner = name.strip_prefix(quote)?.strip_suffix(quote)?;
        (!inner.contains(quote)).then_some(inner)
    });
    inner.map_or(name, str::trim)
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
        let max_arguments = match option {
            "-o" | "-s" | "-t" => 3,
            "-mm" => 2,
            // Those that are unknown, too: all others take one.
            _ => 1,
        };
        words = after.trim_start();
        let mut arguments = Vec::new();
        while arguments.len() < max_arguments {
            // The last word is the file.
            let Some((word, after)) = words.split_once(char::is_whitespace) else { break };
            // -o, -s and -t take one to three numbers.
            if max_arguments > 1 && word.parse::<f64>().is_err() || word.starts_with(QUOTES) {
                break;
            }
            arguments.push(word);
            words = after.trim_start();
        }
        options.push((option, arguments));
    }
    let file = unquoted(words);
    (!file.is_empty()).then_some((options, file))
}

/// A texture as a statement `map_Kd [-option value...]... FILE` describes it.
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
            let two_numbers = |default: f32| {
                let number = |text: &&str| text.parse().ok().filter(|v: &f32| v.is_finite());
                [0, 1].map(|i| values.get(i).and_then(number).unwrap_or(default))
            };
            match option {
                "-s" => map.scale = two_numbers(1.0),
                "-o" => map.offset = two_numbers(0.0),
                "-clamp" => map.clamped = values == ["on"],
                _ => {}
            }
        }
        Some(map)
    }
}

/// A line of a material that names another file instead of its own.
pub(crate) fn with_file(line: &str, file: &str) -> String {
    let line = line.trim_end();
    match self::file(line) {
        Some(old) => {
            // Behind the name are at most quotes and spaces.
            let start = line.rfind(old).unwrap_or(0);
            let before = line[..start].trim_end_matches(QUOTES);
            format!("{before}{file}")
        }
        None => line.to_owned(),
    }
}

/// The numbers of materials by their names; that of the first where several have one name.
pub(crate) fn numbers(materials: &[ObjMaterial]) -> BTreeMap<&str, usize> {
    materials.iter().enumerate().rev().map(|(number, m)| (&*m.name, number)).collect()
}

/// Linear red, green and blue of a material without `Kd` and texture, and of a glTF's mesh without
/// a material: a light grey. Chosen by hand.
pub(crate) const DEFAULT_GREY: f32 = 0.6;

/// The statements of a material that are read; the last of several of one kind holds.
#[derive(Debug, Default, PartialEq)]
pub(crate) struct Meaning {
    /// `Kd`, as written.
    pub(crate) diffuse: Option<[f64; 3]>,
    /// `Ke`, as written.
    pub(crate) emissive: Option<[f64; 3]>,
    /// Opacity: `d` as written, or 1 − `Tr`.
    pub(crate) dissolve: Option<f64>,
    /// What follows `map_Kd`.
    pub(crate) texture: Option<String>,
    /// True if there is a `map_d`: the texture's own opacity cuts holes.
    pub(crate) is_cutout: bool,
}

impl Meaning {
    /// Reads the lines of a material; those with too few numbers are ignored.
    pub(crate) fn of(material: &ObjMaterial) -> Self {
        let finite = |color: &[f64; 3]| color.iter().all(|c| c.is_finite());
        let mut meaning = Self::default();
        for line in material.lines.iter().filter_map(|line| statement(line)) {
            meaning.diffuse = line.diffuse.filter(finite).or(meaning.diffuse);
            meaning.emissive = line.emissive.filter(finite).or(meaning.emissive);
            let transparency = line.unknown_param.get("Tr").and_then(|t| first_number(t));
            let opacity = transparency.map(|t| 1.0 - t.clamp(0.0, 1.0)).or(line.dissolve);
            meaning.dissolve = opacity.filter(|d| d.is_finite()).or(meaning.dissolve);
            meaning.texture = line.diffuse_texture.or(meaning.texture);
            meaning.is_cutout |= line.dissolve_texture.is_some();
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
        // Many writers leave `Kd` black, or leave it out, if a texture has the colour.
        let stated = self.diffuse.filter(|kd| !textured || *kd != [0.0; 3]);
        let default = [if textured { 1.0 } else { DEFAULT_GREY }; 3];
        let [r, g, b] = stated.map_or(default, |kd| kd.map(|v| to_linear(unit(v))));
        [r, g, b, self.opacity()]
    }

    /// Opacity, from 0 to 1.
    fn opacity(&self) -> f32 {
        // Some exporters write 0 for `d` and mean nothing by it: a material that cannot be seen
        // makes no sense.
        let stated = self.dissolve.map(|d| (d as f32).clamp(0.0, 1.0));
        stated.filter(|&d| d > 0.0).unwrap_or(1.0)
    }

    /// How opacity is shown: by blending if `d` is below 1; by cutting if there is a `map_d`.
    pub(crate) fn alpha_mode(&self) -> AlphaMode {
        match self.opacity() {
            d if d < 1.0 => AlphaMode::Blend,
            _ if self.is_cutout && self.dissolve != Some(0.0) => AlphaMode::Mask(0.5),
            _ => AlphaMode::Opaque,
        }
    }
}

/// A statement as a material of its own: tobj refuses a whole material for one statement that it
/// cannot read.
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
