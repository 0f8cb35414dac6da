//! Statements of an MTL file that name an image: `map_Kd -s 2 2 wood.png`.

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
    after_options(rest)
}

/// Returns the text behind the options of a statement; none if there is none.
pub(crate) fn after_options(rest: &str) -> Option<&str> {
    let mut words = rest.trim();
    while words.starts_with('-') {
        let (option, after) = words.split_once(char::is_whitespace)?;
        let arguments = match option {
            "-o" | "-s" | "-t" => 3,
            "-mm" => 2,
            "-blendu" | "-blendv" | "-boost" | "-texres" | "-clamp" | "-bm" | "-imfchan"
            | "-type" | "-cc" => 1,
            _ => 0,
        };
        words = after.trim_start();
        for _ in 0..arguments {
            // -o, -s and -t take one to three numbers.
            let (word, after) = words.split_once(char::is_whitespace)?;
            if arguments > 1 && word.parse::<f64>().is_err() {
                break;
            }
            words = after.trim_start();
        }
    }
    (!words.is_empty()).then_some(words)
}

/// The line with another file in its place.
pub(crate) fn with_file(line: &str, file: &str) -> String {
    let line = line.trim_end();
    match self::file(line) {
        Some(old) => format!("{}{file}", &line[..line.len() - old.len()]),
        None => line.to_owned(),
    }
}
