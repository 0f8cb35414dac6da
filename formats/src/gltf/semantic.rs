//! Names of attributes, and which formats each may have.

use super::accessor::{Accessor, Shape};
use lodc_mesh::{Attribute, Component, Semantic};

/// The meaning of an attribute's name. Names that glTF does not know are kept as they are.
pub(super) fn from_name(name: &str) -> Semantic {
    let set = |prefix: &str| -> Option<u32> {
        let digits = name.strip_prefix(prefix)?;
        let number: u32 = digits.parse().ok()?;
        // `TEXCOORD_01` or `+1` would come back under another name.
        (number.to_string() == digits).then_some(number)
    };
    match name {
        "POSITION" => Semantic::Position,
        "NORMAL" => Semantic::Normal,
        "TANGENT" => Semantic::Tangent,
        _ => None
            .or_else(|| set("TEXCOORD_").map(Semantic::TexCoord))
            .or_else(|| set("COLOR_").map(Semantic::Color))
            .or_else(|| set("JOINTS_").map(Semantic::Joints))
            .or_else(|| set("WEIGHTS_").map(Semantic::Weights))
            .unwrap_or_else(|| Semantic::Custom(name.to_owned())),
    }
}

/// The name of an attribute in glTF.
pub(crate) fn to_name(semantic: &Semantic) -> String {
    match semantic {
        Semantic::Position => "POSITION".to_owned(),
        Semantic::Normal => "NORMAL".to_owned(),
        Semantic::Tangent => "TANGENT".to_owned(),
        Semantic::TexCoord(set) => format!("TEXCOORD_{set}"),
        Semantic::Color(set) => format!("COLOR_{set}"),
        Semantic::Joints(set) => format!("JOINTS_{set}"),
        Semantic::Weights(set) => format!("WEIGHTS_{set}"),
        Semantic::Custom(name) => name.clone(),
    }
}

/// Returns whether an accessor can hold this: the shape that the meaning demands, and no 32-bit
/// integers except in custom data. Any other component type is taken, as KHR_mesh_quantization
/// allows more than the core does.
pub(super) fn accepts(semantic: &Semantic, morph_target: bool, accessor: &Accessor) -> bool {
    let is_vector = |components: usize| accessor.shape == Shape { columns: 1, rows: components };
    let shape_fits = match semantic {
        Semantic::Custom(_) => return true,
        Semantic::Position | Semantic::Normal => is_vector(3),
        // A morph target moves the direction of a tangent, not its handedness.
        Semantic::Tangent => is_vector(if morph_target { 3 } else { 4 }),
        // Some exporters write a third texture coordinate, which is left out.
        Semantic::TexCoord(_) => is_vector(2) || is_vector(3),
        Semantic::Color(_) => is_vector(3) || is_vector(4),
        Semantic::Joints(_) | Semantic::Weights(_) => is_vector(4),
    };
    let joints_fit =
        !matches!(semantic, Semantic::Joints(_)) || accessor.component != Component::F32;
    shape_fits && joints_fit && accessor.component != Component::U32
}

/// Positions as a stream.
pub(super) fn positions(positions: &[[f32; 3]]) -> Attribute {
    Attribute {
        semantic: Semantic::Position,
        morph_target: None,
        component: Component::F32,
        components: 3,
        normalized: false,
        bytes: positions.iter().flatten().flat_map(|c| c.to_le_bytes()).collect(),
    }
}
