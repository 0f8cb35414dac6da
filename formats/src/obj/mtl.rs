//! Statements of MTL files: what a material's colours and textures are, and which files they name.

use crate::ObjMaterial;

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
pub(crate) type MapOption<'a> = (&'a str, Vec<&'a str>);

/// The options of a statement `map_Kd -s 2 2 wood.png`, of which `rest` follows the first word, and
/// the file that it names; none if there is none.
pub(crate) fn options_and_file(rest: &str) -> Option<(Vec<MapOption<'_>>, &str)> {
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
            let (word, after) = words.split_once(char::is_whitespace)?;
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

/// The line with another file in its place.
pub(crate) fn with_file(line: &str, file: &str) -> String {
    let line = line.trim_end();
    match self::file(line) {
        Some(old) => format!("{}{file}", &line[..line.len() - old.len()]),
        None => line.to_owned(),
    }
}

/// What is read of a material; the last of several statements holds.
#[derive(Debug, Default, PartialEq)]
pub(crate) struct Meaning<'a> {
    /// `Kd`, as it stands.
    pub(crate) diffuse: Option<[f64; 3]>,
    /// `Ke`, as it stands.
    pub(crate) emissive: Option<[f64; 3]>,
    /// `d`, or what `Tr` leaves, as it stands.
    pub(crate) dissolve: Option<f64>,
    /// What follows `map_Kd`.
    pub(crate) texture: Option<&'a str>,
    /// True if there is a `map_d`.
    pub(crate) cut: bool,
}

impl<'a> Meaning<'a> {
    /// Reads the lines of a material; those with too few numbers say nothing.
    pub(crate) fn of(material: &'a ObjMaterial) -> Self {
        let mut meaning = Self::default();
        for line in material.lines.iter().map(|l| l.trim()) {
            let (word, rest) = line.split_once(char::is_whitespace).unwrap_or((line, ""));
            let numbers = rest.split_whitespace().map_while(|w| w.parse().ok());
            let numbers: Vec<f64> = numbers.filter(|v: &f64| v.is_finite()).collect();
            match (word, &numbers[..]) {
                ("Kd", &[r, g, b, ..]) => meaning.diffuse = Some([r, g, b]),
                ("Kd", &[grey]) => meaning.diffuse = Some([grey; 3]),
                ("Ke", &[r, g, b, ..]) => meaning.emissive = Some([r, g, b]),
                ("d", &[d, ..]) => meaning.dissolve = Some(d),
                ("Tr", &[t, ..]) => meaning.dissolve = Some(1.0 - t.clamp(0.0, 1.0)),
                ("map_Kd", _) if !rest.trim().is_empty() => meaning.texture = Some(rest),
                ("map_d", _) if !rest.trim().is_empty() => meaning.cut = true,
                _ => {}
            }
        }
        meaning
    }
}
