//! Values of the options of `render`.

use clap::ValueEnum;

/// Sides to look at.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub(super) enum View {
    Front,
    Back,
    Left,
    Right,
    Top,
    Bottom,
    ThreeQuarter,
}

impl View {
    /// Azimuth and elevation in degrees. Left and right are those of the picture of the front.
    pub(super) fn angles(self) -> (f64, f64) {
        match self {
            Self::Front => (0.0, 0.0),
            Self::Back => (180.0, 0.0),
            Self::Left => (-90.0, 0.0),
            Self::Right => (90.0, 0.0),
            Self::Top => (0.0, 90.0),
            Self::Bottom => (0.0, -90.0),
            Self::ThreeQuarter => (35.0, 20.0),
        }
    }
}

/// Normals that light falls on: those of vertices, or one for each triangle.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub(super) enum Shading {
    Smooth,
    Flat,
}

/// Meanings of colours.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub(super) enum ColorMode {
    /// Base colours, textures and vertex colours of the file
    Material,
    /// Grey
    Plain,
    /// A colour for each submesh
    Submesh,
    /// A colour for each triangle strip of the file's model, or of strips made for the picture
    Strips,
    /// Distance from the surface to that of the input
    Error,
}

/// Treatment of back faces.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub(super) enum BackFaceMode {
    Material,
    Show,
    Hide,
    Mark,
}

/// Pixels of a side of a picture at most. Chosen by hand: bounds the memory.
const MAX_SIDE: u32 = 8192;

/// Reads `1024x768`.
pub(super) fn size(text: &str) -> Result<[u32; 2], String> {
    let expected = || format!("a width and a height such as 1024x768, each from 1 to {MAX_SIDE}");
    let (w, h) = text.split_once(['x', 'X']).ok_or_else(expected)?;
    let side = |s: &str| s.parse().ok().filter(|n| (1..=MAX_SIDE).contains(n)).ok_or_else(expected);
    Ok([side(w)?, side(h)?])
}

fn number_between(text: &str, low: f64, high: f64) -> Result<f64, String> {
    let value = text.parse().ok().filter(|value| (low..=high).contains(value));
    value.ok_or_else(|| format!("must be a number from {low} to {high}"))
}

pub(super) fn degrees(text: &str) -> Result<f64, String> {
    number_between(text, -360.0, 360.0)
}

pub(super) fn elevation(text: &str) -> Result<f64, String> {
    number_between(text, -90.0, 90.0)
}

pub(super) fn zoom(text: &str) -> Result<f64, String> {
    number_between(text, 0.01, 1000.0)
}

/// Reads `#rrggbb`, `#rrggbbaa` or a name.
pub(super) fn colour(text: &str) -> Result<[u8; 4], String> {
    match text {
        "white" => return Ok([255; 4]),
        "black" => return Ok([0, 0, 0, 255]),
        "grey" | "gray" => return Ok([128, 128, 128, 255]),
        "transparent" => return Ok([0; 4]),
        _ => {}
    }
    let expected =
        || "a colour as #rrggbb or #rrggbbaa, or white, black, grey, transparent".to_owned();
    let digits = text
        .strip_prefix('#')
        .filter(|d| d.bytes().all(|b| b.is_ascii_hexdigit()))
        .ok_or_else(expected)?;
    let value = u32::from_str_radix(digits, 16).map_err(|_| expected())?;
    match digits.len() {
        6 => Ok((value << 8 | 0xff).to_be_bytes()),
        8 => Ok(value.to_be_bytes()),
        _ => Err(expected()),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn colours_and_sizes_are_read_and_nonsense_is_refused() {
        assert_eq!(colour("#0a0B0c"), Ok([10, 11, 12, 255]));
        assert_eq!(colour("#01020304"), Ok([1, 2, 3, 4]));
        assert_eq!(size("640x480"), Ok([640, 480]));
        for wrong in ["red", "#12", "#12345", "#+12345", "#1234567", "", "#ééé"] {
            assert!(colour(wrong).is_err(), "{wrong}");
        }
        for wrong in ["640", "0x1", "1x0", "1x9999", "x", "axb", "-1x2"] {
            assert!(size(wrong).is_err(), "{wrong}");
        }
        for wrong in ["0", "NaN", "1001", "inf"] {
            assert!(zoom(wrong).is_err(), "{wrong}");
        }
    }
}
